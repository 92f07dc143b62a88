//! Bytes in, numbered readings out: driver and continuity together, still without a clock or a device.

use crate::continuity::{Arrival, Continuity};
use crate::reading::{Batch, Frame, Health, Reading, Shape};
use crate::wire::{Driver, Event};

/// Frames of a wrong kind, without one of the right kind, that prove a wrong device. Ours; damaged frames that look
/// like another kind are far rarer.
const FOREIGN_FRAMES: u64 = 20;
/// Frames whose mean becomes zero, for devices that cannot take their zero themselves. Ours: half a second at 100 Hz.
const TARE_FRAMES: u32 = 50;

/// Takes one device's stream.
pub struct Intake {
    driver: Box<dyn Driver>,
    series: Series,
    /// Readings that were not delivered yet, in order of arrival, without their time. The owner takes them out.
    pub batch: Batch,
}

/// What the events so far amount to.
struct Series {
    continuity: Continuity,
    tare: Option<Tare>,
    awaits_acknowledgement: bool,
    refusal: Option<u32>,
    frames: u64,
    foreign: u64,
    last_foreign: &'static str,
    unanswered: u64,
    device_errors: u64,
    device_status: u32,
}

/// The zero that is taken here.
struct Tare {
    frames: u32,
    mean: Vec<f64>,
    /// Room for a frame without its zero.
    tared: Vec<f64>,
}

impl Intake {
    /// For a device with this driver. With `tare`, the mean of the first frames is subtracted from all that follow.
    #[must_use]
    pub fn new(driver: Box<dyn Driver>, tare: bool) -> Self {
        let shape = driver.shape();
        let series = Series {
            continuity: Continuity::new(driver.counter_bits()),
            tare: tare.then(|| Tare {
                frames: 0,
                mean: vec![0.0; shape.values()],
                tared: Vec::with_capacity(shape.values()),
            }),
            awaits_acknowledgement: false,
            refusal: None,
            frames: 0,
            foreign: 0,
            last_foreign: "",
            unanswered: 0,
            device_errors: 0,
            device_status: 0,
        };
        Self {
            driver,
            series,
            batch: Batch::new(shape),
        }
    }

    /// What every frame holds.
    #[must_use]
    pub fn shape(&self) -> Shape {
        self.driver.shape()
    }

    /// The driver, for its dialogue.
    #[must_use]
    pub fn driver(&self) -> &dyn Driver {
        self.driver.as_ref()
    }

    /// A device was connected. If it was configured, its frames count only after its acknowledgement, because those
    /// before it follow the old settings.
    pub fn begin_stream(&mut self, awaits_acknowledgement: bool) {
        self.series.awaits_acknowledgement = awaits_acknowledgement;
        self.series.refusal = None;
    }

    /// The device was told to begin anew.
    pub fn begin_anew(&mut self) {
        self.series.continuity.expect_restart();
    }

    /// A request was not answered: one frame is missing.
    pub fn miss(&mut self) {
        self.series.unanswered += 1;
    }

    /// Takes bytes; readings gather in [`Intake::batch`].
    pub fn push(&mut self, bytes: &[u8]) {
        let (series, batch) = (&mut self.series, &mut self.batch);
        self.driver
            .receive(bytes, &mut |event| series.sort(event, batch));
    }

    /// The device is gone or the recording at its end: what is pending is settled. All counts go on.
    pub fn finish(&mut self) {
        let (series, batch) = (&mut self.series, &mut self.batch);
        self.driver.finish(&mut |event| series.sort(event, batch));
    }

    /// Whether the configuration was not answered yet.
    #[must_use]
    pub fn awaits_acknowledgement(&self) -> bool {
        self.series.awaits_acknowledgement
    }

    /// The status of an acknowledgement that was not "accepted".
    #[must_use]
    pub fn refusal(&self) -> Option<u32> {
        self.series.refusal
    }

    /// What the device sends, when that is clearly not what was expected.
    #[must_use]
    pub fn foreign(&self) -> Option<&'static str> {
        let Series {
            frames,
            foreign,
            last_foreign,
            ..
        } = self.series;
        (frames == 0 && foreign >= FOREIGN_FRAMES).then_some(last_foreign)
    }

    /// Everything counted so far; whether the device is alive is for the owner to say.
    #[must_use]
    pub fn health(&self) -> Health {
        let mut continuity = self.series.continuity.totals();
        continuity.lost += self.series.unanswered;
        Health {
            bytes: self.driver.counts(),
            continuity,
            device_errors: self.series.device_errors,
            device_status: self.series.device_status,
            alive: false,
        }
    }
}

impl Series {
    fn sort(&mut self, event: Event<'_>, batch: &mut Batch) {
        match event {
            Event::Acknowledged(status) if self.awaits_acknowledgement => {
                self.awaits_acknowledgement = false;
                self.refusal = (status != 0).then_some(status);
            }
            Event::Acknowledged(_) => {}
            Event::Foreign(kind) => {
                self.foreign += 1;
                self.last_foreign = kind;
            }
            Event::Frame(_) if self.awaits_acknowledgement => {}
            Event::Frame(frame) => self.number(&frame, batch),
        }
    }

