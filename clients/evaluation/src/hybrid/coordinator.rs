//! Coordinator: a table of phases, each with its control owner and end conditions.
//!
//! Input: [`Conditions`], the observed state of base and hand. Output: the phase.

use sim_backend::course::{Light, PHOTO_SENSORS_M};

/// Region of the light in which the base stops, base frame: ahead of and beside the eyes. Braking
/// from high speed takes 0.1 m.
const AHEAD: Region = Region {
    ahead_m: [0.25, 0.42],
    beside_m: 0.10,
};
/// Region of the light within reach of the hand after the stop: validated workspace of the right
/// hand less the camera error.
const REACH: Region = Region {
    ahead_m: [0.225, 0.395],
    beside_m: 0.13,
};

/// Distances to the robot with the right of way at which this one stops and resumes, m. Extended
/// arms touch at 0.9 m.
const CROWDED_M: f64 = 1.6;
const FREE_M: f64 = 1.8;

struct Region {
    ahead_m: [f64; 2],
    beside_m: f64,
}

impl Region {
    /// Returns true if a light is inside; false for values that are not finite.
    fn contains(&self, [ahead_m, left_m]: [f64; 2]) -> bool {
        let [near_m, far_m] = self.ahead_m;
        (near_m..=far_m).contains(&ahead_m) && (left_m - PHOTO_SENSORS_M[1]).abs() <= self.beside_m
    }
}

/// Task of the hand.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum HandTask {
    /// Grasp and lift the object.
    Grasp,
    /// Set the object down at the goal.
    SetDown,
}

/// Control owner of a phase.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ControlOwner {
    /// Table drives towards the light; the hand continues its task.
    Table,
    /// None: the base brakes.
    Brake,
    /// Hand executes a task; the base stands.
    Hand(HandTask),
}

/// State of the hand's task.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum HandState {
    /// Running, or no task.
    #[default]
    Busy,
    /// Succeeded.
    Done,
    /// Failed or refused.
    Failed,
}

