//! Frame intake: one faulty frame at a time (fault catalogue F03 to F14).

use crate::support::{EPOCH, MS_NS, frame};
use atas_core::intake::{FrameCounts, FrameIntake};
use atas_core::settings::{Intake as Limits, Settings};
use atas_core::{HandSensorSetup, Tick};
use shm_schemas::{Cause, Hand, HandFrame};

/// Time of tick 0, ns.
pub(crate) const START_NS: u64 = 1_000 * MS_NS;

pub(crate) fn tick(ms: u64) -> Tick {
    Tick {
        index: ms,
        now_ns: START_NS + ms * MS_NS,
    }
}

pub(crate) fn at(ms: u64) -> HandFrame {
    frame(Hand::LEFT, ms, START_NS + ms * MS_NS)
}

pub(crate) fn altered(mut frame: HandFrame, change: impl FnOnce(&mut HandFrame)) -> HandFrame {
    change(&mut frame);
    frame.seal();
    frame
}

pub(crate) fn limits() -> Limits {
    Settings::default().intake
}

/// Intake of the left hand before its first frame.
pub(crate) fn intake(rate_hz: f64) -> FrameIntake {
    FrameIntake::new(
        Hand::LEFT,
        &HandSensorSetup {
            rate_hz,
            ..HandSensorSetup::default()
        },
    )
}

/// Runs one tick with one frame; returns whether it was accepted.
pub(crate) fn feed(intake: &mut FrameIntake, frame: &HandFrame, tick: Tick) -> bool {
    intake.begin();
    intake.validate(frame, tick, &limits()).is_some()
}

/// Intake that has accepted frames 0 to 9.
pub(crate) fn warm() -> FrameIntake {
    let mut intake = intake(1000.0);
    for ms in 0..10 {
        assert!(feed(&mut intake, &at(ms), tick(ms)));
    }
    intake
}

struct Row {
    fault: &'static str,
    frame: HandFrame,
    accepted: bool,
    hold_reason: Cause,
    warning: Cause,
    counts: fn(&mut FrameCounts),
}

fn row(fault: &'static str, frame: HandFrame) -> Row {
    Row {
        fault,
        frame,
        accepted: true,
        hold_reason: Cause::NONE,
        warning: Cause::NONE,
        counts: |_| {},
    }
}

fn rejected(
    fault: &'static str,
    frame: HandFrame,
    warning: Cause,
    counts: fn(&mut FrameCounts),
) -> Row {
    Row {
        accepted: false,
        warning,
        counts,
        ..row(fault, frame)
    }
}

fn flipped(change: fn(&mut HandFrame)) -> HandFrame {
    let mut frame = at(10);
    change(&mut frame);
    frame
}

fn order_rows() -> Vec<Row> {
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
            hold_reason: Cause::FRAMES_LOST,
            ..row("F06 gap of 6", at(16))
        }
        .captured(10),
        rejected("F07 duplicate", at(9), Cause::NONE, |c| c.duplicates += 1),
        rejected("F08 reordered", at(7), Cause::NONE, |c| c.reordered += 1),
    ]
}

fn time_rows() -> Vec<Row> {
    vec![
        rejected(
            "F03 stale",
            altered(at(10), |f| f.stamp.captured_ns -= 101 * MS_NS),
            Cause::FRAME_STALE,
            |c| c.mistimed += 1,
        ),
        rejected(
            "F04 future",
            altered(at(10), |f| f.stamp.captured_ns += 2 * MS_NS),
            Cause::FRAME_FUTURE,
            |c| c.mistimed += 1,
        ),
        rejected(
            "F22 another clock",
            altered(at(10), |f| f.stamp.captured_ns = 5),
            Cause::FRAME_STALE,
            |c| c.mistimed += 1,
        ),
        rejected(
            "F22 end of time",
            altered(at(10), |f| f.stamp.captured_ns = u64::MAX),
            Cause::FRAME_FUTURE,
            |c| c.mistimed += 1,
        ),
        rejected(
            "older than the last",
            altered(at(10), |f| f.stamp.captured_ns = START_NS),
            Cause::FRAME_STALE,
            |c| c.mistimed += 1,
        ),
    ]
}

