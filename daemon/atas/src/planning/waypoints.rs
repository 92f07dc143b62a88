//! The poses that a goal's steps refer to by name.

use crate::goal::Goal;
use crate::path::{PEAK_OF_MEAN, at_height, reachable_yaw_rad};
use crate::settings::Settings;
use crate::tasks::Waypoint;
use core::f64::consts::FRAC_PI_2;
use nalgebra::{Vector2, Vector3};
use robot_model::{GraspFrame, HandModel};
use shm_schemas::{GoalRequest, Turn};

/// Lowest centre of a grasp, m (ours: the dome's radius and 3 mm of air).
const LOWEST_M: f64 = 0.018;

/// Air between fingertips and the top of what they come over, m (ours: what places and heights may be wrong by).
pub(crate) const OVER_TOP_M: f64 = 0.010;

/// How far two arms may disagree about where one place is, m (ours: links that are not as long as their model's, by up to 1 mm each).
/// What one hand feels to be displaced by less stands for the other where it was told.
const ARMS_AGREE_M: f64 = 0.0015;

/// Share of the fingers' speed that a path may take (ours: the rest is for what the modules correct).
const FINGER_SPEED_SHARE: f64 = 0.8;

/// Height of a grasp from the side, m; pitch of the hand below the horizontal and angle of the finger roots, rad (robot
/// design: proved free of collisions with the hand that screws).
const SIDE_HEIGHT_M: f64 = 0.045;
const SIDE_PITCH_RAD: f64 = core::f64::consts::FRAC_PI_4;
const SIDE_ROOT_RAD: f64 = -27.5 * core::f64::consts::PI / 180.0;
/// Opening of each finger before a grasp from the side, and how far behind and above it begins, m (robot design).
const SIDE_OPENING_M: f64 = 0.020;
const SIDE_BEHIND_M: f64 = 0.10;
const SIDE_ABOVE_M: f64 = 0.03;

/// The poses of one goal.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Waypoints {
    tilted: GraspFrame,
    before: GraspFrame,
    around: GraspFrame,
    source: GraspFrame,
    turn_start_m: f64,
    over_target: GraspFrame,
    home: GraspFrame,
    descend_m: f64,
    lift_m: f64,
    lowering_m: f64,
    expected_m: f64,
    turning: f64,
    /// How far each finger can open, m.
    widest_half_m: f64,
    /// How fast its joints let each finger open and close, m/s.
    finger_m_s: f64,
    /// Where the object was told to stand, base frame, m.
    told_m: Vector2<f64>,
    corrections: Corrections,
}

/// What touch may change of where a goal leads the hand, and has.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
struct Corrections {
    /// How far the hand may grasp beside where it was told, m.
    spare_m: f64,
    /// The other hand takes part: what this one holds goes onto what that one does.
    joins: bool,
    /// From the middle of the hand to that of what it holds, along its closing axis and 90° anticlockwise of that, m.
    held_off_m: Vector2<f64>,
    /// From where the target was told to where it stands, base frame, m.
    target_off_m: Vector2<f64>,
}

impl Waypoints {
    /// The poses of a goal for one of its hands, and the width of what that hand grasps, m.
    #[must_use]
    pub fn of(hand: &HandModel, now: &GraspFrame, goal: &Goal, settings: &Settings) -> (Self, f64) {
        let (request, home) = (goal.request(), home(hand, now));
        let corrections = Corrections {
            spare_m: goal.spare_m(),
            joins: goal.demands().both_hands,
            ..Corrections::default()
        };
        let within = |waypoints| Self {
            corrections,
            ..waypoints
        };
        if hand.side() != goal.side() {
            let waypoints = Self::helping(hand, home, request, settings);
            return (within(waypoints), request.helper_width_m);
        }
        let stays = !(goal.demands().visits_source || goal.demands().visits_target);
        let waypoints = if stays {
            Self::resting(hand, *now, home, settings)
        } else {
            Self::new(hand, now, home, goal, settings)
        };
        (within(waypoints), request.width_m)
    }

    /// The poses of a checked goal for a hand that is at `now` and rests at `home`.
    #[must_use]
    pub fn new(
        hand: &HandModel,
        now: &GraspFrame,
        home: GraspFrame,
        goal: &Goal,
        settings: &Settings,
    ) -> Self {
        let (request, motion) = (goal.request(), &settings.motion);
        let opening_m = request.width_m + 2.0 * motion.clearance_m;
        let mut source = from_above(hand, now, request.from_m, request.from_yaw_rad, opening_m);
        // A turn begins at the far end of its travel.
        let start_m = -request.turn.sign() * settings.screw.travel_m;
        if goal.demands().grasps_to_turn {
            source.tangential_m = [start_m, -start_m];
        }
        let (to_m, to_yaw_rad) = goal.destination();
        let descend_m = descent_m(hand, request, settings);
        let travel_m = goal.travel_height_m();
        let over_m = [to_m[0], to_m[1], travel_m];
        let lowest_m = (to_m[2] - settings.place.search_m).max(LOWEST_M);
        Self {
            tilted: home,
            before: raised(&source, descend_m),
            around: source,
            turn_start_m: start_m,
            source,
            over_target: from_above(hand, &source, over_m, to_yaw_rad, opening_m),
            home,
            descend_m,
            lift_m: travel_m - request.from_m[2],
            lowering_m: (travel_m - lowest_m).max(0.0),
            expected_m: to_m[2],
            turning: request.turn.sign(),
            widest_half_m: hand.widest_m() / 2.0,
            finger_m_s: hand.finger_speed_m_s(),
            told_m: source.centre_m.xy(),
            corrections: Corrections::default(),
        }
    }

