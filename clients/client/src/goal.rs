//! What a client asks for: one constructor per task of the paper.
//!
//! In: places and sizes as the client believes them, SI units. Out: a request; the session adds its timestamp and id. What the
//! robot can do is the daemon's to say.

use shm_schemas::{GoalKind, GoalPolicy, GoalRequest, Hand, Text};

/// Usual lift of a grasp, m (ours: clear of the table, seen at a glance).
pub const LIFT_M: f64 = 0.040;
/// Usual hold of a grasp, s (ours: ten slip windows).
pub const HOLD_S: f64 = 1.0;
/// Lift of a cap from its stand in assembly, m (ours: clear of the stand and of the bottle's neck).
const CAP_LIFT_M: f64 = 0.05;

/// Where fingertips shall close on something: metres from the robot's base, x forward, y left, z up.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Target {
    /// The place between the fingertips.
    pub at_m: [f64; 3],
    /// Direction of the closing axis from x towards y, rad.
    pub yaw_rad: f64,
    /// Expected width along that axis, m.
    pub width_m: f64,
    /// How far it reaches above that place, m; zero if unknown.
    pub top_m: f64,
    /// What it may be pressed with at most, N; zero if unknown.
    pub max_force_n: f64,
}

impl Target {
    /// The same with what else is known of it; see the fields.
    #[must_use]
    pub fn knowing(self, top_m: f64, max_force_n: f64) -> Self {
        Self {
            top_m,
            max_force_n,
            ..self
        }
    }
}

/// Grasp, lift and hold.
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

/// Carry an object to a place: where the fingertips shall be when it stands there.
#[must_use]
pub fn pick_place(object: &Target, hand: Hand, to_m: [f64; 3], lift_m: f64) -> GoalRequest {
    GoalRequest {
        kind: GoalKind::PICK_PLACE,
        to_m,
        to_yaw_rad: object.yaw_rad,
        ..grasp(object, hand, lift_m, 0.0)
    }
}

/// Set down what the hand holds at a place, as it lies in the hand: `object` is where it was grasped, and goes back to if
/// there is no support.
#[must_use]
pub fn set_down(object: &Target, hand: Hand, to_m: [f64; 3], lift_m: f64) -> GoalRequest {
    GoalRequest {
        kind: GoalKind::CUSTOM,
        task: Text::new("set-down"),
        ..pick_place(object, hand, to_m, lift_m)
    }
}

/// Close a cap where it sits.
#[must_use]
pub fn screw(cap: &Target, hand: Hand) -> GoalRequest {
    GoalRequest {
        kind: GoalKind::SCREW,
        ..grasp(cap, hand, 0.0, 0.0)
    }
}

/// Close a bottle with a cap from its stand: `cap` as it stands, `on_bottle` where the fingertips shall be when it sits on
/// the bottle, `bottle_width_m` where the other hand holds it.
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
