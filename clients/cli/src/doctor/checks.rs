//! Checks of `atas doctor`: pure functions from facts to findings.

use std::collections::BTreeMap;
use std::io;
use std::time::Duration;

use shm_schemas::{Status, StatusFlags};

use super::finding::Finding;

mod cores;
mod environment;
mod power;

pub(super) use cores::{Interrupt, interrupts, isolated_cores};
pub(super) use environment::{Confinement, Versions, container, versions};
pub(super) use power::{GOVERNOR, PowerMode, governor, idle_states, power_mode};

/// Probe of files that killed processes left in `/dev/shm`.
pub(super) const LEFTOVERS: &str = "leftovers";

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
/// `CAP_SYS_NICE`, see capabilities(7): removes the limit on real-time priorities.
const CAP_SYS_NICE: u32 = 23;
/// Priority of the tick thread, see `atas_process::scheduling`.
const PRIORITY: u64 = atas_process::scheduling::TICK_PRIORITY as u64;
/// Least limit on real-time processor time without a system call that blocks, µs. Design choice:
/// ten ticks at 1 kHz. With a smaller limit the kernel kills a daemon after a few late ticks.
const RTTIME_MIN_US: u64 = 10_000;
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
            LATE_TICKS,
        ),
        Err(error) => Finding::fail(
            PROBE,
            format!("SCHED_FIFO refused ({error})"),
            "allow priority 80: LimitRTPRIO=80 in the unit, `@group - rtprio 80` in limits.conf, or CAP_SYS_NICE; \
             in a container add --cap-add=SYS_NICE",
            LATE_TICKS,
        ),
    }
}

/// Cost of missing real-time scheduling.
const LATE_TICKS: &str = "the daemon does not start with realtime.mode = \"require\"; otherwise it \
    runs DEGRADED, and any busy process can delay its ticks by milliseconds";

/// Soft limits of this process; `None` is unlimited.
#[derive(Clone, Copy, Debug)]
pub(super) struct RealtimeLimits {
    /// Highest real-time priority (`RLIMIT_RTPRIO`).
    pub(super) priority: Option<u64>,
    /// Real-time processor time without a blocking system call, µs (`RLIMIT_RTTIME`).
    pub(super) time_us: Option<u64>,
}

/// Checks the real-time limits of this process and `/proc/self/status`.
pub(super) fn realtime_limits(limits: RealtimeLimits, process_status: &str) -> Finding {
    const PROBE: &str = "real-time limits";
    let is_free = has_capability(process_status, CAP_SYS_NICE);
    match limits {
        RealtimeLimits {
            time_us: Some(time_us),
            ..
        } if time_us < RTTIME_MIN_US => Finding::fail(
            PROBE,
            format!("RLIMIT_RTTIME is {time_us} µs, the daemon needs {RTTIME_MIN_US} µs"),
            "set LimitRTTIME=20000:25000 in the unit, or remove `rttime` from limits.conf",
            "the kernel ends the daemon after a few long ticks; the robot then holds",
        ),
        RealtimeLimits {
            priority: Some(priority),
            ..
        } if priority < PRIORITY && !is_free => Finding::fail(
            PROBE,
            format!("RLIMIT_RTPRIO is {priority}, the tick thread needs {PRIORITY}"),
            "set LimitRTPRIO=80 in the unit, or add `@GROUP - rtprio 80` to \
             /etc/security/limits.conf and log in again",
            LATE_TICKS,
        ),
        RealtimeLimits { time_us, .. } => {
            let time = time_us.map_or("no time limit".to_owned(), |time_us| {
                format!("time limit {time_us} µs")
            });
            Finding::ok(PROBE, format!("priority {PRIORITY} allowed, {time}"))
        }
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
            "run `sudo sysctl kernel.sched_rt_runtime_us=950000`",
            LATE_TICKS,
        ),
        Err(_) => Finding::warn(
            PROBE,
            "unknown to this kernel",
            "nothing to do if real-time scheduling is granted",
            "none if real-time scheduling is granted",
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
            "set LimitMEMLOCK=512M in the unit, or run `ulimit -l 524288`; in a container add \
             --ulimit memlock=-1",
            "the daemon runs DEGRADED; a page fault can delay a tick by milliseconds",
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
            "rare late ticks under load; a late command can make the robot hold",
        ),
        None => Finding::warn(
            PROBE,
            format!("{release}, not preemptible: system calls of other processes delay ticks"),
            "install a PREEMPT_RT kernel",
            "frequent late ticks under load; goals fail if the daemon holds too long",
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
            "the daemon cannot keep its tick rate",
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
            "each tick reads the time several times and takes longer",
        )
    }
}

