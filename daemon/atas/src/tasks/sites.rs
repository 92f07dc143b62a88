//! Sites: the poses that a goal's steps refer to by name.

use crate::goal::travel_height_m;
use crate::path::reachable_yaw_rad;
use crate::settings::Settings;
use nalgebra::Vector3;
use robot_model::{GraspFrame, HandModel};
use shm_schemas::{GoalKind, GoalRequest, Turn};

/// Lowest centre of a grasp, m (ours: the dome's radius and 3 mm of air).
const LOWEST_M: f64 = 0.018;

/// A named pose.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Site {
    /// Before the object, open: straight above it.
    BeforeSource,
    /// At the object, open a little wider than it.
    Source,
    /// Where the object is lifted to.
    Lifted,
    /// Over the target, as high as the object is lifted.
    OverTarget,
    /// Straight above where the hand is.
    Above,
    /// Where the arm rests.
    Home,
}

/// The poses of one goal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sites {
    source: GraspFrame,
    over_target: GraspFrame,
    home: GraspFrame,
    descend_m: f64,
    lift_m: f64,
    lowering_m: f64,
    expected_m: f64,
    turning: f64,
}

impl Sites {
    /// The poses of a checked goal for a hand that is at `now` and rests at `home`.
    #[must_use]
    pub fn new(
        hand: &HandModel,
        now: &GraspFrame,
        home: GraspFrame,
        goal: &GoalRequest,
        settings: &Settings,
    ) -> Self {
        let motion = &settings.motion;
        let opening_m = goal.width_m + 2.0 * motion.clearance_m;
        let mut source = from_above(hand, now, goal.from_m, goal.from_yaw_rad, opening_m);
        if goal.kind == GoalKind::SCREW {
            // A turn begins at the far end of its travel.
            let start_m = -goal.turn.sign() * settings.screw.travel_m;
            source.tangential_m = [start_m, -start_m];
        }
        let places = goal.kind == GoalKind::PICK_PLACE;
        let to_m = if places { goal.to_m } else { goal.from_m };
        let to_yaw_rad = if places {
            goal.to_yaw_rad
        } else {
            goal.from_yaw_rad
        };
        let travel_m = travel_height_m(goal);
        let over_m = [to_m[0], to_m[1], travel_m];
        let lowest_m = (to_m[2] - settings.place.search_m).max(LOWEST_M);
        Self {
            source,
            over_target: from_above(hand, &source, over_m, to_yaw_rad, opening_m),
            home,
            descend_m: motion.descend_m,
            lift_m: travel_m - goal.from_m[2],
            lowering_m: (travel_m - lowest_m).max(0.0),
            expected_m: to_m[2],
            turning: goal.turn.sign(),
        }
    }

    /// The poses of a hand that only opens and goes home.
    #[must_use]
    pub fn resting(now: GraspFrame, home: GraspFrame, settings: &Settings) -> Self {
        Self {
            source: now,
            over_target: now,
            home,
            descend_m: settings.motion.descend_m,
            lift_m: 0.0,
            lowering_m: 0.0,
            expected_m: now.centre_m.z,
            turning: Turn::CLOCKWISE.sign(),
        }
    }

    /// The pose of a site, for a hand that is at `now`.
    #[must_use]
    pub fn pose(&self, site: Site, now: &GraspFrame) -> GraspFrame {
        match site {
            Site::BeforeSource => raised(&self.source, self.descend_m),
            Site::Source => self.source,
            Site::Lifted => raised(&self.source, self.lift_m),
            Site::OverTarget => self.over_target,
            Site::Above => raised(now, self.descend_m),
            Site::Home => self.home,
        }
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

fn raised(frame: &GraspFrame, by_m: f64) -> GraspFrame {
    GraspFrame {
        centre_m: frame.centre_m + Vector3::z() * by_m,
        ..*frame
    }
}
