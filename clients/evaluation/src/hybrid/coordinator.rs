//! Coordinator: a table of phases, each with its control owner and end conditions.
//!
//! Input: [`Signs`], the observed state of base and hand. Output: the phase.

use sim_backend::course::{EYES_M, Light};

/// Region of the light in which the base stops, base frame: ahead of and beside the eyes. Braking
/// from high speed takes 0.1 m.
const AHEAD: Spot = Spot {
    ahead_m: [0.25, 0.42],
    beside_m: 0.10,
};
/// Region of the light within reach of the hand after the stop: validated workspace of the right
/// hand less the camera error.
const REACH: Spot = Spot {
    ahead_m: [0.225, 0.395],
    beside_m: 0.13,
};

/// Distances to the robot with the right of way at which this one stops and resumes, m. Extended
/// arms touch at 0.9 m.
const CROWDED_M: f64 = 1.6;
const FREE_M: f64 = 1.8;

struct Spot {
    ahead_m: [f64; 2],
    beside_m: f64,
}

impl Spot {
    /// Returns true if a light is inside; false for values that are not finite.
    fn has(&self, [ahead_m, left_m]: [f64; 2]) -> bool {
        let [near_m, far_m] = self.ahead_m;
        (near_m..=far_m).contains(&ahead_m) && (left_m - EYES_M[1]).abs() <= self.beside_m
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
pub enum Say {
    /// Table drives towards the light; the hand continues its task.
    Table,
    /// None: the base brakes.
    Nobody,
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
    GaveUp,
}

/// Observed state of base and hand.
#[derive(Clone, Copy, Debug, Default)]
pub struct Signs {
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
enum Sign {
    Ahead,
    Within,
    Beyond,
    Done,
    GaveUp,
    Lost,
    Crowded,
    Free,
}

impl Signs {
    fn show(&self, sign: Sign) -> bool {
        let within = |spot: &Spot| self.light_m.is_some_and(|light_m| spot.has(light_m));
        match sign {
            Sign::Ahead => within(&AHEAD),
            Sign::Within => self.stands && within(&REACH),
            Sign::Beyond => self.stands && !within(&REACH),
            Sign::Done => self.hand == HandState::Done,
            Sign::GaveUp => self.hand == HandState::GaveUp,
            Sign::Lost => !self.holds,
            Sign::Crowded => self.first_m.is_some_and(|m| m < CROWDED_M),
            Sign::Free => self.first_m.is_none_or(|m| m > FREE_M),
        }
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Then {
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
    pub say: Say,
    /// Light that the base observes.
    pub light: Light,
    /// End conditions; the first true one counts.
    ends: &'static [(Sign, Then)],
    /// Time limit of all visits together, s, and the next step after it. Design choice: several
    /// times the usual duration.
    limit_s: f64,
    late: Then,
}

const SEARCH: usize = 0;
const STOP: usize = 1;
const GRASP: usize = 2;
const CARRY: usize = 3;
const ARRIVE: usize = 4;
const SET_DOWN: usize = 5;
const GIVE_WAY: usize = 6;
const GIVE_WAY_CARRYING: usize = 7;

const LOST: (Sign, Then) = (Sign::Lost, Then::Fail("lost on the way"));

/// Phases in the order of the course, then those of a robot that gives way.
pub static PHASES: [Phase; 8] = [
    Phase {
        name: "search",
        say: Say::Table,
        light: Light::Object,
        ends: &[
            (Sign::Ahead, Then::Phase(STOP)),
            (Sign::Crowded, Then::Phase(GIVE_WAY)),
        ],
        limit_s: 180.0,
        late: Then::Fail("object not found"),
    },
    Phase {
        name: "stop",
        say: Say::Nobody,
        light: Light::Object,
        ends: &[
            (Sign::Within, Then::Phase(GRASP)),
            (Sign::Beyond, Then::Phase(SEARCH)),
        ],
        limit_s: 60.0,
        late: Then::Fail("object not within reach"),
    },
    Phase {
        name: "grasp",
        say: Say::Hand(HandTask::Grasp),
        light: Light::Object,
        ends: &[
            (Sign::Done, Then::Phase(CARRY)),
            (Sign::GaveUp, Then::Fail("not grasped")),
        ],
        limit_s: 120.0,
        late: Then::Fail("not grasped in time"),
    },
    Phase {
        name: "carry",
        say: Say::Table,
        light: Light::Goal,
        ends: &[
            LOST,
            (Sign::Ahead, Then::Phase(ARRIVE)),
            (Sign::Crowded, Then::Phase(GIVE_WAY_CARRYING)),
        ],
        limit_s: 180.0,
        late: Then::Fail("goal not found"),
    },
    Phase {
        name: "arrive",
        say: Say::Nobody,
        light: Light::Goal,
        ends: &[
            LOST,
            (Sign::Within, Then::Phase(SET_DOWN)),
            (Sign::Beyond, Then::Phase(CARRY)),
        ],
        limit_s: 60.0,
        late: Then::Fail("goal not within reach"),
    },
    Phase {
        name: "set down",
        say: Say::Hand(HandTask::SetDown),
        light: Light::Goal,
        ends: &[
            (Sign::Done, Then::Done),
            (Sign::GaveUp, Then::Fail("not set down")),
        ],
        limit_s: 120.0,
        late: Then::Fail("not set down in time"),
    },
    Phase {
        name: "give way",
        say: Say::Nobody,
        light: Light::Object,
        ends: &[(Sign::Free, Then::Phase(SEARCH))],
        limit_s: 180.0,
        late: Then::Fail("not let past"),
    },
    Phase {
        name: "give way",
        say: Say::Nobody,
        light: Light::Goal,
        ends: &[LOST, (Sign::Free, Then::Phase(CARRY))],
        limit_s: 180.0,
        late: Then::Fail("not let past"),
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
    pub fn look(&mut self, signs: &Signs, passed_s: f64) -> bool {
        if self.ended.is_some() {
            return false;
        }
        let phase = self.phase();
        let spent_s = &mut self.spent_s[self.phase];
        *spent_s += passed_s;
        // The time limit precedes the conditions, so that two phases cannot alternate for ever.
        let late = (*spent_s > phase.limit_s).then_some(phase.late);
        let sign = phase.ends.iter().find(|(sign, _)| signs.show(*sign));
        match late.or(sign.map(|(_, then)| *then)) {
            Some(Then::Phase(next)) => {
                self.phase = next;
                return true;
            }
            Some(Then::Done) => self.ended = Some(Ended::Done),
            Some(Then::Fail(how)) => self.ended = Some(Ended::Failed(how)),
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

    fn signs(ahead_m: f64, stands: bool) -> Signs {
        Signs {
            light_m: Some([ahead_m, EYES_M[1]]),
            stands,
            holds: true,
            ..Signs::default()
        }
    }

    fn done(hand: HandState) -> Signs {
        Signs {
            hand,
            ..signs(0.35, true)
        }
    }

    fn walk(shown: &[Signs], expected: &[&str], ended: Option<Ended>) {
        let mut coordinator = Coordinator::default();
        let mut phases = vec![coordinator.phase().name];
        for signs in shown {
            if coordinator.look(signs, 0.1) {
                phases.push(coordinator.phase().name);
            }
        }
        assert_eq!((&phases[..], coordinator.ended()), (expected, ended));
    }

    #[test]
    fn phases_follow_what_is_seen_and_felt() {
        let (far, ahead, near) = (signs(2.0, false), signs(0.35, false), signs(0.35, true));
        let empty = Signs {
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
        let gave_up = done(HandState::GaveUp);
        walk(
            &[ahead, near, gave_up],
            &names[..3],
            Some(Ended::Failed("not grasped")),
        );
        let met = Signs {
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
        let turns: Vec<Signs> = (0..4000).map(|k| [met, far][k % 2]).collect();
        let mut coordinator = Coordinator::default();
        turns.iter().for_each(|signs| {
            coordinator.look(signs, 0.1);
        });
        assert!(matches!(coordinator.ended(), Some(Ended::Failed(_))));
        let lost = [ahead, near, done(HandState::Done), empty];
        walk(&lost, &names[..4], Some(Ended::Failed("lost on the way")));
    }

    #[test]
    fn what_is_not_finite_is_never_within_reach() {
        for ahead_m in [f64::NAN, f64::INFINITY] {
            let signs = signs(ahead_m, true);
            assert!(!signs.show(Sign::Ahead) && !signs.show(Sign::Within));
        }
    }
}
