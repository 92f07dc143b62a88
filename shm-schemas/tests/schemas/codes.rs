//! Known values of a code round-trip; unknown values remain readable.

use shm_schemas::*;
use std::collections::HashSet;

macro_rules! check {
    ($($code:ident)*) => {$({
        let (mut names, mut numbers) = (HashSet::new(), HashSet::new());
        for &value in $code::ALL {
            let name = value.name();
            assert!(names.insert(name), "{name} names two values of {}", stringify!($code));
            assert!(numbers.insert(value.0), "{} stands for two values of {}", value.0, stringify!($code));
            assert!(value.is_known());
            assert_eq!($code::from_name(name), Some(value));
            assert_eq!(value.to_string(), name);
            assert_eq!(format!("{value:?}"), name);
        }
        for number in (0..200).chain([u32::MAX]).filter(|n| !numbers.contains(n)) {
            let value = $code(number);
            assert!(!value.is_known());
            assert_eq!(value.name(), "unknown");
            assert_eq!(value.to_string(), format!("unknown({number})"));
        }
        assert_eq!($code::from_name("unknown"), None, "{}", stringify!($code));
        assert_eq!($code::from_name(""), None);
    })*};
}

#[test]
fn every_code_round_trips_and_unknown_values_print() {
    check! { Hand Mode Cause ModuleId EventKind GoalKind GoalPolicy GoalState ControlOp ControlOutcome OrderKind GripOrder }
}

#[test]
fn names_are_padded_to_a_column() {
    assert_eq!(format!("[{:<6}]", Mode::RUN), "[run   ]");
}

#[test]
fn unknown_hands_have_no_index() {
    let places: Vec<_> = [0, 1, 2, u32::MAX].map(|n| Hand(n).index()).to_vec();
    assert_eq!(places, [Some(0), Some(1), None, None]);
}

#[test]
fn only_accepted_and_running_goals_continue() {
    let going_on: Vec<_> = GoalState::ALL.iter().filter(|s| !s.is_final()).collect();
    assert_eq!(going_on, [&GoalState::ACCEPTED, &GoalState::RUNNING]);
}

#[test]
fn module_ids_fit_into_the_mask_of_active_modules() {
    assert!(ModuleId::ALL.iter().all(|m| m.0 < 32));
}

#[test]
fn goal_values_match_their_names() {
    let goal = GoalRequest {
        from_m: [1.0, 2.0, 3.0],
        from_yaw_rad: 4.0,
        to_m: [5.0, 6.0, 7.0],
        to_yaw_rad: 8.0,
        width_m: 9.0,
        lift_m: 10.0,
        hold_s: 11.0,
        helper_width_m: 12.0,
        top_m: 13.0,
        max_force_n: 14.0,
        ..GoalRequest::default()
    };
    let named: Vec<_> = GoalRequest::VALUE_NAMES
        .into_iter()
        .zip(goal.values())
        .collect();
    assert_eq!(named[0], ("from x", 1.0));
    assert_eq!(named[3], ("from yaw", 4.0));
    assert_eq!(named[6], ("to z", 7.0));
    assert_eq!(
        named[8..],
        [
            ("width", 9.0),
            ("lift", 10.0),
            ("hold", 11.0),
            ("helper width", 12.0),
            ("top", 13.0),
            ("maximum force", 14.0)
        ]
    );
}
