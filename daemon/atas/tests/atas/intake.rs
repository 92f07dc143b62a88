//! Intake of frames: the fault catalogue's F02 to F14, F18 and F20, row by row.

use crate::support::{EPOCH, MS_NS, frame};
use atas::intake::{FrameCounts, FrameIntake};
use atas::settings::{Intake as Limits, Settings};
use atas::{HandWiring, Tick};
use shm_schemas::{Cause, Hand, HandFrame};

const START_NS: u64 = 1_000 * MS_NS;

fn tick(ms: u64) -> Tick {
    Tick {
        index: ms,
        now_ns: START_NS + ms * MS_NS,
    }
}

fn at(ms: u64) -> HandFrame {
    frame(Hand::LEFT, ms, START_NS + ms * MS_NS)
}

fn altered(mut frame: HandFrame, change: impl FnOnce(&mut HandFrame)) -> HandFrame {
    change(&mut frame);
    frame.seal();
    frame
}

fn limits() -> Limits {
    Settings::default().intake
}

fn intake(rate_hz: f64) -> FrameIntake {
    FrameIntake::new(
        Hand::LEFT,
        &HandWiring {
            rate_hz,
            ..HandWiring::default()
        },
    )
}

/// One tick with one frame; whether it was believed.
fn feed(intake: &mut FrameIntake, frame: &HandFrame, tick: Tick) -> bool {
    intake.begin();
    intake.check(frame, tick, &limits()).is_some()
}

/// An intake that has believed the frames 0 to 9.
fn warm() -> FrameIntake {
    let mut intake = intake(1000.0);
    for ms in 0..10 {
        assert!(feed(&mut intake, &at(ms), tick(ms)));
    }
    intake
}

/// One frame in tick 10 of a warm intake.
struct Row {
    fault: &'static str,
    frame: HandFrame,
    believed: bool,
    doubt: Cause,
    warning: Cause,
    counts: fn(&mut FrameCounts),
}

fn row(fault: &'static str, frame: HandFrame) -> Row {
    Row {
        fault,
        frame,
        believed: true,
        doubt: Cause::NONE,
        warning: Cause::NONE,
        counts: |_| {},
    }
}

fn rows() -> Vec<Row> {
    let flipped = |field: fn(&mut HandFrame)| {
        let mut frame = at(10);
        field(&mut frame);
        frame
    };
    let refused = |fault, frame, warning, counts| Row {
        believed: false,
        warning,
        counts,
        ..row(fault, frame)
    };
    vec![
        row("in order", at(10)),
        Row {
            counts: |c| c.lost += 3,
            ..row("F05 gap of 3", at(13))
        }
        .captured(10),
        Row {
            counts: |c| c.lost += 5,
            ..row("F05 gap of 5", at(15))
        }
        .captured(10),
        Row {
            counts: |c| c.lost += 6,
            doubt: Cause::FRAMES_LOST,
            ..row("F06 gap of 6", at(16))
        }
        .captured(10),
        refused("F07 duplicate", at(9), Cause::NONE, |c| c.duplicates += 1),
        refused("F08 reordered", at(7), Cause::NONE, |c| c.reordered += 1),
        refused(
            "F03 stale",
            altered(at(10), |f| f.stamp.captured_ns -= 101 * MS_NS),
            Cause::FRAME_STALE,
            |c| c.mistimed += 1,
        ),
        refused(
            "F04 future",
            altered(at(10), |f| f.stamp.captured_ns += 2 * MS_NS),
            Cause::FRAME_FUTURE,
            |c| c.mistimed += 1,
        ),
        refused(
            "F22 another clock",
            altered(at(10), |f| f.stamp.captured_ns = 5),
            Cause::FRAME_STALE,
            |c| c.mistimed += 1,
        ),
        refused(
            "F22 end of time",
            altered(at(10), |f| f.stamp.captured_ns = u64::MAX),
            Cause::FRAME_FUTURE,
            |c| c.mistimed += 1,
        ),
        refused(
            "older than the last",
            altered(at(10), |f| f.stamp.captured_ns = START_NS),
            Cause::FRAME_STALE,
            |c| c.mistimed += 1,
        ),
        refused(
            "F10 flipped force",
            flipped(|f| f.force_n[1][7][0] += 1.0),
            Cause::FRAME_CORRUPT,
            |c| c.corrupt += 1,
        ),
        refused(
            "F10 flipped sequence",
            flipped(|f| f.stamp.sequence += 1),
            Cause::FRAME_CORRUPT,
            |c| c.corrupt += 1,
        ),
        refused(
            "F10 flipped seal",
            flipped(|f| f.crc32 ^= 1),
            Cause::FRAME_CORRUPT,
            |c| c.corrupt += 1,
        ),
        refused(
            "F11 other hand",
            altered(at(10), |f| f.hand = Hand::RIGHT),
            Cause::FRAME_FOREIGN,
            |c| c.foreign += 1,
        ),
        refused(
            "F11 no hand",
            altered(at(10), |f| f.hand = Hand(7)),
            Cause::FRAME_FOREIGN,
            |c| c.foreign += 1,
        ),
        refused(
            "F11 other layout",
            altered(at(10), |f| f.layout_hash ^= 1),
            Cause::FRAME_FOREIGN,
            |c| c.foreign += 1,
        ),
        refused(
            "F11 other writer",
            altered(at(10), |f| f.stamp.writer_epoch += 1),
            Cause::FRAME_FOREIGN,
            |c| c.foreign += 1,
        ),
        refused(
            "too few fingers",
            altered(at(10), |f| f.finger_count = 1),
            Cause::FRAME_FOREIGN,
            |c| c.foreign += 1,
        ),
        refused(
            "too many fingers",
            altered(at(10), |f| f.finger_count = u32::MAX),
            Cause::FRAME_FOREIGN,
            |c| c.foreign += 1,
        ),
        masked("F12 NaN", f32::NAN, 1),
        masked("F12 infinite", f32::INFINITY, 1),
        masked("F12 infinite", f32::NEG_INFINITY, 1),
        masked("F14 1e9 N", 1e9, 1),
        masked("F14 −1e9 N", -1e9, 1),
        masked("F13 denormal", f32::from_bits(1), 0),
        masked("strong but believable", 49.0, 0),
        Row {
            counts: |c| c.masked_elements += 8,
            ..row(
                "8 of 82 invalid",
                altered(at(10), |f| f.valid_mask[0] = !0xff),
            )
        },
        Row {
            counts: |c| c.masked_elements += 9,
            doubt: Cause::ELEMENTS_INVALID,
            ..row(
                "F12 9 of 82 invalid",
                altered(at(10), |f| f.valid_mask[1] = !0x1ff),
            )
        },
    ]
}

