//! Input log: passes the inputs and the command of every tick to a recorder.
//!
//! A fixed number of buffers circulates: the tick fills one, the supervisor publishes and returns
//! it. Nothing is allocated and nothing waits. Without a free buffer, parts are dropped, counted
//! and missing in the sequence, so that a reader detects the gap.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use atas_core::{Inputs, record};
use rtrb::{Consumer, Producer, RingBuffer};
use shm_schemas::capacity::HANDS;
use shm_schemas::{GraspTarget, HandFrame, JointCommand, JointState, OrderKind, Stamp, TickInputs};

/// Number of buffers of 12 KiB, locked memory: 0.128 s of supervisor delay at 1 kHz, about thirty
/// rounds. Design choice.
const BUFFERS: usize = 128;
/// Filled buffers beyond which lock-step waits. They limit its pace to 8,000 ticks per second, at
/// which a recorder may lag 36 ms. Design choice.
const QUEUED_MAX: usize = BUFFERS / 4;
/// Buffers that circulate while the supervisor keeps up, few enough to stay in the processor's
/// cache. Design choice.
const CACHED: usize = 8;

/// Tick side of the log.
#[derive(Debug)]
pub struct LogWriter {
    /// Recently used free buffers, taken first.
    cached: Consumer<Box<TickInputs>>,
    free: Consumer<Box<TickInputs>>,
    filled: Producer<Box<TickInputs>>,
    sequence: u64,
    dropped: Arc<AtomicU64>,
}

/// Supervisor side of the log.
#[derive(Debug)]
pub struct LogReader {
    cached: Producer<Box<TickInputs>>,
    free: Producer<Box<TickInputs>>,
    filled: Consumer<Box<TickInputs>>,
    dropped: Arc<AtomicU64>,
}

/// Creates a log with all buffers free.
#[must_use]
pub fn input_log() -> (LogWriter, LogReader) {
    let (warm_in, warm) = RingBuffer::new(CACHED);
    let (mut spare_in, spare) = RingBuffer::new(BUFFERS);
    let (full_in, full) = RingBuffer::new(BUFFERS);
    while spare_in.push(Box::default()).is_ok() {}
    let dropped = Arc::<AtomicU64>::default();
    let writer = LogWriter {
        cached: warm,
        free: spare,
        filled: full_in,
        sequence: 0,
        dropped: Arc::clone(&dropped),
    };
    let reader = LogReader {
        cached: warm_in,
        free: spare_in,
        filled: full,
        dropped,
    };
    (writer, reader)
}

impl LogWriter {
    /// Records the inputs and the command of a tick.
    pub fn record(&mut self, inputs: &Inputs<'_>, command: &JointCommand) {
        let frames = inputs.frames.iter().map(|frames| frames.len());
        let parts = frames
            .chain([inputs.targets.len()])
            .max()
            .unwrap_or(0)
            .max(1);
        let first = self.sequence;
        self.sequence += parts as u64;
        for part in 0..parts {
            let Some(mut blank) = self.cached.pop().or_else(|_| self.free.pop()).ok() else {
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
            // The queue has room for all buffers.
            let _kept = self.filled.push(blank);
        }
    }

    /// Returns true if few parts are queued. Lock-step waits for this, so that nothing is lost.
    #[must_use]
    pub fn has_room(&self) -> bool {
        BUFFERS - self.filled.slots() < QUEUED_MAX
    }
}

impl LogReader {
    /// The next part; recycle it after use.
    #[must_use]
    pub fn next_part(&mut self) -> Option<Box<TickInputs>> {
        self.filled.pop().ok()
    }

    /// Returns a buffer to the free ones.
    pub fn recycle(&mut self, used: Box<TickInputs>) {
        if let Err(rtrb::PushError::Full(used)) = self.cached.push(used) {
            // The queue has room for all buffers.
            let _kept = self.free.push(used);
        }
    }

    /// Number of parts dropped without a free buffer.
    #[must_use]
    pub fn dropped(&self) -> u64 {
        self.dropped.load(Ordering::Relaxed)
    }
}

/// Writes one part. Missing entries are zero, and written only if the buffer contained others.
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
    if inputs.request.is_some() || blank.order.kind != OrderKind::NONE {
        blank.order = record::write_request(inputs.request);
    }
    blank.command = *command;
}

#[cfg(test)]
mod tests {
    use super::*;
    use atas_core::{OperatorRequest, Tick};

    fn inputs<'a>(
        index: u64,
        frames: &'a [HandFrame],
        order: Option<&'a OperatorRequest>,
    ) -> Inputs<'a> {
        Inputs {
            tick: Tick {
                index,
                now_ns: index,
            },
            frames: [frames, &[]],
            joints: None,
            targets: &[],
            request: order,
        }
    }

    #[test]
    fn recycled_buffer_is_cleared() {
        let (mut log, mut reader) = input_log();
        let command = JointCommand::default();
        let frame = HandFrame {
            finger_count: 2,
            ..HandFrame::default()
        };
        log.record(
            &inputs(0, &[frame], Some(&OperatorRequest::Recover)),
            &command,
        );
        let first = reader.next_part().expect("a part");
        assert_eq!(
            (first.has_frame, first.order.kind),
            ([1, 0], OrderKind::RECOVER)
        );
        assert_eq!(first.frames[0], frame);
        reader.recycle(first);
        log.record(&inputs(1, &[], None), &command);
        let mut second = reader.next_part().expect("a part");
        assert_eq!((second.stamp.sequence, second.parts), (1, 1));
        (second.stamp, second.tick, second.parts) = (Stamp::default(), 0, 0);
        assert_eq!(*second, TickInputs::default());
    }

    #[test]
    fn several_frames_give_several_parts() {
        let (mut log, mut reader) = input_log();
        let frame = |finger_count| HandFrame {
            finger_count,
            ..HandFrame::default()
        };
        log.record(
            &inputs(5, &[frame(1), frame(2), frame(3)], None),
            &JointCommand::default(),
        );
        for part in 0..3 {
            let reported = reader.next_part().expect("a part");
            assert_eq!((reported.part, reported.parts, reported.tick), (part, 3, 5));
            assert_eq!(
                (reported.frames[0].finger_count, reported.stamp.sequence),
                (part + 1, u64::from(part))
            );
        }
        assert!(reader.next_part().is_none());
    }

    #[test]
    fn dropped_parts_are_counted_and_leave_gap() {
        let (mut log, mut reader) = input_log();
        for index in 0..BUFFERS as u64 + 3 {
            log.record(&inputs(index, &[], None), &JointCommand::default());
        }
        assert_eq!(reader.dropped(), 3);
        while let Some(part) = reader.next_part() {
            reader.recycle(part);
        }
        log.record(&inputs(9, &[], None), &JointCommand::default());
        let after = reader.next_part().expect("a part");
        assert_eq!(after.stamp.sequence, BUFFERS as u64 + 3);
    }

    #[test]
    fn has_room_is_false_with_queued_parts() {
        let (mut log, mut reader) = input_log();
        for index in 0..QUEUED_MAX as u64 {
            assert!(log.has_room(), "{index}");
            log.record(&inputs(index, &[], None), &JointCommand::default());
        }
        assert!(!log.has_room());
        let part = reader.next_part().expect("a part");
        reader.recycle(part);
        assert!(log.has_room());
    }
}
