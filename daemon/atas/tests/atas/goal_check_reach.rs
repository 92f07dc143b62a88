//! Goal check: postures at the places of a goal.

use crate::goal::goal;
use crate::goal_check::{check_on, refusal};
use crate::support::{angular_jaw, robot};
use atas_core::Settings;
use nalgebra::Vector3;
use robot_model::{GraspPose, HandSide};
use shm_schemas::{GoalField, GoalRequest, Reason, ReasonRecord};

/// The palm must stay above the object, and the hand must fit above it before it descends.
#[test]
fn object_must_fit_below_the_palm() {
    let at_m = [0.3, -0.1, 0.05];
    let hand = robot().hand(HandSide::Right);
    let centre_m = Vector3::from(at_m);
    let yaw_rad = hand.closing_yaw_rad(&centre_m, 0.0);
    let grasp = hand
        .posture_for(&GraspPose::from_above(centre_m, yaw_rad, 0.05))
        .unwrap();
    // Clearance above the object: 10 mm.
    let room_m = hand.lowest_of_palm_m(&hand.forward(&grasp.q)) - at_m[2] - 0.01;
    let refused = |top_m: f64| {
        let request = GoalRequest {
            from_m: at_m,
            lift_m: 0.01,
            top_m,
            ..goal()
        };
        check_on(robot(), &request, None, &Settings::default()).err()
    };
    assert_eq!(refused(0.0), None, "height unknown");
    assert_eq!(refused(room_m - 1e-9), None);
    let reason = refused(room_m + 1e-9).expect("too high");
    let Reason::OutOfRange { field, limit, .. } = reason else {
        panic!("{reason:?}")
    };
    assert_eq!(field, GoalField::TOP);
    assert!((limit - room_m).abs() < 1e-9, "{reason:?}");
}

/// Approach heights, of 55, at which the hand fits above an object at this place.
fn heights_accepted(at_m: [f64; 3]) -> u32 {
    let hand = robot().hand(HandSide::Right);
    let request = GoalRequest {
        from_m: at_m,
        lift_m: 0.0,
        top_m: 0.02,
        ..goal()
    };
    let mut accepted = 0;
    for centimetres in 5..60_u32 {
        let mut settings = Settings::default();
        settings.motion.descend_m = f64::from(centimetres) * 0.01;
        let above_m = Vector3::new(at_m[0], at_m[1], at_m[2] + settings.motion.descend_m);
        let yaw_rad = hand.closing_yaw_rad(&above_m, 0.0);
        let above = hand.posture_for(&GraspPose::from_above(above_m, yaw_rad, 0.05));
        let found = check_on(robot(), &request, None, &settings).err();
        let index = found.map(|reason| ReasonRecord::from(reason).index);
        let expected = above.err().map(|_| GoalField::TOP.0);
        assert_eq!(index, expected, "{centimetres} cm above {at_m:?}");
        accepted += u32::from(expected.is_none());
    }
    accepted
}

#[test]
fn hand_must_fit_above_the_object() {
    let high = heights_accepted([0.4, -0.3, 0.2]);
    let low = heights_accepted([0.3, -0.1, 0.03]);
    assert!(
        5 < high && high < 50 && high < low,
        "{high} and {low} of 55 heights"
    );
}

/// The search takes steps of 5° to both sides.
#[test]
fn refused_yaw_names_the_nearest_possible_one() {
    let refused = |yaw_rad: f64| {
        let request = GoalRequest {
            from_m: [0.21, 0.0, 0.035],
            from_yaw_rad: yaw_rad,
            width_m: 0.05,
            lift_m: 0.04,
            ..goal()
        };
        check_on(angular_jaw(), &request, None, &Settings::default()).err()
    };
    for yaw_deg in [30.0_f64, 60.0, 120.0] {
        let yaw_rad = yaw_deg.to_radians();
        let reason = refused(yaw_rad).expect("the hand tilts only in the plane of its arm");
        let Reason::Unreachable {
            field,
            value,
            limit,
        } = reason
        else {
            panic!("{reason:?}")
        };
        assert_eq!((field, value), (GoalField::FROM_YAW, yaw_rad));
        let steps = (1..=18).flat_map(|step| [f64::from(step), -f64::from(step)]);
        let mut yaws_rad = steps.map(|step| yaw_rad + step * 5.0_f64.to_radians());
        let nearest_rad = yaws_rad.find(|yaw_rad| refused(*yaw_rad).is_none());
        let nearest_rad = nearest_rad.expect("a possible yaw");
        assert!((limit - nearest_rad).abs() < 1e-9, "{yaw_deg}°: {reason}");
    }
}

/// The release opens the jaw by 30 mm, and its domes tilt as it opens. Fully open, it does not fit.
#[test]
fn tilting_hand_must_fit_while_released() {
    let hand = angular_jaw().hand(HandSide::Right);
    let at_m = [0.18, 0.0, 0.135];
    let centre_m = Vector3::from(at_m);
    let yaw_rad = hand.closing_yaw_rad(&centre_m, 0.0);
    let fits = |opening_m: f64| {
        let open = GraspPose::from_above(centre_m, yaw_rad, opening_m);
        hand.posture_for(&open).is_ok()
    };
    assert!(!fits(hand.max_opening_m()));
    let mut accepted = 0;
    for millimetres in 25..46_u32 {
        let width_m = f64::from(millimetres) * 1e-3;
        let request = GoalRequest {
            from_m: at_m,
            width_m,
            lift_m: 0.0,
            ..goal()
        };
        let found = refusal(angular_jaw(), &request, None);
        let expected = fits(width_m + 0.03);
        assert_eq!(found.is_none(), expected, "{millimetres} mm");
        accepted += u32::from(expected);
    }
    assert!(5 < accepted && accepted < 16, "{accepted} of 21 widths");
}
