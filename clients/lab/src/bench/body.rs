//! Duration of a tick, computed from the daemon's reports.

use shm_schemas::TickReport;
use shm_schemas::capacity::STAGES;

/// Returns the time from wake-up to the published command, ns: all stages except recording, which
/// follows.
pub(super) fn body_ns(report: &TickReport) -> u64 {
    let before = &report.stage_ns[..STAGES - 1];
    before.iter().map(|ns| u64::from(*ns)).sum()
}
