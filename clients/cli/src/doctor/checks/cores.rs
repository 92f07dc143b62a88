//! Checks of isolated cores and of the interrupts on them.

use crate::doctor::finding::Finding;

/// Cost of a core that is not isolated.
const SHARED_CORE: &str = "other processes and their system calls delay single ticks";

/// Interrupt with a handler.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(in crate::doctor) struct Interrupt {
    /// Number in `/proc/irq`.
    pub(in crate::doctor) number: u32,
    /// List of the cores that serve it.
    pub(in crate::doctor) cores: String,
}

/// Checks that no interrupt is served by an isolated core. Arguments: interrupts, isolated and
/// present cores.
pub(in crate::doctor) fn interrupts(
    interrupts: &[Interrupt],
    isolated: &str,
    present: &str,
) -> Finding {
    const PROBE: &str = "interrupts";
    let isolated = core_list(isolated).unwrap_or_default();
    let is_isolated = |core: &u32| isolated.contains(core);
    let others: Vec<String> = core_list(present)
        .unwrap_or_default()
        .iter()
        .filter(|core| !is_isolated(core))
        .map(u32::to_string)
        .collect();
    if isolated.is_empty() || others.is_empty() {
        return Finding::ok(PROBE, "no isolated core to keep free of interrupts");
    }
    let mut disturbing: Vec<u32> = interrupts
        .iter()
        .filter(|interrupt| core_list(&interrupt.cores).is_some_and(|c| c.iter().any(is_isolated)))
        .map(|interrupt| interrupt.number)
        .collect();
    if disturbing.is_empty() {
        return Finding::ok(PROBE, format!("none on the isolated cores {isolated:?}"));
    }
    disturbing.sort_unstable();
    let numbers: Vec<String> = disturbing.iter().map(u32::to_string).collect();
    Finding::warn(
        PROBE,
        format!("interrupts {disturbing:?} can run on the isolated cores {isolated:?}"),
        format!(
            "run `for i in {}; do echo {} | sudo tee /proc/irq/$i/smp_affinity_list; done` and \
             exclude the isolated cores in irqbalance (IRQBALANCE_BANNED_CPULIST)",
            numbers.join(" "),
            others.join(",")
        ),
        "each interrupt on the core of the ticks delays a tick",
    )
}

/// Checks the isolated cores (`/sys/devices/system/cpu/isolated`) against the present ones
/// (`/sys/devices/system/cpu/present`).
pub(in crate::doctor) fn isolated_cores(isolated: &str, present: &str) -> Finding {
    const PROBE: &str = "isolated cores";
    let (Some(isolated), Some(present)) = (core_list(isolated), core_list(present)) else {
        return Finding::warn(
            PROBE,
            format!("could not read {isolated:?} and {present:?}"),
            "report both texts as a bug",
            "unknown: the core of the ticks can be shared",
        );
    };
    let (there, missing): (Vec<u32>, Vec<u32>) = isolated
        .into_iter()
        .partition(|core| present.contains(core));
    let count = present.len();
    if !missing.is_empty() {
        return Finding::warn(
            PROBE,
            format!("cores {missing:?} of the boot options do not exist; there are {count} cores"),
            "correct isolcpus= in the boot options",
            SHARED_CORE,
        );
    }
    if !there.is_empty() {
        return Finding::ok(
            PROBE,
            format!("cores {there:?} of {count}; set realtime.cpu to one of them"),
        );
    }
    match present.last() {
        Some(last) if count > 1 => Finding::warn(
            PROBE,
            format!("none of {count}: other processes share the core of the ticks"),
            format!(
                "boot with isolcpus=managed_irq,domain,{last} nohz_full={last} and set realtime.cpu = {last}"
            ),
            SHARED_CORE,
        ),
        _ => Finding::warn(
            PROBE,
            "only one core: all other processes share it with the ticks",
            "add a core to this computer",
            SHARED_CORE,
        ),
    }
}

/// Parses a core list such as `2-3,6`.
pub(super) fn core_list(text: &str) -> Option<Vec<u32>> {
    let mut cores = Vec::new();
    for range in text.trim().split(',').filter(|range| !range.is_empty()) {
        let (first, last) = range.split_once('-').unwrap_or((range, range));
        let (first, last) = (first.parse::<u32>().ok()?, last.parse::<u32>().ok()?);
        // Rejects core numbers beyond any real computer.
        if last < first || last > 1 << 16 {
            return None;
        }
        cores.extend(first..=last);
    }
    Some(cores)
}