impl Row {
    /// The same sequence number, sampled in this millisecond.
    fn captured(mut self, ms: u64) -> Self {
        self.frame = altered(self.frame, |f| f.stamp.captured_ns = START_NS + ms * MS_NS);
        self
    }
}

fn masked(fault: &'static str, value: f32, count: u64) -> Row {
    let counts: fn(&mut FrameCounts) = if count == 1 {
        |c| c.masked_elements += 1
    } else {
        |_| {}
    };
    Row {
        counts,
        ..row(fault, altered(at(10), |f| f.force_n[0][5][2] = value))
    }
}

#[test]
fn every_fault_is_counted_and_answered_as_catalogued() {
    for Row {
        fault,
        frame,
        believed,
        doubt,
        warning,
        counts,
    } in rows()
    {
        let mut intake = warm();
        let mut expected = *intake.counts();
        assert_eq!(feed(&mut intake, &frame, tick(10)), believed, "{fault}");
        expected.frames += u64::from(believed);
        counts(&mut expected);
        assert_eq!(*intake.counts(), expected, "{fault}");
        assert_eq!(intake.doubt(tick(10), &limits()).cause, doubt, "{fault}");
        assert_eq!(intake.warning().cause, warning, "{fault}");
        assert_eq!(intake.writer_epoch(), EPOCH, "{fault}");
    }
}

#[test]
fn masked_elements_are_not_read() {
    let mut intake = warm();
    let frame = altered(at(10), |f| {
        f.force_n[0][5] = [f32::NAN, 1.0, 1.0];
        f.force_n[0][6] = [1.0, 2.0, 3.0];
        f.valid_mask[1] &= !1;
    });
    intake.begin();
    let checked = intake.check(&frame, tick(10), &limits()).unwrap();
    assert_eq!(checked.element_n(0, 5), None);
    assert_eq!(checked.element_n(0, 6), Some([1.0, 2.0, 3.0]));
    assert_eq!(checked.element_n(1, 0), None);
    assert_eq!(checked.step_s(), 1e-3);
}

