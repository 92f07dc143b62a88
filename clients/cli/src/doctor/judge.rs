//! From facts to findings. Pure: the same facts, the same finding.

use std::collections::BTreeMap;
use std::io;
use std::time::Duration;

use shm_schemas::{Status, StatusFlags};

use super::Finding;

/// Memory that must be lockable, bytes: twice what the daemon may occupy (32 MiB).
const LOCKABLE_BYTES: u64 = 64 << 20;
/// Free shared memory below which the daemon refuses to start or a recorder finds no place, bytes (ours: all streams of
/// one bus take about 14 MiB).
const SHM_NEEDED_BYTES: u64 = 16 << 20;
/// Free shared memory with room for a second bus, a demo and a recording, bytes (ours).
const SHM_WANTED_BYTES: u64 = 64 << 20;
/// Coarsest clock that can place a tick within 1 % of a millisecond, ns.
const RESOLUTION_NS: u64 = 10_000;
/// Shared memory that a bus keeps after everyone left in good order, bytes: measured 4 KiB, with room for a few pages.
const COUNTER_BYTES: u64 = 32 << 10;
/// `CAP_IPC_LOCK`, see capabilities(7): locks memory without a limit.
const CAP_IPC_LOCK: u32 = 14;
/// Clock sources that are read without a system call.
const FAST_CLOCKS: [&str; 5] = [
    "tsc",
    "kvm-clock",
    "hyperv_clocksource_tsc_page",
    "arch_sys_counter",
    "riscv_clocksource",
];

/// Whether a thread may become `SCHED_FIFO`, as tried.
pub(super) fn scheduling(tried: &io::Result<()>, has_rt_groups: bool) -> Finding {
    const PROBE: &str = "real-time scheduling";
    match tried {
        Ok(()) => Finding::ok(PROBE, "SCHED_FIFO at priority 80 granted"),
        Err(error) if has_rt_groups => Finding::fail(
            PROBE,
            format!(
                "SCHED_FIFO refused ({error}); this kernel has real-time groups (RT_GROUP_SCHED)"
            ),
            "give the process's cgroup real-time time (cpu.rt_runtime_us), or run it in the root group; \
             then LimitRTPRIO=80 (ulimit -r 80)",
        ),
        Err(error) => Finding::fail(
            PROBE,
            format!("SCHED_FIFO refused ({error})"),
            "allow priority 80: LimitRTPRIO=80 in the unit, `@group - rtprio 80` in limits.conf, or CAP_SYS_NICE; \
             in a container add --cap-add=SYS_NICE",
        ),
    }
}

/// How long real-time threads may compute, from `/proc/sys/kernel/sched_rt_runtime_us`.
pub(super) fn throttling(runtime_us: &str) -> Finding {
    const PROBE: &str = "real-time throttling";
    match runtime_us.trim().parse::<i64>() {
        Ok(-1) => Finding::ok(PROBE, "off"),
        Ok(runtime_us) if runtime_us > 0 => Finding::ok(
            PROBE,
            format!("{runtime_us} µs of each period; the tick needs a tenth"),
        ),
        Ok(_) => Finding::fail(
            PROBE,
            "real-time threads get no time at all",
            "sysctl kernel.sched_rt_runtime_us=950000",
        ),
        Err(_) => Finding::warn(
            PROBE,
            "unknown to this kernel",
            "none needed if real-time scheduling is granted",
        ),
    }
}

/// Whether enough memory may be locked: the soft limit (`None` is no limit) and `/proc/self/status`.
pub(super) fn memory_lock(limit_bytes: Option<u64>, process_status: &str) -> Finding {
    const PROBE: &str = "memory lock";
    match limit_bytes {
        _ if has_capability(process_status, CAP_IPC_LOCK) => {
            Finding::ok(PROBE, "no limit (CAP_IPC_LOCK)")
        }
        None => Finding::ok(PROBE, "no limit"),
        Some(bytes) if bytes >= LOCKABLE_BYTES => Finding::ok(PROBE, mib(bytes)),
        Some(bytes) => Finding::fail(
            PROBE,
            format!(
                "only {} may be locked, the daemon needs {}",
                mib(bytes),
                mib(LOCKABLE_BYTES)
            ),
            "LimitMEMLOCK=512M in the unit, or `ulimit -l 524288`",
        ),
    }
}

/// Whether a process has an effective capability, from `/proc/self/status`.
fn has_capability(process_status: &str, bit: u32) -> bool {
    let line = process_status
        .lines()
        .find_map(|line| line.strip_prefix("CapEff:"));
    let set = line.and_then(|hex| u64::from_str_radix(hex.trim(), 16).ok());
    set.is_some_and(|set| set & (1 << bit) != 0)
}