/// Observed state of base and hand.
#[derive(Clone, Copy, Debug, Default)]
pub struct Conditions {
    /// Position of the light, m: ahead of the base centre and to the left; `None` without a light.
    pub light_m: Option<[f64; 2]>,
    /// True if the base stands.
    pub stands: bool,
    /// State of the hand's task.
    pub hand: HandState,
    /// True if all grasp sides are in contact.
    pub holds: bool,
    /// Distance to the robot with the right of way, m; `None` if this robot has it.
    pub first_m: Option<f64>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Condition {
    Ahead,
    Within,
    Beyond,
    HandDone,
    HandFailed,
    Lost,
    Crowded,
    Free,
}

impl Conditions {
    fn is_true(&self, sign: Condition) -> bool {
        let within = |spot: &Region| self.light_m.is_some_and(|light_m| spot.contains(light_m));
        match sign {
            Condition::Ahead => within(&AHEAD),
            Condition::Within => self.stands && within(&REACH),
            Condition::Beyond => self.stands && !within(&REACH),
            Condition::HandDone => self.hand == HandState::Done,
            Condition::HandFailed => self.hand == HandState::Failed,
            Condition::Lost => !self.holds,
            Condition::Crowded => self.first_m.is_some_and(|m| m < CROWDED_M),
            Condition::Free => self.first_m.is_none_or(|m| m > FREE_M),
        }
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum NextStep {
    Phase(usize),
    Done,
    Fail(&'static str),
}

/// Row of the phase table.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Phase {
    /// Name, as shown to users.
    pub name: &'static str,
    /// Control owner.
    pub owner: ControlOwner,
    /// Light that the base observes.
    pub light: Light,
    /// End conditions; the first true one counts.
    ends: &'static [(Condition, NextStep)],
    /// Time limit of all visits together, s, and the next step after it. Design choice: several
    /// times the usual duration.
    limit_s: f64,
    after_limit: NextStep,
}

const SEARCH: usize = 0;
const STOP: usize = 1;
const GRASP: usize = 2;
const CARRY: usize = 3;
const ARRIVE: usize = 4;
const SET_DOWN: usize = 5;
const GIVE_WAY: usize = 6;
const GIVE_WAY_CARRYING: usize = 7;

const LOST: (Condition, NextStep) = (Condition::Lost, NextStep::Fail("lost on the way"));

/// Phases in the order of the course, then those of a robot that gives way.
pub static PHASES: [Phase; 8] = [
    Phase {
        name: "search",
        owner: ControlOwner::Table,
        light: Light::Object,
        ends: &[
            (Condition::Ahead, NextStep::Phase(STOP)),
            (Condition::Crowded, NextStep::Phase(GIVE_WAY)),
        ],
        limit_s: 180.0,
        after_limit: NextStep::Fail("object not found"),
    },
    Phase {
        name: "stop",
        owner: ControlOwner::Brake,
        light: Light::Object,
        ends: &[
            (Condition::Within, NextStep::Phase(GRASP)),
            (Condition::Beyond, NextStep::Phase(SEARCH)),
        ],
        limit_s: 60.0,
        after_limit: NextStep::Fail("object not within reach"),
    },
    Phase {
        name: "grasp",
        owner: ControlOwner::Hand(HandTask::Grasp),
        light: Light::Object,
        ends: &[
            (Condition::HandDone, NextStep::Phase(CARRY)),
            (Condition::HandFailed, NextStep::Fail("not grasped")),
        ],
        limit_s: 120.0,
        after_limit: NextStep::Fail("not grasped in time"),
    },
    Phase {
        name: "carry",
        owner: ControlOwner::Table,
        light: Light::Goal,
        ends: &[
            LOST,
            (Condition::Ahead, NextStep::Phase(ARRIVE)),
            (Condition::Crowded, NextStep::Phase(GIVE_WAY_CARRYING)),
        ],
        limit_s: 180.0,
        after_limit: NextStep::Fail("goal not found"),
    },
    Phase {
        name: "arrive",
        owner: ControlOwner::Brake,
        light: Light::Goal,
        ends: &[
            LOST,
            (Condition::Within, NextStep::Phase(SET_DOWN)),
            (Condition::Beyond, NextStep::Phase(CARRY)),
        ],
        limit_s: 60.0,
        after_limit: NextStep::Fail("goal not within reach"),
    },
    Phase {
        name: "set down",
        owner: ControlOwner::Hand(HandTask::SetDown),
        light: Light::Goal,
        ends: &[
            (Condition::HandDone, NextStep::Done),
            (Condition::HandFailed, NextStep::Fail("not set down")),
        ],
        limit_s: 120.0,
        after_limit: NextStep::Fail("not set down in time"),
    },
    Phase {
        name: "give way",
        owner: ControlOwner::Brake,
        light: Light::Object,
        ends: &[(Condition::Free, NextStep::Phase(SEARCH))],
        limit_s: 180.0,
        after_limit: NextStep::Fail("not let past"),
    },
    Phase {
        name: "give way",
        owner: ControlOwner::Brake,
        light: Light::Goal,
        ends: &[LOST, (Condition::Free, NextStep::Phase(CARRY))],
        limit_s: 180.0,
        after_limit: NextStep::Fail("not let past"),
    },
];

/// Result of a course.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ended {
    /// All phases done.
    Done,
    /// Failed, with the failure key.
    Failed(&'static str),
}

/// Phase state of one robot.
#[derive(Clone, Debug, Default)]
pub struct Coordinator {
    phase: usize,
    spent_s: [f64; PHASES.len()],
    ended: Option<Ended>,
}

impl Coordinator {
    /// Returns the current phase.
    #[must_use]
    pub fn phase(&self) -> &'static Phase {
        &PHASES[self.phase]
    }

    /// Returns the result once the course has ended.
    #[must_use]
    pub fn ended(&self) -> Option<Ended> {
        self.ended
    }

    /// Evaluates the end conditions after `passed_s`; returns true for a new phase.
    pub fn update(&mut self, signs: &Conditions, passed_s: f64) -> bool {
        if self.ended.is_some() {
            return false;
        }
        let phase = self.phase();
        let spent_s = &mut self.spent_s[self.phase];
        *spent_s += passed_s;
        // The time limit precedes the conditions, so that two phases cannot alternate for ever.
        let late = (*spent_s > phase.limit_s).then_some(phase.after_limit);
        let sign = phase.ends.iter().find(|(sign, _)| signs.is_true(*sign));
        match late.or(sign.map(|(_, then)| *then)) {
            Some(NextStep::Phase(next)) => {
                self.phase = next;
                return true;
            }
            Some(NextStep::Done) => self.ended = Some(Ended::Done),
            Some(NextStep::Fail(how)) => self.ended = Some(Ended::Failed(how)),
            None => {}
        }
        false
    }

    /// Ends the course for a cause outside the phase table.
    pub fn fail(&mut self, how: &'static str) {
        self.ended.get_or_insert(Ended::Failed(how));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn signs(ahead_m: f64, stands: bool) -> Conditions {
        Conditions {
            light_m: Some([ahead_m, PHOTO_SENSORS_M[1]]),
            stands,
            holds: true,
            ..Conditions::default()
        }
    }

    fn done(hand: HandState) -> Conditions {
        Conditions {
            hand,
            ..signs(0.35, true)
        }
    }

    fn walk(shown: &[Conditions], expected: &[&str], ended: Option<Ended>) {
        let mut coordinator = Coordinator::default();
        let mut phases = vec![coordinator.phase().name];
        for signs in shown {
            if coordinator.update(signs, 0.1) {
                phases.push(coordinator.phase().name);
            }
        }
        assert_eq!((&phases[..], coordinator.ended()), (expected, ended));
    }

    #[test]
    fn phases_follow_their_end_conditions() {
        let (far, ahead, near) = (signs(2.0, false), signs(0.35, false), signs(0.35, true));
        let empty = Conditions {
            holds: false,
            ..far
        };
        let whole = [
            far,
            ahead,
            near,
            done(HandState::Done),
            far,
            ahead,
            near,
            done(HandState::Done),
        ];
        let names: Vec<&str> = PHASES[..GIVE_WAY].iter().map(|phase| phase.name).collect();
        walk(&whole, &names, Some(Ended::Done));
        walk(&whole[..7], &names, None);
        walk(&[far; 100], &names[..1], None);
        walk(
            &[far; 2000],
            &names[..1],
            Some(Ended::Failed("object not found")),
        );
        walk(
            &[ahead, signs(0.6, true), far],
            &["search", "stop", "search"],
            None,
        );
        let gave_up = done(HandState::Failed);
        walk(
            &[ahead, near, gave_up],
            &names[..3],
            Some(Ended::Failed("not grasped")),
        );
        let met = Conditions {
            first_m: Some(1.2),
            ..far
        };
        walk(&[met, met, far], &["search", "give way", "search"], None);
        walk(
            &[met; 1900],
            &["search", "give way"],
            Some(Ended::Failed("not let past")),
        );
        // Alternating phases end at their time limit.
        let turns: Vec<Conditions> = (0..4000).map(|k| [met, far][k % 2]).collect();
        let mut coordinator = Coordinator::default();
        turns.iter().for_each(|signs| {
            coordinator.update(signs, 0.1);
        });
        assert!(matches!(coordinator.ended(), Some(Ended::Failed(_))));
        let lost = [ahead, near, done(HandState::Done), empty];
        walk(&lost, &names[..4], Some(Ended::Failed("lost on the way")));
    }

    #[test]
    fn non_finite_light_is_out_of_reach() {
        for ahead_m in [f64::NAN, f64::INFINITY] {
            let signs = signs(ahead_m, true);
            assert!(!signs.is_true(Condition::Ahead) && !signs.is_true(Condition::Within));
        }
    }
}
