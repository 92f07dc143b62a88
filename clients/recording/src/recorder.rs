//! Recorder: copies bus data into files. One thread only reads the bus, so that a slow disk loses
//! nothing until the channel between the two threads is full. Gaps in the sequence show the loss.

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, SyncSender, sync_channel};
use std::time::Duration;

use atas_client::json;
use atas_process::scheduling;
use shm_bus::{Bus, BusError, Subscriber};
use shm_schemas::{
    ModuleEvent, Payload, RunHeader, SensorStatus, Status, TickInputs, TickReport, service,
};

use super::follower::Follower;
use super::rotation::{Bounds, Recording, Tally};

/// Pause between two polls of the bus, whose streams hold 256 payloads. Design choice: at 10 kHz, 1
/// ms adds 10 ticks.
const POLL: Duration = Duration::from_millis(1);
/// Largest number of payloads per stream and poll.
const PAYLOADS_PER_POLL: usize = 256;
/// Capacity of the channel between the threads, payloads: 4 s at 1 kHz, about 50 MiB. Design
/// choice.
const CHANNEL_CAPACITY: usize = 8192;
/// Real-time priority of the reading thread: below all others. Design choice.
const PRIORITY: i32 = 1;
/// Longest wait of the writing thread before it checks whether to flush.
const IDLE_WAIT: Duration = Duration::from_millis(100);
/// Number of statuses without inputs after which the recorder warns that the daemon does not
/// publish them: 2 s. Design choice.
const SILENT_STATUSES: u32 = 100;

/// Message from the reading to the writing thread.
enum Message {
    Run(Box<RunHeader>),
    Inputs(Box<TickInputs>),
    Report(Box<TickReport>),
    Event(Box<ModuleEvent>),
    Status(Box<Status>),
    Sensor(Box<SensorStatus>),
}

/// Records until `stop` is set or the byte budget is used up. With a `follower`, every file of a
/// run can be replayed separately. Calls `listening` when the recorder misses nothing more; start
/// the daemon after that.
///
/// # Errors
/// The bus or the files cannot be opened, read or written.
/// The bus or the files cannot be opened, read or written.
pub fn record(
    bus: &Bus,
    out: &Path,
    bounds: Bounds,
    notes: BTreeMap<String, String>,
    follower: Option<Box<dyn Follower>>,
    listening: impl FnOnce(),
    stop: &AtomicBool,
) -> anyhow::Result<Tally> {
    let mut ports = Ports::open(bus)?;
    let recording = Recording::create(out, bounds, notes, follower)?;
    listening();
    tracing::info!(file = %out.display(), "recording until Ctrl-C");
    let (send, receive) = sync_channel(CHANNEL_CAPACITY);
    let writing = std::thread::spawn(move || write(recording, &receive));
    let read = ports.read(&send, stop);
    drop(send);
    let written = writing
        .join()
        .unwrap_or_else(|_| Err(anyhow::anyhow!("the writing thread panicked")));
    read?;
    written
}

/// Writes until the channel closes or the disk budget is used up.
fn write(mut recording: Recording, messages: &Receiver<Message>) -> anyhow::Result<Tally> {
    let mut silent = 0;
    loop {
        match messages.recv_timeout(IDLE_WAIT) {
            Ok(message) => write_message(&mut recording, message, &mut silent)?,
            Err(RecvTimeoutError::Timeout) => {}
            Err(RecvTimeoutError::Disconnected) => return recording.finish(),
        }
        if !recording.flush_and_rotate()? {
            return Ok(Tally {
                is_full: true,
                ..recording.finish()?
            });
        }
    }
}

fn write_message(
    recording: &mut Recording,
    message: Message,
    silent: &mut u32,
) -> anyhow::Result<()> {
    match message {
        Message::Run(header) => recording.begin_run(header),
        Message::Inputs(part) => recording.inputs(&part),
        Message::Report(report) => recording.writer().write(&*report),
        Message::Event(event) => {
            recording.writer().write(&*event)?;
            let value = json::event(&event);
            recording
                .writer()
                .write_json("events", &event.stamp, &value)
        }
        Message::Sensor(status) => recording.writer().write(&*status),
        Message::Status(status) => {
            *silent += u32::from(!recording.has_inputs());
            if *silent == SILENT_STATUSES {
                tracing::warn!(
                    "the daemon does not publish what it takes in: this recording cannot be replayed; \
                     start it with --record-stream, after the recorder"
                );
            }
            recording.writer().write(&*status)?;
            let value = json::status(&status, json::CAPACITY);
            recording
                .writer()
                .write_json("status", &status.stamp, &value)
        }
    }
}