/// The kernel's release, and how it preempts, from `uname -r` and `uname -v`.
pub(super) fn kernel(release: &str, version: &str) -> Finding {
    const PROBE: &str = "kernel";
    let words: Vec<&str> = version.split_whitespace().collect();
    let flavour = words.iter().find(|word| word.starts_with("PREEMPT"));
    match flavour {
        Some(&"PREEMPT_RT") => Finding::ok(PROBE, format!("{release}, PREEMPT_RT")),
        Some(flavour) => Finding::warn(
            PROBE,
            format!("{release}, {flavour}: single ticks can be late by milliseconds"),
            "boot with preempt=full, or install a PREEMPT_RT kernel",
        ),
        None => Finding::warn(
            PROBE,
            format!("{release}, not preemptible: system calls of others delay ticks"),
            "install a PREEMPT_RT kernel",
        ),
    }
}

/// Resolution of the sleep's clock, and where the clock's time comes from.
pub(super) fn clock(resolution_ns: u64, source: &str) -> Finding {
    const PROBE: &str = "clock";
    let source = source.trim();
    if resolution_ns > RESOLUTION_NS {
        return Finding::fail(
            PROBE,
            format!("timers resolve {resolution_ns} ns only"),
            "boot without highres=off and nohz=off, on a kernel with CONFIG_HIGH_RES_TIMERS",
        );
    }
    let found = format!("{source}, timers resolve {resolution_ns} ns");
    if source.is_empty() || FAST_CLOCKS.contains(&source) {
        Finding::ok(PROBE, found)
    } else {
        let slow = format!("{found}; every reading is a system call or slower");
        Finding::warn(
            PROBE,
            slow,
            "boot with clocksource=tsc tsc=reliable if the processor's counter is sound",
        )
    }
}

/// The frequency governors of all cores.
pub(super) fn governor(governors: &[String]) -> Finding {
    const PROBE: &str = "frequency governor";
    let mut cores = BTreeMap::<&str, usize>::new();
    for governor in governors {
        *cores.entry(governor.trim()).or_default() += 1;
    }
    let found: Vec<String> = cores
        .iter()
        .map(|(name, count)| {
            format!(
                "{name} ({count} core{})",
                if *count == 1 { "" } else { "s" }
            )
        })
        .collect();
    if cores.is_empty() {
        Finding::ok(PROBE, "none: the frequency is not this kernel's to choose")
    } else if cores.keys().all(|name| *name == "performance") {
        Finding::ok(PROBE, found.join(", "))
    } else {
        let cure = "cpupower frequency-set -g performance";
        Finding::warn(
            PROBE,
            format!("{}: cores slow down between ticks", found.join(", ")),
            cure,
        )
    }
}

/// The cores that nothing is scheduled on by itself, from `/sys/devices/system/cpu/isolated`, among those that exist, from
/// `/sys/devices/system/cpu/present`.
pub(super) fn isolated_cores(isolated: &str, present: &str) -> Finding {
    const PROBE: &str = "isolated cores";
    let (Some(isolated), Some(present)) = (core_list(isolated), core_list(present)) else {
        return Finding::warn(
            PROBE,
            format!("could not read {isolated:?} and {present:?}"),
            "none; report the texts",
        );
    };
    let (there, missing): (Vec<u32>, Vec<u32>) = isolated
        .into_iter()
        .partition(|core| present.contains(core));
    let count = present.len();
    if !missing.is_empty() {
        return Finding::warn(
            PROBE,
            format!("{missing:?} of the boot options do not exist; there are {count} cores"),
            "correct isolcpus= in the boot options",
        );
    }
    if !there.is_empty() {
        return Finding::ok(
            PROBE,
            format!("{there:?} of {count}; realtime.cpu should be one of them"),
        );
    }
    match present.last() {
        Some(last) if count > 1 => Finding::warn(
            PROBE,
            format!("none of {count}: other work shares the core of the ticks"),
            format!(
                "boot with isolcpus=managed_irq,domain,{last} nohz_full={last} and set realtime.cpu = {last}"
            ),
        ),
        _ => Finding::warn(
            PROBE,
            "there is one core: all other work shares it with the ticks",
            "give this machine another core",
        ),
    }
}

/// Reads a list of cores such as `2-3,6`.
fn core_list(text: &str) -> Option<Vec<u32>> {
    let mut cores = Vec::new();
    for range in text.trim().split(',').filter(|range| !range.is_empty()) {
        let (first, last) = range.split_once('-').unwrap_or((range, range));
        let (first, last) = (first.parse::<u32>().ok()?, last.parse::<u32>().ok()?);
        // More cores than any machine has: not a list of cores.
        if last < first || last > 1 << 16 {
            return None;
        }
        cores.extend(first..=last);
    }
    Some(cores)
}

/// Free space in `/dev/shm`.
pub(super) fn shared_memory(free_bytes: u64) -> Finding {
    const PROBE: &str = "shared memory";
    let cure = "mount -o remount,size=256M /dev/shm (in a container: --shm-size=256m), or remove what fills it";
    let found = format!("{} free in /dev/shm", mib(free_bytes));
    if free_bytes < SHM_NEEDED_BYTES {
        Finding::fail(
            PROBE,
            format!("{found}, a bus needs {}", mib(SHM_NEEDED_BYTES)),
            cure,
        )
    } else if free_bytes < SHM_WANTED_BYTES {
        Finding::warn(
            PROBE,
            format!("{found}: enough for one bus without a recorder"),
            cure,
        )
    } else {
        Finding::ok(PROBE, found)
    }
}