    /// The poses of the hand that holds the bottle of a checked assembly, from the side.
    #[must_use]
    pub fn helping(
        hand: &HandModel,
        home: GraspFrame,
        goal: &GoalRequest,
        settings: &Settings,
    ) -> Self {
        let source = from_the_side(hand, goal, settings.motion.clearance_m);
        let around = from_the_side(hand, goal, SIDE_OPENING_M);
        let (sin, cos) = libm::sincos(around.hand_azimuth_rad);
        let behind_m = Vector3::new(-SIDE_BEHIND_M * cos, -SIDE_BEHIND_M * sin, SIDE_ABOVE_M);
        let centre_m = around.centre_m + behind_m;
        Self {
            tilted: pointing(
                hand,
                GraspFrame {
                    centre_m: home.centre_m,
                    ..around
                },
            ),
            before: GraspFrame { centre_m, ..around },
            around,
            source,
            ..Self::resting(hand, source, home, settings)
        }
    }

    /// The poses of a hand that only opens and goes home.
    #[must_use]
    pub fn resting(
        hand: &HandModel,
        now: GraspFrame,
        home: GraspFrame,
        settings: &Settings,
    ) -> Self {
        Self {
            tilted: home,
            before: raised(&now, settings.motion.descend_m),
            around: now,
            turn_start_m: 0.0,
            source: now,
            over_target: now,
            home,
            descend_m: settings.motion.descend_m,
            lift_m: 0.0,
            lowering_m: 0.0,
            expected_m: now.centre_m.z,
            turning: Turn::CLOCKWISE.sign(),
            widest_half_m: hand.widest_m() / 2.0,
            finger_m_s: hand.finger_speed_m_s(),
            told_m: now.centre_m.xy(),
            corrections: Corrections::default(),
        }
    }

    /// The pose of a waypoint, for a hand that is at `now`.
    #[must_use]
    pub fn pose(&self, waypoint: Waypoint, now: &GraspFrame) -> GraspFrame {
        match waypoint {
            Waypoint::Tilted => self.tilted,
            Waypoint::BeforeSource => self.before,
            Waypoint::Around => self.around,
            Waypoint::Source => self.source,
            Waypoint::Lifted => raised(&self.source, self.lift_m),
            Waypoint::OverTarget => self.over_target(),
            Waypoint::TurnStart => GraspFrame {
                half_opening_m: self.source.half_opening_m,
                tangential_m: [self.turn_start_m, -self.turn_start_m],
                ..*now
            },
            Waypoint::Above => raised(now, self.descend_m),
            Waypoint::Home => self.home,
        }
    }

    /// The hand opened by so much on each side, m, as far as it opens; never closed.
    #[must_use]
    pub fn opened(&self, now: &GraspFrame, by_m: f64) -> GraspFrame {
        let widest_m = self.widest_half_m;
        GraspFrame {
            half_opening_m: now
                .half_opening_m
                .map(|half_m| (half_m + by_m).min(half_m.max(widest_m))),
            ..*now
        }
    }

    /// Mean speed of a path on which the fingers keep up with what is commanded: what a drive that lags behind leaves undone, the
    /// arm would try to do.
    #[must_use]
    pub fn finger_speed_m_s(&self, wanted_m_s: f64) -> f64 {
        wanted_m_s.min(FINGER_SPEED_SHARE * self.finger_m_s / PEAK_OF_MEAN)
    }

    /// Over where the target stands, with the middle of the object above its middle.
    fn over_target(&self) -> GraspFrame {
        let axis = self.over_target.closing_axis().xy();
        let across = Vector2::new(-axis.y, axis.x);
        let Corrections {
            held_off_m,
            target_off_m,
            ..
        } = self.corrections;
        let off_m = target_off_m - axis * held_off_m.x - across * held_off_m.y;
        moved(&self.over_target, &off_m)
    }

    /// The object was felt to stand there, base frame, m, its faces turned, rad: it is grasped there.
    pub fn grasp_at(&mut self, at_m: &Vector2<f64>, turn_rad: f64) {
        self.shift_source(&(at_m - self.source.centre_m.xy()));
        self.corrections.held_off_m = Vector2::zeros();
        for frame in [&mut self.before, &mut self.around, &mut self.source] {
            frame.closing_yaw_rad += turn_rad;
        }
    }

