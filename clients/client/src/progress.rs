//! How a goal goes on: its updates, condensed to what a user wants to hear at the end.

use shm_schemas::{GoalState, GoalUpdate, GraspFigures, Text};

/// Normal force of a finger that presses, N (ours: above the sensors' noise, below the least grip).
const PRESSED_N: f32 = 0.1;

// Steps by what they mean to a client, named as the controller's tables name them; a test compares.
/// The hand opens what it held.
const OPENING: [&str; 2] = ["open", "let go"];
/// The hand lets go of what it placed.
const LETTING_GO: &str = "let go";
/// The hand is on its way home without an object.
const GOING_HOME: [&str; 2] = ["leave", "home"];
/// The hand turns back because it could not go on.
const RETREATING: [&str; 5] = ["lower", "open", "leave", "raise", "withdraw"];
/// The hand raises again what found no support.
const RAISING: &str = "raise";

/// What happened to a goal so far.
#[derive(Clone, Copy, Debug, Default)]
pub struct GoalProgress {
    last: GoalUpdate,
    /// When the goal began, ns; 0 before the first update.
    begun_ns: u64,
    /// The last step of the task: what ends it early names what the hand does afterwards, or nothing.
    step: Text<16>,
    /// The last update of the attempt itself, before the hand let go of the object.
    attempt: GoalUpdate,
    /// When the hand began to let go of what it had placed, ns.
    let_go_ns: Option<u64>,
}

impl GoalProgress {
    /// Takes in the next update.
    pub fn add(&mut self, update: &GoalUpdate) {
        self.last = *update;
        if self.begun_ns == 0 {
            self.begun_ns = update.stamp.captured_ns;
        }
        let is_cut_short = update.state.is_final() && update.state != GoalState::SUCCEEDED;
        let is_known = !self.step.as_str().is_empty();
        if update.step.as_str().is_empty() || (is_cut_short && is_known) {
            return;
        }
        self.step = update.step;
        if !self.lets_go() {
            self.attempt = *update;
        }
        if update.step.as_str() == LETTING_GO {
            self.let_go_ns.get_or_insert(update.stamp.captured_ns);
        }
    }

    /// When the hand began to let go of what it had placed, ns of the controller's clock; `None` if it never did.
    #[must_use]
    pub fn let_go_ns(&self) -> Option<u64> {
        self.let_go_ns
    }

    /// From the first update to the last, s.
    #[must_use]
    pub fn took_s(&self) -> f64 {
        self.last.stamp.captured_ns.saturating_sub(self.begun_ns) as f64 * 1e-9
    }

    /// The last update.
    #[must_use]
    pub fn last(&self) -> &GoalUpdate {
        &self.last
    }

    /// Whether the hand is done with the object: opens, goes home, or retreats.
    fn lets_go(&self) -> bool {
        let step = self.step.as_str();
        OPENING.contains(&step) || GOING_HOME.contains(&step) || self.retreats()
    }

