//! Progress of a goal: its updates, condensed to the result for a user.

use shm_schemas::{GoalState, GoalUpdate, GraspFigures, Text};

/// Normal force of a pressing fingertip, N. Design choice: above sensor noise, below the smallest
/// grip force.
const PRESSED_N: f32 = 0.1;

// Steps by meaning, named as in the controller's tables (tested).
/// The hand opens.
const OPENING: [&str; 2] = ["open", "let go"];
/// The hand releases an object that it placed.
const RELEASING: &str = "let go";
/// The hand moves home without an object.
const GOING_HOME: [&str; 2] = ["leave", "home"];
/// The hand executes a recovery because it could not continue.
const RECOVERING: [&str; 5] = ["lower", "open", "leave", "raise", "withdraw"];
/// The hand raises an object that found no support.
const RAISING: &str = "raise";

/// Updates of a goal so far.
#[derive(Clone, Copy, Debug, Default)]
pub struct GoalProgress {
    last: GoalUpdate,
    /// Start time of the goal, ns; 0 before the first update.
    begun_ns: u64,
    /// Last step of the task. The update that ends a task early names a later step, or none.
    step: Text<16>,
    /// Last update of the attempt, before the hand released the object.
    attempt: GoalUpdate,
    /// Time at which the hand began to release the placed object, ns.
    released_ns: Option<u64>,
}

impl GoalProgress {
    /// Adds the next update.
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
        if !self.is_releasing() {
            self.attempt = *update;
        }
        if update.step.as_str() == RELEASING {
            self.released_ns.get_or_insert(update.stamp.captured_ns);
        }
    }

    /// Returns the time at which the hand began to release the placed object, ns of the
    /// controller's clock; `None` if it did not.
    #[must_use]
    pub fn released_ns(&self) -> Option<u64> {
        self.released_ns
    }

    /// Returns the time from the first update to the last, s.
    #[must_use]
    pub fn took_s(&self) -> f64 {
        self.last.stamp.captured_ns.saturating_sub(self.begun_ns) as f64 * 1e-9
    }

    /// Returns the last update.
    #[must_use]
    pub fn last(&self) -> &GoalUpdate {
        &self.last
    }

    /// Returns true if the hand has finished with the object: opens, moves home, or recovers.
    fn is_releasing(&self) -> bool {
        let step = self.step.as_str();
        OPENING.contains(&step) || GOING_HOME.contains(&step) || self.is_recovering()
    }

    /// Returns true if the hand executes a recovery.
    fn is_recovering(&self) -> bool {
        RECOVERING.contains(&self.step.as_str())
    }

    /// Returns the estimates and forces of the hand at its last attempt.
    #[must_use]
    pub fn figures(&self) -> &GraspFigures {
        if self.was_attempted() {
            &self.attempt.figures
        } else {
            &self.last.figures
        }
    }

    /// Returns the decisive step: the last one, or the one before a recovery.
    #[must_use]
    pub fn step(&self) -> &str {
        let refused = self.last.state == GoalState::REFUSED;
        let failed = self.last.state == GoalState::FAILED && self.step.as_str() == RAISING;
        if (refused || failed) && self.is_recovering() && self.was_attempted() {
            self.attempt.step.as_str()
        } else {
            self.step.as_str()
        }
    }

    /// Returns one sentence about an end without success: step, cause, value with limit, module.
    #[must_use]
    pub fn text(&self) -> String {
        match self.step() {
            "" => self.last.reason.to_string(),
            step => format!("{step}: {}", self.last.reason),
        }
    }

    /// Returns true if a fingertip of the acting hand presses.
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
    use shm_schemas::Reason;

    fn progress_of(updates: &[(GoalState, &str, f32)]) -> GoalProgress {
        let mut progress = GoalProgress::default();
        for (state, step, normal_n) in updates {
            progress.add(&GoalUpdate {
                goal_id: 7,
                state: *state,
                step: Text::new(step),
                reason: Reason::Cancelled.into(),
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
    fn progress_has_decisive_step_and_holding_force() {
        use GoalState as S;
        let check = |updates: &[(GoalState, &str, f32)], step: &str, normal_n: f32| {
            let progress = progress_of(updates);
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
    fn step_names_equal_the_controller_tables() {
        use atas_core::tasks::{BUILT_IN, Motion, PICK_PLACE, PUT_BACK, RAISE, RELEASE, WITHDRAW};
        let names = |track: &atas_core::tasks::StepSequence| -> Vec<String> {
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
            assert_eq!(step.name.as_str() == RELEASING, lets_go, "{step:?}");
        }
        assert!(names(&RELEASE.acting).iter().all(|name| known(name)));
        let retreats = [names(&PUT_BACK), names(&RAISE), names(&WITHDRAW)].concat();
        let mut reported: Vec<&str> = retreats.iter().map(String::as_str).collect();
        let mut here = RECOVERING.to_vec();
        reported.sort_unstable();
        here.sort_unstable();
        assert_eq!(reported, here);
        assert_eq!(names(&RAISE), [RAISING]);
    }

    #[test]
    fn fingertip_presses_above_sensor_noise() {
        let presses =
            |normal_n| progress_of(&[(GoalState::CANCELLED, "screw", normal_n)]).presses();
        assert!(presses(2.5) && !presses(0.02) && !presses(f32::NAN));
    }
}
