//! Flight recorder: saves the last 256 ticks to a file when the robot holds or stops.
//!
//! * **In:** report of every tick, mode changes. **Out:**
//!   `flight-<seconds since 1970>-<tick>-<mode>.csv`, one line per tick after a first line with the
//!   cause.
//! * **Invariants:** a separate thread writes, so that a full or slow disk blocks nothing; failures
//!   are logged. At most [`FILES_MAX`] files exist.
//!
//! Stops by a shutdown are not saved.

mod table;

use std::collections::VecDeque;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};
use std::{fs, io, thread};

use crossbeam::channel::{Receiver, Sender, bounded};
use shm_schemas::{EventKind, Mode, ModuleEvent, Reason, TickReport};

/// Number of saved ticks before a fault.
const TICKS: usize = 256;
/// Maximum number of files; the oldest are removed. 256 ticks are about 150 KiB. Design choice.
const FILES_MAX: usize = 64;
/// Minimum time between two files, so that a recurring fault does not displace older files. Design
/// choice.
const FILE_INTERVAL: Duration = Duration::from_secs(1);
/// Stack of the writing thread, bytes, locked memory.
const STACK_BYTES: usize = 128 << 10;

#[derive(Debug)]
pub(super) struct FlightRecorder {
    reports: VecDeque<TickReport>,
    writer: Option<Sender<FlightRecord>>,
    saved_at: Option<Instant>,
}

#[derive(Debug)]
struct FlightRecord {
    fault: ModuleEvent,
    reports: Vec<TickReport>,
}

impl FlightRecorder {
    /// A recorder that writes into this folder and creates it if necessary; `None` disables it.
    pub(super) fn new(folder: Option<PathBuf>) -> io::Result<Self> {
        let start = |folder: PathBuf| {
            let (send, receive) = bounded(1);
            let builder = thread::Builder::new().name("atasd-flight".to_owned());
            builder
                .stack_size(STACK_BYTES)
                .spawn(move || write_all(&folder, &receive))?;
            io::Result::Ok(send)
        };
        Ok(Self {
            reports: VecDeque::with_capacity(TICKS),
            writer: folder.map(start).transpose()?,
            saved_at: None,
        })
    }

    pub(super) fn record(&mut self, report: &TickReport) {
        if self.reports.len() == TICKS {
            self.reports.pop_front();
        }
        self.reports.push_back(*report);
    }

    /// Saves the last ticks if this event is a fault.
    pub(super) fn save_on_fault(&mut self, event: &ModuleEvent) {
        let Some(writer) = &self.writer else { return };
        if !is_fault(event) || self.saved_at.is_some_and(|at| at.elapsed() < FILE_INTERVAL) {
            return;
        }
        self.saved_at = Some(Instant::now());
        let until_fault = |report: &&TickReport| report.tick <= event.tick;
        let flight = FlightRecord {
            fault: *event,
            reports: self.reports.iter().filter(until_fault).copied().collect(),
        };
        if writer.try_send(flight).is_err() {
            tracing::warn!(
                tick = event.tick,
                "the flight recorder's disk is too slow; the ticks before this fault are lost"
            );
        }
    }
}

fn is_fault(event: &ModuleEvent) -> bool {
    event.kind == EventKind::MODE
        && matches!(event.mode, Mode::HOLD | Mode::SAFE_STOP | Mode::FAULT)
        && Reason::from(event.reason) != Reason::Shutdown
}

fn write_all(folder: &Path, flights: &Receiver<FlightRecord>) {
    for flight in flights {
        match write(folder, &flight) {
            Ok(file) => tracing::info!(file = %file.display(), "flight record saved"),
            Err(error) => tracing::warn!(
                folder = %folder.display(), %error,
                "could not write the last ticks; check that the disk has space and the folder is \
                 writable"
            ),
        }
    }
}

