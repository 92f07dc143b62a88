//! Who has the say: a table of phases, each with the signs that end it.
//!
//! Adding a phase is adding a line. Nothing here moves anything or looks at anything: [`Signs`] are what was seen and felt.

use sim_backend::course::{EYES_M, Light};

/// Where a light must be for the base to stop, base frame: metres ahead, and to each side of the eyes. Braking from high speed
/// takes 0.1 m.
const AHEAD: Spot = Spot {
    ahead_m: [0.25, 0.42],
    beside_m: 0.10,
};
/// Where it must be for the hand, once the base stands: the proved workspace of the right hand, less what a camera may err by.
const REACH: Spot = Spot {
    ahead_m: [0.225, 0.395],
    beside_m: 0.13,
};

/// Distance of the robot that has the right of way from which on this one stands, and from which on it drives again, between the
/// middles of their bases, m: two robots with their arms before them touch at 0.9 m.
const CROWDED_M: f64 = 1.6;
const FREE_M: f64 = 1.8;

/// A rectangle before the eyes.
struct Spot {
    ahead_m: [f64; 2],
    beside_m: f64,
}

impl Spot {
    /// Whether a light is in it; what is not finite is not.
    fn has(&self, [ahead_m, left_m]: [f64; 2]) -> bool {
        let [near_m, far_m] = self.ahead_m;
        (near_m..=far_m).contains(&ahead_m) && (left_m - EYES_M[1]).abs() <= self.beside_m
    }
}

/// What a hand is told to do.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum HandTask {
    /// Grasp the object and lift it.
    Grasp,
    /// Set it down at the goal.
    SetDown,
}

/// Which side has the say.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Say {
    /// The table, which looks for the light; the hand goes on with what it does.
    Table,
    /// Nobody: the base brakes.
    Nobody,
    /// The hand; the base stands.
    Hand(HandTask),
}

/// What the hand says of its task.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum HandState {
    /// It is at work, or has nothing to do.
    #[default]
    Busy,
    /// It has done it.
    Done,
    /// It has given it up.
    GaveUp,
}

/// What is seen and felt.
#[derive(Clone, Copy, Debug, Default)]
pub struct Signs {
    /// Where the light is: metres ahead of the base's middle and to the left; `None` where there is none.
    pub light_m: Option<[f64; 2]>,
    /// The base stands.
    pub stands: bool,
    /// What the hand says.
    pub hand: HandState,
    /// Every finger of the hand presses.
    pub holds: bool,
    /// Distance of the robot that has the right of way, m; `None` if this one has it.
    pub first_m: Option<f64>,
}

/// A sign that a phase looks for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Sign {
    /// The light is where the base should stop.
    Ahead,
    /// The base stands, and the hand reaches the light.
    Within,
    /// The base stands, and the hand does not.
    Beyond,
    /// The hand has done its task.
    Done,
    /// The hand has given up.
    GaveUp,
    /// The hand holds nothing.
    Lost,
    /// The robot that has the right of way is near.
    Crowded,
    /// It is not.
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

/// What follows a sign.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Then {
    /// The phase with this index.
    Phase(usize),
    /// The course is done.
    Done,
    /// The course has failed.
    Fail(&'static str),
}

/// One phase.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Phase {
    /// Name, as users see it.
    pub name: &'static str,
    /// Which side has the say.
    pub say: Say,
    /// Which light counts.
    pub light: Light,
    /// What ends it: the first sign that shows counts.
    ends: &'static [(Sign, Then)],
    /// Longest time in this phase, all its visits together, s (ours: several times what it takes), and what then follows.
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

/// The phases, in the order of the course, and those of a robot that lets another one pass.
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

/// How a course has ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ended {
    /// All phases are done.
    Done,
    /// It has failed, in these words.
    Failed(&'static str),
}

/// Walks one robot through the phases.
#[derive(Clone, Debug, Default)]
pub struct Coordinator {
    phase: usize,
    spent_s: [f64; PHASES.len()],
    ended: Option<Ended>,
}

impl Coordinator {
    /// The present phase.
    #[must_use]
    pub fn phase(&self) -> &'static Phase {
        &PHASES[self.phase]
    }

    /// How the course has ended, if it has.
    #[must_use]
    pub fn ended(&self) -> Option<Ended> {
        self.ended
    }

    /// Looks at the signs after `passed_s` more; whether another phase has begun.
    pub fn look(&mut self, signs: &Signs, passed_s: f64) -> bool {
        if self.ended.is_some() {
            return false;
        }
        let phase = self.phase();
        let spent_s = &mut self.spent_s[self.phase];
        *spent_s += passed_s;
        // Time counts before any sign: two phases whose signs lead to one another would go on for ever.
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

    /// Ends the course because of something that no phase looks for.
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

    /// Shows signs one after another and compares the phases that follow.
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
        // Signs that lead from one phase to another and back hold nothing up for ever.
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
