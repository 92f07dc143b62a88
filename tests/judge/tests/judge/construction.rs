//! A judge with invalid limits is not created.

use atas_judge::{BoundsError, JointBounds, Judge};

use crate::reference::{TICK_NS, VALID_NS, bounds};

/// Change of the bounds, and the text of the error.
type Case = (fn(&mut JointBounds), &'static str);

fn error(change: impl Fn(&mut JointBounds)) -> String {
    let mut bounds = bounds();
    change(&mut bounds[1]);
    let error = Judge::new(bounds, TICK_NS, VALID_NS).expect_err("invalid bounds");
    error.to_string()
}

#[test]
fn inconsistent_bounds_are_rejected_by_name() {
    let cases: [Case; 6] = [
        (
            |it| it.lower = f64::NAN,
            "`lower` of joint \"elbow\" is NaN; it must be finite",
        ),
        (
            |it| it.upper = f64::INFINITY,
            "`upper` of joint \"elbow\" is inf; it must be finite",
        ),
        (
            |it| it.upper = it.lower,
            "`upper` of joint \"elbow\" is -1.5; it must be above `lower`",
        ),
        (
            |it| it.speed_max = 0.0,
            "`speed_max` of joint \"elbow\" is 0; it must be finite and positive",
        ),
        (
            |it| it.acceleration_max = -1.0,
            "`acceleration_max` of joint \"elbow\" is -1; it must be finite and positive",
        ),
        (
            |it| it.jerk_max = f64::NAN,
            "`jerk_max` of joint \"elbow\" is NaN; it must be finite and positive",
        ),
    ];
    for (change, expected) in cases {
        assert_eq!(error(change), format!("judge not created: {expected}"));
    }
}

#[test]
fn missing_joints_and_durations_are_rejected() {
    let error = |count: usize, tick_ns, validity_max_ns| {
        let bounds = bounds().into_iter().cycle().take(count).collect();
        Judge::new(bounds, tick_ns, validity_max_ns).err()
    };
    assert_eq!(error(32, 1, 1), None);
    for count in [0, 33] {
        assert_eq!(error(count, 1, 1), Some(BoundsError::JointCount { count }));
    }
    for (tick_ns, validity_max_ns) in [(0, 1), (1, 0)] {
        let duration = error(1, tick_ns, validity_max_ns);
        assert!(matches!(duration, Some(BoundsError::Duration { .. })));
    }
}