/// Checks size and free space of `/dev/shm`.
pub(super) fn shared_memory(free_bytes: u64, total_bytes: u64) -> Finding {
    const PROBE: &str = "shared memory";
    let cure = "run `sudo mount -o remount,size=256M /dev/shm` (in a container: --shm-size=256m), \
        or delete files there";
    let found = format!(
        "{} of {} free in /dev/shm",
        mib(free_bytes),
        mib(total_bytes)
    );
    if free_bytes < SHM_NEEDED_BYTES {
        Finding::fail(
            PROBE,
            format!("{found}, a bus needs {}", mib(SHM_NEEDED_BYTES)),
            cure,
            "daemon and clients end with exit code 9",
        )
    } else if free_bytes < SHM_RECOMMENDED_BYTES {
        Finding::warn(
            PROBE,
            format!("{found}: enough for one bus without a recorder"),
            cure,
            "a recorder, a demo or a second bus does not start",
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
            "programs of this user do not join the bus of the service",
        ),
        _ if uid == 0 => Finding::warn(
            PROBE,
            "root: all other processes of the bus must run as root, too",
            "run daemon and clients as one ordinary user, preferably the service user atas",
            "an error in any program can damage the system; clients of other users are refused",
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
            "only the commands of access.group; sensors and recorders do not connect",
        ),
        Some(missing) => Finding::fail("bus", error, missing, "every command on this bus fails"),
    }
}

/// Returns true if unused shared memory of a bus comes from a killed process.
pub(super) fn is_leftover(bytes: u64) -> bool {
    bytes > LEFTOVER_MAX_BYTES
}

/// Checks for unused shared memory in `/dev/shm`, by bus name, bytes. More than
/// [`LEFTOVER_MAX_BYTES`] per bus comes from killed processes.
pub(super) fn leftovers(unused: &BTreeMap<String, u64>) -> Finding {
    let left = || unused.iter().filter(|(_, bytes)| is_leftover(**bytes));
    let Some((first, _)) = left().next() else {
        return Finding::ok(LEFTOVERS, "none");
    };
    let total: u64 = left().map(|(_, bytes)| bytes).sum();
    Finding::warn(
        LEFTOVERS,
        format!(
            "{} in {} buses that no process uses, the first is {first:?}",
            mib(total),
            left().count()
        ),
        "run `atas doctor --fix` to remove these files",
        format!("{} of memory stay occupied until a restart", mib(total)),
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

/// Checks a bus with files but without a process.
pub(super) fn unused_bus(bus: &str) -> Finding {
    let found = format!("no visible process is on bus {bus:?}, but its files exist");
    Finding::warn("bus", found, START_DAEMON, NO_DAEMON)
}

/// Checks a bus without files. `error`: description.
pub(super) fn absent_bus(error: &str) -> Finding {
    Finding::warn("bus", error, START_DAEMON, NO_DAEMON)
}

const START_DAEMON: &str = "start `atasd`, or select its bus with --bus";
const NO_DAEMON: &str = "commands to the robot fail with exit code 3";

/// Checks the daemon's status. `frozen`: time since the last tick, if the ticks have stopped.
pub(super) fn daemon(status: Option<&Status>, frozen: Option<Duration>, bus: &str) -> Finding {
    const PROBE: &str = "daemon";
    let Some(status) = status else {
        return Finding::warn(
            PROBE,
            format!("no daemon reports on bus {bus:?}"),
            START_DAEMON,
            NO_DAEMON,
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
            "the robot receives no commands; `atas estop` has no effect",
        )
    } else if status.flags & StatusFlags::DEGRADED != 0 {
        Finding::fail(
            PROBE,
            format!("{found}, DEGRADED: real-time scheduling or memory locking was refused"),
            "see the other findings and the daemon's log, then restart it",
            "ticks can be late by milliseconds; the robot then holds",
        )
    } else if status.dropped_records > 0 {
        Finding::warn(
            PROBE,
            format!("{found}, {} records dropped", status.dropped_records),
            "reduce the load on this computer: the supervisor gets too little time",
            "recordings have gaps and do not replay",
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
