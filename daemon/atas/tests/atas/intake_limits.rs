//! Frame intake at its limits, and the values and limits that its reasons name.

use crate::intake::{START_NS, altered, at, feed, intake, limits, tick, warm};
use atas_core::Tick;
use atas_core::intake::FrameIntake;
use atas_core::settings::Intake as Limits;
use shm_schemas::{Cause, Hand, HandFrame, Reason, ReasonRecord};

const AT: Tick = Tick {
    index: 0,
    now_ns: START_NS,
};

/// Frame captured this long before (positive) or after [`AT`].
fn aged(age_ns: i64) -> HandFrame {
    let captured_ns = START_NS.checked_add_signed(-age_ns).unwrap();
    altered(at(0), |f| f.stamp.captured_ns = captured_ns)
}

fn near(found: f64, expected: f64) -> bool {
    (found - expected).abs() <= 1e-9 * expected.abs()
}

#[track_caller]
fn assert_reason(reason: Reason, cause: Cause, value: f64, limit: f64) {
    let reason = ReasonRecord::from(reason);
    assert_eq!(reason.cause, cause);
    assert!(near(reason.value, value), "value {}", reason.value);
    assert!(near(reason.limit, limit), "limit {}", reason.limit);
}

/// The first frame has no predecessor, so only its age can reject it.
#[test]
fn first_frame_outside_time_limits_is_rejected() {
    let ms = 1_000_000.0;
    for (age_ns, cause, value_ns, limit_ns) in [
        (0, Cause::NONE, 0.0, 0.0),
        (100_000_000, Cause::NONE, 0.0, 0.0),
        (100_000_001, Cause::FRAME_STALE, 100_000_001.0, 100.0 * ms),
        (250_000_000, Cause::FRAME_STALE, 250.0 * ms, 100.0 * ms),
        (-1_000_000, Cause::NONE, 0.0, 0.0),
        (-1_000_001, Cause::FRAME_FUTURE, 1_000_001.0, ms),
        (-70_000_000, Cause::FRAME_FUTURE, 70.0 * ms, ms),
    ] {
        let mut intake = intake(1000.0);
        let accepted = feed(&mut intake, &aged(age_ns), AT);
        assert_eq!(accepted, cause == Cause::NONE, "{age_ns} ns");
        assert_reason(intake.warning(), cause, value_ns, limit_ns);
    }
}

#[test]
fn accepted_frame_reports_sequence_and_age() {
    let mut intake = intake(1000.0);
    assert_eq!((intake.sequence(), intake.age_ns(AT)), (0, u64::MAX));
    let frame = altered(aged(3_000_000), |f| f.stamp.sequence = 41);
    let checked = intake.validate(&frame, AT, &limits()).unwrap();
    assert!(near(checked.age_s(), 0.003));
    assert_eq!(checked.captured_ns(), START_NS - 3_000_000);
    assert_eq!((intake.sequence(), intake.age_ns(AT)), (41, 3_000_000));
}

#[test]
fn missing_frames_are_reported_with_age_and_limit() {
    let mut waiting = intake(1000.0);
    waiting.begin();
    let reason = waiting.hold_reason(AT, &limits());
    let Reason::FramesStopped {
        age_ns: None,
        limit_ns,
        ..
    } = reason
    else {
        panic!("{reason:?}")
    };
    assert!(near(limit_ns, 5e6), "limit {limit_ns}");
    // Received with this age, reported this long after the capture.
    for (received_ns, now_ns, cause) in [
        (0, 8_000_000, Cause::FRAMES_STOPPED),
        (5_000_000, 9_000_000, Cause::FRAMES_STOPPED),
        (5_000_001, 9_000_000, Cause::FRAME_STALE),
    ] {
        let mut intake = intake(1000.0);
        let frame = aged(received_ns);
        assert!(feed(&mut intake, &frame, AT));
        let later = Tick {
            index: 1,
            now_ns: frame.stamp.captured_ns + now_ns as u64,
        };
        let reason = intake.hold_reason(later, &limits());
        assert_reason(reason, cause, now_ns as f64, 5e6);
    }
}

#[test]
fn second_frame_of_the_same_instant_is_mistimed() {
    let mut intake = intake(1000.0);
    assert!(feed(&mut intake, &aged(0), AT));
    let second = altered(aged(0), |f| f.stamp.sequence = 1);
    assert!(!feed(&mut intake, &second, AT));
    assert_eq!(intake.warning().cause(), Cause::FRAME_STALE);
    assert_eq!(intake.counts().mistimed, 1);
}

#[test]
fn jump_of_the_counter_is_a_gap_foreign_or_reordered() {
    for (jump, accepted, lost, foreign, reordered) in [
        (10_000, true, 9_999, 0, 0),
        (10_001, false, 0, 1, 0),
        (u64::MAX / 2, false, 0, 1, 0),
        (u64::MAX / 2 + 1, false, 0, 0, 1),
        (u64::MAX - 10_000, false, 0, 0, 1),
    ] {
        let mut intake = intake(1000.0);
        assert!(feed(&mut intake, &at(0), tick(0)));
        let far = altered(at(1), |f| f.stamp.sequence = jump);
        assert_eq!(feed(&mut intake, &far, tick(1)), accepted, "{jump}");
        let counts = intake.counts();
        assert_eq!(
            (counts.lost, counts.foreign, counts.reordered),
            (lost, foreign, reordered),
            "{jump}"
        );
    }
}

