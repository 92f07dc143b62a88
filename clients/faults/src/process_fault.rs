//! Faults of processes and of the machine, by name.

/// Fault that a running daemon process can show.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ProcessFault {
    /// The wall clock of the daemon jumps by ten years during a goal.
    WallClock,
    /// SIGSTOP for 1.5 s, then SIGCONT.
    Stopped,
    /// SIGKILL during a goal; a new daemon starts.
    DaemonKilled,
    /// The kernel kills the daemon for the memory of its control group.
    OutOfMemory,
    /// SIGXCPU, which the kernel sends to a real-time thread that does not return.
    ModuleLoops,
    /// The daemon does not run for 2 ms in 50 of its ticks, as with a slow module.
    SlowTicks,
    /// Two busy threads per core for 2 s.
    Overload,
    /// A thread of the highest real-time priority takes a core.
    RealTimeHog,
    /// A second daemon starts on the same bus.
    SecondDaemon,
    /// The client of an attached goal is killed.
    ClientKilled,
    /// The client of an attached goal is stopped by SIGSTOP.
    ClientHangs,
    /// Two clients send thousands of goals.
    GoalFlood,
    /// A client sends goals with invalid numbers and random bytes, before a valid goal.
    MalformedGoals,
    /// A client sends a valid goal during another one.
    ConflictingGoals,
    /// The daemon's log is on a full disk.
    LogDiskFull,
    /// The disk of a recording is full.
    RecordingDiskFull,
    /// The file systems of the daemon are read-only.
    ReadOnlyDisk,
    /// A second daemon, on another bus, finds no shared memory.
    NoSharedMemory,
    /// A shared-memory file that only the daemon uses is truncated; the daemon ends by SIGBUS.
    SegmentTruncated,
    /// The daemon is killed, and further ones at random moments of their start.
    HalfCreated,
    /// A process without rights tries to read the status.
    ForeignUser,
    /// A second process opens the streams of commands and of sensors for writing.
    RoguePublisher,
    /// A process of the same user writes into the shared memory of published frames.
    FrameRewritten,
    /// Each parameter in turn has a value above its range: the configuration is refused.
    InvalidConfiguration,
    /// SIGHUP during a goal, with a changed configuration, then with an invalid one.
    Reload,
    /// SIGTERM during a goal: the daemon ends by itself with exit code 0.
    Terminated,
    /// The daemon has no free file descriptor.
    NoDescriptors,
    /// The kernel refuses real-time scheduling to the daemon.
    NoRealTime,
    /// The reader of the daemon's log reads nothing.
    LogUnread,
}
