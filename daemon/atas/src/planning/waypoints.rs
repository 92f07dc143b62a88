//! Grasp poses of the named waypoints of a goal.

use crate::goal::Goal;
use crate::path::{PEAK_TO_MEAN_SPEED, reachable_yaw_rad, with_height};
use crate::settings::Settings;
use crate::tasks::Waypoint;
use core::f64::consts::FRAC_PI_2;
use nalgebra::{Vector2, Vector3};
use robot_model::{GraspPose, GraspSide, HandModel, PerSide};
use shm_schemas::{GoalRequest, Turn};

/// Minimum height of a grasp centre, m (design choice: fingertip radius plus 3 mm).
const GRASP_HEIGHT_MIN_M: f64 = 0.018;

/// Vertical clearance between fingertips and object top, m (design choice: covers errors of the
/// commanded place and height).
pub(crate) const TOP_CLEARANCE_M: f64 = 0.010;

/// Position disagreement between two arms, m (design choice: link length errors of up to 1 mm
/// each). Smaller target shifts are ignored.
const ARM_DISAGREEMENT_M: f64 = 0.0015;

/// Share of the finger speed available to a path (design choice: modules use the rest).
const FINGER_SPEED_SHARE: f64 = 0.8;

/// Height, m, pitch below the horizontal and finger root angle, rad, of a side grasp (robot design:
/// free of collisions with the screwing hand).
const SIDE_HEIGHT_M: f64 = 0.045;
const SIDE_PITCH_RAD: f64 = core::f64::consts::FRAC_PI_4;
const SIDE_ROOT_RAD: f64 = -27.5 * core::f64::consts::PI / 180.0;
/// Opening before a side grasp, and start position behind and above it, m (robot design).
const SIDE_OPENING_M: f64 = 0.020;
const SIDE_BEHIND_M: f64 = 0.10;
const SIDE_ABOVE_M: f64 = 0.03;

/// Grasp poses of one goal.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Waypoints {
    tilted: GraspPose,
    before_source: GraspPose,
    around: GraspPose,
    source: GraspPose,
    turn_start_m: f64,
    over_target: GraspPose,
    home: GraspPose,
    descend_m: f64,
    lift_m: f64,
    lowering_m: f64,
    expected_height_m: f64,
    turning: f64,
    /// Maximum opening of each grasp side, m.
    max_half_opening_m: f64,
    /// Maximum closing and opening speed of each grasp side, m/s.
    finger_m_s: f64,
    wrist_turn_radius_m: Option<f64>,
    /// Commanded object position, base frame, m.
    commanded_m: Vector2<f64>,
    corrections: Corrections,
}

/// Corrections of the waypoints from tactile measurements.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
struct Corrections {
    /// Permitted deviation from the commanded grasp, m.
    clearance_margin_m: f64,
    /// The object is joined to the object of the other hand.
    joins_objects: bool,
    /// Offset from the hand centre to the held object, along the closing axis and 90° anticlockwise
    /// of it, m.
    held_offset_m: Vector2<f64>,
    /// Offset from the commanded to the actual target, base frame, m.
    target_offset_m: Vector2<f64>,
}

