//! Frame intake over time: silence, slow sensors, frozen data, restarts, second writers (fault
//! catalogue F01 to F20).

use crate::intake::{altered, at, feed, intake, limits, tick, warm};
use crate::support::{EPOCH, MS_NS};
use atas_core::HandSensorSetup;
use atas_core::intake::{FrameCounts, FrameIntake};
use shm_schemas::{Cause, Hand, HandFrame};

/// F01, F03: silence or age beyond `hold_age_s` holds until the next frame.
#[test]
fn silence_holds_after_five_milliseconds() {
    let mut intake = warm();
    for (ms, cause) in [
        (10, Cause::NONE),
        (14, Cause::NONE),
        (15, Cause::FRAMES_STOPPED),
        (500, Cause::FRAMES_STOPPED),
    ] {
        intake.begin();
        assert_eq!(
            intake.hold_reason(tick(ms), &limits()).cause(),
            cause,
            "at {ms} ms"
        );
    }
    // Continuous but old frames.
    assert!(feed(
        &mut intake,
        &altered(at(510), |f| f.stamp.captured_ns -= 20 * MS_NS),
        tick(510)
    ));
    assert_eq!(
        intake.hold_reason(tick(510), &limits()).cause(),
        Cause::FRAMES_LOST
    );
    assert!(feed(
        &mut intake,
        &altered(at(511), |f| f.stamp.captured_ns -= 20 * MS_NS),
        tick(511)
    ));
    assert_eq!(
        intake.hold_reason(tick(511), &limits()).cause(),
        Cause::FRAME_STALE
    );
    assert!(feed(&mut intake, &at(512), tick(512)));
    assert_eq!(
        intake.hold_reason(tick(512), &limits()).cause(),
        Cause::NONE
    );
}

#[test]
fn only_required_hand_holds_before_first_frame() {
    let doubt = |required| {
        let wiring = HandSensorSetup {
            required,
            ..HandSensorSetup::default()
        };
        FrameIntake::new(Hand::LEFT, &wiring)
            .hold_reason(tick(0), &limits())
            .cause()
    };
    assert_eq!(doubt(true), Cause::FRAMES_STOPPED);
    assert_eq!(doubt(false), Cause::NONE);
}

/// F18: a 100 Hz sensor has gaps of 10 ms.
#[test]
fn slow_sensor_may_pause_for_three_periods() {
    let mut intake = intake(100.0);
    assert!(feed(&mut intake, &at(0), tick(0)));
    for (ms, cause) in [
        (9, Cause::NONE),
        (34, Cause::NONE),
        (36, Cause::FRAMES_STOPPED),
    ] {
        intake.begin();
        assert_eq!(
            intake.hold_reason(tick(ms), &limits()).cause(),
            cause,
            "at {ms} ms"
        );
    }
}

/// F09.
#[test]
fn counter_overflow_is_accepted() {
    let mut intake = intake(1000.0);
    for ms in 0..20 {
        let wrapping = altered(at(ms), |f| {
            f.stamp.sequence = (u64::MAX - 9).wrapping_add(ms)
        });
        assert!(feed(&mut intake, &wrapping, tick(ms)), "at {ms} ms");
        assert_eq!(intake.hold_reason(tick(ms), &limits()).cause(), Cause::NONE);
    }
    assert_eq!(
        *intake.counts(),
        FrameCounts {
            frames: 20,
            ..FrameCounts::default()
        }
    );
}

/// Regression: one frame with a counter far ahead blocked all following frames until a restart.
#[test]
fn counter_far_ahead_blocks_no_later_frames() {
    for sequence in [20_000, u64::MAX / 2, u64::MAX - 5] {
        let mut intake = intake(1000.0);
        assert!(feed(&mut intake, &at(0), tick(0)));
        let far = altered(at(1), |f| f.stamp.sequence = sequence);
        assert!(!feed(&mut intake, &far, tick(1)), "{sequence}");
        assert!(feed(&mut intake, &at(2), tick(2)), "after {sequence}");
        assert_eq!(intake.counts().lost, 1);
    }
}

