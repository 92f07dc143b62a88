//! Module 0 (paper II.b (2)): "provides an initial cap screwing task in which the fingers follow
//! the square trajectories in Fig. 5. This behavior is repeated until the behavior provided by
//! Module 4 is defined."
//!
//! ```text
//!            turn →
//!        ┌────────────┐ cap
//!     in │            │ out
//!        └────────────┘
//!           ← return
//! ```
//!
//! Seen from one side: in until modules 1 to 3 have a grip, turn, out, return. During the turn, the
//! distance of the side is a straight line minus an offset e(s). Closing by other modules there is
//! added to e(s), propagated forwards, and kept between turns. The line becomes the contour of the
//! cap (Fig. 6).
//!
//! A cap that does not descend during a turn has not engaged the thread. The next turns then carry
//! it around the place where it was put down, until it descends.
//!
//! Two reflexes keep the square on the cap: the side with the larger force opens, and the hand
//! presses lightly down to follow the thread. When the wrist rotates the hand, excessive force
//! slows the turn.

use super::{Context, Module, PoseCommand, Proposal, Roles};
use crate::filter::Dwell;
use crate::perception::Percept;
use crate::thresholds::Thresholds;
use core::f64::consts::PI;
use nalgebra::Vector3;
use robot_model::{GraspPose, GraspSide, PerSide};
use shm_schemas::ModuleId;

/// Samples of the offset along the turn (prototype: one per 0.5 mm).
const BINS: usize = 29;
/// Share of a correction that the two nearest bins receive (prototype).
const GAIN: f64 = 1.5;
/// Ratio of the correction between consecutive bins ahead (prototype); 1 for wrist rotation, where
/// the object stays between the fingertips.
const DECAY: f64 = 0.75;
/// Share of F_2 reached before wrist rotation (design choice). Straight fingertip paths reach it
/// while they pass a cap; wrist rotation does not raise the force.
const WRIST_GRIP_SHARE: f64 = 0.5;
/// Largest offset, m (prototype).
const OFFSET_MAX_M: f64 = 0.003;
/// Distance from the last grip at which Module 1 takes over closing, m (design choice).
const GRIP_GAP_M: f64 = 0.0005;
/// Largest turning distance from the tightening of the cap until the hand can respond, m. Design
/// choice: sensors of 140 Hz and more allow `screw.turn_m_s`.
const TIGHTENING_TRAVEL_M: f64 = 0.0001;
/// Acceleration time along an edge, s (design choice: 0.5 mm at 10 mm/s).
const RAMP_S: f64 = 0.1;
/// Vertical compliance of the hand, m/s per newton (design choice).
const CAP_FOLLOWING_M_S_N: f64 = 0.003;
/// Downward force on the cap, N (design choice: a few times the weight of a cap).
const CAP_PRESS_N: f64 = 0.3;
/// Largest vertical travel, m (design choice: more than any cap travels).
const CAP_TRAVEL_MAX_M: f64 = 0.008;
/// Descent of an engaged cap during a turn, m (design choice: half of a fine thread's).
pub(super) const ENGAGED_DESCENT_M: f64 = 0.0001;
/// Spiral of places at which a cap is sought to engage: radius of the first one and its growth per
/// place, m, angle between places, rad, and their number. Design choice: with a thread that
/// captures a cap within 2 mm, they cover place errors of up to 3.5 mm; a cap stays on its rim
/// meanwhile.
const SEARCH_RADIUS_M: f64 = 0.0010;
const SEARCH_GROWTH_M: f64 = 0.0001;
const SEARCH_TURN_RAD: f64 = PI / 3.0;
const SEARCH_PLACES: u32 = 12;

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
enum Edge {
    In,
    #[default]
    Grip,
    Turn,
    Out,
    Return,
    /// The cap engaged nowhere: the hand waits, open.
    Rest,
}