/// Who runs this, and whose the service's folder is.
pub(super) fn user(uid: u32, service_uid: Option<u32>) -> Finding {
    const PROBE: &str = "user";
    match service_uid {
        Some(service) if service != uid => Finding::warn(
            PROBE,
            format!("user {uid}, but the installed service's bus belongs to user {service}"),
            "run daemon and sensors as that user; a member of its group reaches it through the gate",
        ),
        _ if uid == 0 => Finding::warn(
            PROBE,
            "root: every process of the bus must then run as root",
            "run daemon and clients as one ordinary user, best the service's user atas",
        ),
        _ => Finding::ok(PROBE, format!("user {uid}")),
    }
}

/// A bus of another user: what this user lacks to pass its gate, if anything.
pub(super) fn elsewhere(error: &str, missing: Option<String>) -> Finding {
    match missing {
        None => Finding::warn(
            "bus",
            error,
            "this user may knock at its gate: `atas status` asks through it; what else passes, access.group says",
        ),
        Some(missing) => Finding::fail("bus", error, missing),
    }
}

/// What lies in `/dev/shm` for buses that nobody uses: names of buses with bytes. A bus that ended well leaves its
/// counter of nodes, one page; what is counted here was left by killed processes.
pub(super) fn leftovers(unused: &BTreeMap<String, u64>) -> Finding {
    const PROBE: &str = "leftovers";
    let left = || unused.iter().filter(|(_, bytes)| **bytes > COUNTER_BYTES);
    let Some((first, _)) = left().next() else {
        return Finding::ok(PROBE, "none");
    };
    let total: u64 = left().map(|(_, bytes)| bytes).sum();
    Finding::warn(
        PROBE,
        format!(
            "{} of {} buses that no process uses, the first is {first:?}",
            mib(total),
            left().count()
        ),
        format!("join such a bus once and it is cleared: atas status --bus {first}"),
    )
}

/// The bus of a file in `/dev/shm`: what stands before `_` and sixteen hexadecimal digits and `_`.
pub(super) fn bus_of_file(name: &str) -> Option<&str> {
    let (bus, rest) = name.split_once('_')?;
    let (hash, _) = rest.split_once('_')?;
    let is_hash = hash.len() == 16 && hash.bytes().all(|b| b.is_ascii_hexdigit());
    (is_hash && !bus.is_empty()).then_some(bus)
}

/// Whether the cores can be kept from idle states that they wake up from slowly: the processor's idle driver, and what became
/// of opening the kernel's device for it.
pub(super) fn idle_states(driver: &str, opened: &io::Result<()>) -> Finding {
    const PROBE: &str = "idle states";
    match (driver.trim(), opened) {
        ("" | "none", _) => Finding::ok(PROBE, "none that this kernel chooses"),
        (driver, Ok(())) => Finding::ok(
            PROBE,
            format!("{driver}; the daemon may keep the cores awake"),
        ),
        (driver, Err(error)) => Finding::warn(
            PROBE,
            format!(
                "{driver}; /dev/cpu_dma_latency refused ({error}): ticks wake up tens of µs later"
            ),
            "install daemon/systemd/60-atas.rules, which gives the group atas the right, and join it",
        ),
    }
}

/// The daemon's own view of itself, and the process that owns the bus. `frozen`: how long its ticks have stood still.
pub(super) fn daemon(status: Option<&Status>, frozen: Option<Duration>, bus: &str) -> Finding {
    const PROBE: &str = "daemon";
    let Some(status) = status else {
        return Finding::warn(
            PROBE,
            format!("no daemon reports on bus {bus:?}"),
            "start `atasd`, or name its bus with --bus",
        );
    };
    let found = format!(
        "atasd {}, process {}, {} Hz, mode {}",
        status.version, status.pid, status.rate_hz, status.mode
    );
    if let Some(frozen) = frozen {
        Finding::fail(
            PROBE,
            format!(
                "{found}, but its ticks have stood still for {:.1} s",
                frozen.as_secs_f64()
            ),
            "stop the robot by its own switch, then restart the daemon and report its log",
        )
    } else if status.flags & StatusFlags::DEGRADED != 0 {
        Finding::fail(
            PROBE,
            format!("{found}, DEGRADED: real-time scheduling or memory locking was refused"),
            "see the other findings and the daemon's log, then restart it",
        )
    } else if status.dropped_records > 0 {
        Finding::warn(
            PROBE,
            format!("{found}, {} records dropped", status.dropped_records),
            "its supervisor gets too little time: look for load on this machine",
        )
    } else {
        Finding::ok(PROBE, found)
    }
}

fn mib(bytes: u64) -> String {
    format!("{:.1} MiB", bytes as f64 / f64::from(1 << 20))
}

#[cfg(test)]
mod tests;
