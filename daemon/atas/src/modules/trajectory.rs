//! Module 0 (paper II.b (2)): "provides an initial cap screwing task in which the fingers follow the square trajectories in
//! Fig. 5. This behavior is repeated until the behavior provided by Module 4 is defined."
//!
//! ```text
//!            turn →               Seen from one finger: in until modules 1 to 3 have a grip, turn, out, return.
//!        ┌────────────┐ cap       Along the turn the finger's distance is a straight line minus a learnt offset e(s).
//!     in │            │ out       Whatever the other modules make the fingers do there is learnt into e(s), spread
//!        └────────────┘           forwards, and kept between turns: the straight line becomes the cap's contour (Fig. 6).
//!           ← return
//! ```
//!
//! Two reflexes keep the square on the cap: a finger that presses harder than the other gives way, and the hand presses
//! lightly down, so that it follows the cap along its thread. Where the wrist turns the hand, what is pressed too hard is relieved
//! before the turn goes on.

use super::{Context, Module, PoseCommand, Proposal, Roles, force_range_n, force_up_n};
use crate::perception::Percept;
use crate::thresholds::Thresholds;
use robot_model::{GraspFrame, VIRTUAL_FINGERS};
use shm_schemas::ModuleId;

/// Samples of the learnt offset along the turn (prototype: 29, one per half millimetre).
const BINS: usize = 29;
/// Share of a correction that the bins at hand take (prototype).
const GAIN: f64 = 1.5;
/// Share of a correction that each further bin takes of the one before (prototype); where the wrist turns the hand, all take the
/// same, because then what the fingertips hold stays between them.
const DECAY: f64 = 0.75;
/// Share of F_2 with which a hand grips before its wrist turns it (ours: fingertips that go straight past a cap are pressed on it half
/// as hard by the time they have passed; a hand that turns as a whole is not).
const WRIST_GRIP_SHARE: f64 = 0.5;
/// Largest learnt offset, m (prototype).
const OFFSET_MAX_M: f64 = 0.003;
/// Distance from the last grip at which Module 1 takes over the closing, m (ours).
const GRIP_GAP_M: f64 = 0.0005;
/// Time in which the speed along an edge builds up, s (ours: half a millimetre at 10 mm/s).
const RAMP_S: f64 = 0.1;
/// Speed at which the hand follows a vertical force, m/s per newton (ours).
const FOLLOW_M_S_N: f64 = 0.003;
/// Force with which the hand presses the cap down, N (ours: a few times a cap's weight).
const PRESS_N: f64 = 0.3;
/// Farthest that the hand follows the cap, m (ours: more than any cap travels).
const FOLLOW_MAX_M: f64 = 0.008;

/// The edges of the square.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
enum Edge {
    /// Towards the cap.
    In,
    /// At the cap, until the grip is firm.
    #[default]
    Grip,
    /// With the cap.
    Turn,
    /// Away from the cap.
    Out,
    /// Back to where the turn began.
    Return,
}

/// Where on its square the hand is, and what it has learnt.
#[derive(Clone, Copy, Debug)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Trajectory {
    edge: Edge,
    /// Way along the edge, m, and speed, m/s.
    way_m: f64,
    speed_m_s: f64,
    /// The pose of the first grip.
    anchor: Option<GraspFrame>,
    /// e(s) of each finger, m, inwards.
    inward_m: [[f64; BINS]; VIRTUAL_FINGERS],
    /// How long the grip has been firm, s.
    gripped_s: f64,
    /// How far the hand has followed the cap down, m, negative.
    followed_m: f64,
}

impl Default for Trajectory {
    fn default() -> Self {
        Self {
            edge: Edge::default(),
            way_m: 0.0,
            speed_m_s: 0.0,
            anchor: None,
            inward_m: [[0.0; BINS]; VIRTUAL_FINGERS],
            gripped_s: 0.0,
            followed_m: 0.0,
        }
    }
}

impl Module for Trajectory {
    const ID: ModuleId = ModuleId::TRAJECTORY;
    const ROLES: Roles = Roles {
        moves_hand: true,
        closes_fingers: true,
        forgets_each_step: true,
        ..Roles::NONE
    };