fn origin_rows() -> Vec<Row> {
    vec![
        rejected(
            "F10 flipped force",
            flipped(|f| f.force_n[1][7][0] += 1.0),
            Cause::FRAME_CORRUPT,
            |c| c.corrupt += 1,
        ),
        rejected(
            "F10 flipped sequence",
            flipped(|f| f.stamp.sequence += 1),
            Cause::FRAME_CORRUPT,
            |c| c.corrupt += 1,
        ),
        rejected(
            "F10 flipped seal",
            flipped(|f| f.crc32 ^= 1),
            Cause::FRAME_CORRUPT,
            |c| c.corrupt += 1,
        ),
        rejected(
            "F11 other hand",
            altered(at(10), |f| f.hand = Hand::RIGHT),
            Cause::FRAME_FOREIGN,
            |c| c.foreign += 1,
        ),
        rejected(
            "F11 no hand",
            altered(at(10), |f| f.hand = Hand(7)),
            Cause::FRAME_FOREIGN,
            |c| c.foreign += 1,
        ),
        rejected(
            "F11 other layout",
            altered(at(10), |f| f.layout_hash ^= 1),
            Cause::FRAME_FOREIGN,
            |c| c.foreign += 1,
        ),
        rejected(
            "F11 other writer",
            altered(at(10), |f| f.stamp.writer_epoch += 1),
            Cause::FRAME_FOREIGN,
            |c| c.foreign += 1,
        ),
        rejected(
            "too few fingers",
            altered(at(10), |f| f.finger_count = 1),
            Cause::FRAME_FOREIGN,
            |c| c.foreign += 1,
        ),
        rejected(
            "too many fingers",
            altered(at(10), |f| f.finger_count = u32::MAX),
            Cause::FRAME_FOREIGN,
            |c| c.foreign += 1,
        ),
    ]
}

fn element_rows() -> Vec<Row> {
    vec![
        masked("F12 NaN", f32::NAN, 1),
        masked("F12 infinite", f32::INFINITY, 1),
        masked("F12 infinite", f32::NEG_INFINITY, 1),
        masked("F14 1e9 N", 1e9, 1),
        masked("F14 −1e9 N", -1e9, 1),
        masked("F13 denormal", f32::from_bits(1), 1),
        masked("large but valid", 49.0, 0),
        Row {
            counts: |c| c.masked_elements += 8,
            ..row(
                "4 of 41 invalid on each finger",
                altered(at(10), |f| f.valid_mask = [!0xf; 4]),
            )
        },
        Row {
            counts: |c| c.masked_elements += 5,
            hold_reason: Cause::ELEMENTS_INVALID,
            ..row(
                "F12 5 of 41 invalid on one finger",
                altered(at(10), |f| f.valid_mask[1] = !0x1f),
            )
        },
    ]
}

impl Row {
    /// Sets the capture time in ms.
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
fn faults_are_counted_and_handled_as_catalogued() {
    let rows = [order_rows(), time_rows(), origin_rows(), element_rows()]
        .into_iter()
        .flatten();
    for Row {
        fault,
        frame,
        accepted,
        hold_reason,
        warning,
        counts,
    } in rows
    {
        let mut intake = warm();
        let mut expected = *intake.counts();
        assert_eq!(feed(&mut intake, &frame, tick(10)), accepted, "{fault}");
        expected.frames += u64::from(accepted);
        counts(&mut expected);
        assert_eq!(*intake.counts(), expected, "{fault}");
        assert_eq!(
            intake.hold_reason(tick(10), &limits()).cause(),
            hold_reason,
            "{fault}"
        );
        assert_eq!(intake.warning().cause(), warning, "{fault}");
        assert_eq!(intake.writer_epoch(), EPOCH, "{fault}");
    }
}

#[test]
fn masked_elements_are_ignored() {
    let mut intake = warm();
    let frame = altered(at(10), |f| {
        f.force_n[0][5] = [f32::NAN, 1.0, 1.0];
        f.force_n[0][6] = [1.0, 2.0, 3.0];
        f.valid_mask[1] &= !1;
    });
    intake.begin();
    let checked = intake.validate(&frame, tick(10), &limits()).unwrap();
    assert_eq!(checked.element_n(0, 5), None);
    assert_eq!(checked.element_n(0, 6), Some([1.0, 2.0, 3.0]));
    assert_eq!(checked.element_n(1, 0), None);
    assert_eq!(checked.step_s(), 1e-3);
}
