//! Faults of other processes on the bus: a second daemon, another user, a second publisher.

use std::path::Path;
use std::time::Instant;

use atas_processes::{Child, sibling_program};
use rustix::process::geteuid;
use shm_bus::{Bus, BusError, Realtime};
use shm_schemas::{HandFrame, JointCommand, JointState, service};

use super::disk::wrapper_obstacle;
use super::pace::TIMEOUT;
use super::start::daemon_words;
use super::{Drill, Effect, Pace, Rig};

/// Words before a program without any right on the bus.
const AS_NOBODY: &[&str] = &[
    "setpriv",
    "--reuid=65534",
    "--regid=65534",
    "--clear-groups",
];

/// A second daemon starts on the same bus.
pub(super) const SECOND_DAEMON: Drill = Drill::new(Pace::LockStep, second_daemon);

/// A process without rights tries to read the status.
pub(super) const FOREIGN_USER: Drill =
    Drill::new(Pace::LockStep, foreign_user).unless(no_other_user);

/// A second process opens the streams of commands and of sensors for writing.
pub(super) const ROGUE_PUBLISHER: Drill = Drill::new(Pace::LockStep, rogue_publisher);

fn second_daemon(rig: &mut Rig<'_>) -> anyhow::Result<Effect> {
    rig.promise();
    let words = daemon_words(rig.setup.pace, rig.environment, &rig.bus);
    let words: Vec<&str> = words.iter().map(String::as_str).collect();
    let program = sibling_program("atasd")?;
    let mut second = Child::start_program(&program, "second", &words, &rig.logs.folder)?;
    let begin = Instant::now();
    let status = loop {
        if let Some(status) = second.exit_status()? {
            break status;
        }
        if begin.elapsed() > TIMEOUT {
            return Ok(Effect::Failed("the second daemon does not end".to_owned()));
        }
        rig.advance(1)?;
    };
    let (log, owner) = (second.log(), format!("process {}", rig.daemon.pid()));
    Ok(Effect::require(
        status.code() == Some(8) && log.contains(&owner),
        || format!("the second daemon ends with {status}; expected code 8 and {owner}: {log}"),
    ))
}

fn no_other_user() -> Option<String> {
    if !geteuid().is_root() {
        return Some("only root can start a process of another user".to_owned());
    }
    let program = sibling_program("atas").ok()?;
    let words = [AS_NOBODY, &[program.to_str()?, "--version"]].concat();
    wrapper_obstacle(&words)
}

fn foreign_user(rig: &mut Rig<'_>) -> anyhow::Result<Effect> {
    rig.promise();
    let program = sibling_program("atas")?.display().to_string();
    for command in ["status", "estop", "topic"] {
        let ask: &[&str] = match command {
            "topic" => &["topic", "list"],
            other => &[other],
        };
        let bus = ["--bus", rig.bus.as_str()];
        let words = [&AS_NOBODY[1..], &[&program], ask, &bus].concat();
        let first = Path::new(AS_NOBODY[0]);
        let mut foreign = Child::start_program(first, "foreign", &words, &rig.logs.folder)?;
        let begin = Instant::now();
        let status = loop {
            if let Some(status) = foreign.exit_status()? {
                break status;
            }
            anyhow::ensure!(begin.elapsed() < TIMEOUT, "`atas {command}` does not end");
            rig.advance(1)?;
        };
        if status.success() {
            let text = format!("`atas {command}` of another user succeeds");
            return Ok(Effect::Failed(text));
        }
    }
    Ok(Effect::Done)
}

fn rogue_publisher(rig: &mut Rig<'_>) -> anyhow::Result<Effect> {
    rig.promise();
    let rogue = Bus::open(&rig.bus, "rogue", Realtime::No)?;
    let refused = [
        rogue
            .publisher::<JointCommand>(service::JOINT_COMMAND)
            .err(),
        rogue.publisher::<JointState>(service::JOINT_STATE).err(),
        rogue.publisher::<HandFrame>(service::HAND_FRAME[0]).err(),
    ];
    let all = refused
        .iter()
        .all(|error| matches!(error, Some(BusError::Taken { .. })));
    Ok(Effect::require(all, || {
        format!("a second publisher is not refused: {refused:?}")
    }))
}