    /// The object is grasped that far aside, m: 90° anticlockwise of the closing axis.
    pub fn grasp_aside(&mut self, by_m: f64, axis: &Vector2<f64>) {
        self.shift_source(&(Vector2::new(-axis.y, axis.x) * by_m));
        self.corrections.held_off_m.y -= by_m;
    }

    fn shift_source(&mut self, by_m: &Vector2<f64>) {
        for frame in [&mut self.before, &mut self.around, &mut self.source] {
            *frame = moved(frame, by_m);
        }
    }

    /// What the hand holds was felt to be beside its middle, along its closing axis, m.
    pub fn hold_beside(&mut self, off_m: f64) {
        self.corrections.held_off_m.x = off_m;
    }

    /// What the other hand holds stands beside where it was told, base frame, m: so does the target, if it is that.
    pub fn displace_target(&mut self, off_m: Vector2<f64>) {
        if self.corrections.joins {
            let is_known = off_m.norm() > ARMS_AGREE_M;
            self.corrections.target_off_m = if is_known { off_m } else { Vector2::zeros() };
        }
    }

    /// How far the hand may grasp beside where it was told, m.
    #[must_use]
    pub fn spare_m(&self) -> f64 {
        self.corrections.spare_m
    }

    /// Whether what the hand holds goes onto what the other one holds.
    #[must_use]
    pub fn joins(&self) -> bool {
        self.corrections.joins
    }

    /// Where the object was told to stand, base frame, m.
    #[must_use]
    pub fn told_m(&self) -> Vector2<f64> {
        self.told_m
    }

    /// How far the hand may go down from over the target, m.
    #[must_use]
    pub fn lowering_m(&self) -> f64 {
        self.lowering_m
    }

    /// Sense of turning, seen from above: 1 anticlockwise, −1 clockwise.
    #[must_use]
    pub fn turning(&self) -> f64 {
        self.turning
    }

    /// Height of the grasp at which the object is expected to stand at the target, m.
    #[must_use]
    pub fn expected_m(&self) -> f64 {
        self.expected_m
    }
}

/// How far above its grasp a hand comes from, m: over the object's top, as far as the goal tells it.
#[must_use]
pub(crate) fn descent_m(hand: &HandModel, goal: &GoalRequest, settings: &Settings) -> f64 {
    if goal.top_m <= 0.0 {
        return settings.motion.descend_m;
    }
    let dome_m = hand.tip_radius_m().iter().copied().fold(0.0, f64::max);
    (goal.top_m + dome_m + OVER_TOP_M).max(settings.motion.descend_m)
}

/// Where an arm rests, for a hand that is at `now`: before its own shoulder, out of the other arm's way.
#[must_use]
pub fn home(hand: &HandModel, now: &GraspFrame) -> GraspFrame {
    from_above(
        hand,
        now,
        hand.home_m().into(),
        hand.home_yaw_rad(),
        hand.home_opening_m(),
    )
}

/// The helping hand's grasp of the bottle: from the side, coming from its own shoulder.
#[must_use]
pub fn from_the_side(hand: &HandModel, goal: &GoalRequest, clearance_m: f64) -> GraspFrame {
    let centre_m = Vector3::new(goal.to_m[0], goal.to_m[1], SIDE_HEIGHT_M);
    let opening_m = goal.helper_width_m + 2.0 * clearance_m;
    let grasp = GraspFrame {
        hand_pitch_rad: SIDE_PITCH_RAD,
        root_rad: SIDE_ROOT_RAD,
        ..GraspFrame::from_above(centre_m, 0.0, opening_m)
    };
    pointing(hand, grasp)
}

/// The same pose with the hand pointing straight away from its shoulder, fingers to its left and right.
fn pointing(hand: &HandModel, frame: GraspFrame) -> GraspFrame {
    let azimuth_rad = hand.bearing_rad(&frame.centre_m);
    GraspFrame {
        hand_azimuth_rad: azimuth_rad,
        closing_yaw_rad: azimuth_rad + FRAC_PI_2,
        ..frame
    }
}

/// A grasp from straight above, with the yaw that the hand reaches from `now`.
fn from_above(
    hand: &HandModel,
    now: &GraspFrame,
    centre_m: [f64; 3],
    yaw_rad: f64,
    opening_m: f64,
) -> GraspFrame {
    let centre_m = Vector3::from(centre_m);
    let yaw_rad = reachable_yaw_rad(hand, now, &centre_m, yaw_rad);
    GraspFrame {
        hand_azimuth_rad: hand.bearing_rad(&centre_m),
        ..GraspFrame::from_above(centre_m, yaw_rad, opening_m)
    }
}

fn moved(frame: &GraspFrame, by_m: &Vector2<f64>) -> GraspFrame {
    let by_m = Vector3::new(by_m.x, by_m.y, 0.0);
    GraspFrame {
        centre_m: frame.centre_m + by_m,
        ..*frame
    }
}

fn raised(frame: &GraspFrame, by_m: f64) -> GraspFrame {
    at_height(frame, frame.centre_m.z + by_m)
}
