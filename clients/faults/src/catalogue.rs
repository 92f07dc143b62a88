//! Rows of the fault catalogue: fault, required reaction, evidence.

use atas_core::Settings;
use shm_schemas::Mode;

use crate::Injection;
use crate::process_fault::ProcessFault;

/// Row of the catalogue.
#[derive(Clone, Copy, Debug)]
pub struct Fault {
    /// Number, for example `F01`. Variants of one fault have a letter.
    pub id: &'static str,
    /// Short name.
    pub name: &'static str,
    /// Description of the event.
    pub about: &'static str,
    /// Evidence of the reaction.
    pub evidence: Evidence,
}

/// Evidence of the reaction to a fault.
#[derive(Clone, Copy, Debug)]
pub enum Evidence {
    /// `atas fault run`, in virtual time.
    Injected(Injection, Reaction),
    /// `atas fault run`, with a daemon process.
    Process(ProcessFault, Reaction),
    /// Test with real processes, `file::name`.
    Test(&'static str),
    /// Nothing yet, for this reason.
    Nothing(&'static str),
}

impl Evidence {
    /// Returns the required reaction to an injection; `None` without one.
    #[must_use]
    pub fn reaction(self) -> Option<Reaction> {
        match self {
            Self::Injected(_, reaction) | Self::Process(_, reaction) => Some(reaction),
            Self::Test(_) | Self::Nothing(_) => None,
        }
    }

    /// Returns `injection`, `process`, the test, or the reason why there is none.
    #[must_use]
    pub fn text(self) -> &'static str {
        match self {
            Self::Injected(..) => "injection",
            Self::Process(..) => "process",
            Self::Test(text) | Self::Nothing(text) => text,
        }
    }
}

/// Required reaction. In addition, each command keeps all limits, and no object is lost or harmed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reaction {
    /// HOLD, or a more severe mode, within this number of ticks.
    Hold(u64),
    /// HOLD this number of ticks after the age limit of the configuration (`intake.hold_age_s`).
    HoldAfterAge(u64),
    /// HOLD this number of ticks after the limit of equal frames (`intake.frozen_frames`).
    HoldAfterEqual(u64),
    /// A new daemon is READY, without a goal, within this number of its ticks.
    Restart(u64),
    /// SAFE_STOP, or a more severe mode, within this number of ticks.
    SafeStop(u64),
    /// None: the goal continues.
    Continue,
    /// HOLD, SAFE_STOP or none.
    Safe,
}

/// HOLD and the more severe modes.
pub(crate) const HOLDING: &[Mode] = &[Mode::HOLD, Mode::SAFE_STOP, Mode::FAULT];
const STOPPED: &[Mode] = &[Mode::SAFE_STOP, Mode::FAULT];

impl Reaction {
    /// Returns the reaction with the limits of a configuration as a number of ticks.
    #[must_use]
    pub fn with_settings(self, settings: &Settings) -> Self {
        match self {
            Self::HoldAfterAge(more) => {
                Self::Hold((settings.intake.hold_age_s * 1e3).ceil() as u64 + more)
            }
            Self::HoldAfterEqual(more) => {
                Self::Hold(settings.intake.frozen_frames.ceil() as u64 + more)
            }
            other => other,
        }
    }

    /// Returns the required modes and the bound in ticks; `None` without a required mode. Call
    /// [`Reaction::with_settings`] before.
    #[must_use]
    pub fn required(self) -> Option<(&'static [Mode], u64)> {
        match self.with_settings(&Settings::default()) {
            Self::Hold(ticks) | Self::HoldAfterAge(ticks) | Self::HoldAfterEqual(ticks) => {
                Some((HOLDING, ticks))
            }
            Self::SafeStop(ticks) => Some((STOPPED, ticks)),
            Self::Restart(ticks) => Some((&[Mode::READY], ticks)),
            Self::Continue | Self::Safe => None,
        }
    }

    /// Returns the modes that must not appear.
    #[must_use]
    pub fn forbidden(self) -> &'static [Mode] {
        match self {
            Self::Continue => HOLDING,
            Self::Restart(_) => STOPPED,
            Self::Safe => &[Mode::FAULT],
            _ => &[],
        }
    }

    /// Returns the reaction in words.
    #[must_use]
    pub fn text(self) -> String {
        match self.with_settings(&Settings::default()) {
            Self::Hold(ticks) | Self::HoldAfterAge(ticks) | Self::HoldAfterEqual(ticks) => {
                format!("HOLD within {ticks} ticks")
            }
            Self::SafeStop(ticks) => format!("SAFE_STOP within {ticks} ticks"),
            Self::Restart(ticks) => format!("READY within {ticks} ticks"),
            Self::Continue => "the goal continues".to_owned(),
            Self::Safe => "a stop, or the goal continues".to_owned(),
        }
    }
}

/// Returns the rows with this number or name. A number without letter selects all its variants.
pub fn find(text: &str) -> impl Iterator<Item = &'static Fault> {
    CATALOGUE.iter().filter(move |fault| {
        let variant = fault.id.strip_prefix(text);
        let is_id = variant.is_some_and(|rest| rest.chars().all(|letter| letter.is_alphabetic()));
        (is_id && text.len() >= 3) || fault.name == text
    })
}