/// Streams of the daemon's supervisor, and device information of sensor processes.
struct Ports {
    runs: Subscriber<RunHeader>,
    inputs: Subscriber<TickInputs>,
    reports: Subscriber<TickReport>,
    events: Subscriber<ModuleEvent>,
    statuses: Subscriber<Status>,
    sensors: Subscriber<SensorStatus>,
    has_run: bool,
}

impl Ports {
    fn open(bus: &Bus) -> Result<Self, BusError> {
        Ok(Self {
            inputs: bus.subscriber(service::TICK_INPUTS)?,
            runs: bus.subscriber(service::RUN_HEADER)?,
            reports: bus.subscriber(service::TICK_REPORT)?,
            events: bus.subscriber(service::MODULE_EVENT)?,
            statuses: bus.subscriber(service::STATUS)?,
            sensors: bus.subscriber(service::SENSOR_STATUS)?,
            has_run: false,
        })
    }

    /// Forwards payloads until a signal arrives or no writer is left.
    ///
    /// The stream of inputs holds a quarter of a second, so this thread runs with real-time
    /// priority if permitted.
    fn read(&mut self, messages: &SyncSender<Message>, stop: &AtomicBool) -> Result<(), BusError> {
        // Without permission, a busy machine may lose parts, which are counted.
        let _ = scheduling::enter_fifo(PRIORITY);
        let mut waiting = Vec::new();
        loop {
            let last = stop.load(Ordering::Relaxed);
            self.poll(&mut waiting)?;
            for message in waiting.drain(..) {
                if messages.send(message).is_err() {
                    return Ok(());
                }
            }
            if last {
                return Ok(());
            }
            std::thread::sleep(POLL);
        }
    }

    /// Reads all streams. A header is published before the ticks of its run and has arrived when
    /// they have. So it is read after them and placed before them.
    fn poll(&mut self, waiting: &mut Vec<Message>) -> Result<(), BusError> {
        take(&mut self.inputs, waiting, Message::Inputs)?;
        let mut header = Vec::new();
        take(&mut self.runs, &mut header, Message::Run)?;
        if !header.is_empty() {
            let at = first_part_of_run(waiting, self.has_run);
            waiting.splice(at..at, header);
            self.has_run = true;
        }
        take(&mut self.reports, waiting, Message::Report)?;
        take(&mut self.events, waiting, Message::Event)?;
        take(&mut self.statuses, waiting, Message::Status)?;
        take(&mut self.sensors, waiting, Message::Sensor)
    }
}

/// Returns the index at which the new run begins among the parts that arrived with its header: its
/// first part. Without a first part, all belong to the previous run or to a run that was joined
/// late.
fn first_part_of_run(parts: &[Message], has_run: bool) -> usize {
    let is_first =
        |message: &Message| matches!(message, Message::Inputs(part) if part.stamp.sequence == 0);
    let otherwise = if has_run { parts.len() } else { 0 };
    parts.iter().position(is_first).unwrap_or(otherwise)
}

fn take<T: Payload>(
    port: &mut Subscriber<T>,
    waiting: &mut Vec<Message>,
    message: impl Fn(Box<T>) -> Message,
) -> Result<(), BusError> {
    port.drain(PAYLOADS_PER_POLL, |payload| {
        waiting.push(message(Box::new(*payload)))
    })?;
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn header_is_placed_between_runs() {
        let check = |sequences: &[u64], has_run: bool, at: usize| {
            let part = |sequence: &u64| {
                let mut part = Box::<TickInputs>::default();
                part.stamp.sequence = *sequence;
                Message::Inputs(part)
            };
            let parts: Vec<Message> = sequences.iter().map(part).collect();
            assert_eq!(first_part_of_run(&parts, has_run), at, "{sequences:?}");
        };
        check(&[], false, 0);
        check(&[0, 1], false, 0);
        check(&[70, 71, 0, 1], true, 2);
        check(&[70, 71], true, 2);
        check(&[70, 71], false, 0);
    }
}