    /// Whether the hand does what it does because it could not go on.
    fn retreats(&self) -> bool {
        RETREATING.contains(&self.step.as_str())
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

    /// The step that decided: the last one, but the one before if the hand then retreated.
    #[must_use]
    pub fn step(&self) -> &str {
        let refused = self.last.state == GoalState::REFUSED;
        let failed = self.last.state == GoalState::FAILED && self.step.as_str() == RAISING;
        if (refused || failed) && self.retreats() && self.was_attempted() {
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

    /// Whether a finger of the acting hand presses.
    #[must_use]
    pub fn presses(&self) -> bool {
        let pressed_n = &self.last.figures.normal_n;
        pressed_n.iter().any(|force_n| *force_n > PRESSED_N)
    }

    fn was_attempted(&self) -> bool {
        self.attempt.goal_id != 0
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use shm_schemas::{Cause, Reason};

    fn told(updates: &[(GoalState, &str, f32)]) -> GoalProgress {
        let mut progress = GoalProgress::default();
        for (state, step, normal_n) in updates {
            progress.add(&GoalUpdate {
                goal_id: 7,
                state: *state,
                step: Text::new(step),
                reason: Reason::of(Cause::CANCELLED),
                figures: GraspFigures {
                    normal_n: [*normal_n; 4],
                    ..GraspFigures::default()
                },
                ..GoalUpdate::default()
            });
        }
        progress
    }

    #[test]
    fn the_step_that_decided_and_the_force_that_held() {
        use GoalState as S;
        let check = |updates: &[(GoalState, &str, f32)], step: &str, normal_n: f32| {
            let progress = told(updates);
            let held_n = progress.figures().normal_n[0];
            assert_eq!((progress.step(), held_n), (step, normal_n), "{updates:?}");
        };
        check(&[(S::REJECTED, "", 0.0)], "", 0.0);
        check(
            &[
                (S::RUNNING, "lift", 2.0),
                (S::RUNNING, "hold", 3.0),
                (S::SUCCEEDED, "hold", 4.0),
            ],
            "hold",
            4.0,
        );
        check(
            &[(S::RUNNING, "screw", 2.0), (S::CANCELLED, "", 2.5)],
            "screw",
            2.0,
        );
        check(
            &[(S::RUNNING, "lift", 2.0), (S::CANCELLED, "hold", 2.5)],
            "lift",
            2.0,
        );
        check(
            &[
                (S::RUNNING, "lift", 8.0),
                (S::RUNNING, "lower", 8.0),
                (S::REFUSED, "leave", 0.0),
            ],
            "lift",
            8.0,
        );
        check(
            &[
                (S::RUNNING, "descend", 0.0),
                (S::RUNNING, "withdraw", 0.3),
                (S::REFUSED, "withdraw", 0.0),
            ],
            "descend",
            0.0,
        );
        check(
            &[
                (S::RUNNING, "place", 4.0),
                (S::RUNNING, "raise", 4.1),
                (S::FAILED, "raise", 4.1),
            ],
            "place",
            4.0,
        );
        check(
            &[
                (S::RUNNING, "place", 4.0),
                (S::RUNNING, "let go", 3.9),
                (S::SUCCEEDED, "home", 0.0),
            ],
            "home",
            4.0,
        );
        check(
            &[(S::RUNNING, "open", 0.5), (S::FAILED, "open", 0.5)],
            "open",
            0.5,
        );
    }

    #[test]
    fn steps_mean_what_the_controllers_tables_say() {
        use atas_core::tasks::{BACK_OUT, BUILT_IN, Motion, PICK_PLACE, RAISE, RELEASE, WITHDRAW};
        let names = |track: &atas_core::tasks::Track| -> Vec<String> {
            track
                .iter()
                .map(|step| step.name.as_str().to_owned())
                .collect()
        };
        let known = |name: &str| OPENING.contains(&name) || GOING_HOME.contains(&name);
        for step in BUILT_IN.iter().flat_map(|task| task.acting.iter()) {
            let opens = matches!(step.motion, Motion::Open | Motion::LetGo);
            assert!(!opens || OPENING.contains(&step.name.as_str()), "{step:?}");
        }
        let placing = PICK_PLACE.acting.iter();
        for step in placing {
            let lets_go = step.motion == Motion::LetGo;
            assert_eq!(step.name.as_str() == LETTING_GO, lets_go, "{step:?}");
        }
        assert!(names(&RELEASE.acting).iter().all(|name| known(name)));
        let retreats = [names(&BACK_OUT), names(&RAISE), names(&WITHDRAW)].concat();
        let mut told: Vec<&str> = retreats.iter().map(String::as_str).collect();
        let mut here = RETREATING.to_vec();
        told.sort_unstable();
        here.sort_unstable();
        assert_eq!(told, here);
        assert_eq!(names(&RAISE), [RAISING]);
    }

    #[test]
    fn a_finger_presses_above_the_sensors_noise() {
        let presses = |normal_n| told(&[(GoalState::CANCELLED, "screw", normal_n)]).presses();
        assert!(presses(2.5) && !presses(0.02) && !presses(f32::NAN));
    }
}
