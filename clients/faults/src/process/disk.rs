//! Faults of file systems.

use std::path::Path;
use std::process::{Command, Stdio};
use std::time::Instant;

use atas_processes::{Child, sibling_program};
use shm_bus::FreshBus;
use shm_schemas::ControlOp;

use super::pace::TIMEOUT;
use super::start::{LogOutput, daemon_words};
use super::{Drill, Effect, Pace, Rig};

/// Requests, each with a log line: several times the capacity of a pipe.
const REQUESTS: u64 = 1_500;
/// Ticks between requests.
const BETWEEN_TICKS: u64 = 2;

/// Words before a program that finds every file system but `/dev/shm` read-only.
const READ_ONLY: &[&str] = &[
    "unshare",
    "-rm",
    "sh",
    "-c",
    "mount -o remount,bind,ro / && exec \"$@\"",
    "sh",
];
/// Words before a program that finds 64 KiB of shared memory.
const SMALL_SHARED_MEMORY: &[&str] = &[
    "unshare",
    "-rm",
    "sh",
    "-c",
    "mount -t tmpfs -o size=64k none /dev/shm && unset XDG_RUNTIME_DIR && exec \"$@\"",
    "sh",
];
/// Words before a program whose files may have 64 KiB: a write beyond fails as on a full disk.
const SMALL_FILES: &[&str] = &["sh", "-c", "trap '' XFSZ; ulimit -f 64; exec \"$@\"", "sh"];

/// The daemon's log is on a full disk.
pub(super) const LOG_DISK_FULL: Drill = Drill::new(Pace::LockStep, logging)
    .unless(|| missing("/dev/full"))
    .with_setup(|setup| setup.log = LogOutput::Full);

/// The reader of the daemon's log reads nothing.
pub(super) const LOG_UNREAD: Drill =
    Drill::new(Pace::LockStep, logging).with_setup(|setup| setup.log = LogOutput::Unread);

/// The disk of a recording is full.
pub(super) const RECORDING_DISK_FULL: Drill =
    Drill::new(Pace::LockStep, recording_disk_full).with_setup(|setup| setup.records = true);

/// The file systems of the daemon are read-only.
pub(super) const READ_ONLY_DISK: Drill = Drill::new(Pace::LockStep, |rig| {
    rig.promise();
    Ok(Effect::Done)
})
.unless(|| wrapper_obstacle(READ_ONLY))
.with_setup(|setup| setup.wrapper = READ_ONLY.to_vec());

/// A second daemon, on another bus, finds no shared memory.
pub(super) const NO_SHARED_MEMORY: Drill =
    Drill::new(Pace::LockStep, no_shared_memory).unless(|| wrapper_obstacle(SMALL_SHARED_MEMORY));

/// Returns the reason why a program cannot run after these words.
pub(crate) fn wrapper_obstacle(words: &[&str]) -> Option<String> {
    let tried = Command::new(words[0])
        .args(&words[1..])
        .arg("true")
        .stdin(Stdio::null())
        .output();
    match tried {
        Ok(output) if output.status.success() => None,
        Ok(output) => {
            let text = String::from_utf8_lossy(&output.stderr);
            let first = text.lines().next().unwrap_or("no message");
            Some(format!("`{}` is not permitted here: {first}", words[0]))
        }
        Err(error) => Some(format!("could not start `{}`: {error}", words[0])),
    }
}

fn missing(device: &str) -> Option<String> {
    (!Path::new(device).exists()).then(|| format!("this machine has no {device}"))
}

fn logging(rig: &mut Rig<'_>) -> anyhow::Result<Effect> {
    rig.promise();
    let name = atas_core::settings::PARAMETERS[0].name;
    for _ in 0..REQUESTS {
        rig.control(ControlOp::PARAM_GET, name, 0.0)?;
        rig.advance(BETWEEN_TICKS)?;
    }
    Ok(Effect::Done)
}

fn recording_disk_full(rig: &mut Rig<'_>) -> anyhow::Result<Effect> {
    rig.promise();
    let program = sibling_program("atas")?.display().to_string();
    let out = rig.logs.folder.join("run.mcap").display().to_string();
    let record = ["record", "--bus", rig.bus.as_str(), "--out", &out];
    let words = [&SMALL_FILES[1..], &[&program], &record].concat();
    let mut recorder = Child::start_program(
        Path::new(SMALL_FILES[0]),
        "recorder",
        &words,
        &rig.logs.folder,
    )?;
    let begin = Instant::now();
    let status = loop {
        if let Some(status) = recorder.exit_status()? {
            break status;
        }
        if begin.elapsed() > TIMEOUT {
            return Ok(Effect::Failed(
                "the recorder does not report its full disk".to_owned(),
            ));
        }
        rig.advance(1)?;
    };
    let log = recorder.log();
    Ok(Effect::require(
        status.code() == Some(1) && log.contains("could not write"),
        || format!("the recorder ends with {status}; expected the error of its full disk: {log}"),
    ))
}

fn no_shared_memory(rig: &mut Rig<'_>) -> anyhow::Result<Effect> {
    rig.promise();
    let bus = FreshBus::new("small");
    let program = sibling_program("atasd")?.display().to_string();
    let arguments = daemon_words(Pace::LockStep, rig.environment, &bus);
    let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
    let words = [&SMALL_SHARED_MEMORY[1..], &[&program], &arguments].concat();
    let (first, folder) = (Path::new(SMALL_SHARED_MEMORY[0]), &rig.logs.folder);
    let mut second = Child::start_program(first, "small", &words, folder)?;
    let begin = Instant::now();
    let status = loop {
        if let Some(status) = second.exit_status()? {
            break status;
        }
        if begin.elapsed() > TIMEOUT {
            let text = "a daemon without shared memory does not end";
            return Ok(Effect::Failed(text.to_owned()));
        }
        rig.advance(1)?;
    };
    let log = second.log();
    Ok(Effect::require(
        status.code() == Some(9) && log.contains("/dev/shm"),
        || format!("a daemon without shared memory ends with {status}: {log}"),
    ))
}
