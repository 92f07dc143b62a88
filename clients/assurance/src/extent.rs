//! Extent of the evidence: seeds, ticks and stops.

use serde::{Deserialize, Serialize};

/// Least extent of the evidence.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Eq, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Extent {
    /// Seeds of each task for faults in virtual time.
    pub seeds: u64,
    /// Seeds of each task for faults of processes.
    pub process_seeds: u64,
    /// Ticks of random runs.
    pub ticks: u64,
    /// Stops.
    pub stops: u64,
}

impl Extent {
    /// Returns the extent times a factor.
    #[must_use]
    pub fn times(self, factor: u64) -> Self {
        Self {
            seeds: self.seeds.saturating_mul(factor),
            process_seeds: self.process_seeds.saturating_mul(factor),
            ticks: self.ticks.saturating_mul(factor),
            stops: self.stops.saturating_mul(factor),
        }
    }
}
