//! Checks of containers, control groups and program versions.

use crate::doctor::finding::Finding;

/// Smallest memory limit of a control group, bytes. Design choice: locked memory and shared memory
/// of the daemon, with a margin of two. With a smaller limit the kernel kills it.
const MEMORY_MIN_BYTES: u64 = 256 << 20;

/// Restrictions of this process by a container or a control group.
#[derive(Clone, Debug, Default)]
pub(in crate::doctor) struct Confinement {
    /// Kind of container.
    pub(in crate::doctor) container: Option<String>,
    /// Processor time limits of all control groups, `QUOTA PERIOD` in µs.
    pub(in crate::doctor) quotas: Vec<String>,
    /// Memory limits of all control groups, bytes or `max`.
    pub(in crate::doctor) memory: Vec<String>,
    /// Cores that the control group allows; empty if unknown.
    pub(in crate::doctor) allowed: String,
    /// Isolated cores.
    pub(in crate::doctor) isolated: String,
}

/// Checks the restrictions by a container or a control group.
pub(in crate::doctor) fn container(confinement: &Confinement) -> Finding {
    const PROBE: &str = "container";
    let place = confinement.container.as_deref();
    let place = place.map_or("no container".to_owned(), |kind| {
        format!("in a container ({kind})")
    });
    if let Some(share) = smallest_share(&confinement.quotas) {
        return Finding::warn(
            PROBE,
            format!("{place}, processor time limited to {share:.2} cores"),
            "remove the quota: no --cpus or cpu limit for the container, CPUQuota= for a unit",
            "the kernel stops supervisor, sensors and clients for the rest of each period",
        );
    }
    let memory = confinement.memory.iter();
    let memory = memory
        .filter_map(|limit| limit.trim().parse::<u64>().ok())
        .min();
    if let Some(bytes) = memory.filter(|bytes| *bytes < MEMORY_MIN_BYTES) {
        return Finding::warn(
            PROBE,
            format!(
                "{place}, memory limited to {}, the daemon needs {}",
                super::mib(bytes),
                super::mib(MEMORY_MIN_BYTES)
            ),
            "raise the limit: --memory=512m for the container, MemoryMax= for a unit",
            "the kernel kills the daemon when it locks its memory",
        );
    }
    let forbidden = forbidden_cores(&confinement.allowed, &confinement.isolated);
    if !forbidden.is_empty() {
        return Finding::warn(
            PROBE,
            format!("{place}, the isolated cores {forbidden:?} are not allowed"),
            "allow them: --cpuset-cpus for the container, AllowedCPUs= for a unit",
            "realtime.cpu cannot select an isolated core; ticks share a core with other processes",
        );
    }
    Finding::ok(PROBE, format!("{place}, no limit of time, memory or cores"))
}

/// Returns the smallest share of processor time, cores, if there is a limit.
fn smallest_share(quotas: &[String]) -> Option<f64> {
    let share = |text: &String| {
        let (quota, period) = text.trim().split_once(' ')?;
        let (quota, period) = (quota.parse::<f64>().ok()?, period.parse::<f64>().ok()?);
        (quota > 0.0 && period > 0.0).then_some(quota / period)
    };
    quotas.iter().filter_map(share).reduce(f64::min)
}

/// Returns the isolated cores that are not allowed.
fn forbidden_cores(allowed: &str, isolated: &str) -> Vec<u32> {
    let allowed = super::cores::core_list(allowed).unwrap_or_default();
    let mut isolated = super::cores::core_list(isolated).unwrap_or_default();
    isolated.retain(|core| !allowed.is_empty() && !allowed.contains(core));
    isolated
}

/// Versions of the programs of one computer.
#[derive(Clone, Debug, Default)]
pub(in crate::doctor) struct Versions<'a> {
    /// This program.
    pub(in crate::doctor) own: &'a str,
    /// Running daemon.
    pub(in crate::doctor) daemon: Option<String>,
    /// Name and version of the programs next to this one.
    pub(in crate::doctor) installed: Vec<(String, String)>,
    /// Processes on the bus whose program file was replaced.
    pub(in crate::doctor) replaced: Vec<String>,
}

/// Checks that daemon and clients have the same version.
pub(in crate::doctor) fn versions(versions: &Versions) -> Finding {
    const PROBE: &str = "versions";
    const COST: &str = "services with another layout are refused; a recording replays only with \
        the version of its daemon";
    let own = versions.own;
    let daemon = versions.daemon.as_deref();
    if let Some(daemon) = daemon.filter(|daemon| *daemon != own) {
        return Finding::warn(
            PROBE,
            format!("this program is {own}, the running daemon is {daemon}"),
            "install one version of all programs, then run `systemctl restart atasd` with empty \
             hands",
            COST,
        );
    }
    let others = versions
        .installed
        .iter()
        .filter(|(_, version)| version != own);
    let others: Vec<String> = others
        .map(|(name, version)| format!("{name} {version}"))
        .collect();
    if !others.is_empty() {
        return Finding::warn(
            PROBE,
            format!("this program is {own}, beside it are {}", others.join(", ")),
            "install or build all programs together (`cargo build --workspace`)",
            COST,
        );
    }
    if !versions.replaced.is_empty() {
        return Finding::warn(
            PROBE,
            format!(
                "program file replaced since start: {}",
                versions.replaced.join(", ")
            ),
            "restart these processes when the hands are empty",
            COST,
        );
    }
    Finding::ok(PROBE, format!("{own} everywhere"))
}