    fn evaluate(&mut self, percept: &Percept, context: &Context<'_>) -> Proposal {
        self.anchor.get_or_insert(*context.frame);
        match self.edge {
            Edge::Grip => self.grip(percept, context),
            Edge::Turn => self.learn(percept, context),
            Edge::In | Edge::Out | Edge::Return => {}
        }
        if self.advance(context) {
            self.turn_corner(context);
        }
        let touching = matches!(self.edge, Edge::Grip | Edge::Turn);
        let waits = self.edge == Edge::Turn && is_relieved(percept, context);
        let presses = self.edge == Edge::Grip && context.turns_by_wrist && self.gripped_s == 0.0;
        let closing_m_s = if presses {
            context.settings.grasp.enhance_m_s
        } else {
            0.0
        };
        Proposal {
            active: true,
            closing_m_s: [closing_m_s; VIRTUAL_FINGERS],
            carry_ceiling: if waits {
                context.settings.grasp.slip_carry_scale
            } else {
                1.0
            },
            closing_ceiling_m_s: [if touching { f64::INFINITY } else { 0.0 }; VIRTUAL_FINGERS],
            pose: Some(PoseCommand {
                frame: self.frame(context),
                with_fingers: self.edge != Edge::Grip,
                arrived: false,
            }),
            ..Proposal::default()
        }
    }
}

impl Trajectory {
    /// Goes on from where it is, from rest.
    pub(super) fn halt(&mut self) {
        self.speed_m_s = 0.0;
    }

    /// Waits until the weakest finger has pressed hard enough for a while.
    fn grip(&mut self, percept: &Percept, context: &Context<'_>) {
        let (weakest_n, strongest_n) = force_range_n(percept);
        let Thresholds { f1_n, f2_n, .. } = context.thresholds;
        let needed_n = if context.turns_by_wrist {
            f1_n.max(WRIST_GRIP_SHARE * f2_n)
        } else {
            f1_n
        };
        let firm = weakest_n > needed_n || strongest_n > f2_n;
        self.gripped_s = if firm {
            self.gripped_s + context.step_s
        } else {
            0.0
        };
        self.follow(percept, context);
    }

    /// Takes what arbitration made the fingers do, and the two reflexes, into the trajectory.
    fn learn(&mut self, percept: &Percept, context: &Context<'_>) {
        let settings = &context.settings.screw;
        let place = self.way_m / (2.0 * settings.travel_m) * (BINS - 1) as f64;
        let normal_n = percept.virtual_fingers.map(|finger| finger.normal_n);
        // Where both give way, the softer one does not press on.
        let centring_m_s_n = if is_relieved(percept, context) {
            0.0
        } else {
            settings.centring_m_s_n
        };
        for finger in 0..VIRTUAL_FINGERS {
            let softer_n = (normal_n[1 - finger] - normal_n[finger]) / 2.0;
            let inwards_m_s = context.closing_m_s[finger] + centring_m_s_n * softer_n;
            correct(
                &mut self.inward_m[finger],
                place,
                inwards_m_s * context.step_s,
                decay(context),
            );
        }
        self.follow(percept, context);
    }

    /// Presses lightly down on the cap: follows it along its thread, and never pulls it off before the thread holds it.
    fn follow(&mut self, percept: &Percept, context: &Context<'_>) {
        if !percept.virtual_fingers.iter().all(|f| f.in_contact) {
            return;
        }
        let followed_m_s = FOLLOW_M_S_N * (force_up_n(percept, context.base_from_tip) - PRESS_N);
        let followed_m = self.followed_m + followed_m_s * context.step_s;
        self.followed_m = followed_m.clamp(-FOLLOW_MAX_M, FOLLOW_MAX_M);
    }

    /// Moves along the edge; true at its end. Only the turn waits for slip and too much force to be answered.
    fn advance(&mut self, context: &Context<'_>) -> bool {
        let settings = &context.settings.screw;
        let (length_m, top_m_s) = match self.edge {
            Edge::Grip => return self.gripped_s >= settings.grip_s,
            Edge::In => (settings.clearance_m - GRIP_GAP_M, settings.in_m_s),
            Edge::Turn => (2.0 * settings.travel_m, settings.turn_m_s),
            Edge::Out => (settings.clearance_m, settings.out_m_s),
            Edge::Return => (2.0 * settings.travel_m, settings.return_m_s),
        };
        let scale = if self.edge == Edge::Turn {
            context.carry_scale.max(0.0)
        } else {
            1.0
        };
        let ramp_m_s2 = top_m_s / RAMP_S;
        let left_m = (length_m - self.way_m).max(0.0);
        // Slow enough to stop at the end, and never so slow as not to get there.
        let braking_m_s =
            libm::sqrt(2.0 * ramp_m_s2 * left_m).max(top_m_s * context.step_s / RAMP_S);
        self.speed_m_s = (self.speed_m_s + ramp_m_s2 * context.step_s)
            .min(top_m_s)
            .min(braking_m_s);
        self.way_m = (self.way_m + self.speed_m_s * scale * context.step_s).min(length_m);
        self.way_m >= length_m
    }

