//! Evasion: a fingertip that touches the object from above withdraws and comes down beside it.
//!
//! The descent touches an object that stands farther to one side, or is wider, than the goal says.
//! The hand withdraws along its path, moves the touching side outwards and descends again.

use super::{Course, TaskExecutor};
use crate::modules::{Modules, Verdict};
use crate::perception::Percept;
use crate::settings::Settings;
use crate::tasks::{Motion, Waypoint};
use robot_model::GraspPose;
use shm_schemas::Reason;

/// Distance by which the touching side moves outwards, m (design choice: a place error of 5 mm on a
/// face that is turned by 15°).
const OUTWARDS_M: f64 = 0.010;
/// Number of evasions before an obstacle is reported (design choice: one for each side).
const EVASIONS_MAX: u8 = 2;

impl TaskExecutor {
    /// Starts to withdraw from a touch during the descent. Returns true if it did.
    pub(super) fn start_evasion(
        &mut self,
        verdict: Verdict,
        percept: &Percept,
        now: &GraspPose,
        settings: &Settings,
        modules: &mut Modules,
    ) -> bool {
        let obstructed = matches!(verdict, Verdict::Refuse(Reason::Obstructed { .. }));
        let descends =
            self.course == Course::Task && self.step().motion == Motion::Reach(Waypoint::Source);
        let has_room = self.corrections.evasions < EVASIONS_MAX
            && OUTWARDS_M <= self.waypoints.clearance_margin_m();
        if !(obstructed && descends && has_room) {
            return false;
        }
        self.corrections.evasions += 1;
        for (side, percept) in percept.sides.entries() {
            if percept.in_contact {
                self.waypoints.widen_grasp(side, OUTWARDS_M);
            }
        }
        self.course = Course::Evasion {
            resume_step: self.index,
        };
        self.enter(0, now, settings, modules);
        true
    }
}