/// F01, F03: silence and age lead to a doubt after `hold_age_s`, and end with the next frame.
#[test]
fn silence_is_doubted_after_five_milliseconds() {
    let mut intake = warm();
    for (ms, cause) in [
        (10, Cause::NONE),
        (14, Cause::NONE),
        (15, Cause::FRAMES_STOPPED),
        (500, Cause::FRAMES_STOPPED),
    ] {
        intake.begin();
        assert_eq!(intake.doubt(tick(ms), &limits()).cause, cause, "at {ms} ms");
    }
    // Frames that keep coming, but old.
    assert!(feed(
        &mut intake,
        &altered(at(510), |f| f.stamp.captured_ns -= 20 * MS_NS),
        tick(510)
    ));
    assert_eq!(intake.doubt(tick(510), &limits()).cause, Cause::FRAMES_LOST);
    assert!(feed(
        &mut intake,
        &altered(at(511), |f| f.stamp.captured_ns -= 20 * MS_NS),
        tick(511)
    ));
    assert_eq!(intake.doubt(tick(511), &limits()).cause, Cause::FRAME_STALE);
    assert!(feed(&mut intake, &at(512), tick(512)));
    assert_eq!(intake.doubt(tick(512), &limits()).cause, Cause::NONE);
}

#[test]
fn before_the_first_frame_only_a_required_hand_is_doubted() {
    let doubt = |required| {
        let wiring = HandWiring {
            required,
            ..HandWiring::default()
        };
        FrameIntake::new(Hand::LEFT, &wiring)
            .doubt(tick(0), &limits())
            .cause
    };
    assert_eq!(doubt(true), Cause::FRAMES_STOPPED);
    assert_eq!(doubt(false), Cause::NONE);
}

/// F18: a sensor at 100 Hz is silent for 10 ms between its frames.
#[test]
fn a_slow_sensor_may_be_silent_for_three_and_a_half_periods() {
    let mut intake = intake(100.0);
    assert!(feed(&mut intake, &at(0), tick(0)));
    for (ms, cause) in [
        (9, Cause::NONE),
        (34, Cause::NONE),
        (36, Cause::FRAMES_STOPPED),
    ] {
        intake.begin();
        assert_eq!(intake.doubt(tick(ms), &limits()).cause, cause, "at {ms} ms");
    }
}

/// F09.
#[test]
fn a_counter_that_wraps_is_no_fault() {
    let mut intake = intake(1000.0);
    for ms in 0..20 {
        let wrapping = altered(at(ms), |f| {
            f.stamp.sequence = (u64::MAX - 9).wrapping_add(ms)
        });
        assert!(feed(&mut intake, &wrapping, tick(ms)), "at {ms} ms");
        assert_eq!(intake.doubt(tick(ms), &limits()).cause, Cause::NONE);
    }
    assert_eq!(
        *intake.counts(),
        FrameCounts {
            frames: 20,
            ..FrameCounts::default()
        }
    );
}

/// A hostile counter must not overflow the statistics.
#[test]
fn absurd_gaps_are_counted_without_overflow() {
    let mut intake = intake(1000.0);
    let sequences = [
        0,
        u64::MAX / 2,
        u64::MAX - 5,
        u64::MAX / 2 - 8,
        u64::MAX - 9,
    ];
    for (ms, sequence) in (0..).zip(sequences) {
        assert!(feed(
            &mut intake,
            &altered(at(ms), |f| f.stamp.sequence = sequence),
            tick(ms)
        ));
    }
    assert_eq!(intake.counts().lost, u64::MAX);
}

/// F02: data that repeats bit by bit while the counter advances.
#[test]
fn frozen_readings_are_doubted_after_forty_frames() {
    for reading in [0.0, 0.5, f32::NAN] {
        let mut intake = intake(1000.0);
        let mut doubted = None;
        for ms in 0..60 {
            let frozen = altered(at(ms), |f| {
                f.force_n = HandFrame::default().force_n;
                f.force_n[0][0][0] = reading;
            });
            assert!(feed(&mut intake, &frozen, tick(ms)));
            if intake.doubt(tick(ms), &limits()).cause == Cause::FRAMES_FROZEN {
                doubted = doubted.or(Some(ms));
            }
        }
        assert_eq!(doubted, Some(40), "frozen at {reading}");
        assert!(feed(&mut intake, &at(60), tick(60)));
        assert!(!intake.doubt(tick(60), &limits()).is_some());
    }
}

/// F20: a restarted sensor is believed after a silence and twenty good frames, with the robot held meanwhile.
#[test]
fn a_restarted_writer_is_believed_after_silence_and_a_run_of_good_frames() {
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
            intake.doubt(tick(ms), &limits()).cause,
            intake.writer_epoch(),
        ));
    }
    // Until 29 ms the old writer may only be late; then 20 frames on probation.
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

/// F11: whoever speaks between the frames of a slow, living sensor is never believed.
#[test]
fn a_second_writer_cannot_take_over_from_a_living_one() {
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
                !intake.doubt(tick(ms), &limits()).is_some(),
                "at {ms} ms of {rate_hz} Hz"
            );
        }
        assert_eq!(
            (intake.writer_epoch(), intake.counts().restarts),
            (EPOCH, 0)
        );
    }
}
