//! Bytes in, numbered readings out: decoder and continuity together, still without a clock or a device.

use crate::output::{Health, Reading};
use crate::wire::continuity::Continuity;
use crate::wire::optoforce::{DataFrame, Decoder, DeviceStatus, Kind, Message};

/// Frames of a wrong kind, without one of the right kind, that prove a wrong device. Ours; damaged frames that look
/// like another kind are far rarer.
const WRONG_KIND_FRAMES: u64 = 20;
/// Readings that one read can bring at most, rounded up: 4096 bytes of 16-byte frames, and two that were pending.
const BATCH: usize = 260;

/// Takes one device's stream.
#[derive(Debug)]
pub struct Intake {
    decoder: Decoder,
    series: Series,
    /// Readings that were not delivered yet, in order of arrival, without their time. The owner takes them out.
    pub batch: Vec<Reading>,
}

/// What the messages so far amount to.
#[derive(Debug)]
struct Series {
    kind: Kind,
    continuity: Continuity,
    /// Number of the next frame that is newer than all before and follows without a gap.
    next_sequence: u64,
    awaits_acknowledgement: bool,
    refusal: Option<u8>,
    right_kind: u64,
    wrong_kind: u64,
    last_wrong: Kind,
    device_errors: u64,
    device_status: DeviceStatus,
}

impl Intake {
    /// For a device that sends this kind of frame.
    #[must_use]
    pub fn new(kind: Kind) -> Self {
        let series = Series {
            kind,
            continuity: Continuity::default(),
            next_sequence: 0,
            awaits_acknowledgement: false,
            refusal: None,
            right_kind: 0,
            wrong_kind: 0,
            last_wrong: kind,
            device_errors: 0,
            device_status: DeviceStatus::default(),
        };
        Self {
            decoder: Decoder::default(),
            series,
            batch: Vec::with_capacity(BATCH),
        }
    }

    /// A device was connected. If it was configured, its frames count only after its acknowledgement, because those
    /// before it follow the old settings.
    pub fn begin_stream(&mut self, awaits_acknowledgement: bool) {
        self.series.awaits_acknowledgement = awaits_acknowledgement;
        self.series.refusal = None;
    }

    /// Takes bytes; readings gather in [`Intake::batch`].
    pub fn push(&mut self, bytes: &[u8]) {
        self.decoder
            .push(bytes, |message| self.series.sort(message, &mut self.batch));
    }

    /// The device is gone or the recording at its end: what is pending is settled. All counts go on.
    pub fn finish(&mut self) {
        self.decoder
            .finish(|message| self.series.sort(message, &mut self.batch));
    }

    /// Whether the configuration was not answered yet.
    #[must_use]
    pub fn awaits_acknowledgement(&self) -> bool {
        self.series.awaits_acknowledgement
    }

    /// The status of an acknowledgement that was not "accepted".
    #[must_use]
    pub fn refusal(&self) -> Option<u8> {
        self.series.refusal
    }

    /// What the device sends, when that is clearly not what was expected.
    #[must_use]
    pub fn wrong_kind(&self) -> Option<Kind> {
        let Series {
            right_kind,
            wrong_kind,
            last_wrong,
            ..
        } = self.series;
        (right_kind == 0 && wrong_kind >= WRONG_KIND_FRAMES).then_some(last_wrong)
    }

    /// Everything counted so far; whether the device is alive is for the owner to say.
    #[must_use]
    pub fn health(&self) -> Health {
        Health {
            bytes: self.decoder.counts(),
            continuity: self.series.continuity.totals(),
            device_errors: self.series.device_errors,
            device_status: self.series.device_status,
            alive: false,
        }
    }
}

impl Series {
    fn sort(&mut self, message: Message, batch: &mut Vec<Reading>) {
        match message {
            Message::Acknowledgement(answer) if self.awaits_acknowledgement => {
                self.awaits_acknowledgement = false;
                self.refusal = (answer.status != 0).then_some(answer.status);
            }
            Message::Acknowledgement(_) => {}
            Message::Data(frame) if frame.kind != self.kind => {
                self.wrong_kind += 1;
                self.last_wrong = frame.kind;
            }
            Message::Data(_) if self.awaits_acknowledgement => {}
            Message::Data(frame) => batch.push(self.number(frame)),
        }
    }

    fn number(&mut self, frame: DataFrame) -> Reading {
        self.right_kind += 1;
        self.device_status = frame.status;
        self.device_errors += u64::from(frame.status.is_abnormal());
        let arrival = self.continuity.observe(frame.count);
        self.next_sequence += arrival.advance().unwrap_or(0);
        Reading {
            frame,
            arrival,
            sequence: self.next_sequence - 1,
            captured_ns: 0,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Intake;
    use crate::wire::optoforce::Kind;

    /// A one-channel frame with no load.
    fn frame(count: u16) -> [u8; 16] {
        let mut bytes = [0; 16];
        bytes[..4].copy_from_slice(&[0xAA, 7, 8, 10]);
        bytes[4..6].copy_from_slice(&count.to_be_bytes());
        let sum: u16 = bytes.iter().map(|&byte| u16::from(byte)).sum();
        bytes[14..].copy_from_slice(&sum.to_be_bytes());
        bytes
    }

    fn sequences(intake: &Intake) -> Vec<u64> {
        intake
            .batch
            .iter()
            .map(|reading| reading.sequence)
            .collect()
    }

    #[test]
    fn the_series_has_the_devices_gaps_and_never_goes_back() {
        let mut intake = Intake::new(Kind::OneChannel);
        for count in [65535, 0, 3, 3, 2, 4, 40000, 40001] {
            intake.push(&frame(count));
        }
        assert_eq!(sequences(&intake), [0, 1, 4, 4, 4, 5, 6, 7]);
    }

    #[test]
    fn frames_before_the_acknowledgement_follow_old_settings_and_are_left_out() {
        let mut intake = Intake::new(Kind::OneChannel);
        intake.begin_stream(true);
        intake.push(&frame(1));
        intake.push(&[0xAA, 0, 0x50, 1, 0, 0, 0xFB]);
        intake.push(&frame(9));
        assert_eq!(
            (sequences(&intake), intake.awaits_acknowledgement()),
            (vec![0], false)
        );
        assert_eq!(intake.health().bytes.frames, 2);
    }

    #[test]
    fn a_refusal_and_a_wrong_kind_are_noticed() {
        let mut intake = Intake::new(Kind::FourChannel);
        intake.begin_stream(true);
        intake.push(&[0xAA, 0, 0x50, 1, 2, 0, 0xFD]);
        assert_eq!(intake.refusal(), Some(2));
        (0..19).for_each(|count| intake.push(&frame(count)));
        assert_eq!(intake.wrong_kind(), None);
        intake.push(&frame(19));
        assert_eq!(intake.wrong_kind(), Some(Kind::OneChannel));
    }
}
