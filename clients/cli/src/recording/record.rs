//! `atas record`: from the bus into files. One thread only reads the bus, so that a slow disk costs nothing until the
//! channel between the two is full; what is lost then shows in the sequence.

use std::path::PathBuf;
use std::sync::mpsc::{Receiver, RecvTimeoutError, SyncSender, sync_channel};
use std::time::{Duration, SystemTime};

use serde_json::json;
use shm_bus::{Bus, BusError, Subscriber};
use shm_schemas::{
    ModuleEvent, Payload, RunHeader, SensorStatus, Status, TickInputs, TickReport, service,
};

use super::rotation::{Bounds, Recording, Tally};
use crate::arguments;
use crate::client::Session;
use crate::exit::{Ended, Exit};
use crate::fifo;
use crate::interrupt::Interrupt;
use crate::json;
use crate::output::Output;

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
enum Word {
    Run(Box<RunHeader>),
    Inputs(Box<TickInputs>),
    Report(Box<TickReport>),
    Event(Box<ModuleEvent>),
    Status(Box<Status>),
    Sensor(Box<SensorStatus>),
}

/// `atas record`.
pub(crate) fn record(
    arguments: &arguments::Record,
    interrupt: &Interrupt,
    output: &mut Output,
) -> anyhow::Result<()> {
    let session = Session::join(&arguments.bus.bus)?;
    let mut ports = Ports::open(session.bus())?;
    let out = arguments.out.clone().unwrap_or_else(default_out);
    let bounds = Bounds {
        file_bytes: arguments.max_size,
        files: arguments.max_files.map(usize::from),
        total_bytes: arguments.disk_budget,
    };
    let recording = Recording::create(&out, bounds, arguments.notes.iter().cloned().collect())?;
    tracing::info!(file = %out.display(), "recording until Ctrl-C");
    let (send, receive) = sync_channel(WAITING);
    let writing = std::thread::spawn(move || write(recording, &receive));
    let read = ports.read(&send, interrupt);
    drop(send);
    let written = writing
        .join()
        .unwrap_or_else(|_| Err(anyhow::anyhow!("the writing thread panicked")));
    read?;
    let (tally, is_full) = written?;
    print(&tally, is_full, output)
}

/// Until the channel closes, or the disk budget is used up.
fn write(mut recording: Recording, words: &Receiver<Word>) -> anyhow::Result<(Tally, bool)> {
    let mut silent = 0;
    loop {
        match words.recv_timeout(IDLE) {
            Ok(word) => write_word(&mut recording, word, &mut silent)?,
            Err(RecvTimeoutError::Timeout) => {}
            Err(RecvTimeoutError::Disconnected) => return Ok((recording.finish()?, false)),
        }
        if !recording.keep_up()? {
            return Ok((recording.finish()?, true));
        }
    }
}

fn write_word(recording: &mut Recording, word: Word, silent: &mut u32) -> anyhow::Result<()> {
    match word {
        Word::Run(header) => recording.begin_run(header),
        Word::Inputs(part) => recording.inputs(&part),
        Word::Report(report) => recording.writer().write(&*report),
        Word::Event(event) => {
            recording.writer().write(&*event)?;
            let value = json::event(&event);
            recording
                .writer()
                .write_json("events", &event.stamp, &value)
        }
        Word::Sensor(status) => recording.writer().write(&*status),
        Word::Status(status) => {
            *silent += u32::from(!recording.has_run());
            if *silent == SILENT_STATUSES {
                tracing::warn!(
                    "the daemon does not publish what it takes in: this recording cannot be replayed; \
                     start it with --record-stream, after the recorder"
                );
            }
            recording.writer().write(&*status)?;
            let value = json::status(&status);
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
    fn read(&mut self, words: &SyncSender<Word>, interrupt: &Interrupt) -> Result<(), BusError> {
        // Where it is refused, a busy machine may cost parts, which are counted.
        let _ = fifo::enter(PRIORITY);
        let mut waiting = Vec::new();
        loop {
            let last = interrupt.is_set();
            self.look(&mut waiting)?;
            for word in waiting.drain(..) {
                if words.send(word).is_err() {
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
    fn look(&mut self, waiting: &mut Vec<Word>) -> Result<(), BusError> {
        take(&mut self.inputs, waiting, Word::Inputs)?;
        let mut header = Vec::new();
        take(&mut self.runs, &mut header, Word::Run)?;
        if !header.is_empty() {
            let at = begin_of_run(waiting, self.has_run);
            waiting.splice(at..at, header);
            self.has_run = true;
        }
        take(&mut self.reports, waiting, Word::Report)?;
        take(&mut self.events, waiting, Word::Event)?;
        take(&mut self.statuses, waiting, Word::Status)?;
        take(&mut self.sensors, waiting, Word::Sensor)
    }
}

/// Where the new run begins among the parts that arrived together with its header: at its first part. Without that,
/// they are the rest of the run before, or, if there was none, of a run that the recorder joined late.
fn begin_of_run(parts: &[Word], has_run: bool) -> usize {
    let is_first = |word: &Word| matches!(word, Word::Inputs(part) if part.stamp.sequence == 0);
    let otherwise = if has_run { parts.len() } else { 0 };
    parts.iter().position(is_first).unwrap_or(otherwise)
}

fn take<T: Payload>(
    port: &mut Subscriber<T>,
    waiting: &mut Vec<Word>,
    word: impl Fn(Box<T>) -> Word,
) -> Result<(), BusError> {
    port.drain(AT_ONCE, |payload| waiting.push(word(Box::new(*payload))))?;
    Ok(())
}

fn default_out() -> PathBuf {
    let unix = SystemTime::now().duration_since(SystemTime::UNIX_EPOCH);
    format!("atas-{}.mcap", unix.map_or(0, |time| time.as_secs())).into()
}

fn print(tally: &Tally, is_full: bool, output: &mut Output) -> anyhow::Result<()> {
    let files: Vec<String> = tally
        .files
        .iter()
        .map(|file| file.display().to_string())
        .collect();
    if output.is_json() {
        output.json(&json!({
            "parts": tally.parts,
            "lost": tally.lost,
            "has_beginning": tally.has_beginning,
            "disk_budget_reached": is_full,
            "bytes": tally.bytes,
            "files": files,
        }))?;
    } else {
        output.line(format_args!(
            "recorded {} parts of ticks, lost {}, {:.1} MiB in {}",
            tally.parts,
            tally.lost,
            tally.bytes as f64 / f64::from(1 << 20),
            files.join(", ")
        ))?;
    }
    if is_full {
        return Err(Ended::with(
            Exit::Failed,
            "the disk budget is used up; the recording ended early",
        ));
    }
    if tally.lost > 0 {
        let sentence = format!(
            "lost {} parts of ticks: the recording cannot be replayed beyond them",
            tally.lost
        );
        return Err(Ended::with(Exit::Failed, sentence));
    }
    if !tally.has_beginning {
        tracing::warn!(
            "a run was not recorded from its first tick and cannot be replayed; start the recorder first"
        );
    }
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
                Word::Inputs(part)
            };
            let parts: Vec<Word> = sequences.iter().map(part).collect();
            assert_eq!(begin_of_run(&parts, has_run), at, "{sequences:?}");
        };
        check(&[], false, 0);
        check(&[0, 1], false, 0);
        check(&[70, 71, 0, 1], true, 2);
        check(&[70, 71], true, 2);
        check(&[70, 71], false, 0);
    }
}
