//! Start of a daemon process.

use std::fs::OpenOptions;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use anyhow::Context;
use atas_processes::{Child, sibling_program};
use shm_bus::BusName;

use super::{Pace, wall_clock};

/// Configuration by the clock for a busy machine: tolerates frames that are late by a third of a
/// second, so that only the injected fault causes a reaction.
const PATIENT: [&str; 3] = [
    "intake.hold_age_s=0.3",
    "intake.reject_age_s=5",
    "safety.stall_s=1",
];

/// Robot and configuration of all daemons of a plan.
#[derive(Clone, Debug)]
pub struct Environment {
    /// Robot: a name or a file.
    pub robot: String,
    /// The user's configuration; `None`: built-in defaults.
    pub config: Option<PathBuf>,
}

/// Destination of the daemon's log.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum LogOutput {
    /// File of the run.
    #[default]
    File,
    /// Full disk.
    Full,
    /// Pipe without a reader.
    Unread,
}

/// Way to start the daemon.
#[derive(Clone, Debug)]
pub(crate) struct Setup {
    pub(crate) pace: Pace,
    /// Words before the program, for example `unshare`.
    pub(crate) wrapper: Vec<&'static str>,
    pub(crate) log: LogOutput,
    /// Publishes the inputs of every tick for a recorder.
    pub(crate) records: bool,
    /// Lets the wall clock of the daemon jump once a file exists.
    pub(crate) has_jumping_clock: bool,
    /// Copies the configuration to a file of the run, which a fault may change.
    pub(crate) has_own_file: bool,
}

impl Setup {
    pub(crate) fn new(pace: Pace) -> Self {
        Self {
            pace,
            wrapper: Vec::new(),
            log: LogOutput::File,
            records: false,
            has_jumping_clock: false,
            has_own_file: false,
        }
    }
}

/// Returns the configuration file of the daemon in a run.
pub(crate) fn own_file(folder: &Path) -> PathBuf {
    folder.join("atas.toml")
}

/// Starts the daemon of a run.
pub(crate) fn start_daemon(
    setup: &Setup,
    environment: &Environment,
    bus: &BusName,
    folder: &Path,
) -> anyhow::Result<Child> {
    let mut words = daemon_words(setup.pace, environment, bus);
    if setup.has_own_file {
        let own = own_file(folder);
        if !own.exists() {
            let text = match &environment.config {
                Some(file) => std::fs::read_to_string(file)
                    .with_context(|| format!("could not read {}", file.display()))?,
                None => String::new(),
            };
            std::fs::write(&own, text)?;
        }
        words[1] = own.display().to_string();
    }
    if setup.records {
        words.push("--record-stream".to_owned());
    }
    let program = sibling_program("atasd")?.display().to_string();
    let wrapper = setup.wrapper.iter().map(|&word| word.to_owned());
    let all: Vec<String> = wrapper.chain([program]).chain(words).collect();
    let arguments: Vec<&str> = all[1..].iter().map(String::as_str).collect();
    let log = setup.log;
    let clock = setup
        .has_jumping_clock
        .then(|| wall_clock::library(folder))
        .transpose()?;
    let adjust = |command: &mut Command| {
        redirect(command, log);
        if let Some([library, jump]) = &clock {
            command
                .env("LD_PRELOAD", library)
                .env("ATAS_CLOCK_JUMP", jump);
        }
    };
    Child::start_adjusted(Path::new(&all[0]), "atasd", &arguments, folder, adjust)
}

/// Returns the arguments of a daemon; the second one is its configuration file.
pub(crate) fn daemon_words(pace: Pace, environment: &Environment, bus: &BusName) -> Vec<String> {
    let config = match &environment.config {
        Some(file) => file.display().to_string(),
        None => "/dev/null".to_owned(),
    };
    let mut words: Vec<String> = ["--config", &config, "--bus", bus.as_str()]
        .into_iter()
        .map(str::to_owned)
        .collect();
    words.extend(["--robot".to_owned(), environment.robot.clone()]);
    match pace {
        Pace::LockStep => words.push("--lockstep".to_owned()),
        Pace::Clock => {
            for setting in PATIENT {
                words.extend(["--set".to_owned(), setting.to_owned()]);
            }
        }
    }
    words
}

fn redirect(command: &mut Command, log: LogOutput) {
    command.env_remove("NOTIFY_SOCKET").env_remove("RUST_LOG");
    match log {
        LogOutput::File => {}
        LogOutput::Full => {
            command.env("RUST_LOG", "debug");
            // Without the device, the log goes to its file; the fault reports that it is missing.
            if let Ok(full) = OpenOptions::new().write(true).open("/dev/full") {
                command.stderr(full);
            }
        }
        LogOutput::Unread => {
            command.env("RUST_LOG", "debug").stderr(Stdio::piped());
        }
    }
}
