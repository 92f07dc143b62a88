//! `ebts agents`: the robots of a field on the bus, and their tables exchanged while they drive.

use std::io::Write;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use clap::Args;
use serde::Serialize;
use shm_bus::{Bus, BusName, Realtime, now_ns};
use signal_hook::consts::SIGHUP;
use signal_hook::iterator::Signals;

use ebts::agents::{Counts, Exchange, Fields, Lookup, TeamController, field_hash};
use ebts::built_in;
use ebts::course::table_file::CourseFile;
use ebts::error::{Error, Result};
use std::path::Path;

use super::{Format, stop_flag};

/// A frame is awaited for so long without giving up the core, ns. Ours: in lock-step a frame of 1,000 robots takes less.
const SPIN_NS: u64 = 100_000;
/// Time between two looks afterwards. Ours: a tenth of a frame at 1 kHz.
const NAP: Duration = Duration::from_micros(100);

#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  ebts agents --table r3-two-agents\n  ebts agents --table course\n  ebts agents --table left.toml --table right.toml --bus mine"
)]
pub(crate) struct AgentsArgs {
    /// Table file, or r3-two-agents, which ships. Given several times, robots take the tables in turn: one each. Or one table of
    /// `ebts evolve course`, or course, which ships, for a base of `atas-sim course`.
    /// SIGHUP reads the files again: intact ones are used from the next frame on, else the former ones stay in use.
    #[arg(long, required = true, value_name = "FILE")]
    table: Vec<String>,
    /// Drive whatever field is hosted, also one that the tables were not evolved for.
    #[arg(long)]
    any_field: bool,
    /// Bus of the field.
    #[arg(long, env = BusName::ENV, default_value_t, value_name = "NAME")]
    bus: BusName,
}

/// What an agents process has to say, one line each.
#[derive(Debug, Serialize)]
#[serde(tag = "event", rename_all = "kebab-case")]
enum Event {
    /// Ready to answer.
    Ready { hash: String, tables: usize },
    /// Other tables from the next frame on.
    Exchanged { hash: String, tables: usize },
    /// The former tables stay in use.
    Refused { why: String },
    /// The process ends.
    Ended(Counts),
}

impl Event {
    fn human(&self) -> String {
        match self {
            Self::Ready { hash, tables } => format!("answering by {tables} table(s), hash {hash}"),
            Self::Exchanged { hash, tables } => {
                format!("{tables} table(s) with hash {hash} from the next frame on")
            }
            Self::Refused { why } => format!("the tables in use stay in use: {why}"),
            Self::Ended(Counts {
                answered,
                lost,
                malformed,
            }) => {
                format!(
                    "answered {answered} frames; {lost} came too fast, {malformed} were malformed"
                )
            }
        }
    }

    /// Prints it. A reader who has gone away is no reason to stop the robots.
    fn tell(&self, format: Format) {
        let line = match format {
            Format::Human => self.human(),
            // Strings and numbers always have a JSON form.
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
        true => Fields::Any,
        false => Fields::TheirOwn,
    };
    let lookup = read(&args.table, fields, None)?;
    let only = Reading {
        tables: args.table,
        fields,
        field_hash: lookup.field_hash(),
    };
    let (hash, tables) = name(&lookup);
    let bus = Bus::open(&args.bus, "ebts-agents", Realtime::Yes)?;
    let mut controller = TeamController::open(&bus, lookup, fields)?;
    Event::Ready { hash, tables }.tell(format);
    let watcher = watch(signals, only, Arc::clone(&exchange), format);
    let served = serve(&mut controller, &exchange, &stop);
    watcher.close();
    Event::Ended(controller.counts()).tell(format);
    served
}

/// Answers frame after frame until a signal comes.
fn serve(controller: &mut TeamController, exchange: &Exchange, stop: &AtomicBool) -> Result<()> {
    let mut idle_since_ns = now_ns();
    while !stop.load(Ordering::Relaxed) {
        if controller.answer(exchange)? {
            idle_since_ns = now_ns();
        } else if now_ns() - idle_since_ns < SPIN_NS {
            std::hint::spin_loop();
        } else {
            std::thread::sleep(NAP);
        }
    }
    Ok(())
}

/// Reads the tables again whenever SIGHUP comes, in a thread of its own, so that no frame waits for a disk.
fn watch(
    mut signals: Signals,
    reading: Reading,
    exchange: Arc<Exchange>,
    format: Format,
) -> signal_hook::iterator::Handle {
    let handle = signals.handle();
    std::thread::spawn(move || {
        for _ in signals.forever() {
            match read(&reading.tables, reading.fields, Some(reading.field_hash)) {
                Ok(lookup) => {
                    let (hash, tables) = name(&lookup);
                    exchange.offer(lookup);
                    Event::Exchanged { hash, tables }.tell(format);
                }
                Err(error) => {
                    let why = error.to_string();
                    Event::Refused { why }.tell(format);
                }
            }
        }
    });
    handle
}

/// What SIGHUP reads again.
struct Reading {
    tables: Vec<String>,
    fields: Fields,
    /// Names the field of the tables in use.
    field_hash: u64,
}

/// Reads and checks every table: all of one field, and of that of the tables in use.
fn read(names: &[String], fields: Fields, in_use: Option<u64>) -> Result<Lookup> {
    if let [name] = names
        && CourseFile::is_named(name)
    {
        let (file, table) = CourseFile::named(name)?;
        return Ok(Lookup::of_course(&file.hash, table));
    }
    let files = names.iter().map(|name| built_in::table(name));
    let files = files.collect::<Result<Vec<_>>>()?;
    let expected = in_use.or(files.first().map(field_hash));
    let other = files
        .iter()
        .zip(names)
        .find(|(file, _)| Some(field_hash(file)) != expected);
    match (fields, other) {
        (Fields::TheirOwn, Some((file, name))) => Err(Error::refused(
            format_args!("use table {name}"),
            format_args!(
                "its preset {} was another field than that of the other tables",
                file.condition.model.preset().name
            ),
            "tables of one field",
            "take tables evolved for the same preset, or say --any-field",
        )),
        _ => Ok(Lookup::new(&files)),
    }
}

/// How the commands name the tables, and how many they are.
fn name(lookup: &Lookup) -> (String, usize) {
    (format!("{:016x}", lookup.hash()), lookup.tables())
}
