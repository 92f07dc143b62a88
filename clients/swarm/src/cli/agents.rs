//! `ebts agents`: controls the robots of a field on the bus; tables can be exchanged during
//! operation.

use std::io::Write;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use clap::Args;
use serde::Serialize;
use shm_bus::{Bus, BusName, Realtime, now_ns};
use signal_hook::consts::SIGHUP;
use signal_hook::iterator::Signals;

use ebts::agents::{Counts, Exchange, FieldPolicy, Lookup, TeamController, field_hash};
use ebts::built_in;
use ebts::course::table_file::CourseFile;
use ebts::error::{Error, Result};
use std::path::Path;

use super::{Format, stop_flag};

/// Busy-wait time for a frame before sleeping, ns. Design choice: in lock-step a frame of 1,000
/// robots takes less.
const SPIN_NS: u64 = 100_000;
/// Poll interval after the busy-wait. Design choice: a tenth of a frame at 1 kHz.
const POLL_INTERVAL: Duration = Duration::from_micros(100);

#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  ebts agents --table r3-two-agents\n  ebts agents --table course\n  ebts agents --table left.toml --table right.toml --bus mine"
)]
pub(crate) struct AgentsArgs {
    /// Table file, or the built-in r3-two-agents. Several tables are assigned to the robots in
    /// turn.
    ///
    /// For a base of `atas-sim course`: one table of `ebts evolve course`, or the built-in course.
    /// SIGHUP reads the files again: valid ones are used from the next frame on, otherwise the
    /// current ones stay in use.
    #[arg(long, required = true, value_name = "FILE")]
    table: Vec<String>,
    /// Control any hosted field, even one that the tables were not evolved for.
    #[arg(long)]
    any_field: bool,
    /// Bus of the field.
    #[arg(long, env = BusName::ENV, default_value_t, value_name = "NAME")]
    bus: BusName,
}

#[derive(Debug, Serialize)]
#[serde(tag = "event", rename_all = "kebab-case")]
enum Event {
    Ready {
        hash: String,
        tables: usize,
    },
    Exchanged {
        hash: String,
        tables: usize,
    },
    /// New tables were rejected; the current ones stay in use.
    Refused {
        why: String,
    },
    Ended(Counts),
}

impl Event {
    fn human(&self) -> String {
        match self {
            Self::Ready { hash, tables } => {
                format!("answering with {tables} table(s), hash {hash}")
            }
            Self::Exchanged { hash, tables } => {
                format!("{tables} table(s) with hash {hash} from the next frame on")
            }
            Self::Refused { why } => format!(
                "new tables rejected, the current ones stay in use: \
                {why}"
            ),
            Self::Ended(Counts {
                answered,
                lost,
                malformed,
            }) => {
                format!(
                    "answered {answered} frames; {lost} were missed, {malformed} were malformed"
                )
            }
        }
    }

    /// Prints the event. A closed reader does not stop the robots.
    fn print(&self, format: Format) {
        let line = match format {
            Format::Human => self.human(),
            Format::Json => serde_json::to_string(self).unwrap_or_default(),
        };
        let _ = writeln!(std::io::stdout().lock(), "{line}");
    }
}

pub(super) fn agents(args: AgentsArgs, format: Format) -> Result<()> {
    let exchange = Arc::new(Exchange::default());
    let stop = stop_flag()?;
    let signals = Signals::new([SIGHUP])
        .map_err(Error::io("watch signals for", Path::new("this process")))?;
    let fields = match args.any_field {
        true => FieldPolicy::Any,
        false => FieldPolicy::SameField,
    };
    let lookup = read(&args.table, fields, None)?;
    let only = TableSource {
        tables: args.table,
        fields,
        field_hash: lookup.field_hash(),
    };
    let (hash, tables) = describe(&lookup);
    let bus = Bus::open(&args.bus, "ebts-agents", Realtime::Yes)?;
    let mut controller = TeamController::open(&bus, lookup, fields)?;
    Event::Ready { hash, tables }.print(format);
    let watcher = watch(signals, only, Arc::clone(&exchange), format);
    let served = serve(&mut controller, &exchange, &stop);
    watcher.close();
    Event::Ended(controller.counts()).print(format);
    served
}

fn serve(controller: &mut TeamController, exchange: &Exchange, stop: &AtomicBool) -> Result<()> {
    let mut idle_since_ns = now_ns();
    while !stop.load(Ordering::Relaxed) {
        if controller.answer(exchange)? {
            idle_since_ns = now_ns();
        } else if now_ns() - idle_since_ns < SPIN_NS {
            std::hint::spin_loop();
        } else {
            std::thread::sleep(POLL_INTERVAL);
        }
    }
    Ok(())
}

/// Separate thread for SIGHUP, so that no frame waits for the disk.
fn watch(
    mut signals: Signals,
    reading: TableSource,
    exchange: Arc<Exchange>,
    format: Format,
) -> signal_hook::iterator::Handle {
    let handle = signals.handle();
    std::thread::spawn(move || {
        for _ in signals.forever() {
            match read(&reading.tables, reading.fields, Some(reading.field_hash)) {
                Ok(lookup) => {
                    let (hash, tables) = describe(&lookup);
                    exchange.offer(lookup);
                    Event::Exchanged { hash, tables }.print(format);
                }
                Err(error) => {
                    let why = error.to_string();
                    Event::Refused { why }.print(format);
                }
            }
        }
    });
    handle
}

struct TableSource {
    tables: Vec<String>,
    fields: FieldPolicy,
    /// Hash of the field of the tables in use.
    field_hash: u64,
}

/// Reads and validates all tables. They must belong to one field, and to that of the tables in use.
fn read(names: &[String], fields: FieldPolicy, in_use: Option<u64>) -> Result<Lookup> {
    if let [name] = names
        && CourseFile::is_course_name(name)
    {
        let (file, table) = CourseFile::from_name(name)?;
        return Ok(Lookup::from_course(&file.hash, table));
    }
    let files = names.iter().map(|name| built_in::table(name));
    let files = files.collect::<Result<Vec<_>>>()?;
    let expected = in_use.or(files.first().map(field_hash));
    let other = files
        .iter()
        .zip(names)
        .find(|(file, _)| Some(field_hash(file)) != expected);
    match (fields, other) {
        (FieldPolicy::SameField, Some((file, name))) => Err(Error::refused(
            format_args!("use table {name}"),
            format_args!(
                "its preset {} is another field than that of the other tables",
                file.condition.model.preset().name
            ),
            "tables of one field",
            "use tables evolved for the same preset, or give --any-field",
        )),
        _ => Ok(Lookup::new(&files)),
    }
}

fn describe(lookup: &Lookup) -> (String, usize) {
    (format!("{:016x}", lookup.hash()), lookup.tables())
}