    fn turn_corner(&mut self, context: &Context<'_>) {
        if self.edge == Edge::Grip {
            self.adopt_grip(context.frame, decay(context));
        }
        self.edge = match self.edge {
            Edge::In => Edge::Grip,
            Edge::Grip => Edge::Turn,
            Edge::Turn => Edge::Out,
            Edge::Out => Edge::Return,
            Edge::Return => Edge::In,
        };
        (self.way_m, self.speed_m_s, self.gripped_s) = (0.0, 0.0, 0.0);
    }

    /// The turn begins where the grip was found firm.
    fn adopt_grip(&mut self, now: &GraspFrame, decay: f64) {
        let Some(anchor) = self.anchor else { return };
        for finger in 0..VIRTUAL_FINGERS {
            let gripped_m = anchor.half_opening_m[finger] - now.half_opening_m[finger];
            let news_m = gripped_m - self.inward_m[finger][0];
            let mut share = 1.0;
            for inward_m in &mut self.inward_m[finger] {
                *inward_m += news_m * share;
                share *= decay;
            }
        }
    }

    /// The pose on the square.
    fn frame(&self, context: &Context<'_>) -> GraspFrame {
        let settings = &context.settings.screw;
        let mut frame = self.anchor.unwrap_or(*context.frame);
        let (clearance_m, travel_m) = (settings.clearance_m, settings.travel_m);
        let way = self.way_m / (2.0 * travel_m);
        let (along, away_m) = match self.edge {
            Edge::In => (0.0, clearance_m - self.way_m),
            Edge::Grip => (0.0, 0.0),
            Edge::Turn => (way, 0.0),
            Edge::Out => (1.0, self.way_m),
            Edge::Return => (1.0 - way, clearance_m),
        };
        let turned_m = context.turning * travel_m * (2.0 * along - 1.0);
        frame.tangential_m = [turned_m, -turned_m];
        frame.centre_m.z += self.followed_m;
        for finger in 0..VIRTUAL_FINGERS {
            let inward_m = match self.edge {
                Edge::Return => mix(
                    self.inward_m[finger][0],
                    self.inward_m[finger][BINS - 1],
                    along,
                ),
                _ => at(&self.inward_m[finger], along * (BINS - 1) as f64),
            };
            frame.half_opening_m[finger] += away_m - inward_m;
        }
        frame
    }
}

/// Share of a correction that each further bin takes of the one before.
fn decay(context: &Context<'_>) -> f64 {
    if context.turns_by_wrist { 1.0 } else { DECAY }
}

/// Whether Module 3 opens fingers that press with more than F_2, of a hand that turns as a whole: nothing but that ends their pressing,
/// where fingertips that go past a cap leave it by themselves.
fn is_relieved(percept: &Percept, context: &Context<'_>) -> bool {
    let (_, strongest_n) = force_range_n(percept);
    let opens = context.closing_m_s.iter().any(|closing| *closing < 0.0);
    context.turns_by_wrist && opens && strongest_n > context.thresholds.f2_n
}

/// The offset at a place between two bins.
fn at(inward_m: &[f64; BINS], place: f64) -> f64 {
    let bin = (place as usize).min(BINS - 2);
    mix(inward_m[bin], inward_m[bin + 1], place - bin as f64)
}

fn mix(a: f64, b: f64, share: f64) -> f64 {
    a + (b - a) * share
}

/// Adds a correction at a place between two bins, and less and less of it to the bins ahead.
fn correct(inward_m: &mut [f64; BINS], place: f64, by_m: f64, decay: f64) {
    let bin = (place as usize).min(BINS - 2);
    let beyond = place - bin as f64;
    let mut ahead = 1.0;
    for (index, inward_m) in inward_m.iter_mut().enumerate().skip(bin) {
        let share = match index - bin {
            0 => GAIN * (1.0 - beyond),
            1 => GAIN * beyond,
            _ => {
                ahead *= decay;
                ahead
            }
        };
        *inward_m = (*inward_m + by_m * share).clamp(-OFFSET_MAX_M, OFFSET_MAX_M);
    }
}
