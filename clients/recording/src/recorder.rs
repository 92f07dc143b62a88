//! From the bus into files. One thread only reads the bus, so that a slow disk costs nothing until the
//! channel between the two is full; what is lost then shows in the sequence.

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

/// Pause between two looks at the bus, whose streams hold 256 payloads (ours: 5 ms of ticks at 10 kHz are 50).
const LOOK: Duration = Duration::from_millis(1);
/// Most payloads taken of one stream in one look.
const AT_ONCE: usize = 256;
/// Payloads between the threads: 4 s at 1 kHz, about 50 MiB. Ours.
const WAITING: usize = 8192;
/// Real-time priority of the reading thread: below every other that there is. Ours.
const PRIORITY: i32 = 1;
/// How long the writing thread waits before it looks whether to flush.
const IDLE: Duration = Duration::from_millis(100);
/// Statuses heard before a daemon counts as one that does not publish what it takes in (ours: 2 s).
const SILENT_STATUSES: u32 = 100;

/// What goes from the reading to the writing thread.
enum Message {
    Run(Box<RunHeader>),
    Inputs(Box<TickInputs>),
    Report(Box<TickReport>),
    Event(Box<ModuleEvent>),
    Status(Box<Status>),
    Sensor(Box<SensorStatus>),
}

/// Records until `stop` is set or the bytes are used up. With a `follower`, every file of a run can be replayed by itself.
/// `listening` is called once nothing that a daemon says can be missed: before, it should not begin.
///
/// # Errors
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
    let (send, receive) = sync_channel(WAITING);
    let writing = std::thread::spawn(move || write(recording, &receive));
    let read = ports.read(&send, stop);
    drop(send);
    let written = writing
        .join()
        .unwrap_or_else(|_| Err(anyhow::anyhow!("the writing thread panicked")));
    read?;
    written
}

/// Until the channel closes, or the disk budget is used up.
fn write(mut recording: Recording, messages: &Receiver<Message>) -> anyhow::Result<Tally> {
    let mut silent = 0;
    loop {
        match messages.recv_timeout(IDLE) {
            Ok(message) => write_message(&mut recording, message, &mut silent)?,
            Err(RecvTimeoutError::Timeout) => {}
            Err(RecvTimeoutError::Disconnected) => return recording.finish(),
        }
        if !recording.keep_up()? {
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
            let value = json::status(&status, json::ROOM);
            recording
                .writer()
                .write_json("status", &status.stamp, &value)
        }
    }
}

/// The streams of the daemon's non-real-time side, and what sensor processes say of their devices.
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

    /// Passes on until a signal comes or nobody writes any more.
    ///
    /// The stream of inputs holds a quarter of a second: where it may, this thread goes before other work.
    fn read(&mut self, messages: &SyncSender<Message>, stop: &AtomicBool) -> Result<(), BusError> {
        // Where it is refused, a busy machine may cost parts, which are counted.
        let _ = scheduling::enter_fifo(PRIORITY);
        let mut waiting = Vec::new();
        loop {
            let last = stop.load(Ordering::Relaxed);
            self.look(&mut waiting)?;
            for message in waiting.drain(..) {
                if messages.send(message).is_err() {
                    return Ok(());
                }
            }
            if last {
                return Ok(());
            }
            std::thread::sleep(LOOK);
        }
    }

    /// A header is published before the ticks of its run, so it has arrived when they have: it is looked for after them,
    /// and put before them.
    fn look(&mut self, waiting: &mut Vec<Message>) -> Result<(), BusError> {
        take(&mut self.inputs, waiting, Message::Inputs)?;
        let mut header = Vec::new();
        take(&mut self.runs, &mut header, Message::Run)?;
        if !header.is_empty() {
            let at = begin_of_run(waiting, self.has_run);
            waiting.splice(at..at, header);
            self.has_run = true;
        }
        take(&mut self.reports, waiting, Message::Report)?;
        take(&mut self.events, waiting, Message::Event)?;
        take(&mut self.statuses, waiting, Message::Status)?;
        take(&mut self.sensors, waiting, Message::Sensor)
    }
}

/// Where the new run begins among the parts that arrived together with its header: at its first part. Without that,
/// they are the rest of the run before, or, if there was none, of a run that the recorder joined late.
fn begin_of_run(parts: &[Message], has_run: bool) -> usize {
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
    port.drain(AT_ONCE, |payload| waiting.push(message(Box::new(*payload))))?;
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_header_stands_between_the_runs() {
        let check = |sequences: &[u64], has_run: bool, at: usize| {
            let part = |sequence: &u64| {
                let mut part = Box::<TickInputs>::default();
                part.stamp.sequence = *sequence;
                Message::Inputs(part)
            };
            let parts: Vec<Message> = sequences.iter().map(part).collect();
            assert_eq!(begin_of_run(&parts, has_run), at, "{sequences:?}");
        };
        check(&[], false, 0);
        check(&[0, 1], false, 0);
        check(&[70, 71, 0, 1], true, 2);
        check(&[70, 71], true, 2);
        check(&[70, 71], false, 0);
    }
}
