//! The input log: what every tick took in and gave out, on its way from the tick to a recorder.
//!
//! A fixed number of boxes goes round: the tick fills a blank one and passes it on, the supervisor publishes it and gives
//! it back. Nothing is allocated, nothing waits; if the blanks are used up, parts are dropped, counted, and missing from
//! the sequence, so that no reader can mistake the rest for the whole.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use atas_core::{Inputs, record};
use rtrb::{Consumer, Producer, RingBuffer};
use shm_schemas::capacity::HANDS;
use shm_schemas::{GraspTarget, HandFrame, JointCommand, JointState, OrderKind, Stamp, TickInputs};

/// Boxes of 12 KiB, locked memory: the supervisor may fall behind by an eighth of a second at 1 kHz, thirty of its rounds.
/// Ours.
const BOXES: usize = 128;
/// Boxes beyond which lock-step waits for the supervisor. They bound its pace to 8,000 ticks per second, at which a recorder
/// may fall behind by 36 ms. Ours.
const WAITING: usize = BOXES / 4;
/// Boxes that go round as long as the supervisor keeps up, few enough to stay in the processor's cache. Ours.
const WARM: usize = 8;

/// The tick's end.
#[derive(Debug)]
pub struct LogWriter {
    /// Blank boxes that were used lately; taken first.
    warm: Consumer<Box<TickInputs>>,
    spare: Consumer<Box<TickInputs>>,
    full: Producer<Box<TickInputs>>,
    sequence: u64,
    dropped: Arc<AtomicU64>,
}

/// The supervisor's end.
#[derive(Debug)]
pub struct LogReader {
    warm: Producer<Box<TickInputs>>,
    spare: Producer<Box<TickInputs>>,
    full: Consumer<Box<TickInputs>>,
    dropped: Arc<AtomicU64>,
}

/// A log with all its boxes blank.
#[must_use]
pub fn input_log() -> (LogWriter, LogReader) {
    let (warm_in, warm) = RingBuffer::new(WARM);
    let (mut spare_in, spare) = RingBuffer::new(BOXES);
    let (full_in, full) = RingBuffer::new(BOXES);
    while spare_in.push(Box::default()).is_ok() {}
    let dropped = Arc::<AtomicU64>::default();
    let writer = LogWriter {
        warm,
        spare,
        full: full_in,
        sequence: 0,
        dropped: Arc::clone(&dropped),
    };
    let reader = LogReader {
        warm: warm_in,
        spare: spare_in,
        full,
        dropped,
    };
    (writer, reader)
}

impl LogWriter {
    /// Keeps what a tick took in, and the command that it gave out.
    pub fn keep(&mut self, inputs: &Inputs<'_>, command: &JointCommand) {
        let frames = inputs.frames.iter().map(|frames| frames.len());
        let parts = frames
            .chain([inputs.targets.len()])
            .max()
            .unwrap_or(0)
            .max(1);
        let first = self.sequence;
        self.sequence += parts as u64;
        for part in 0..parts {
            let Some(mut blank) = self.warm.pop().or_else(|_| self.spare.pop()).ok() else {
                let lost = (parts - part) as u64;
                self.dropped.fetch_add(lost, Ordering::Relaxed);
                return;
            };
            blank.stamp = Stamp {
                sequence: first + part as u64,
                captured_ns: inputs.tick.now_ns,
                writer_epoch: command.stamp.writer_epoch,
            };
            (blank.part, blank.parts) = (part as u32, parts as u32);
            fill(&mut blank, inputs, part, command);
            // There is room for every box there is.
            let _kept = self.full.push(blank);
        }
    }

    /// Whether few parts wait. Time that stands still, as in lock-step, can wait until it is so; nothing is lost then.
    #[must_use]
    pub fn has_room(&self) -> bool {
        BOXES - self.full.slots() < WAITING
    }
}

impl LogReader {
    /// The next part; give it back after use.
    #[must_use]
    pub fn next_part(&mut self) -> Option<Box<TickInputs>> {
        self.full.pop().ok()
    }

    /// Makes a box blank again.
    pub fn give_back(&mut self, used: Box<TickInputs>) {
        if let Err(rtrb::PushError::Full(used)) = self.warm.push(used) {
            // There is room for every box there is.
            let _kept = self.spare.push(used);
        }
    }