    fn number(&mut self, frame: &Frame<'_>, batch: &mut Batch) {
        let first = self.frames == 0;
        self.frames += 1;
        self.device_status = frame.status;
        self.device_errors += u64::from(frame.condition != Default::default());
        let arrival = match frame.count {
            Some(count) => self.continuity.observe(count),
            None if first => Arrival::First,
            None => Arrival::Newer { gap: 0 },
        };
        let reading = Reading {
            byte_offset: frame.byte_offset,
            count: frame.count,
            status: frame.status,
            temperature_c: frame.temperature_c,
            condition: frame.condition,
            arrival,
            advance: arrival.advance().unwrap_or(0),
            captured_ns: 0,
        };
        match &mut self.tare {
            None => batch.push(reading, frame.values),
            Some(tare) => {
                if let Some(values) = tare.subtract(frame.values) {
                    batch.push(reading, values);
                }
            }
        }
    }
}

impl Tare {
    /// The values without their zero; `None` while it is being taken.
    fn subtract(&mut self, values: &[f64]) -> Option<&[f64]> {
        if self.frames < TARE_FRAMES {
            self.frames += 1;
            for (mean, value) in self.mean.iter_mut().zip(values) {
                *mean += (value - *mean) / f64::from(self.frames);
            }
            return None;
        }
        self.tared.clear();
        self.tared.extend(
            values
                .iter()
                .zip(&self.mean)
                .map(|(value, zero)| value - zero),
        );
        Some(&self.tared)
    }
}

#[cfg(test)]
mod tests {
    use super::Intake;
    use crate::reading::{ByteCounts, Condition, Frame, Quantity, Shape};
    use crate::wire::{Dialogue, Driver, Event};

    /// Each byte is an event: below 100 a frame with that count and value, 100 foreign, above an acknowledgement.
    #[derive(Default)]
    struct Spoken(ByteCounts);

    impl Driver for Spoken {
        fn shape(&self) -> Shape {
            Shape {
                quantity: Quantity::Pressure,
                unit: "counts",
                fingers: 1,
                taxels: 1,
            }
        }

        fn dialogue(&self) -> Dialogue {
            Dialogue::default()
        }

        fn receive(&mut self, bytes: &[u8], report: &mut dyn FnMut(Event<'_>)) {
            for &byte in bytes {
                self.0.frames += u64::from(byte < 100);
                match byte {
                    0..100 => report(Event::Frame(Frame {
                        byte_offset: 0,
                        count: Some(byte.into()),
                        status: 0,
                        temperature_c: None,
                        condition: Condition::Well,
                        values: &[byte.into()],
                    })),
                    100 => report(Event::Foreign("others; pass --others")),
                    _ => report(Event::Acknowledged((byte - 101).into())),
                }
            }
        }

        fn counts(&self) -> ByteCounts {
            self.0
        }
    }

    fn intake(tare: bool) -> Intake {
        Intake::new(Box::new(Spoken::default()), tare)
    }

    #[test]
    fn a_reading_advances_by_the_devices_gaps_and_never_goes_back() {
        let mut intake = intake(false);
        intake.push(&[1, 2, 5, 5, 4, 6]);
        let advances: Vec<u64> = intake.batch.readings.iter().map(|r| r.advance).collect();
        assert_eq!(advances, [1, 1, 3, 0, 0, 1]);
        intake.miss();
        assert_eq!(intake.health().continuity.lost, 1 + 1);
    }

    #[test]
    fn frames_before_the_acknowledgement_follow_old_settings_and_are_left_out() {
        let mut intake = intake(false);
        intake.begin_stream(true);
        intake.push(&[1, 101, 9]);
        assert_eq!(
            (intake.batch.len(), intake.awaits_acknowledgement()),
            (1, false)
        );
        assert_eq!(intake.health().bytes.frames, 2);
    }

    #[test]
    fn a_refusal_and_a_wrong_kind_are_noticed() {
        let mut intake = intake(false);
        intake.begin_stream(true);
        intake.push(&[103]);
        assert_eq!(intake.refusal(), Some(2));
        intake.push(&[100; 19]);
        assert_eq!(intake.foreign(), None);
        intake.push(&[100]);
        assert_eq!(intake.foreign(), Some("others; pass --others"));
    }

    #[test]
    fn the_load_at_the_start_becomes_zero() {
        let mut intake = intake(true);
        for n in 0..25 {
            intake.push(&[10, 20]);
            assert!(intake.batch.is_empty(), "{n}");
        }
        intake.push(&[18]);
        assert_eq!(intake.batch.iter().next().unwrap().1, [3.0]);
    }
}
