//! A goal's story: its updates, condensed to what a user wants to hear at the end.

use atas::tasks::{BACK_OUT, RAISE, RELEASE};
use shm_schemas::{GoalState, GoalUpdate, GraspFigures, Text};

/// What happened to a goal so far.
#[derive(Clone, Copy, Debug, Default)]
pub struct Story {
    last: GoalUpdate,
    /// The last step of the task: what ends it early names what the hand does afterwards, or nothing.
    step: Text<16>,
    /// The last update of the attempt itself, before the hand let go of the object.
    attempt: GoalUpdate,
}

impl Story {
    /// Takes in the next update.
    pub fn add(&mut self, update: &GoalUpdate) {
        self.last = *update;
        let is_cut_short = update.state.is_final() && update.state != GoalState::SUCCEEDED;
        let is_known = !self.step.as_str().is_empty();
        if update.step.as_str().is_empty() || (is_cut_short && is_known) {
            return;
        }
        self.step = update.step;
        if !self.lets_go() {
            self.attempt = *update;
        }
    }

    /// The last update.
    #[must_use]
    pub fn last(&self) -> &GoalUpdate {
        &self.last
    }

    /// Whether the hand is putting the object back, raising it again, opening, or on its way home.
    #[must_use]
    pub fn lets_go(&self) -> bool {
        let mut steps = [BACK_OUT, RAISE, RELEASE.acting]
            .into_iter()
            .flat_map(|track| track.to_vec());
        steps.any(|step| step.name == self.step.as_str())
    }

    /// What the hand knew and pressed when it last tried.
    #[must_use]
    pub fn figures(&self) -> &GraspFigures {
        if self.was_attempted() {
            &self.attempt.figures
        } else {
            &self.last.figures
        }
    }

    /// The step that decided: the last one, but the one before if the hand then put the object back or raised it again.
    #[must_use]
    pub fn step(&self) -> &str {
        let raised = RAISE.iter().any(|step| step.name == self.step.as_str());
        let retreated = self.last.state == GoalState::REFUSED || raised;
        if retreated && self.was_attempted() {
            self.attempt.step.as_str()
        } else {
            self.step.as_str()
        }
    }

    /// One sentence about an end without success: the step, the cause, the value against its limit, the module.
    #[must_use]
    pub fn sentence(&self) -> String {
        match self.step() {
            "" => self.last.reason.to_string(),
            step => format!("{step}: {}", self.last.reason),
        }
    }

    /// What the hand does after an end: a goal that ends lets nothing fall.
    #[must_use]
    pub fn hand_now(&self) -> &'static str {
        let figures = &self.last.figures;
        let presses = figures.normal_n.iter().any(|force_n| *force_n > 0.0);
        if self.last.state == GoalState::REFUSED {
            "the hand has put the object back and is open above it"
        } else if figures.hardness_n_m > 0.0 && presses {
            "the hand keeps holding what it holds; `atas release` lets go"
        } else {
            "the hand stays where it is"
        }
    }

    fn was_attempted(&self) -> bool {
        self.attempt.goal_id != 0
    }
}
