//! Position-controlled gripper, a baseline without tactile sensing: it closes to the expected width
//! minus a margin without regard to the force, then lifts and holds.
//!
//! It streams targets to the teleoperation of the production controller with a touch threshold that
//! no force reaches. Motion limits and safety gate are therefore those of the other policies.

use atas_client::goal::LIFT_M;
use atas_core::Settings;
use robot_model::HandSide;
use shm_schemas::{GoalKind, GoalPolicy, GoalRequest, GraspTarget, GripOrder, Hand, Stamp};
use sim_backend::{GraspHint, TICK_NS, World};

/// Writer epoch of the gripper. Any value different from a sensor's.
const EPOCH: u64 = 0x706f_7369_7469_6f6e;
/// Touch threshold that no force reaches, N: the hand executes commanded widths.
const UNREACHABLE_TOUCH_N: f64 = 10_000.0;
/// Period of the targets, ticks. Design choice: 100 Hz.
const PERIOD_TICKS: u64 = 10;
/// Validity of a target, ns. Design choice: many periods.
const VALID_NS: u64 = 500_000_000;
/// Additional opening in the approach, m. Design choice: 9 mm per side.
const APPROACH_OPENING_M: f64 = 0.018;
/// Height above the grasp of the approach, m. Design choice.
const APPROACH_HEIGHT_M: f64 = 0.06;
/// End of each phase, s: above the object, down, closed. Design choice: the times of the other
/// policies without waiting.
const PHASES_S: [f64; 3] = [2.5, 4.5, 10.5];
/// Speeds of closing (both sides) and lifting, m/s: those of the other policies (approach 2 mm/s
/// per side, lift 10 mm/s).
const CLOSING_M_S: f64 = 0.004;
const LIFTING_M_S: f64 = 0.01;

/// Gripper of one trial.
#[derive(Clone, Debug)]
pub(super) struct PositionGripper {
    hint: GraspHint,
    hand: Hand,
    width_m: f64,
    begin_ns: u64,
    sequence: u64,
}

impl PositionGripper {
    /// Creates a gripper that begins now.
    pub(super) fn new(hint: GraspHint, side: HandSide, margin_m: f64, world: &World) -> Self {
        Self {
            width_m: hint.width_m - margin_m,
            hint,
            hand: Hand::BOTH[side.index()],
            begin_ns: world.now_ns(),
            sequence: 0,
        }
    }

    /// Returns controller settings with which no touch is detected.
    pub(super) fn settings(ours: &Settings) -> Settings {
        let mut settings = *ours;
        settings.perception.touch_on_n = UNREACHABLE_TOUCH_N;
        settings.perception.touch_off_n = UNREACHABLE_TOUCH_N;
        settings
    }

    /// Returns the goal whose targets the gripper streams.
    pub(super) fn goal(&self) -> GoalRequest {
        GoalRequest {
            stamp: Stamp {
                captured_ns: self.begin_ns,
                writer_epoch: EPOCH,
                ..Stamp::default()
            },
            goal_id: 1,
            kind: GoalKind::TELEOP,
            hand: self.hand,
            policy: GoalPolicy::ATTACHED,
            ..GoalRequest::default()
        }
    }

    /// Returns the target of this tick, if one is due.
    pub(super) fn target(&mut self, now_ns: u64) -> Option<GraspTarget> {
        let tick = now_ns.saturating_sub(self.begin_ns) / TICK_NS;
        if !tick.is_multiple_of(PERIOD_TICKS) {
            return None;
        }
        let (up_m, opening_m) = self.motion(tick as f64 * TICK_NS as f64 * 1e-9);
        let [x_m, y_m, z_m] = self.hint.from_m;
        let mut target = GraspTarget {
            stamp: Stamp {
                sequence: self.sequence,
                captured_ns: now_ns,
                writer_epoch: EPOCH,
            },
            valid_until_ns: now_ns + VALID_NS,
            hand: self.hand,
            grip: GripOrder::WIDTH,
            centre_m: [x_m, y_m, z_m + up_m],
            closing_yaw_rad: self.hint.yaw_rad,
            opening_m,
            ..GraspTarget::default()
        };
        target.seal();
        self.sequence += 1;
        Some(target)
    }

    /// Returns height above the grasp and opening at this time since the begin, m.
    fn motion(&self, time_s: f64) -> (f64, f64) {
        let [above_s, down_s, closed_s] = PHASES_S;
        let open_m = self.hint.width_m + APPROACH_OPENING_M;
        if time_s < above_s {
            return (APPROACH_HEIGHT_M, open_m);
        }
        let closing_m = CLOSING_M_S * (time_s - down_s).max(0.0);
        let up_m = LIFTING_M_S * (time_s - closed_s).max(0.0);
        (up_m.min(LIFT_M), (open_m - closing_m).max(self.width_m))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use robot_model::RobotModel;
    use sim_backend::{Object, Scene};

    #[test]
    fn gripper_closes_before_it_lifts() {
        let robot = RobotModel::two_hand_arm().expect("built-in robot");
        let wood = Object::built_in("wood").expect("built-in object");
        let scene = Scene::grasp(wood, HandSide::Right);
        let world = World::new(&robot, &scene, 1).expect("valid scene");
        let hint = scene.grasp_hint(0).expect("an object");
        let gripper = PositionGripper::new(hint, HandSide::Right, 0.002, &world);
        let check = |time_s: f64, up_m: f64, opening_m: f64| {
            let (up, opening) = gripper.motion(time_s);
            assert!((up - up_m).abs() < 1e-9, "{time_s} s: {up} m");
            assert!(
                (opening - opening_m).abs() < 1e-9,
                "{time_s} s: {opening} m"
            );
        };
        check(1.0, APPROACH_HEIGHT_M, 0.068);
        check(3.0, 0.0, 0.068);
        check(10.49, 0.0, 0.048);
        check(12.5, 0.02, 0.048);
        check(100.0, LIFT_M, 0.048);
    }
}
