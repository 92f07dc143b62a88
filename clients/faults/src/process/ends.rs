//! Faults that end the daemon: the robot keeps the grip until the next one.

use std::process::ExitStatus;
use std::time::{Duration, Instant};

use anyhow::Context;
use rustix::process::Signal;
use sim_backend::random::split_mix;

use super::memory_group::MemoryGroup;
use super::pace::TIMEOUT;
use super::{Drill, Effect, Pace, Rig};

/// Ticks without a daemon, as a supervisor needs for its restart. Design choice.
const DEAD_TICKS: u64 = 100;
/// Kills during the start, and the longest time after which they come. Design choice: a start takes
/// about 0.1 s.
const EARLY_KILLS: u64 = 8;
pub(super) const EARLY_KILL_MAX: Duration = Duration::from_millis(150);

/// Longest time until the daemon touches a truncated file. Design choice: streams of the supervisor
/// are at least 50 Hz.
const TOUCHED_WITHIN: Duration = Duration::from_secs(3);

/// SIGKILL during a goal; a new daemon starts.
pub(super) const DAEMON_KILLED: Drill =
    Drill::new(Pace::Clock, |rig| ended_by(rig, Signal::KILL)).ending_the_goal();

/// SIGXCPU, which the kernel sends to a real-time thread that does not return.
pub(super) const MODULE_LOOPS: Drill =
    Drill::new(Pace::Clock, |rig| ended_by(rig, Signal::XCPU)).ending_the_goal();

/// SIGTERM during a goal: the daemon ends by itself with exit code 0.
pub(super) const TERMINATED: Drill = Drill::new(Pace::Clock, terminated).ending_the_goal();

/// The kernel kills the daemon for the memory of its control group.
pub(super) const OUT_OF_MEMORY: Drill = Drill::new(Pace::Clock, out_of_memory).ending_the_goal();

/// A shared-memory file that only the daemon uses is truncated; the daemon ends by SIGBUS.
pub(super) const SEGMENT_TRUNCATED: Drill =
    Drill::new(Pace::Clock, segment_truncated).ending_the_goal();

/// The daemon is killed, and further ones at random moments of their start.
pub(super) const HALF_CREATED: Drill = Drill::new(Pace::Clock, half_created).ending_the_goal();

fn ended_by(rig: &mut Rig<'_>, signal: Signal) -> anyhow::Result<Effect> {
    rig.daemon.signal(signal)?;
    wait_end(rig)?;
    restart(rig)
}

fn terminated(rig: &mut Rig<'_>) -> anyhow::Result<Effect> {
    rig.daemon.signal(Signal::TERM)?;
    let status = wait_end(rig)?;
    let restarted = restart(rig)?;
    let ended = Effect::require(status.code() == Some(0), || {
        format!("the daemon ends with {status} after SIGTERM; expected exit code 0")
    });
    Ok(if restarted == Effect::Done {
        ended
    } else {
        restarted
    })
}

fn out_of_memory(rig: &mut Rig<'_>) -> anyhow::Result<Effect> {
    let group = match MemoryGroup::create() {
        Ok(group) => group,
        Err(reason) => return Ok(Effect::Skipped(reason)),
    };
    if let Err(reason) = group.exhaust(rig.daemon.pid()) {
        return Ok(Effect::Skipped(reason));
    }
    let begin = Instant::now();
    while rig.has_ended()?.is_none() {
        rig.advance(1)?;
        if group.has_ended() && begin.elapsed() > Duration::from_secs(1) {
            let reason = "the kernel does not enforce the memory limit of a control group";
            return Ok(Effect::Skipped(reason.to_owned()));
        }
        anyhow::ensure!(begin.elapsed() < TIMEOUT, "the daemon was not killed");
    }
    restart(rig)
}

fn segment_truncated(rig: &mut Rig<'_>) -> anyhow::Result<Effect> {
    let (own, daemon) = (mapped("self")?, mapped(&rig.daemon.pid().to_string())?);
    let prefix = rig.observer.prefix().to_owned();
    let only_daemon = |path: &&String| path.contains(&prefix) && !own.contains(path);
    let path = daemon.iter().find(only_daemon);
    let Some(path) = path else {
        let reason = "/proc shows no shared-memory file that only the daemon uses";
        return Ok(Effect::Skipped(reason.to_owned()));
    };
    let file = std::fs::OpenOptions::new().write(true).open(path);
    file.and_then(|file| file.set_len(0))
        .with_context(|| format!("could not truncate {path}"))?;
    let begin = Instant::now();
    while rig.has_ended()?.is_none() {
        if begin.elapsed() > TOUCHED_WITHIN {
            // A daemon that does not touch the file runs on.
            rig.daemon.signal(Signal::KILL)?;
        }
        rig.advance(1)?;
    }
    restart(rig)
}

/// Returns the files below `/dev/shm` that a process has mapped, in the order of their names.
fn mapped(process: &str) -> anyhow::Result<Vec<String>> {
    let maps = std::fs::read_to_string(format!("/proc/{process}/maps"))
        .with_context(|| format!("could not read the memory map of process {process}"))?;
    let files = maps
        .lines()
        .filter_map(|line| line.find("/dev/shm/").map(|at| &line[at..]));
    let mut files: Vec<String> = files.map(str::to_owned).collect();
    files.sort();
    files.dedup();
    Ok(files)
}

fn half_created(rig: &mut Rig<'_>) -> anyhow::Result<Effect> {
    rig.daemon.signal(Signal::KILL)?;
    wait_end(rig)?;
    let mut random = rig.course.fault_seed();
    for _ in 0..EARLY_KILLS {
        rig.start_next()?;
        // This daemon may send commands before it is killed.
        rig.judge.restarted();
        random = split_mix(random);
        let until = Instant::now() + EARLY_KILL_MAX.mul_f64((random % 1000) as f64 / 1000.0);
        while Instant::now() < until {
            rig.advance(1)?;
        }
        rig.daemon.signal(Signal::KILL)?;
        wait_end(rig)?;
    }
    restart(rig)
}

/// Advances the robot until the daemon has ended, and judges its last commands.
pub(super) fn wait_end(rig: &mut Rig<'_>) -> anyhow::Result<ExitStatus> {
    let begin = Instant::now();
    loop {
        if let Some(status) = rig.has_ended()? {
            return Ok(status);
        }
        anyhow::ensure!(
            begin.elapsed() < TIMEOUT,
            "the daemon does not end within {TIMEOUT:?}"
        );
        rig.advance(1)?;
    }
}

/// Starts the next daemon and advances the robot until it reports its status.
fn restart(rig: &mut Rig<'_>) -> anyhow::Result<Effect> {
    rig.advance_alone(DEAD_TICKS)?;
    rig.promise();
    rig.replace_daemon()?;
    let begin = Instant::now();
    while rig.status()?.pid != rig.daemon.pid() {
        rig.advance(1)?;
        rig.daemon.check()?;
        anyhow::ensure!(
            begin.elapsed() < TIMEOUT,
            "the next daemon does not start within {TIMEOUT:?}"
        );
    }
    let goal_id = rig.status()?.goal_id;
    Ok(Effect::require(goal_id == 0, || {
        format!("the next daemon pursues the goal {goal_id} of the former one")
    }))
}
