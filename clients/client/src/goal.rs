//! Goal requests: one constructor per task of the paper.
//!
//! Inputs: positions and sizes as known to the client, SI units. Output: a request; the session
//! adds stamp and id. The daemon decides whether the robot can execute it.

use shm_schemas::{GoalKind, GoalPolicy, GoalRequest, Hand, Text};

/// Default lift of a grasp, m. Design choice: clear of the table and easily visible.
pub const LIFT_M: f64 = 0.040;
/// Default hold time of a grasp, s. Design choice: ten slip windows.
pub const HOLD_S: f64 = 1.0;
/// Lift of a cap from its stand in assembly, m. Design choice: clear of the stand and of the
/// bottle's neck.
const CAP_LIFT_M: f64 = 0.05;

/// Grasp target: metres from the robot's base, x forward, y left, z up.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Target {
    /// Position between the fingertips.
    pub at_m: [f64; 3],
    /// Direction of the closing axis from x towards y, rad.
    pub yaw_rad: f64,
    /// Expected width along that axis, m.
    pub width_m: f64,
    /// Height of the object above that position, m; zero if unknown.
    pub top_m: f64,
    /// Largest permitted force, N; zero if unknown.
    pub max_force_n: f64,
}

impl Target {
    /// Returns the target with height and force limit.
    #[must_use]
    pub fn with_limits(self, top_m: f64, max_force_n: f64) -> Self {
        Self {
            top_m,
            max_force_n,
            ..self
        }
    }
}

/// Creates a request to grasp, lift and hold.
///
/// ```
/// use atas_client::goal::{HOLD_S, LIFT_M, Target, grasp};
/// use shm_schemas::{GoalKind, Hand};
///
/// let object = Target { at_m: [0.32, -0.15, 0.03], width_m: 0.05, ..Target::default() };
/// let request = grasp(&object, Hand::RIGHT, LIFT_M, HOLD_S);
/// assert_eq!((request.kind, request.width_m), (GoalKind::GRASP, 0.05));
/// ```
#[must_use]
pub fn grasp(object: &Target, hand: Hand, lift_m: f64, hold_s: f64) -> GoalRequest {
    GoalRequest {
        goal_id: 1,
        kind: GoalKind::GRASP,
        hand,
        policy: GoalPolicy::DETACHED,
        from_m: object.at_m,
        from_yaw_rad: object.yaw_rad,
        width_m: object.width_m,
        top_m: object.top_m,
        max_force_n: object.max_force_n,
        lift_m,
        hold_s,
        ..GoalRequest::default()
    }
}

/// Creates a request to carry an object; `to_m` is the position between the fingertips at the
/// destination.
#[must_use]
pub fn pick_place(object: &Target, hand: Hand, to_m: [f64; 3], lift_m: f64) -> GoalRequest {
    GoalRequest {
        kind: GoalKind::PICK_PLACE,
        to_m,
        to_yaw_rad: object.yaw_rad,
        ..grasp(object, hand, lift_m, 0.0)
    }
}

/// Creates a request to set down the held object, in its present orientation in the hand. `object`
/// is where it was grasped; the hand puts it back there if there is no support.
#[must_use]
pub fn set_down(object: &Target, hand: Hand, to_m: [f64; 3], lift_m: f64) -> GoalRequest {
    GoalRequest {
        kind: GoalKind::CUSTOM,
        task: Text::new("set-down"),
        ..pick_place(object, hand, to_m, lift_m)
    }
}

/// Creates a request to screw a cap at its position.
#[must_use]
pub fn screw(cap: &Target, hand: Hand) -> GoalRequest {
    GoalRequest {
        kind: GoalKind::SCREW,
        ..grasp(cap, hand, 0.0, 0.0)
    }
}

/// Creates a request to screw a cap from a stand onto a bottle. `cap` is the cap on its stand,
/// `on_bottle` the position between the fingertips with the cap on the bottle, `bottle_width_m` the
/// width where the other hand holds it.
#[must_use]
pub fn assemble(
    cap: &Target,
    on_bottle: &Target,
    bottle_width_m: f64,
    screws: Hand,
) -> GoalRequest {
    GoalRequest {
        kind: GoalKind::ASSEMBLE,
        to_m: on_bottle.at_m,
        to_yaw_rad: on_bottle.yaw_rad,
        helper_width_m: bottle_width_m,
        ..grasp(cap, screws, CAP_LIFT_M, 0.0)
    }
}