#[derive(Clone, Copy, Debug)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Trajectory {
    edge: Edge,
    /// Position on the edge, m, and speed, m/s.
    position_m: f64,
    speed_m_s: f64,
    first_grip: Option<GraspPose>,
    /// Offset e(s) of each side, m, positive inwards.
    inward_m: PerSide<[f64; BINS]>,
    /// Time for which the grip force has been sufficient, s.
    gripped: Dwell,
    /// Vertical travel with the cap, m; negative is down.
    cap_travel_m: f64,
    /// Vertical travel at the start of the turn, m.
    turn_start_m: f64,
    search: Search,
}

/// Search for the place at which a cap engages its thread.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
struct Search {
    engaged: bool,
    /// Indices of the places at the start and at the end of the turn.
    from: u32,
    to: u32,
}

impl Default for Trajectory {
    fn default() -> Self {
        Self {
            edge: Edge::default(),
            position_m: 0.0,
            speed_m_s: 0.0,
            first_grip: None,
            inward_m: PerSide::repeat([0.0; BINS]),
            gripped: Dwell::default(),
            cap_travel_m: 0.0,
            turn_start_m: 0.0,
            search: Search::default(),
        }
    }
}

impl Module for Trajectory {
    const ID: ModuleId = ModuleId::TRAJECTORY;
    const ROLES: Roles = Roles {
        moves_hand: true,
        closes_fingers: true,
        resets_each_step: true,
        ..Roles::NONE
    };

    fn evaluate(&mut self, percept: &Percept, context: &Context<'_>) -> Proposal {
        self.first_grip.get_or_insert(*context.hand.pose);
        match self.edge {
            Edge::Grip => self.grip(percept, context),
            Edge::Turn => self.adapt(percept, context),
            Edge::In | Edge::Out | Edge::Return | Edge::Rest => {}
        }
        if self.advance(percept, context) {
            self.start_next_edge(context);
        }
        let touching = matches!(self.edge, Edge::Grip | Edge::Turn);
        let waits = self.edge == Edge::Turn && waits_for_relief(percept, context);
        let presses =
            self.edge == Edge::Grip && context.hand.turns_by_wrist && self.gripped.seconds() == 0.0;
        let closing_m_s = if presses {
            context.settings.grasp.enhance_m_s
        } else {
            0.0
        };
        Proposal {
            active: true,
            closing_m_s: PerSide::repeat(closing_m_s),
            carry_ceiling: if waits {
                context.settings.grasp.slip_carry_scale
            } else {
                1.0
            },
            closing_ceiling_m_s: PerSide::repeat(if touching { f64::INFINITY } else { 0.0 }),
            pose: Some(PoseCommand {
                pose: self.pose(context),
                with_fingers: self.edge != Edge::Grip,
                arrived: false,
            }),
            ..Proposal::default()
        }
    }
}

impl Trajectory {
    /// Restarts from rest.
    pub(super) fn stop(&mut self) {
        self.speed_m_s = 0.0;
    }

    /// Measures how long the weaker side has pressed with the required force.
    fn grip(&mut self, percept: &Percept, context: &Context<'_>) {
        let (weakest_n, strongest_n) = percept.normal_range_n();
        let Thresholds { f1_n, f2_n, .. } = context.object.thresholds;
        let needed_n = if context.hand.turns_by_wrist {
            f1_n.max(WRIST_GRIP_SHARE * f2_n)
        } else {
            f1_n
        };
        let firm = weakest_n > needed_n || strongest_n > f2_n;
        self.gripped.update(firm, context.step_s);
        self.follow_cap(percept, context);
    }

    /// Adds the arbitrated closing and the centring reflex to the offset.
    fn adapt(&mut self, percept: &Percept, context: &Context<'_>) {
        let settings = &context.settings.screw;
        let place = self.position_m / (2.0 * settings.travel_m) * (BINS - 1) as f64;
        let normal_n = percept.sides.map(|finger| finger.normal_n);
        // While both sides open, the weaker one must not close.
        let centring_m_s_n = if waits_for_relief(percept, context) {
            0.0
        } else {
            settings.centring_m_s_n
        };
        for side in GraspSide::BOTH {
            let softer_n = (normal_n[side.opposite()] - normal_n[side]) / 2.0;
            let inwards_m_s = context.hand.closing_m_s[side] + centring_m_s_n * softer_n;
            add_correction(
                &mut self.inward_m[side],
                place,
                inwards_m_s * context.step_s,
                decay(context),
            );
        }
        self.follow_cap(percept, context);
    }