/// Detection of missing data: the tick after the age limit finds it.
const SILENT: Reaction = Reaction::HoldAfterAge(1);

/// The first burst may arrive before the gap is noticed.
const BURSTS: Reaction = Reaction::HoldAfterAge(6);

/// Start of a new daemon. Without a goal it is ready after 20 ticks without a fault.
const RESTART: Reaction = Reaction::Restart(500);

/// All rows, in the order of their numbers.
#[rustfmt::skip]
pub const CATALOGUE: &[Fault] = {
    use Injection::{Disconnected, Frames, FramesWrap, Joints, Pause, Restart};
    use Reaction::{Continue, Hold, Safe, SafeStop};
    use Evidence::{Injected, Nothing, Process, Test};
    const fn row(id: &'static str, name: &'static str, about: &'static str, evidence: Evidence) -> Fault {
        Fault { id, name, about, evidence }
    }
    &[
        row("F01", "frames-lost", "the sensor of the acting hand stops", Injected(Frames("drop=1", None), SILENT)),
        row("F02", "frames-frozen", "frames repeat one content, with new sequence numbers", Injected(Frames("freeze", None), Reaction::HoldAfterEqual(10))),
        row("F03", "frames-stale", "frames carry a time 50 ms in the past", Injected(Frames("stale=0.05", None), SILENT)),
        row("F04", "frames-future", "frames carry a time 50 ms in the future", Injected(Frames("future=0.05", None), SILENT)),
        row("F05", "short-gap", "three frames are missing", Injected(Frames("drop=1", Some(0.003)), Continue)),
        row("F06", "long-gap", "eight frames are missing", Injected(Frames("drop=1", Some(0.008)), SILENT)),
        row("F07", "frames-duplicated", "every frame arrives twice", Injected(Frames("duplicate", None), Continue)),
        row("F08", "frames-reordered", "neighbouring frames swap their order", Injected(Frames("reorder", None), Continue)),
        row("F09", "counter-wraps", "the sequence number wraps to zero", Injected(FramesWrap, Safe)),
        row("F10a", "some-bits-flipped", "a bit flips in one of ten frames", Injected(Frames("corrupt=0.1", None), Continue)),
        row("F10b", "all-bits-flipped", "a bit flips in every frame", Injected(Frames("corrupt=1", None), SILENT)),
        row("F11", "wrong-hand", "frames carry the id of the other hand", Injected(Frames("foreign", None), SILENT)),
        row("F12a", "one-nan", "one element reads NaN", Injected(Frames("nan=1", None), Continue)),
        row("F12b", "many-nan", "twenty elements read NaN", Injected(Frames("nan=20", None), Hold(1))),
        row("F13", "denormal", "every reading is a denormal number", Injected(Frames("denormal", None), Hold(1))),
        row("F14", "huge-reading", "one element reads 1e9 N", Injected(Frames("huge", None), Continue)),
        row("F15", "stuck-element", "one element repeats its reading", Injected(Frames("stick=0", None), Safe)),
        row("F16", "drift", "normal forces drift by 10 mN/s", Injected(Frames("bias=0.01", None), Safe)),
        row("F17", "saturated", "every element reads 25 N", Injected(Frames("saturate", None), Safe)),
        row("F18", "slow-sensor", "the sensor delivers 100 frames per second", Test("sim-backend/tests/closed_loop/interrupted.rs::tasks_succeed_despite_repeated_holds")),
        row("F19", "bursts", "frames arrive twenty at once", Injected(Frames("burst=20", None), BURSTS)),
        row("F20", "sensor-restarted", "frames begin again with a new writer epoch", Injected(Frames("epoch", None), Safe)),
        row("F21", "wall-clock", "the wall clock of the daemon jumps by ten years", Process(ProcessFault::WallClock, Continue)),
        row("F22", "clock-offset", "frames carry a time 1e6 s in the future", Injected(Frames("future=1000000", None), SILENT)),
        row("F23", "all-frozen", "no process runs for 5 s", Injected(Pause(5000), Hold(0))),
        row("F24a", "daemon-paused", "the controller does not run for 100 ms", Injected(Pause(100), Hold(0))),
        row("F24b", "daemon-stopped", "the daemon is stopped for 1.5 s by SIGSTOP", Process(ProcessFault::Stopped, Hold(0))),
        row("F25a", "controller-replaced", "a new controller begins after 100 ms", Injected(Restart(100), Safe)),
        row("F25b", "daemon-killed", "the daemon is killed and another one starts", Process(ProcessFault::DaemonKilled, RESTART)),
        row("F26", "out-of-memory", "the kernel kills the daemon for its memory", Process(ProcessFault::OutOfMemory, RESTART)),
        row("F27", "module-panics", "a module panics", Test("daemon/src/panic_guard.rs::panic_holds_from_the_same_tick_on")),
        row("F28", "module-loops", "a module does not return; the kernel ends the daemon by SIGXCPU", Process(ProcessFault::ModuleLoops, RESTART)),
        row("F29", "module-slow", "the daemon does not run for 2 ms, 50 times", Process(ProcessFault::SlowTicks, Safe)),
        row("F30", "overload", "two busy threads per core run for 2 s", Process(ProcessFault::Overload, Safe)),
        row("F31", "real-time-hog", "a thread of the highest priority takes a core", Process(ProcessFault::RealTimeHog, Safe)),
        row("F32", "second-daemon", "a second daemon starts", Process(ProcessFault::SecondDaemon, Continue)),
        row("F33", "client-killed", "the client of an attached goal is killed", Process(ProcessFault::ClientKilled, Safe)),
        row("F34", "client-hangs", "the client of a goal is stopped", Process(ProcessFault::ClientHangs, Safe)),
        row("F35", "goal-flood", "two clients flood the daemon with goals", Process(ProcessFault::GoalFlood, Continue)),
        row("F36", "goal-malformed", "goals have invalid values or random bytes", Process(ProcessFault::MalformedGoals, Continue)),
        row("F37", "goal-oversized", "a goal has another size", Nothing("payloads of the bus have a fixed size")),
        row("F38", "unknown-version", "a client has another ABI", Test("shm-schemas/bus/tests/versions.rs::client_and_daemon_of_other_abi_are_refused")),
        row("F39", "conflicting-goals", "a goal comes during another", Process(ProcessFault::ConflictingGoals, Continue)),
        row("F40a", "joints-lost", "joint states stop", Injected(Joints("drop=1", None), SILENT)),
        row("F40b", "joints-late", "joint states arrive 10 ms late", Injected(Joints("delay=10", None), SILENT)),
        row("F41a", "joints-jump", "joint states jump by 0.5 rad", Injected(Joints("jump=0.5", None), SafeStop(1))),
        row("F41b", "joints-nan", "a joint state is NaN", Injected(Joints("nan=1", None), SafeStop(1))),
        row("F42", "joint-jammed", "a joint does not move", Test("daemon/atas/tests/atas/faults.rs::following_error_stops_the_robot")),
        row("F43", "command-saturated", "a request exceeds the limits", Test("daemon/atas/tests/atas/gate.rs::arbitrary_commands_stay_within_limits")),
        row("F44", "commands-ignored", "the robot ignores all commands", Injected(Disconnected, Safe)),
        row("F45", "log-disk-full", "the disk of the log is full", Process(ProcessFault::LogDiskFull, Continue)),
        row("F46", "recording-disk-full", "the disk of the recording is full", Process(ProcessFault::RecordingDiskFull, Continue)),
        row("F47", "read-only-disk", "the file systems are read-only", Process(ProcessFault::ReadOnlyDisk, Continue)),
        row("F48", "no-shared-memory", "a daemon finds no shared memory at its start", Process(ProcessFault::NoSharedMemory, Continue)),
        row("F49", "shared-memory-full", "shared memory fills up later", Test("shm-schemas/bus/tests/stop.rs::stop_arrives_on_a_full_locked_bus")),
        row("F50", "segment-truncated", "a shared-memory file of the daemon is truncated", Process(ProcessFault::SegmentTruncated, RESTART)),
        row("F51", "half-created-bus", "daemons are killed during their start", Process(ProcessFault::HalfCreated, RESTART)),
        row("F52", "foreign-user", "another user reads the status and stops", Process(ProcessFault::ForeignUser, Continue)),
        row("F53", "squatted-folder", "another user owns the folder of the bus", Test("shm-schemas/bus/tests/isolation.rs::foreign_folder_is_named_if_it_has_bus")),
        row("F54", "rogue-publisher", "a second process publishes the same data", Process(ProcessFault::RoguePublisher, Continue)),
        row("F55", "frame-rewritten", "frames change after their publication", Process(ProcessFault::FrameRewritten, Safe)),
        row("F56", "table-malformed", "a behaviour table is malformed", Test("tests/tests/system/swarm.rs::valid_tables_replace_running_ones_malformed_never")),
        row("F57", "agents-killed", "the process of the swarm is killed", Test("tests/tests/system/swarm.rs::agents_stop_after_kill_and_resume_with_next")),
        row("F58", "invalid-configuration", "each parameter in turn is out of range", Process(ProcessFault::InvalidConfiguration, Continue)),
        row("F59", "reload-in-goal", "the configuration is read again during a goal, also an invalid one", Process(ProcessFault::Reload, Continue)),
        row("F60", "terminated", "the daemon receives SIGTERM during a goal", Process(ProcessFault::Terminated, RESTART)),
        row("F61", "no-descriptors", "no file descriptor is free", Process(ProcessFault::NoDescriptors, Continue)),
        row("F62", "no-real-time", "real-time scheduling is refused", Process(ProcessFault::NoRealTime, Safe)),
        row("F63", "log-reader-hangs", "the reader of the log hangs", Process(ProcessFault::LogUnread, Continue)),
    ]
};
