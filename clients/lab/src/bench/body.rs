//! How long a tick works: what both measurements of the daemon take from its reports.

use shm_schemas::TickReport;
use shm_schemas::capacity::STAGES;

/// From the wake-up to the published command, ns: every stage but the recording, which comes after it.
pub(super) fn body_ns(report: &TickReport) -> u64 {
    let before = &report.stage_ns[..STAGES - 1];
    before.iter().map(|ns| u64::from(*ns)).sum()
}