impl Waypoints {
    /// Returns the waypoints of a goal for one hand, and the width of its object, m.
    #[must_use]
    pub fn for_goal(
        hand: &HandModel,
        now: &GraspPose,
        goal: &Goal,
        settings: &Settings,
    ) -> (Self, f64) {
        let (request, home) = (goal.request(), home_pose(hand, now));
        let corrections = Corrections {
            clearance_margin_m: goal.clearance_margin_m(),
            joins_objects: goal.requirements().both_hands,
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
        let stays = !(goal.requirements().visits_source || goal.requirements().visits_target);
        let waypoints = if stays {
            Self::resting(hand, *now, home, settings)
        } else {
            Self::acting(hand, now, home, goal, settings)
        };
        (within(waypoints), request.width_m)
    }

    /// Returns the waypoints of the acting hand at `now` with rest pose `home`.
    #[must_use]
    pub fn acting(
        hand: &HandModel,
        now: &GraspPose,
        home: GraspPose,
        goal: &Goal,
        settings: &Settings,
    ) -> Self {
        let (request, motion) = (goal.request(), &settings.motion);
        let opening_m = request.width_m + 2.0 * motion.clearance_m;
        let mut source = top_grasp(hand, now, request.from_m, request.from_yaw_rad, opening_m);
        // A turn begins at the far end of its travel.
        let start_m = -request.turn.sign() * settings.screw.travel_m;
        if goal.requirements().grasps_to_turn {
            source.tangential_m = PerSide::new(start_m, -start_m);
        }
        let (to_m, to_yaw_rad) = goal.destination();
        let descend_m = approach_height_m(hand, request, settings);
        let travel_m = goal.travel_height_m();
        let over_m = [to_m[0], to_m[1], travel_m];
        let lowest_m = (to_m[2] - settings.place.search_m).max(GRASP_HEIGHT_MIN_M);
        Self {
            tilted: home,
            before_source: raised(&source, descend_m),
            around: source,
            turn_start_m: start_m,
            source,
            over_target: top_grasp(hand, &source, over_m, to_yaw_rad, opening_m),
            home,
            descend_m,
            lift_m: travel_m - request.from_m[2],
            lowering_m: (travel_m - lowest_m).max(0.0),
            expected_height_m: to_m[2],
            turning: request.turn.sign(),
            max_half_opening_m: hand.max_opening_m() / 2.0,
            finger_m_s: hand.finger_speed_m_s(),
            wrist_turn_radius_m: hand.wrist_turn_radius_m(),
            commanded_m: source.centre_m.xy(),
            corrections: Corrections::default(),
        }
    }

    /// Returns the waypoints of the hand that holds the bottle from the side during an assembly.
    #[must_use]
    pub fn helping(
        hand: &HandModel,
        home: GraspPose,
        goal: &GoalRequest,
        settings: &Settings,
    ) -> Self {
        let source = side_grasp(hand, goal, settings.motion.clearance_m);
        let around = side_grasp(hand, goal, SIDE_OPENING_M);
        let (sin, cos) = libm::sincos(around.hand_azimuth_rad);
        let behind_m = Vector3::new(-SIDE_BEHIND_M * cos, -SIDE_BEHIND_M * sin, SIDE_ABOVE_M);
        let centre_m = around.centre_m + behind_m;
        Self {
            tilted: pointing_from_shoulder(
                hand,
                GraspPose {
                    centre_m: home.centre_m,
                    ..around
                },
            ),
            before_source: GraspPose { centre_m, ..around },
            around,
            source,
            ..Self::resting(hand, source, home, settings)
        }
    }

    /// Returns the waypoints of a hand that only opens and goes home.
    #[must_use]
    pub fn resting(hand: &HandModel, now: GraspPose, home: GraspPose, settings: &Settings) -> Self {
        Self {
            tilted: home,
            before_source: raised(&now, settings.motion.descend_m),
            around: now,
            turn_start_m: 0.0,
            source: now,
            over_target: now,
            home,
            descend_m: settings.motion.descend_m,
            lift_m: 0.0,
            lowering_m: 0.0,
            expected_height_m: now.centre_m.z,
            turning: Turn::CLOCKWISE.sign(),
            max_half_opening_m: hand.max_opening_m() / 2.0,
            finger_m_s: hand.finger_speed_m_s(),
            wrist_turn_radius_m: hand.wrist_turn_radius_m(),
            commanded_m: now.centre_m.xy(),
            corrections: Corrections::default(),
        }
    }

    /// Returns the grasp pose of a waypoint for a hand at `now`.
    #[must_use]
    pub fn pose(&self, waypoint: Waypoint, now: &GraspPose) -> GraspPose {
        match waypoint {
            Waypoint::Tilted => self.tilted,
            Waypoint::BeforeSource => self.before_source,
            Waypoint::Around => self.around,
            Waypoint::Source => self.source,
            Waypoint::Lifted => raised(&self.source, self.lift_m),
            Waypoint::OverTarget => self.over_target(),
            Waypoint::TurnStart => GraspPose {
                half_opening_m: self.source.half_opening_m,
                tangential_m: PerSide::new(self.turn_start_m, -self.turn_start_m),
                ..*now
            },
            Waypoint::Above => raised(now, self.descend_m),
            Waypoint::Home => self.home,
        }
    }

    /// Returns the pose opened by `by_m` per grasp side, m, limited to the maximum opening.
    #[must_use]
    pub fn opened(&self, now: &GraspPose, by_m: f64) -> GraspPose {
        let widest_m = self.max_half_opening_m;
        GraspPose {
            half_opening_m: now
                .half_opening_m
                .map(|half_m| (half_m + by_m).min(half_m.max(widest_m))),
            ..*now
        }
    }

    /// Returns the mean path speed that the fingers can track, m/s. Otherwise the arm would
    /// compensate for their lag.
    #[must_use]
    pub fn finger_speed_m_s(&self, desired_m_s: f64) -> f64 {
        desired_m_s.min(FINGER_SPEED_SHARE * self.finger_m_s / PEAK_TO_MEAN_SPEED)
    }

    /// Returns [`HandModel::wrist_turn_radius_m`] of the hand.
    #[must_use]
    pub fn wrist_turn_radius_m(&self) -> Option<f64> {
        self.wrist_turn_radius_m
    }

    /// Returns the pose that centres the held object above the target.
    fn over_target(&self) -> GraspPose {
        let axis = self.over_target.closing_axis().xy();
        let across = Vector2::new(-axis.y, axis.x);
        let Corrections {
            held_offset_m: held_off_m,
            target_offset_m: target_off_m,
            ..
        } = self.corrections;
        let off_m = target_off_m - axis * held_off_m.x - across * held_off_m.y;
        shifted(&self.over_target, &off_m)
    }

    /// Moves the grasp to the measured object position, base frame, m, and turns it by `turn_rad`,
    /// rad.
    pub fn move_grasp(&mut self, at_m: &Vector2<f64>, turn_rad: f64) {
        self.shift_source(&(at_m - self.source.centre_m.xy()));
        self.corrections.held_offset_m = Vector2::zeros();
        for frame in [&mut self.before_source, &mut self.around, &mut self.source] {
            frame.closing_yaw_rad += turn_rad;
        }
    }

    /// Shifts the grasp by `by_m`, m, 90° anticlockwise of the closing axis.
    pub fn shift_grasp(&mut self, by_m: f64, axis: &Vector2<f64>) {
        self.shift_source(&(Vector2::new(-axis.y, axis.x) * by_m));
        self.corrections.held_offset_m.y -= by_m;
    }

    /// Moves one side of the grasp outwards by `by_m`, m, as far as the hand opens.
    pub fn widen_grasp(&mut self, side: GraspSide, by_m: f64) {
        let half_m = self.source.half_opening_m[side] + by_m / 2.0;
        let half_m = half_m.min(self.max_half_opening_m);
        for pose in [&mut self.before_source, &mut self.source] {
            pose.half_opening_m = pose.half_opening_m.map(|before_m| half_m.max(before_m));
        }
        let outwards = self.source.closing_axis().xy() * side.outward();
        self.shift_source(&(outwards * (by_m / 2.0)));
    }

    fn shift_source(&mut self, by_m: &Vector2<f64>) {
        for frame in [&mut self.before_source, &mut self.around, &mut self.source] {
            *frame = shifted(frame, by_m);
        }
    }

    /// Sets the measured offset of the held object along the closing axis, m.
    pub fn set_held_offset(&mut self, off_m: f64) {
        self.corrections.held_offset_m.x = off_m;
    }

    /// Shifts the target with the other hand's object, base frame, m, if both objects are joined.
    pub fn shift_target(&mut self, off_m: Vector2<f64>) {
        if self.corrections.joins_objects {
            let is_known = off_m.norm() > ARM_DISAGREEMENT_M;
            self.corrections.target_offset_m = if is_known { off_m } else { Vector2::zeros() };
        }
    }

    /// Permitted deviation from the commanded grasp, m.
    #[must_use]
    pub fn clearance_margin_m(&self) -> f64 {
        self.corrections.clearance_margin_m
    }

    /// Returns true if the held object is joined to the object of the other hand.
    #[must_use]
    pub fn joins_objects(&self) -> bool {
        self.corrections.joins_objects
    }

    /// Commanded object position, base frame, m.
    #[must_use]
    pub fn commanded_m(&self) -> Vector2<f64> {
        self.commanded_m
    }

    /// Maximum lowering distance at the target, m.
    #[must_use]
    pub fn lowering_m(&self) -> f64 {
        self.lowering_m
    }

    /// Sense of turning, seen from above: 1 anticlockwise, −1 clockwise.
    #[must_use]
    pub fn turning(&self) -> f64 {
        self.turning
    }

    /// Expected grasp height when the object stands at the target, m.
    #[must_use]
    pub fn expected_height_m(&self) -> f64 {
        self.expected_height_m
    }
}

/// Returns the approach height above the grasp, m, which clears the object top if the goal gives
/// it.
#[must_use]
pub(crate) fn approach_height_m(hand: &HandModel, goal: &GoalRequest, settings: &Settings) -> f64 {
    if goal.top_m <= 0.0 {
        return settings.motion.descend_m;
    }
    let dome_m = hand.tip_radius_m().iter().copied().fold(0.0, f64::max);
    (goal.top_m + dome_m + TOP_CLEARANCE_M).max(settings.motion.descend_m)
}

/// Returns the rest pose of an arm, clear of the other arm.
#[must_use]
pub fn home_pose(hand: &HandModel, now: &GraspPose) -> GraspPose {
    top_grasp(
        hand,
        now,
        hand.home_m().into(),
        hand.home_yaw_rad(),
        hand.home_opening_m(),
    )
}

/// Returns the helping hand's side grasp of the bottle.
#[must_use]
pub fn side_grasp(hand: &HandModel, goal: &GoalRequest, clearance_m: f64) -> GraspPose {
    let centre_m = Vector3::new(goal.to_m[0], goal.to_m[1], SIDE_HEIGHT_M);
    let opening_m = goal.helper_width_m + 2.0 * clearance_m;
    let grasp = GraspPose {
        hand_pitch_rad: SIDE_PITCH_RAD,
        root_rad: SIDE_ROOT_RAD,
        ..GraspPose::from_above(centre_m, 0.0, opening_m)
    };
    pointing_from_shoulder(hand, grasp)
}

/// Returns the pose with the hand pointing away from its shoulder.
fn pointing_from_shoulder(hand: &HandModel, frame: GraspPose) -> GraspPose {
    let azimuth_rad = hand.bearing_rad(&frame.centre_m);
    GraspPose {
        hand_azimuth_rad: azimuth_rad,
        closing_yaw_rad: azimuth_rad + FRAC_PI_2,
        ..frame
    }
}

/// Returns a vertical grasp with the yaw reachable from `now`.
fn top_grasp(
    hand: &HandModel,
    now: &GraspPose,
    centre_m: [f64; 3],
    yaw_rad: f64,
    opening_m: f64,
) -> GraspPose {
    let centre_m = Vector3::from(centre_m);
    let yaw_rad = reachable_yaw_rad(hand, now, &centre_m, yaw_rad);
    GraspPose {
        hand_azimuth_rad: hand.bearing_rad(&centre_m),
        ..GraspPose::from_above(centre_m, yaw_rad, opening_m)
    }
}

fn shifted(frame: &GraspPose, by_m: &Vector2<f64>) -> GraspPose {
    let by_m = Vector3::new(by_m.x, by_m.y, 0.0);
    GraspPose {
        centre_m: frame.centre_m + by_m,
        ..*frame
    }
}

fn raised(frame: &GraspPose, by_m: f64) -> GraspPose {
    with_height(frame, frame.centre_m.z + by_m)
}
