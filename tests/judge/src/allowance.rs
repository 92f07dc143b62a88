//! Deviations that a test expects, for example because it causes them.

/// Deviation that is no violation.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Allowance {
    /// Tick counter and captured time may skip whole periods.
    MissedTicks,
    /// Captured time may deviate from the period, as that of a real-time clock does.
    UnevenTicks,
    /// An object may be crushed.
    CrushedObject,
    /// An object may be dropped.
    DroppedObject,
    /// An object may tip over.
    TippedObject,
    /// A bottle may be spilt.
    SpiltObject,
}