    /// Follows the cap along its thread with a light downward force.
    fn follow_cap(&mut self, percept: &Percept, context: &Context<'_>) {
        if !percept.sides.iter().all(|f| f.in_contact) {
            return;
        }
        let followed_m_s =
            CAP_FOLLOWING_M_S_N * (percept.force_up_n(context.hand.base_from_tip) - CAP_PRESS_N);
        let followed_m = self.cap_travel_m + followed_m_s * context.step_s;
        self.cap_travel_m = followed_m.clamp(-CAP_TRAVEL_MAX_M, CAP_TRAVEL_MAX_M);
    }

    /// Advances along the edge; true at its end. Slip and excessive force slow only the turn.
    fn advance(&mut self, percept: &Percept, context: &Context<'_>) -> bool {
        let settings = &context.settings.screw;
        let (length_m, top_m_s) = match self.edge {
            Edge::Grip => return self.gripped.seconds() >= settings.grip_s,
            Edge::Rest => return false,
            Edge::In => (settings.clearance_m - GRIP_GAP_M, settings.in_m_s),
            Edge::Turn => {
                let responsive_m_s =
                    percept.touch_speed_m_s(TIGHTENING_TRAVEL_M, 1, context.settings);
                (
                    2.0 * settings.travel_m,
                    settings.turn_m_s.min(responsive_m_s),
                )
            }
            Edge::Out => (settings.clearance_m, settings.out_m_s),
            Edge::Return => (2.0 * settings.travel_m, settings.return_m_s),
        };
        let scale = if self.edge == Edge::Turn {
            context.hand.carry_scale.max(0.0)
        } else {
            1.0
        };
        let ramp_m_s2 = top_m_s / RAMP_S;
        let left_m = (length_m - self.position_m).max(0.0);
        // Keeps a minimum speed to reach the end.
        let braking_m_s =
            libm::sqrt(2.0 * ramp_m_s2 * left_m).max(top_m_s * context.step_s / RAMP_S);
        self.speed_m_s = (self.speed_m_s + ramp_m_s2 * context.step_s)
            .min(top_m_s)
            .min(braking_m_s);
        self.position_m = (self.position_m + self.speed_m_s * scale * context.step_s).min(length_m);
        self.position_m >= length_m
    }

    fn start_next_edge(&mut self, context: &Context<'_>) {
        match self.edge {
            Edge::Grip => {
                self.adopt_grip(context.hand.pose, decay(context));
                self.turn_start_m = self.cap_travel_m;
            }
            Edge::Turn => {
                let descent_m = self.turn_start_m - self.cap_travel_m;
                self.search.engaged |= descent_m > ENGAGED_DESCENT_M;
            }
            Edge::In | Edge::Out | Edge::Return | Edge::Rest => {}
        }
        self.edge = match self.edge {
            Edge::In => Edge::Grip,
            Edge::Grip => Edge::Turn,
            Edge::Turn => Edge::Out,
            Edge::Out => Edge::Return,
            Edge::Return if self.search.is_over() => Edge::Rest,
            Edge::Return => {
                self.search.advance();
                Edge::In
            }
            Edge::Rest => Edge::Rest,
        };
        (self.position_m, self.speed_m_s) = (0.0, 0.0);
        self.gripped = Dwell::default();
    }

    /// Starts the turn at the opening at which the grip was reached.
    fn adopt_grip(&mut self, now: &GraspPose, decay: f64) {
        let Some(anchor) = self.first_grip else {
            return;
        };
        for side in GraspSide::BOTH {
            let gripped_m = anchor.half_opening_m[side] - now.half_opening_m[side];
            let news_m = gripped_m - self.inward_m[side][0];
            let mut share = 1.0;
            for inward_m in &mut self.inward_m[side] {
                *inward_m += news_m * share;
                share *= decay;
            }
        }
    }