/// Writes under a temporary name first, so that a file is always complete.
fn write(folder: &Path, flight: &FlightRecord) -> io::Result<PathBuf> {
    fs::create_dir_all(folder)?;
    let now = SystemTime::now().duration_since(UNIX_EPOCH);
    let (seconds, fault) = (now.map_or(0, |now| now.as_secs()), &flight.fault);
    let name = format!("flight-{seconds:010}-{:012}-{}.csv", fault.tick, fault.mode);
    let (unfinished, file) = (folder.join("unfinished"), folder.join(name));
    fs::write(&unfinished, table::render(fault, &flight.reports))?;
    fs::rename(&unfinished, &file)?;
    remove_oldest(folder)?;
    Ok(file)
}

fn remove_oldest(folder: &Path) -> io::Result<()> {
    let is_ours = |path: &PathBuf| {
        let name = path.file_name().and_then(|name| name.to_str());
        name.is_some_and(|name| name.starts_with("flight-") && name.ends_with(".csv"))
    };
    let entries = fs::read_dir(folder)?.filter_map(|entry| Some(entry.ok()?.path()));
    let mut files: Vec<PathBuf> = entries.filter(is_ours).collect();
    files.sort();
    let surplus = files.len().saturating_sub(FILES_MAX);
    files[..surplus].iter().try_for_each(fs::remove_file)
}

#[cfg(test)]
mod tests {
    use super::*;
    use tempfile::TempDir;

    fn fault(tick: u64) -> ModuleEvent {
        ModuleEvent {
            tick,
            kind: EventKind::MODE,
            mode: Mode::HOLD,
            reason: Reason::LoopStalled {
                stalled_ns: 3e7,
                limit_ns: 2e7,
            }
            .into(),
            ..ModuleEvent::default()
        }
    }

    #[test]
    fn file_contains_ticks_and_cause() {
        let folder = TempDir::new().expect("a temporary folder");
        let mut recorder = FlightRecorder::new(None).expect("no thread to start");
        for tick in 0..1000 {
            recorder.record(&TickReport {
                tick,
                ..TickReport::default()
            });
        }
        assert_eq!(recorder.reports.len(), TICKS);
        let reports = recorder.reports.into_iter().collect();
        let file = write(
            folder.path(),
            &FlightRecord {
                fault: fault(999),
                reports,
            },
        )
        .expect("written");
        let text = fs::read_to_string(&file).expect("readable");
        let mut lines = text.lines();
        let why = lines.next().expect("a first line");
        assert!(why.contains("the loop stood still for 30.0 ms"), "{why}");
        let columns = lines.next().expect("names").split(',').count();
        let ticks: Vec<&str> = lines.collect();
        assert_eq!(ticks.len(), TICKS);
        assert!(
            ticks.iter().all(|line| line.split(',').count() == columns),
            "{}",
            ticks[0]
        );
        assert!(ticks[0].starts_with("744,") && ticks[TICKS - 1].starts_with("999,"));
    }

    #[test]
    fn file_count_is_bounded() {
        let folder = TempDir::new().expect("a temporary folder");
        fs::write(folder.path().join("a-note.txt"), "").expect("writable");
        for tick in 0..FILES_MAX as u64 + 5 {
            write(
                folder.path(),
                &FlightRecord {
                    fault: fault(tick),
                    reports: vec![],
                },
            )
            .expect("written");
        }
        let names: Vec<_> = fs::read_dir(folder.path()).expect("readable").collect();
        assert_eq!(names.len(), FILES_MAX + 1);
        assert!(folder.path().join("a-note.txt").exists());
    }

    #[test]
    fn only_faults_are_saved() {
        let check = |event: ModuleEvent, is: bool| assert_eq!(is_fault(&event), is);
        check(fault(0), true);
        check(
            ModuleEvent {
                mode: Mode::SAFE_STOP,
                ..fault(0)
            },
            true,
        );
        check(
            ModuleEvent {
                mode: Mode::RUN,
                ..fault(0)
            },
            false,
        );
        check(
            ModuleEvent {
                kind: EventKind::WARNING,
                ..fault(0)
            },
            false,
        );
        check(
            ModuleEvent {
                reason: Reason::Shutdown.into(),
                ..fault(0)
            },
            false,
        );
    }
}