/// A restarted counter is accepted after a silence, like another writer.
#[test]
fn restarted_counter_is_accepted_after_silence() {
    let mut intake = intake(1000.0);
    assert!(feed(&mut intake, &at(50_000), tick(50_000)));
    let repeated = |ms| altered(at(ms), |f| f.stamp.sequence = ms - 50_001);
    let believed = (50_001..50_100).find(|ms| feed(&mut intake, &repeated(*ms), tick(*ms)));
    assert!(
        believed.is_some_and(|ms| (50_020..50_060).contains(&ms)),
        "{believed:?}"
    );
}

/// F02: data repeats bit for bit while the counter advances.
#[test]
fn frozen_readings_hold_after_forty_frames() {
    for reading in [0.0, 0.5, f32::NAN] {
        let mut intake = intake(1000.0);
        let mut doubted = None;
        for ms in 0..60 {
            let frozen = altered(at(ms), |f| {
                f.force_n = HandFrame::default().force_n;
                f.force_n[0][0][0] = reading;
            });
            assert!(feed(&mut intake, &frozen, tick(ms)));
            if intake.hold_reason(tick(ms), &limits()).cause() == Cause::FRAMES_FROZEN {
                doubted = doubted.or(Some(ms));
            }
        }
        assert_eq!(doubted, Some(40), "frozen at {reading}");
        assert!(feed(&mut intake, &at(60), tick(60)));
        assert!(!intake.hold_reason(tick(60), &limits()).is_some());
    }
}

/// F20: a restarted sensor is accepted after a silence and twenty good frames; the robot holds
/// meanwhile.
#[test]
fn restarted_writer_is_accepted_after_good_frames() {
    let mut intake = warm();
    let restarted = |ms: u64| {
        altered(at(ms), |f| {
            (f.stamp.writer_epoch, f.stamp.sequence) = (99, ms - 20)
        })
    };
    let mut seen = Vec::new();
    for ms in 20..60 {
        let believed = feed(&mut intake, &restarted(ms), tick(ms));
        seen.push((
            believed,
            intake.hold_reason(tick(ms), &limits()).cause(),
            intake.writer_epoch(),
        ));
    }
    // Until 29 ms the old writer may only be late; then 20 frames of resynchronisation.
    assert!(
        seen[..9]
            .iter()
            .all(|s| *s == (false, Cause::FRAMES_STOPPED, EPOCH)),
        "{seen:?}"
    );
    assert!(
        seen[9..28]
            .iter()
            .all(|s| *s == (false, Cause::SENSOR_RESTARTED, EPOCH)),
        "{seen:?}"
    );
    assert_eq!(seen[28], (true, Cause::SENSOR_RESTARTED, 99));
    assert!(
        seen[29..].iter().all(|s| *s == (true, Cause::NONE, 99)),
        "{seen:?}"
    );
    assert_eq!((intake.counts().restarts, intake.counts().foreign), (1, 9));
}

/// F11: a second writer between the frames of a slow sensor is never accepted.
#[test]
fn second_writer_cannot_replace_a_live_one() {
    for rate_hz in [1000.0, 100.0, 30.0] {
        let mut intake = intake(rate_hz);
        let period_ms = (1000.0 / rate_hz) as u64;
        for ms in 0..3000 {
            if ms % period_ms == 0 {
                assert!(feed(
                    &mut intake,
                    &altered(at(ms), |f| f.stamp.sequence = ms / period_ms),
                    tick(ms)
                ));
            } else {
                let rogue = altered(at(ms), |f| {
                    (f.stamp.writer_epoch, f.stamp.sequence) = (66, ms)
                });
                assert!(!feed(&mut intake, &rogue, tick(ms)));
            }
            assert!(
                !intake.hold_reason(tick(ms), &limits()).is_some(),
                "at {ms} ms of {rate_hz} Hz"
            );
        }
        assert_eq!(
            (intake.writer_epoch(), intake.counts().restarts),
            (EPOCH, 0)
        );
    }
}
