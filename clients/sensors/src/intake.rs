//! Converts bytes to numbered readings: driver plus [`Continuity`], without clock or device.

use crate::continuity::{Arrival, Continuity};
use crate::reading::{Batch, Frame, Health, Reading, Shape};
use crate::wire::{Driver, Event};

/// Wrong-type frames, without a right one, that identify a wrong device. Design choice: damaged
/// frames rarely resemble another type.
const FOREIGN_FRAMES: u64 = 20;
/// Frames averaged as zero, if the device cannot zero itself. Design choice: half a second at 100
/// Hz.
const TARE_FRAMES: u32 = 50;

/// Decoder state of one stream.
pub struct Intake {
    driver: Box<dyn Driver>,
    series: Series,
    /// Pending readings without capture time; the owner removes them.
    pub batch: Batch,
}

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

/// Zero taken in this process.
struct Tare {
    frames: u32,
    mean: Vec<f64>,
    tared: Vec<f64>,
}

impl Intake {
    /// Creates the intake. With `tare`, subtracts the mean of the first frames from all later ones.
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

    /// Returns the frame content.
    #[must_use]
    pub fn shape(&self) -> Shape {
        self.driver.shape()
    }

    /// Returns the driver.
    #[must_use]
    pub fn driver(&self) -> &dyn Driver {
        self.driver.as_ref()
    }

    /// Begins the stream of a connected device. With `awaits_acknowledgement`, discards earlier
    /// frames, which follow the old settings.
    pub fn begin_stream(&mut self, awaits_acknowledgement: bool) {
        self.series.awaits_acknowledgement = awaits_acknowledgement;
        self.series.refusal = None;
    }

    /// Expects the device's counter to restart.
    pub fn expect_restart(&mut self) {
        self.series.continuity.expect_restart();
    }

    /// Counts an unanswered poll as a lost frame.
    pub fn count_unanswered(&mut self) {
        self.series.unanswered += 1;
    }

    /// Decodes bytes and appends readings to [`Intake::batch`].
    pub fn push(&mut self, bytes: &[u8]) {
        let (series, batch) = (&mut self.series, &mut self.batch);
        self.driver
            .receive(bytes, &mut |event| series.handle_event(event, batch));
    }

    /// Classifies pending bytes at the end of the stream; counts continue.
    pub fn finish(&mut self) {
        let (series, batch) = (&mut self.series, &mut self.batch);
        self.driver
            .finish(&mut |event| series.handle_event(event, batch));
    }

    /// Returns whether the configuration is still unacknowledged.
    #[must_use]
    pub fn awaits_acknowledgement(&self) -> bool {
        self.series.awaits_acknowledgement
    }

    /// Returns the status of a negative acknowledgement.
    #[must_use]
    pub fn refusal(&self) -> Option<u32> {
        self.series.refusal
    }

    /// Returns the type of the data if it is clearly a wrong one.
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

    /// Returns all counts; the owner sets `alive`.
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
    fn handle_event(&mut self, event: Event<'_>, batch: &mut Batch) {
        match event {
            Event::Acknowledged(status) if self.awaits_acknowledgement => {
                self.awaits_acknowledgement = false;
                self.refusal = (status != 0).then_some(status);
            }
            Event::Acknowledged(_) => {}
            Event::OtherKind(kind) => {
                self.foreign += 1;
                self.last_foreign = kind;
            }
            Event::Frame(_) if self.awaits_acknowledgement => {}
            Event::Frame(frame) => self.add_frame(&frame, batch),
        }
    }

    fn add_frame(&mut self, frame: &Frame<'_>, batch: &mut Batch) {
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
    /// Returns values minus zero; `None` while taking the zero.
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
    use crate::wire::{DeviceMessages, Driver, Event};

    /// Driver that treats bytes as events: below 100 a frame with that count and value, 100
    /// foreign, above an acknowledgement.
    #[derive(Default)]
    struct ScriptedDriver(ByteCounts);

    impl Driver for ScriptedDriver {
        fn shape(&self) -> Shape {
            Shape {
                quantity: Quantity::Pressure,
                unit: "counts",
                fingers: 1,
                taxels: 1,
            }
        }

        fn messages(&self) -> DeviceMessages {
            DeviceMessages::default()
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
                        condition: Condition::Normal,
                        values: &[byte.into()],
                    })),
                    100 => report(Event::OtherKind("others; pass --others")),
                    _ => report(Event::Acknowledged((byte - 101).into())),
                }
            }
        }

        fn counts(&self) -> ByteCounts {
            self.0
        }
    }

    fn intake(tare: bool) -> Intake {
        Intake::new(Box::new(ScriptedDriver::default()), tare)
    }

    #[test]
    fn reading_advance_includes_device_gaps() {
        let mut intake = intake(false);
        intake.push(&[1, 2, 5, 5, 4, 6]);
        let advances: Vec<u64> = intake.batch.readings.iter().map(|r| r.advance).collect();
        assert_eq!(advances, [1, 1, 3, 0, 0, 1]);
        intake.count_unanswered();
        assert_eq!(intake.health().continuity.lost, 1 + 1);
    }

    #[test]
    fn frames_before_acknowledgement_are_discarded() {
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
    fn refusal_and_wrong_sensor_type_are_detected() {
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
    fn tare_subtracts_the_initial_load() {
        let mut intake = intake(true);
        for n in 0..25 {
            intake.push(&[10, 20]);
            assert!(intake.batch.is_empty(), "{n}");
        }
        intake.push(&[18]);
        assert_eq!(intake.batch.iter().next().unwrap().1, [3.0]);
    }
}