    fn pose(&self, context: &Context<'_>) -> GraspPose {
        let settings = &context.settings.screw;
        let mut frame = self.first_grip.unwrap_or(*context.hand.pose);
        let (clearance_m, travel_m) = (settings.clearance_m, settings.travel_m);
        let way = self.position_m / (2.0 * travel_m);
        let (along, away_m) = match self.edge {
            Edge::In => (0.0, clearance_m - self.position_m),
            Edge::Grip => (0.0, 0.0),
            Edge::Turn => (way, 0.0),
            Edge::Out => (1.0, self.position_m),
            Edge::Return => (1.0 - way, clearance_m),
            Edge::Rest => (0.0, clearance_m),
        };
        let turned_m = context.turning * travel_m * (2.0 * along - 1.0);
        frame.tangential_m = PerSide::new(turned_m, -turned_m);
        frame.centre_m.z += self.cap_travel_m;
        let carried = match self.edge {
            Edge::In | Edge::Grip => 0.0,
            Edge::Turn => along,
            Edge::Out | Edge::Return | Edge::Rest => 1.0,
        };
        frame.centre_m += self.search.offset_m(carried);
        for side in GraspSide::BOTH {
            let inward_m = match self.edge {
                Edge::Return | Edge::Rest => {
                    interpolate(self.inward_m[side][0], self.inward_m[side][BINS - 1], along)
                }
                _ => offset_at(&self.inward_m[side], along * (BINS - 1) as f64),
            };
            frame.half_opening_m[side] += away_m - inward_m;
        }
        frame
    }
}

impl Search {
    /// The cap engaged at no place.
    fn is_over(self) -> bool {
        !self.engaged && self.to == SEARCH_PLACES
    }

    /// Begins a turn: it carries a cap that has not engaged to the next place.
    fn advance(&mut self) {
        self.from = self.to;
        self.to += u32::from(!self.engaged);
    }

    /// Returns the horizontal offset after this share of the turn, m.
    fn offset_m(self, share: f64) -> Vector3<f64> {
        let from_m = place_m(self.from);
        from_m + (place_m(self.to) - from_m) * share
    }
}

/// Returns a place of the search, m; the first one is the commanded place.
fn place_m(index: u32) -> Vector3<f64> {
    if index == 0 {
        return Vector3::zeros();
    }
    let (sin, cos) = libm::sincos(SEARCH_TURN_RAD * f64::from(index));
    let radius_m = SEARCH_RADIUS_M + SEARCH_GROWTH_M * f64::from(index);
    Vector3::new(cos, sin, 0.0) * radius_m
}

fn decay(context: &Context<'_>) -> f64 {
    if context.hand.turns_by_wrist {
        1.0
    } else {
        DECAY
    }
}

/// Returns whether Module 3 opens fingers above F_2 during wrist rotation. On straight paths the
/// fingertips leave the cap by themselves.
fn waits_for_relief(percept: &Percept, context: &Context<'_>) -> bool {
    let (_, strongest_n) = percept.normal_range_n();
    let opens = context
        .hand
        .closing_m_s
        .iter()
        .any(|closing| *closing < 0.0);
    context.hand.turns_by_wrist && opens && strongest_n > context.object.thresholds.f2_n
}

fn offset_at(inward_m: &[f64; BINS], place: f64) -> f64 {
    let bin = (place as usize).min(BINS - 2);
    interpolate(inward_m[bin], inward_m[bin + 1], place - bin as f64)
}

fn interpolate(a: f64, b: f64, share: f64) -> f64 {
    a + (b - a) * share
}

/// Adds a correction between two bins and decreasing shares of it to the bins ahead.
fn add_correction(inward_m: &mut [f64; BINS], place: f64, by_m: f64, decay: f64) {
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
