//! Faults of processes and of the machine, injected into a running task.
//!
//! ```text
//!  Course ─▶ Rig: atasd on a private bus ◀─▶ simulated robot, client and judge (the runner)
//!             └─▶ Drill: signal, limit, file system, peer ─▶ Verdict, or skipped: reason
//! ```
//!
//! * **In:** a task, a phase, a seed, the user's configuration. **Out:** a verdict of the judge.
//! * **Invariants:** the daemon is the program beside this one. The bus is private. In lock-step
//!   the seed determines the tick of the fault. A fault that this machine does not permit is
//!   reported with the reason; it never passes.
//! * **Not included:** the process of a simulator; the runner sends sensors itself, so that it
//!   knows the world of every tick also while the daemon does not run.

mod clients;
mod disk;
mod ends;
mod files;
mod goals;
mod limits;
mod memory_group;
mod pace;
mod peers;
mod ports;
mod requests;
mod restarts;
mod rewritten;
mod rig;
mod stalls;
mod start;
mod wall_clock;

pub use pace::Pace;
pub use restarts::{RestartPlan, RestartReport};
pub use start::Environment;

pub(crate) use rig::Rig;
pub(crate) use start::Setup;

use crate::catalogue::{Fault, Reaction};
use crate::course::{Course, Phase};
use crate::process_fault::ProcessFault;
use crate::verdict::{Verdict, WATCH_TICKS, is_lifted, judged};

/// Result of an injection, apart from the judge's.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Effect {
    /// The fault acted.
    Done,
    /// This machine does not permit the fault, for this reason.
    Skipped(String),
    /// The system did not react as required.
    Failed(String),
}

impl Effect {
    /// Returns `Done` if the condition holds, else `Failed` with a text.
    pub(crate) fn require(holds: bool, text: impl FnOnce() -> String) -> Self {
        if holds {
            Self::Done
        } else {
            Self::Failed(text())
        }
    }
}

/// Moment of an injection.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Moment {
    /// In a phase of the task.
    Phase,
    /// Before the goal; the goal follows.
    Ready,
    /// Instead of the goal: another process is the client.
    Client,
}

/// Way to inject a fault.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Drill {
    pace: Pace,
    moment: Moment,
    /// True: the goal cannot continue, so the hand must keep its object.
    keeps_object: bool,
    /// Returns the reason why this machine cannot show the fault.
    obstacle: fn() -> Option<String>,
    prepare: fn(&mut Setup),
    inject: fn(&mut Rig<'_>) -> anyhow::Result<Effect>,
}

