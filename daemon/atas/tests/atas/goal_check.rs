//! Goal check: limits of values, capabilities of the hand.

use crate::goal::goal;
use crate::support::{robot, test_bench};
use atas_core::check::{self, GoalContext};
use atas_core::{Goal, SensorSetup, Settings};
use robot_model::{RobotModel, RobotVector};
use shm_schemas::{Cause, GoalKind, GoalRequest, Hand, Reason, ReasonRecord};

/// Checks a request; `q` is the commanded position.
pub(crate) fn check_on(
    robot: &RobotModel,
    request: &GoalRequest,
    q: Option<&RobotVector>,
    settings: &Settings,
) -> Result<Goal, Reason> {
    let now = GoalContext {
        robot,
        wiring: &SensorSetup::from_robot(robot),
        settings,
        tasks: &[],
        commanded_position: q,
    };
    check::check(request, &now)
}

/// Cause and index of the refusal; `None` if accepted.
pub(crate) fn refusal(
    robot: &RobotModel,
    request: &GoalRequest,
    q: Option<&RobotVector>,
) -> Option<(Cause, u32)> {
    let refused = check_on(robot, request, q, &Settings::default()).err()?;
    let refused = ReasonRecord::from(refused);
    Some((refused.cause, refused.index))
}

#[test]
fn hand_must_be_able_to_turn_caps() {
    let on_bench = |kind| GoalRequest {
        kind,
        from_m: [0.3, 0.0, 0.1],
        from_yaw_rad: core::f64::consts::FRAC_PI_2,
        ..goal()
    };
    let grasp = on_bench(GoalKind::GRASP);
    assert_eq!(refusal(test_bench(), &grasp, None), None);
    let screw = on_bench(GoalKind::SCREW);
    assert_eq!(
        refusal(test_bench(), &screw, None),
        Some((Cause::CANNOT_TURN, 1))
    );
    let screw = GoalRequest {
        kind: GoalKind::SCREW,
        ..goal()
    };
    assert_eq!(refusal(robot(), &screw, None), None);
}

#[test]
fn width_of_the_helping_hand_is_checked_for_either_side() {
    let assemble = |hand, y_m: f64, helper_width_m| GoalRequest {
        kind: GoalKind::ASSEMBLE,
        hand,
        from_m: [0.3, y_m, 0.05],
        to_m: [0.3, y_m / 2.0, 0.12],
        width_m: 0.03,
        helper_width_m,
        ..goal()
    };
    for (hand, y_m) in [(Hand::RIGHT, -0.1), (Hand::LEFT, 0.1)] {
        for (helper_width_m, expected) in [
            (0.06, None),
            (0.11, None),
            (0.02, None),
            (0.111, Some((Cause::OUT_OF_RANGE, 11))),
            (0.019, Some((Cause::OUT_OF_RANGE, 11))),
        ] {
            let request = assemble(hand, y_m, helper_width_m);
            assert_eq!(
                refusal(robot(), &request, None),
                expected,
                "{helper_width_m} m"
            );
        }
    }
}

#[test]
fn refusal_names_the_violated_limit() {
    type Change = fn(&mut GoalRequest);
    let rows: [(Change, Cause, u32, f64); 12] = [
        (
            |g| g.from_yaw_rad = -6.3,
            Cause::OUT_OF_RANGE,
            3,
            -core::f64::consts::TAU,
        ),
        (
            |g| g.from_yaw_rad = 6.3,
            Cause::OUT_OF_RANGE,
            3,
            core::f64::consts::TAU,
        ),
        (
            |g| g.to_yaw_rad = -6.3,
            Cause::OUT_OF_RANGE,
            7,
            -core::f64::consts::TAU,
        ),
        (
            |g| g.to_yaw_rad = 6.3,
            Cause::OUT_OF_RANGE,
            7,
            core::f64::consts::TAU,
        ),
        (|g| g.lift_m = -0.01, Cause::OUT_OF_RANGE, 9, 0.0),
        (|g| g.lift_m = 0.16, Cause::OUT_OF_RANGE, 9, 0.15),
        (|g| g.from_m[0] = 0.219_998, Cause::UNREACHABLE, 0, 0.22),
        (|g| g.from_m[0] = 0.400_002, Cause::UNREACHABLE, 0, 0.4),
        (|g| g.from_m[1] = -0.300_002, Cause::UNREACHABLE, 1, -0.3),
        (|g| g.from_m[1] = 0.060_002, Cause::UNREACHABLE, 1, 0.06),
        (|g| g.from_m[2] = 0.024_998, Cause::UNREACHABLE, 2, 0.025),
        (|g| g.width_m = 0.019_998, Cause::UNREACHABLE, 8, 0.02),
    ];
    for (change, cause, index, limit) in rows {
        let mut request = goal();
        change(&mut request);
        let reason = check_on(robot(), &request, None, &Settings::default()).unwrap_err();
        let reason = ReasonRecord::from(reason);
        assert_eq!(
            (reason.cause, reason.index, reason.limit),
            (cause, index, limit),
            "{request:?}"
        );
    }
}

#[test]
fn limits_themselves_are_accepted() {
    type Change = fn(&mut GoalRequest);
    let rows: [Change; 10] = [
        |g| g.from_yaw_rad = -core::f64::consts::TAU,
        |g| g.to_yaw_rad = core::f64::consts::TAU,
        |g| g.lift_m = 0.15,
        |g| g.hold_s = 3600.0,
        // Rounding errors of decimal sums.
        |g| g.from_m[0] = 0.22 - 0.9e-6,
        |g| g.from_m[0] = 0.4 + 0.9e-6,
        |g| g.from_m[2] = 0.025 - 0.9e-6,
        |g| g.width_m = 0.02 - 0.9e-6,
        |g| g.max_force_n = 8.0,
        |g| g.max_force_n = Settings::default().grasp.carry_min_n,
    ];
    for change in rows {
        let mut request = goal();
        change(&mut request);
        assert_eq!(refusal(robot(), &request, None), None, "{request:?}");
    }
}
