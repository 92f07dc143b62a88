//! Violations and their collection.

use std::collections::BTreeMap;
use std::fmt;

/// Number of violations of each kind that a judge keeps; it counts all. Design choice: shows the
/// onset; one kind with a violation per tick does not displace the others.
pub const KEPT_PER_KIND: u64 = 8;

/// Kind of a violation.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[non_exhaustive]
pub enum ViolationKind {
    /// The checksum does not match.
    Checksum,
    /// A value is not finite.
    NotFinite,
    /// The command names another number of joints.
    JointCount,
    /// A joint is commanded beyond its position limits.
    Position,
    /// A joint exceeds its speed limit.
    Speed,
    /// A joint exceeds its acceleration limit.
    Acceleration,
    /// A joint exceeds its jerk limit.
    Jerk,
    /// The velocity feed-forward differs from the position difference, or is not zero at rest.
    FeedForward,
    /// A joint moves in a mode that only brakes and keeps positions.
    Motion,
    /// The first command after a restart is not the position last in force, at rest.
    Restart,
    /// The sequence number is not the next one.
    Sequence,
    /// The writer epoch changed without a restart.
    WriterEpoch,
    /// The captured time is not later than the last one, or not a multiple of the period.
    CapturedTime,
    /// Ticks are missing.
    MissedTick,
    /// The tick counter does not advance with the captured time.
    TickCounter,
    /// The end of validity is not after the captured time, or too late.
    Validity,
    /// The mode is unknown, or its transition is not permitted.
    Transition,
    /// A promised mode was not reached in time.
    PromiseBroken,
    /// A mode appeared that must not appear.
    ForbiddenMode,
    /// An object was crushed.
    ObjectCrushed,
    /// An object was dropped.
    ObjectDropped,
    /// An object tipped over.
    ObjectTipped,
    /// A bottle was spilt.
    ObjectSpilt,
    /// The hand lost or damaged the object that it must keep.
    GripLost,
    /// The object slid in the hand.
    GripSlip,
    /// The object turned in the hand.
    GripTurn,
}

impl ViolationKind {
    /// Returns the name of the kind in tables.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Checksum => "checksum",
            Self::NotFinite => "not-finite",
            Self::JointCount => "joint-count",
            Self::Position => "position",
            Self::Speed => "speed",
            Self::Acceleration => "acceleration",
            Self::Jerk => "jerk",
            Self::FeedForward => "feed-forward",
            Self::Motion => "motion",
            Self::Restart => "restart",
            Self::Sequence => "sequence",
            Self::WriterEpoch => "writer-epoch",
            Self::CapturedTime => "captured-time",
            Self::MissedTick => "missed-tick",
            Self::TickCounter => "tick-counter",
            Self::Validity => "validity",
            Self::Transition => "transition",
            Self::PromiseBroken => "promise-broken",
            Self::ForbiddenMode => "forbidden-mode",
            Self::ObjectCrushed => "object-crushed",
            Self::ObjectDropped => "object-dropped",
            Self::ObjectTipped => "object-tipped",
            Self::ObjectSpilt => "object-spilt",
            Self::GripLost => "grip-lost",
            Self::GripSlip => "grip-slip",
            Self::GripTurn => "grip-turn",
        }
    }
}

impl fmt::Display for ViolationKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

/// One violation.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Violation {
    /// Tick counter of the command.
    pub tick: u64,
    /// Kind.
    pub kind: ViolationKind,
    /// Failure with value and limit.
    pub text: String,
}

impl fmt::Display for Violation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "tick {}: {}: {}", self.tick, self.kind, self.text)
    }
}

/// Collected violations: the first of each kind, and the count of all.
#[derive(Clone, Debug, Default)]
pub(crate) struct Findings {
    tick: u64,
    kept: Vec<Violation>,
    counts: BTreeMap<ViolationKind, u64>,
}

impl Findings {
    /// Begins a tick.
    pub(crate) fn begin(&mut self, tick: u64) {
        self.tick = tick;
    }

    /// Adds a violation of the current tick.
    pub(crate) fn report(&mut self, kind: ViolationKind, text: fmt::Arguments<'_>) {
        let count = self.counts.entry(kind).or_default();
        *count += 1;
        if *count <= KEPT_PER_KIND {
            self.kept.push(Violation {
                tick: self.tick,
                kind,
                text: text.to_string(),
            });
        }
    }

    pub(crate) fn kept(&self) -> &[Violation] {
        &self.kept
    }

    pub(crate) fn count(&self) -> u64 {
        self.counts.values().sum()
    }

    pub(crate) fn count_of(&self, kind: ViolationKind) -> u64 {
        self.counts.get(&kind).copied().unwrap_or(0)
    }
}
