//! cyclictest, the standard measurement of wake-up latency (Debian package rt-tests).

use std::path::Path;
use std::time::Duration;

use atas_client::percentiles;
use atas_process::scheduling;
use shm_schemas::Percentiles;

use super::Plan;
use super::site::Site;
use super::tool::{self, Notes};

/// Longest run time beyond the requested duration.
const GRACE: Duration = Duration::from_secs(20);

/// Measures the wake-up latency of cyclictest on the plan's core. Returns `None` and adds a note if
/// it cannot run.
pub(super) fn measure(plan: &Plan<'_>, notes: &mut Notes) -> anyhow::Result<Option<Percentiles>> {
    let site = Site::new()?;
    let (core, priority) = (
        format!("-a{}", plan.core),
        format!("-p{}", scheduling::TICK_PRIORITY),
    );
    let duration = format!("-D{}", plan.window.as_secs());
    // All samples in nanoseconds, one thread, locked memory, period 1 ms.
    let arguments = [
        "-m", "-t1", "-i1000", "-d0", "-N", "-v", &core, &priority, &duration,
    ];
    let cure = "apt-get install rt-tests; without it the wake ratios are null";
    let started = tool::start(
        Path::new("cyclictest"),
        "cyclictest",
        cure,
        &arguments,
        site.folder(),
        notes,
    )?;
    let Some(mut child) = started else {
        return Ok(None);
    };
    let status = tool::wait(&mut child, plan.window + GRACE, plan.interrupt)?;
    let late_ns: Vec<u64> = child
        .results()
        .iter()
        .filter_map(|line| sample(line))
        .collect();
    if !status.success() || late_ns.is_empty() {
        notes.add(format!(
            "cyclictest failed ({}); the wake ratios are null",
            child.tail().trim()
        ));
        return Ok(None);
    }
    Ok(Some(percentiles::from_unsorted(late_ns)))
}

/// Parses a line `thread: cycle: latency`.
fn sample(line: &str) -> Option<u64> {
    let mut fields = line.split(':').map(str::trim);
    let _thread = fields.next()?.parse::<u64>().ok()?;
    let _cycle = fields.next()?.parse::<u64>().ok()?;
    let latency = fields.next()?.parse().ok()?;
    fields.next().is_none().then_some(latency)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_sample_lines_are_parsed() {
        let check = |line, expected| assert_eq!(sample(line), expected, "{line}");
        check("       0:       1:    3745", Some(3745));
        check("Thread 0 Interval: 1500", None);
        check("Max CPUs = 4", None);
        check("0: 1: 2: 3", None);
        check("", None);
    }
}