impl Drill {
    /// Fault in a phase, on every machine, after which the goal may continue.
    pub(crate) const fn new(
        pace: Pace,
        inject: fn(&mut Rig<'_>) -> anyhow::Result<Effect>,
    ) -> Self {
        Self {
            pace,
            moment: Moment::Phase,
            keeps_object: false,
            obstacle: || None,
            prepare: |_| (),
            inject,
        }
    }

    pub(crate) const fn ending_the_goal(mut self) -> Self {
        self.keeps_object = true;
        self
    }

    pub(crate) const fn at(mut self, moment: Moment) -> Self {
        self.moment = moment;
        self
    }

    pub(crate) const fn with_setup(mut self, prepare: fn(&mut Setup)) -> Self {
        self.prepare = prepare;
        self
    }

    pub(crate) const fn unless(mut self, obstacle: fn() -> Option<String>) -> Self {
        self.obstacle = obstacle;
        self
    }
}

/// Returns true if the fault needs a client program, which exists for the grasp only.
pub(crate) fn is_for_grasp_only(fault: ProcessFault) -> bool {
    drill(fault).moment == Moment::Client
}

fn drill(fault: ProcessFault) -> Drill {
    match fault {
        ProcessFault::WallClock => wall_clock::WALL_CLOCK,
        ProcessFault::Stopped => stalls::STOPPED,
        ProcessFault::DaemonKilled => ends::DAEMON_KILLED,
        ProcessFault::OutOfMemory => ends::OUT_OF_MEMORY,
        ProcessFault::ModuleLoops => ends::MODULE_LOOPS,
        ProcessFault::SlowTicks => stalls::SLOW_TICKS,
        ProcessFault::Overload => stalls::OVERLOAD,
        ProcessFault::RealTimeHog => stalls::REAL_TIME_HOG,
        ProcessFault::SecondDaemon => peers::SECOND_DAEMON,
        ProcessFault::ClientKilled => clients::CLIENT_KILLED,
        ProcessFault::ClientHangs => clients::CLIENT_HANGS,
        ProcessFault::GoalFlood => goals::GOAL_FLOOD,
        ProcessFault::MalformedGoals => goals::MALFORMED_GOALS,
        ProcessFault::ConflictingGoals => goals::CONFLICTING_GOALS,
        ProcessFault::LogDiskFull => disk::LOG_DISK_FULL,
        ProcessFault::RecordingDiskFull => disk::RECORDING_DISK_FULL,
        ProcessFault::ReadOnlyDisk => disk::READ_ONLY_DISK,
        ProcessFault::NoSharedMemory => disk::NO_SHARED_MEMORY,
        ProcessFault::SegmentTruncated => ends::SEGMENT_TRUNCATED,
        ProcessFault::HalfCreated => ends::HALF_CREATED,
        ProcessFault::ForeignUser => peers::FOREIGN_USER,
        ProcessFault::RoguePublisher => peers::ROGUE_PUBLISHER,
        ProcessFault::FrameRewritten => rewritten::FRAME_REWRITTEN,
        ProcessFault::InvalidConfiguration => files::INVALID_CONFIGURATION,
        ProcessFault::Reload => files::RELOAD,
        ProcessFault::Terminated => ends::TERMINATED,
        ProcessFault::NoDescriptors => limits::NO_DESCRIPTORS,
        ProcessFault::NoRealTime => limits::NO_REAL_TIME,
        ProcessFault::LogUnread => disk::LOG_UNREAD,
    }
}

/// Runs a task with a daemon process, injects a fault in a phase, and judges the reaction.
pub(crate) fn process_verdict(
    course: &Course<'_>,
    phase: &Phase,
    environment: &Environment,
    (fault, process, reaction): (&'static Fault, ProcessFault, Reaction),
) -> anyhow::Result<Verdict> {
    let process = drill(process);
    let skipped = |reason: String| Verdict::skipped(fault, course, phase, reason);
    if let Some(reason) = (process.obstacle)() {
        return Ok(skipped(reason));
    }
    let mut setup = Setup::new(process.pace);
    (process.prepare)(&mut setup);
    let started = Rig::start(course, environment, setup, reaction).and_then(|mut rig| {
        if process.moment == Moment::Phase {
            rig.begin_goal()?;
            rig.advance_into(phase)?;
        }
        Ok(rig)
    });
    let mut rig = match started {
        Ok(rig) => rig,
        // By the clock, a busy machine may end the goal before the fault.
        Err(error) if process.pace == Pace::Clock => {
            let text = format!(
                "the task does not reach {} by the clock: {error:#}",
                phase.name
            );
            return Ok(skipped(text));
        }
        Err(error) => return Err(error),
    };
    if process.keeps_object && is_lifted(&rig.object()) {
        rig.judge.expect_grip_kept(0)?;
    }
    let injected = (process.inject)(&mut rig);
    let mut effect = injected.unwrap_or_else(|error| Effect::Failed(format!("{error:#}")));
    if let Effect::Skipped(reason) = effect {
        return Ok(skipped(reason));
    }
    if process.moment == Moment::Ready {
        rig.begin_goal()?;
    }
    let bound = reaction.required().map_or(0, |(_, ticks)| ticks);
    if let Err(error) = rig
        .advance(bound + WATCH_TICKS)
        .and_then(|()| rig.daemon.check())
    {
        effect = Effect::Failed(format!("{error:#}"));
    }
    rig.judge.finish();
    let mut verdict = judged(fault, course, phase, &rig.judge, reaction);
    if let Effect::Failed(text) = effect {
        verdict.failure = Some(text);
    }
    let failed_goal = rig.end.filter(|end| {
        reaction == Reaction::Continue && end.state != shm_schemas::GoalState::SUCCEEDED
    });
    if let Some(end) = failed_goal {
        let text = format!("the goal ends as {}: {}", end.state, end.reason);
        verdict.failure.get_or_insert(text);
    }
    Ok(verdict)
}
