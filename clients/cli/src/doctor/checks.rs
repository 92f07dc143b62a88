//! Checks of `atas doctor`: pure functions from facts to findings.

use std::collections::BTreeMap;
use std::io;
use std::time::Duration;

use shm_schemas::{Status, StatusFlags};

use super::Finding;

/// Required lockable memory, bytes: twice the daemon's maximum (32 MiB).
const LOCKABLE_BYTES: u64 = 64 << 20;
/// Shared memory for one bus, bytes. With less free memory, the daemon or a recorder does not
/// start. Design choice: the streams of a bus take about 14 MiB.
const SHM_NEEDED_BYTES: u64 = 16 << 20;
/// Shared memory for a second bus, a demo and a recording, bytes (design choice).
const SHM_RECOMMENDED_BYTES: u64 = 64 << 20;
/// Largest timer resolution that keeps tick times within 1 % of a millisecond, ns.
const RESOLUTION_NS: u64 = 10_000;
/// Shared memory left by a bus after an orderly end, bytes: 4 KiB measured, plus a margin of a few
/// pages.
const LEFTOVER_MAX_BYTES: u64 = 32 << 10;
/// `CAP_IPC_LOCK`, see capabilities(7): removes the limit on locked memory.
const CAP_IPC_LOCK: u32 = 14;
/// Clock sources that need no system call.
const FAST_CLOCKS: [&str; 5] = [
    "tsc",
    "kvm-clock",
    "hyperv_clocksource_tsc_page",
    "arch_sys_counter",
    "riscv_clocksource",
];

/// Checks whether a test thread could become `SCHED_FIFO`.
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

/// Checks the time limit of real-time threads, from `/proc/sys/kernel/sched_rt_runtime_us`.
pub(super) fn throttling(runtime_us: &str) -> Finding {
    const PROBE: &str = "real-time throttling";
    match runtime_us.trim().parse::<i64>() {
        Ok(-1) => Finding::ok(PROBE, "off"),
        Ok(runtime_us) if runtime_us > 0 => Finding::ok(
            PROBE,
            format!("{runtime_us} µs per period; a tick needs a tenth"),
        ),
        Ok(_) => Finding::fail(
            PROBE,
            "real-time threads get no time",
            "run `sysctl kernel.sched_rt_runtime_us=950000`",
        ),
        Err(_) => Finding::warn(
            PROBE,
            "unknown to this kernel",
            "nothing to do if real-time scheduling is granted",
        ),
    }
}

/// Checks the soft limit of locked memory (`None` is unlimited) and `/proc/self/status`.
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
                "only {} can be locked, the daemon needs {}",
                mib(bytes),
                mib(LOCKABLE_BYTES)
            ),
            "set LimitMEMLOCK=512M in the unit, or run `ulimit -l 524288`",
        ),
    }
}

/// Returns true if the process has an effective capability, from `/proc/self/status`.
fn has_capability(process_status: &str, bit: u32) -> bool {
    let line = process_status
        .lines()
        .find_map(|line| line.strip_prefix("CapEff:"));
    let set = line.and_then(|hex| u64::from_str_radix(hex.trim(), 16).ok());
    set.is_some_and(|set| set & (1 << bit) != 0)
}

/// Checks kernel release and preemption model, from `uname -r` and `uname -v`.
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
            format!("{release}, not preemptible: system calls of other processes delay ticks"),
            "install a PREEMPT_RT kernel",
        ),
    }
}

/// Checks timer resolution and clock source.
pub(super) fn clock(resolution_ns: u64, source: &str) -> Finding {
    const PROBE: &str = "clock";
    let source = source.trim();
    if resolution_ns > RESOLUTION_NS {
        return Finding::fail(
            PROBE,
            format!("timer resolution is only {resolution_ns} ns"),
            "boot without highres=off and nohz=off, on a kernel with CONFIG_HIGH_RES_TIMERS",
        );
    }
    let found = format!("{source}, timer resolution {resolution_ns} ns");
    if source.is_empty() || FAST_CLOCKS.contains(&source) {
        Finding::ok(PROBE, found)
    } else {
        let slow = format!("{found}; each reading needs a system call or more");
        Finding::warn(
            PROBE,
            slow,
            "boot with clocksource=tsc tsc=reliable if the processor's counter is reliable",
        )
    }
}

/// Checks the frequency governors of all cores.
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
        Finding::ok(PROBE, "none: this kernel does not control the frequency")
    } else if cores.keys().all(|name| *name == "performance") {
        Finding::ok(PROBE, found.join(", "))
    } else {
        let cure = "run `cpupower frequency-set -g performance`";
        Finding::warn(
            PROBE,
            format!("{}: cores slow down between ticks", found.join(", ")),
            cure,
        )
    }
}

/// Checks the isolated cores (`/sys/devices/system/cpu/isolated`) against the present ones
/// (`/sys/devices/system/cpu/present`).
pub(super) fn isolated_cores(isolated: &str, present: &str) -> Finding {
    const PROBE: &str = "isolated cores";
    let (Some(isolated), Some(present)) = (core_list(isolated), core_list(present)) else {
        return Finding::warn(
            PROBE,
            format!("could not read {isolated:?} and {present:?}"),
            "report both texts as a bug",
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
        ),
        _ => Finding::warn(
            PROBE,
            "only one core: all other processes share it with the ticks",
            "add a core to this computer",
        ),
    }
}

