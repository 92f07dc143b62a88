//! Sites: the poses that a goal's steps refer to by name.

use crate::path::reachable_yaw_rad;
use crate::settings::Motion;
use core::f64::consts::FRAC_PI_2;
use nalgebra::Vector3;
use robot_model::{FINGERS, GraspFrame, HandModel};
use shm_schemas::GoalRequest;

/// A named pose.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Site {
    /// Over the object, open.
    AboveSource,
    /// At the object, open a little wider than it.
    Source,
    /// Where the object is lifted to.
    Lifted,
    /// Straight above where the hand is.
    Above,
    /// Where the arm rests.
    Home,
}

/// The poses of one goal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sites {
    source: GraspFrame,
    home: GraspFrame,
    descend_m: f64,
    lift_m: f64,
}

impl Sites {
    /// The poses of a checked goal for a hand that is at `now` and rests at `home`.
    #[must_use]
    pub fn new(
        hand: &HandModel,
        now: &GraspFrame,
        home: GraspFrame,
        goal: &GoalRequest,
        settings: &Motion,
    ) -> Self {
        let centre_m = Vector3::from(goal.from_m);
        let source = GraspFrame {
            centre_m,
            closing_yaw_rad: reachable_yaw_rad(hand, now, &centre_m, goal.from_yaw_rad),
            hand_azimuth_rad: hand.bearing_rad(&centre_m),
            hand_pitch_rad: FRAC_PI_2,
            root_rad: 0.0,
            half_opening_m: [goal.width_m / 2.0 + settings.clearance_m; FINGERS],
            tangential_m: [0.0; FINGERS],
            up_m: [0.0; FINGERS],
        };
        Self {
            source,
            home,
            descend_m: settings.descend_m,
            lift_m: goal.lift_m,
        }
    }

    /// The poses of a hand that only opens and goes home.
    #[must_use]
    pub fn resting(now: GraspFrame, home: GraspFrame, settings: &Motion) -> Self {
        Self {
            source: now,
            home,
            descend_m: settings.descend_m,
            lift_m: 0.0,
        }
    }

    /// The pose of a site, for a hand that is at `now`.
    #[must_use]
    pub fn pose(&self, site: Site, now: &GraspFrame) -> GraspFrame {
        match site {
            Site::AboveSource => raised(&self.source, self.descend_m),
            Site::Source => self.source,
            Site::Lifted => raised(&self.source, self.lift_m),
            Site::Above => raised(now, self.descend_m),
            Site::Home => self.home,
        }
    }
}

fn raised(frame: &GraspFrame, by_m: f64) -> GraspFrame {
    GraspFrame {
        centre_m: frame.centre_m + Vector3::z() * by_m,
        ..*frame
    }
}
