//! Tests of the evaluation of pick and place, screwing and assembly: ground truth to failure key.

use shm_schemas::{Cause, GoalState, GoalUpdate, ObjectTruth, ReasonRecord, Text, WorldTruth};

use super::*;

const MS_NS: u64 = 1_000_000;

fn end(state: GoalState, cause: Cause, step: &str) -> GoalUpdate {
    GoalUpdate {
        state,
        reason: ReasonRecord {
            cause,
            ..ReasonRecord::default()
        },
        step: Text::new(step),
        ..GoalUpdate::default()
    }
}

fn done() -> GoalUpdate {
    end(GoalState::SUCCEEDED, Cause::NONE, "home")
}

fn world(first: ObjectTruth, second: ObjectTruth) -> WorldTruth {
    let mut truth = WorldTruth::default();
    (truth.objects[0], truth.objects[1]) = (first, second);
    truth
}

/// Object at its destination: landed after 100 ms, carried by the support after 101 ms, released
/// after 190 ms.
fn placed() -> ObjectTruth {
    ObjectTruth {
        position_m: [0.32, -0.27, 0.03],
        landed_ns: 100 * MS_NS,
        carried_ns: 101 * MS_NS,
        released_ns: 190 * MS_NS,
        released_above_m: 0.0001,
        ..ObjectTruth::default()
    }
}

#[test]
fn placing_failures_have_their_keys() {
    let check = |end: GoalUpdate, object: ObjectTruth, opened_ms, expected: Option<&str>| {
        let truth = world(object, ObjectTruth::default());
        let let_go_ns = Option::map(opened_ms, |ms: u64| ms * MS_NS);
        let placing = Placing::evaluate(&end, &truth, [0.32, -0.27], let_go_ns);
        assert_eq!(placing.failure.as_deref(), expected, "{placing:?}");
    };
    let object = placed();
    check(done(), object, Some(108), None);
    let off = |dx_m: f64| ObjectTruth {
        position_m: [0.32 + dx_m, -0.27, 0.03],
        ..object
    };
    check(done(), off(0.0049), Some(108), None);
    check(done(), off(-0.0051), Some(108), Some("off its place"));
    check(done(), off(f64::NAN), Some(108), Some("off its place"));
    check(done(), object, Some(500), None);
    let pressed = |pressed_down_n: f64| ObjectTruth {
        pressed_down_n,
        ..object
    };
    check(done(), pressed(0.99), Some(108), None);
    let rough = Some("pressed onto its support");
    check(done(), pressed(1.01), Some(108), rough);
    check(done(), pressed(f64::NAN), Some(108), rough);
    let above = |released_above_m: f64| ObjectTruth {
        released_above_m,
        ..object
    };
    check(done(), above(0.0019), Some(99), None);
    check(done(), above(0.0021), Some(99), Some("released early"));
    check(done(), above(f64::NAN), Some(99), Some("released early"));
    let never = ObjectTruth {
        released_ns: 0,
        ..object
    };
    check(done(), never, Some(108), Some("never released"));
    let in_the_air = ObjectTruth {
        carried_ns: 0,
        ..object
    };
    check(done(), in_the_air, Some(108), Some("never released"));
    let harmed = ObjectTruth {
        dropped: 1,
        ..object
    };
    check(done(), harmed, Some(108), Some("dropped"));
    let slipped = ObjectTruth {
        slip_in_hand_m: 0.0031,
        ..object
    };
    check(done(), slipped, Some(108), Some("slipped in the hand"));
    let turned = ObjectTruth {
        turn_in_hand_rad: 0.18,
        ..object
    };
    check(done(), turned, Some(108), Some("turned in the hand"));
    let heavy = end(GoalState::REFUSED, Cause::TOO_HEAVY, "leave");
    check(heavy, object, Some(108), Some("refused: too-heavy"));
    let stayed = ObjectTruth {
        landed_ns: 0,
        carried_ns: 0,
        ..object
    };
    let lost = end(GoalState::FAILED, Cause::LOST_OBJECT, "convey");
    check(lost, stayed, None, Some("left behind"));
    check(done(), stayed, None, Some("left behind"));
    let out_of_reach = end(GoalState::FAILED, Cause::UNREACHABLE, "");
    check(out_of_reach, stayed, None, Some("failed: unreachable"));
    check(heavy, stayed, None, Some("refused: too-heavy"));
    check(lost, object, None, Some("failed in convey: lost-object"));
}

fn cap(tightness: f64) -> ObjectTruth {
    ObjectTruth {
        cap_angle_rad: 4.2,
        cap_closing_rad: 4.0,
        cap_friction_n_m: 0.01,
        cap_holding_n_m: 0.01 * tightness,
        cap_engaged: 1,
        cap_closed: 1,
        ..ObjectTruth::default()
    }
}