/// Time at which a new writer is accepted; it writes from 30 ms on.
fn accepted_ms(stamp: impl Fn(u64) -> (u64, u64)) -> Option<u64> {
    let mut intake = warm();
    (30..200).find(|ms| {
        let other = altered(at(*ms), |f| {
            (f.stamp.writer_epoch, f.stamp.sequence) = stamp(*ms);
        });
        feed(&mut intake, &other, tick(*ms))
    })
}

#[test]
fn new_writer_needs_an_increasing_run_of_its_own() {
    assert_eq!(accepted_ms(|ms| (66, ms)), Some(49), "every frame");
    assert_eq!(accepted_ms(|_| (66, 3)), None, "one repeated frame");
    assert_eq!(
        accepted_ms(|ms| (66 + ms % 2, ms)),
        None,
        "two writers take turns"
    );
    assert_eq!(
        accepted_ms(|ms| (66, 500 - ms)),
        None,
        "counter runs backwards"
    );
    assert_eq!(
        accepted_ms(|ms| (66, if ms < 40 { ms } else { ms - 40 })),
        Some(59),
        "counter that restarts"
    );
}

/// Causes that a frame raises under changed limits.
fn causes(change: fn(&mut Limits), frame: &HandFrame) -> (Cause, u64) {
    let mut limits = limits();
    change(&mut limits);
    let mut intake = warm();
    intake.begin();
    let before = intake.counts().masked_elements;
    assert!(intake.validate(frame, tick(10), &limits).is_some());
    let masked = intake.counts().masked_elements - before;
    (intake.hold_reason(tick(10), &limits).cause(), masked)
}

#[test]
fn share_of_invalid_elements_may_equal_its_limit() {
    let frame = altered(at(10), |f| f.valid_mask[1] = !0xf);
    let exact = |limits: &mut Limits| limits.invalid_share = 4.0 / 41.0;
    let below = |limits: &mut Limits| limits.invalid_share = (4.0_f64 / 41.0).next_down();
    assert_eq!(causes(exact, &frame), (Cause::NONE, 4));
    assert_eq!(causes(below, &frame), (Cause::ELEMENTS_INVALID, 4));
}

/// Single precision rounds some limits up; a reading there is already above the limit.
#[test]
fn reading_may_equal_the_largest_force() {
    let limited_to = |limit_n: f64, reading_n: f32| {
        let mut limits = limits();
        limits.element_force_n = limit_n;
        let mut intake = warm();
        let before = intake.counts().masked_elements;
        let frame = altered(at(10), |f| f.force_n[0][5][2] = reading_n);
        intake.begin();
        assert!(intake.validate(&frame, tick(10), &limits).is_some());
        intake.counts().masked_elements - before
    };
    for (limit_n, reading_n, masked) in [
        (50.0, 50.0, 0),
        (50.0, 50.0_f32.next_up(), 1),
        (0.1, 0.1_f32.next_down(), 0),
        (0.1, 0.1_f32, 1),
        (0.3, 0.3_f32, 1),
        (0.7, 0.7_f32, 0),
        (0.7, 0.7_f32.next_up(), 1),
    ] {
        assert_eq!(
            limited_to(limit_n, reading_n),
            masked,
            "{reading_n} N of {limit_n} N"
        );
    }
}

#[test]
fn frozen_check_is_off_at_zero() {
    for (frozen_frames, holds) in [
        (0.0, false),
        (1.0, true),
        (2.0, true),
        (59.0, true),
        (60.0, false),
    ] {
        let mut limits = limits();
        limits.frozen_frames = frozen_frames;
        let mut intake = intake(1000.0);
        for ms in 0..60 {
            let frozen = altered(at(ms), |f| f.force_n = at(0).force_n);
            intake.begin();
            assert!(intake.validate(&frozen, tick(ms), &limits).is_some());
        }
        let cause = intake.hold_reason(tick(59), &limits).cause();
        assert_eq!(cause == Cause::FRAMES_FROZEN, holds, "{frozen_frames}");
    }
}

/// Frame with changing readings of three elements; the last one stops at `stuck_from`.
fn partly_stuck(ms: u64, stuck_from: u64) -> HandFrame {
    altered(at(ms), |f| {
        let reading = |ms: u64| 0.2 + (ms % 7) as f32 * 1e-3;
        f.force_n[1][1][0] = reading(ms);
        f.force_n[1][2][0] = reading(ms);
        f.force_n[1][9][0] = reading(ms.min(stuck_from));
    })
}

#[test]
fn stuck_element_is_reported_once_and_masked() {
    let mut intake = intake(1000.0);
    let step = |intake: &mut FrameIntake, ms: u64, stuck_from: u64| {
        let frame = partly_stuck(ms, stuck_from);
        intake.begin();
        let checked = intake.validate(&frame, tick(ms), &limits()).unwrap();
        let masked = checked.element_n(1, 9).is_none();
        let others = [1, 2].map(|element| checked.element_n(1, element).is_none());
        assert_eq!(others, [false; 2], "at {ms} ms");
        (masked, intake.warning())
    };
    for ms in 0..550 {
        let (masked, warning) = step(&mut intake, ms, 300);
        assert!(!masked && !warning.is_some(), "at {ms} ms");
    }
    let (masked, warning) = step(&mut intake, 550, 300);
    assert!(masked);
    assert_eq!(
        warning,
        Reason::ElementStuck {
            hand: Hand::LEFT,
            fingertip: 1,
            element: 9
        }
    );
    let (masked, warning) = step(&mut intake, 551, 300);
    assert!(masked && !warning.is_some(), "reported already");
    let (masked, _) = step(&mut intake, 553, 553);
    assert!(!masked, "it changes again");
}