    /// Parts dropped because no box was blank.
    #[must_use]
    pub fn dropped(&self) -> u64 {
        self.dropped.load(Ordering::Relaxed)
    }
}

/// Writes one part. What a part has not is zero; it is only written where the box had something before.
fn fill(blank: &mut TickInputs, inputs: &Inputs<'_>, part: usize, command: &JointCommand) {
    blank.tick = inputs.tick.index;
    for hand in 0..HANDS {
        match inputs.frames[hand].get(part) {
            Some(frame) => blank.frames[hand] = *frame,
            None if blank.has_frame[hand] != 0 => blank.frames[hand] = HandFrame::default(),
            None => {}
        }
        blank.has_frame[hand] = u32::from(part < inputs.frames[hand].len());
    }
    match inputs.joints {
        Some(joints) => blank.joints = *joints,
        None if blank.has_joints != 0 => blank.joints = JointState::default(),
        None => {}
    }
    blank.has_joints = u32::from(inputs.joints.is_some());
    match inputs.targets.get(part) {
        Some(target) => blank.target = *target,
        None if blank.has_target != 0 => blank.target = GraspTarget::default(),
        None => {}
    }
    blank.has_target = u32::from(part < inputs.targets.len());
    if inputs.order.is_some() || blank.order.kind != OrderKind::NONE {
        blank.order = record::write_order(inputs.order);
    }
    blank.command = *command;
}

#[cfg(test)]
mod tests {
    use super::*;
    use atas_core::{Order, Tick};

    fn inputs<'a>(index: u64, frames: &'a [HandFrame], order: Option<&'a Order>) -> Inputs<'a> {
        Inputs {
            tick: Tick {
                index,
                now_ns: index,
            },
            frames: [frames, &[]],
            joints: None,
            targets: &[],
            order,
        }
    }

    #[test]
    fn a_used_box_carries_nothing_over() {
        let (mut log, mut reader) = input_log();
        let command = JointCommand::default();
        let frame = HandFrame {
            finger_count: 2,
            ..HandFrame::default()
        };
        log.keep(&inputs(0, &[frame], Some(&Order::Recover)), &command);
        let first = reader.next_part().expect("a part");
        assert_eq!(
            (first.has_frame, first.order.kind),
            ([1, 0], OrderKind::RECOVER)
        );
        assert_eq!(first.frames[0], frame);
        reader.give_back(first);
        log.keep(&inputs(1, &[], None), &command);
        let mut second = reader.next_part().expect("a part");
        assert_eq!((second.stamp.sequence, second.parts), (1, 1));
        (second.stamp, second.tick, second.parts) = (Stamp::default(), 0, 0);
        assert_eq!(*second, TickInputs::default());
    }

    #[test]
    fn several_frames_are_several_parts() {
        let (mut log, mut reader) = input_log();
        let frame = |finger_count| HandFrame {
            finger_count,
            ..HandFrame::default()
        };
        log.keep(
            &inputs(5, &[frame(1), frame(2), frame(3)], None),
            &JointCommand::default(),
        );
        for part in 0..3 {
            let told = reader.next_part().expect("a part");
            assert_eq!((told.part, told.parts, told.tick), (part, 3, 5));
            assert_eq!(
                (told.frames[0].finger_count, told.stamp.sequence),
                (part + 1, u64::from(part))
            );
        }
        assert!(reader.next_part().is_none());
    }

    #[test]
    fn what_finds_no_blank_box_is_counted_and_missing_from_the_sequence() {
        let (mut log, mut reader) = input_log();
        for index in 0..BOXES as u64 + 3 {
            log.keep(&inputs(index, &[], None), &JointCommand::default());
        }
        assert_eq!(reader.dropped(), 3);
        while let Some(part) = reader.next_part() {
            reader.give_back(part);
        }
        log.keep(&inputs(9, &[], None), &JointCommand::default());
        let after = reader.next_part().expect("a part");
        assert_eq!(after.stamp.sequence, BOXES as u64 + 3);
    }

    #[test]
    fn there_is_room_until_a_few_parts_wait() {
        let (mut log, mut reader) = input_log();
        for index in 0..WAITING as u64 {
            assert!(log.has_room(), "{index}");
            log.keep(&inputs(index, &[], None), &JointCommand::default());
        }
        assert!(!log.has_room());
        let part = reader.next_part().expect("a part");
        reader.give_back(part);
        assert!(log.has_room());
    }
}