#[test]
fn screwing_failures_have_their_keys() {
    let check = |end: GoalUpdate, cap: ObjectTruth, expected: Option<&str>| {
        let screwing = Screwing::evaluate(&end, &world(cap, ObjectTruth::default()));
        assert_eq!(screwing.failure.as_deref(), expected, "{screwing:?}");
    };
    check(done(), cap(1.301), None);
    check(done(), cap(2.499), None);
    check(done(), cap(1.299), Some("too loose"));
    check(done(), cap(2.501), Some("too tight"));
    check(done(), cap(f64::NAN), Some("too loose"));
    check(done(), ObjectTruth::default(), Some("off its thread"));
    let late = end(GoalState::FAILED, Cause::TIMED_OUT, "screw");
    check(late, cap(1.0), Some("timed out"));
    let tipped = ObjectTruth {
        tipped: 1,
        ..cap(2.0)
    };
    check(late, tipped, Some("tipped"));
    let held = end(GoalState::FAILED, Cause::BUSY, "");
    check(held, cap(2.0), Some("failed: busy"));
}

fn turned_by(deg: f64) -> ObjectTruth {
    let half_rad = deg.to_radians() / 2.0;
    ObjectTruth {
        orientation: [half_rad.cos(), 0.0, 0.0, half_rad.sin()],
        ..ObjectTruth::default()
    }
}

#[test]
fn assembly_failures_have_their_keys() {
    let check = |cap: ObjectTruth, bottle: ObjectTruth, expected: Option<&str>| {
        let start = world(ObjectTruth::default(), turned_by(10.0));
        let assembly = Assembly::evaluate(&done(), &start, &world(cap, bottle));
        assert_eq!(assembly.failure.as_deref(), expected, "{assembly:?}");
    };
    let bottle = ObjectTruth {
        table_n: 3.0,
        ..turned_by(10.0)
    };
    check(cap(2.0), bottle, None);
    check(cap(1.299), bottle, Some("cap too loose"));
    check(cap(2.501), bottle, Some("cap too tight"));
    let by = |deg| ObjectTruth {
        table_n: 3.0,
        ..turned_by(deg)
    };
    check(cap(2.0), by(19.9), None);
    check(cap(2.0), by(0.1), None);
    check(cap(2.0), by(20.1), Some("bottle turned in the hand"));
    check(cap(2.0), by(-0.1), Some("bottle turned in the hand"));
    check(cap(2.0), by(f64::NAN), Some("bottle turned in the hand"));
    let slid = ObjectTruth {
        slip_in_hand_m: 0.004,
        ..cap(2.0)
    };
    check(slid, bottle, Some("cap slipped in the hand"));
    let tilted = |tilt_rad: f64| ObjectTruth { tilt_rad, ..bottle };
    check(cap(2.0), tilted(-0.03), None);
    check(cap(2.0), tilted(0.04), Some("bottle not standing"));
    check(cap(2.0), tilted(f64::NAN), Some("bottle not standing"));
    let lifted = turned_by(10.0);
    check(cap(2.0), lifted, Some("bottle not standing"));
    let spilt = ObjectTruth { spilt: 1, ..bottle };
    check(cap(2.0), spilt, Some("bottle spilt"));
    let dropped = ObjectTruth {
        dropped: 1,
        ..cap(2.0)
    };
    check(dropped, bottle, Some("cap dropped"));
    let open = ObjectTruth {
        cap_closed: 0,
        ..cap(2.0)
    };
    check(open, bottle, Some("cap not closed"));
    check(ObjectTruth::default(), bottle, Some("cap off its thread"));
}

#[test]
fn motion_is_hidden_only_by_reported_success() {
    let check = |state, [slip_mm, turn_deg]: [f64; 2], expected: [bool; 2]| {
        let moved = ObjectTruth {
            slip_in_hand_m: slip_mm * 1e-3,
            turn_in_hand_rad: turn_deg.to_radians(),
            ..ObjectTruth::default()
        };
        let mut truth = world(ObjectTruth::default(), moved);
        truth.object_count = 2;
        let hidden = HiddenMotion::evaluate(&end(state, Cause::NONE, ""), &truth);
        assert_eq!(
            [hidden.slid, hidden.turned],
            expected,
            "{state} {slip_mm} mm {turn_deg} deg"
        );
    };
    check(GoalState::SUCCEEDED, [2.9, 9.9], [false, false]);
    check(GoalState::SUCCEEDED, [3.1, 9.9], [true, false]);
    check(GoalState::SUCCEEDED, [2.9, 10.1], [false, true]);
    check(GoalState::SUCCEEDED, [3.1, 10.1], [true, true]);
    check(GoalState::SUCCEEDED, [f64::NAN, f64::NAN], [true, true]);
    check(GoalState::REFUSED, [3.1, 10.1], [false, false]);
    check(GoalState::FAILED, [3.1, 10.1], [false, false]);
}