/// Parses a core list such as `2-3,6`.
fn core_list(text: &str) -> Option<Vec<u32>> {
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

/// Checks the free space in `/dev/shm`.
pub(super) fn shared_memory(free_bytes: u64) -> Finding {
    const PROBE: &str = "shared memory";
    let cure = "run `mount -o remount,size=256M /dev/shm` (in a container: --shm-size=256m), or \
        delete files there";
    let found = format!("{} free in /dev/shm", mib(free_bytes));
    if free_bytes < SHM_NEEDED_BYTES {
        Finding::fail(
            PROBE,
            format!("{found}, a bus needs {}", mib(SHM_NEEDED_BYTES)),
            cure,
        )
    } else if free_bytes < SHM_RECOMMENDED_BYTES {
        Finding::warn(
            PROBE,
            format!("{found}: enough for one bus without a recorder"),
            cure,
        )
    } else {
        Finding::ok(PROBE, found)
    }
}

/// Checks the current user against the owner of the service's folder.
pub(super) fn user(uid: u32, service_uid: Option<u32>) -> Finding {
    const PROBE: &str = "user";
    match service_uid {
        Some(service) if service != uid => Finding::warn(
            PROBE,
            format!("user {uid}, but the bus of the installed service belongs to user {service}"),
            "run daemon and sensors as that user; members of its group connect through the gate",
        ),
        _ if uid == 0 => Finding::warn(
            PROBE,
            "root: all other processes of the bus must run as root, too",
            "run daemon and clients as one ordinary user, preferably the service user atas",
        ),
        _ => Finding::ok(PROBE, format!("user {uid}")),
    }
}

/// Reports a bus of another user. `missing`: reason why this user cannot use its gate, if any.
pub(super) fn foreign_bus(error: &str, missing: Option<String>) -> Finding {
    match missing {
        None => Finding::warn(
            "bus",
            error,
            "this user may use its gate, for example with `atas status`; access.group sets the \
             allowed commands",
        ),
        Some(missing) => Finding::fail("bus", error, missing),
    }
}

/// Checks for unused shared memory in `/dev/shm`, by bus name, bytes. More than
/// [`LEFTOVER_MAX_BYTES`] per bus comes from killed processes.
pub(super) fn leftovers(unused: &BTreeMap<String, u64>) -> Finding {
    const PROBE: &str = "leftovers";
    let left = || {
        unused
            .iter()
            .filter(|(_, bytes)| **bytes > LEFTOVER_MAX_BYTES)
    };
    let Some((first, _)) = left().next() else {
        return Finding::ok(PROBE, "none");
    };
    let total: u64 = left().map(|(_, bytes)| bytes).sum();
    Finding::warn(
        PROBE,
        format!(
            "{} in {} buses that no process uses, the first is {first:?}",
            mib(total),
            left().count()
        ),
        format!("run `atas status --bus {first}` once to remove such files"),
    )
}

/// Returns the bus name of a file in `/dev/shm`, named `BUS_HASH_…` with a hash of sixteen
/// hexadecimal digits.
pub(super) fn bus_of_file(name: &str) -> Option<&str> {
    let (bus, rest) = name.split_once('_')?;
    let (hash, _) = rest.split_once('_')?;
    let is_hash = hash.len() == 16 && hash.bytes().all(|b| b.is_ascii_hexdigit());
    (is_hash && !bus.is_empty()).then_some(bus)
}

/// Checks whether cores can be kept out of deep idle states: idle driver, and result of opening
/// `/dev/cpu_dma_latency`.
pub(super) fn idle_states(driver: &str, opened: &io::Result<()>) -> Finding {
    const PROBE: &str = "idle states";
    match (driver.trim(), opened) {
        ("" | "none", _) => Finding::ok(PROBE, "none controlled by this kernel"),
        (driver, Ok(())) => Finding::ok(
            PROBE,
            format!("{driver}; the daemon can keep the cores awake"),
        ),
        (driver, Err(error)) => Finding::warn(
            PROBE,
            format!(
                "{driver}; could not open /dev/cpu_dma_latency ({error}): ticks wake up tens of µs \
                 later"
            ),
            "install daemon/systemd/60-atas.rules, which permits this to the group atas, and join \
             the group",
        ),
    }
}

/// Checks the daemon's status. `frozen`: time since the last tick, if the ticks have stopped.
pub(super) fn daemon(status: Option<&Status>, frozen: Option<Duration>, bus: &str) -> Finding {
    const PROBE: &str = "daemon";
    let Some(status) = status else {
        return Finding::warn(
            PROBE,
            format!("no daemon reports on bus {bus:?}"),
            "start `atasd`, or select its bus with --bus",
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
            "stop the robot with its own switch, then restart the daemon and report its log",
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
            "reduce the load on this computer: the supervisor gets too little time",
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
