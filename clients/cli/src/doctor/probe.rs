//! Facts for `atas doctor`, from kernel, files and bus. Unreadable facts are empty; the checks
//! interpret them.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::io;
use std::os::unix::fs::MetadataExt;
use std::path::Path;

use atas_client::{ClientError, Session, standstill};
use atas_process::scheduling;
use rustix::process::{Resource, geteuid, getrlimit};
use rustix::time::{ClockId, clock_getres};
use shm_bus::{BusError, BusName, now_ns};
use shm_schemas::Status;

use super::{Finding, checks};

/// Folder of the installed service.
const SERVICE: &str = "/run/atas";
const SHM: &str = "/dev/shm";
/// Idle latency device. Opening it changes nothing; only writing does.
const IDLE_LATENCY: &str = "/dev/cpu_dma_latency";
/// One of these files exists if control groups limit real-time time (only cgroup v1).
const RT_GROUPS: [&str; 2] = [
    "/sys/fs/cgroup/cpu/cpu.rt_runtime_us",
    "/sys/fs/cgroup/cpu,cpuacct/cpu.rt_runtime_us",
];

/// Checks the computer, independent of a bus.
pub(super) fn machine() -> Vec<Finding> {
    let uname = rustix::system::uname();
    let text = |part: &std::ffi::CStr| part.to_string_lossy().into_owned();
    let resolution = clock_getres(ClockId::Monotonic);
    let resolution_ns = resolution.tv_sec as u64 * 1_000_000_000 + resolution.tv_nsec as u64;
    let has_rt_groups = RT_GROUPS.iter().any(|file| Path::new(file).exists());
    vec![
        checks::user(
            geteuid().as_raw(),
            fs::metadata(SERVICE).ok().map(|meta| meta.uid()),
        ),
        checks::kernel(&text(uname.release()), &text(uname.version())),
        checks::scheduling(&try_fifo(), has_rt_groups),
        checks::throttling(&read("/proc/sys/kernel/sched_rt_runtime_us")),
        checks::memory_lock(
            getrlimit(Resource::Memlock).current,
            &read("/proc/self/status"),
        ),
        checks::governor(&governors()),
        checks::idle_states(
            &read("/sys/devices/system/cpu/cpuidle/current_driver"),
            &fs::OpenOptions::new()
                .write(true)
                .open(IDLE_LATENCY)
                .map(drop),
        ),
        checks::isolated_cores(
            &read("/sys/devices/system/cpu/isolated"),
            &read("/sys/devices/system/cpu/present"),
        ),
        checks::clock(
            resolution_ns,
            &read("/sys/devices/system/clocksource/clocksource0/current_clocksource"),
        ),
        checks::shared_memory(free_shared_memory()),
    ]
}

/// Checks the bus and its daemon.
pub(super) fn bus(name: &BusName) -> Vec<Finding> {
    // Before joining, which removes leftovers of this bus.
    let mut findings = vec![checks::leftovers(&unused_shared_memory())];
    match Session::existing(name) {
        Ok(session) => {
            findings.push(peers(&session));
            let status: Option<Status> = session.watch_status().ok().map(|(_, status)| status);
            let frozen = status.as_ref().and_then(|s| standstill(s, now_ns()));
            findings.push(checks::daemon(status.as_ref(), frozen, name.as_str()));
        }
        Err(ClientError::Bus(BusError::Absent {
            bus,
            folder,
            unseen,
        })) => {
            let found = format!(
                "{bus:?} is not there: {} does not exist{unseen}",
                folder.display()
            );
            findings.push(Finding::warn(
                "bus",
                found,
                "start `atasd`, or select its bus with --bus",
            ));
            findings.push(checks::daemon(None, None, name.as_str()));
        }
        Err(ClientError::Bus(error @ BusError::OtherUser { .. })) => {
            findings.push(checks::foreign_bus(
                &error.to_string(),
                atas_gate::missing(),
            ));
        }
        Err(error) => findings.push(Finding::fail("bus", error.to_string(), fix(&error))),
    }
    findings
}

fn fix(error: &ClientError) -> &'static str {
    match error {
        ClientError::Bus(BusError::NoSpace { .. }) => {
            "free space in /dev/shm, see the shared \
            memory finding"
        }
        _ => "follow the message; daemon and clients must run as the same user",
    }
}

/// Lists the other processes on the bus.
fn peers(session: &Session) -> Finding {
    let bus = session.bus();
    let place = format!(
        "{:?} in {}, prefix {} in {SHM}",
        bus.name().as_str(),
        bus.folder().display(),
        bus.prefix()
    );
    let own = std::process::id();
    match bus.peers() {
        Ok(peers) => {
            let others = peers.iter().filter(|peer| peer.alive && peer.pid != own);
            let others: BTreeSet<String> = others.map(ToString::to_string).collect();
            let others: Vec<String> = others.into_iter().collect();
            let who = if others.is_empty() {
                "none".to_owned()
            } else {
                others.join(", ")
            };
            Finding::ok("bus", format!("{place}; other processes: {who}"))
        }
        Err(error) => Finding::fail("bus", error.to_string(), "follow the message"),
    }
}

fn read(path: &str) -> String {
    fs::read_to_string(path).unwrap_or_default()
}

fn governors() -> Vec<String> {
    let cores = fs::read_dir("/sys/devices/system/cpu")
        .into_iter()
        .flatten()
        .flatten();
    cores
        .filter_map(|core| fs::read_to_string(core.path().join("cpufreq/scaling_governor")).ok())
        .collect()
}

fn free_shared_memory() -> u64 {
    rustix::fs::statvfs(SHM).map_or(0, |stat| stat.f_bavail.saturating_mul(stat.f_frsize))
}

/// Tries to make a short-lived thread `SCHED_FIFO`.
fn try_fifo() -> io::Result<()> {
    std::thread::spawn(|| scheduling::enter_fifo(scheduling::TICK_PRIORITY))
        .join()
        .unwrap_or_else(|_| Err(io::Error::other("the test thread panicked")))
}

/// Returns this user's shared memory in buses that no process of the user maps, bytes.
fn unused_shared_memory() -> BTreeMap<String, u64> {
    let own = geteuid().as_raw();
    let mut buses = BTreeMap::<String, u64>::new();
    for file in fs::read_dir(SHM).into_iter().flatten().flatten() {
        let Ok(meta) = file.metadata() else { continue };
        if let Some(bus) = checks::bus_of_file(&file.file_name().to_string_lossy())
            && meta.is_file()
            && meta.uid() == own
        {
            *buses.entry(bus.to_owned()).or_default() += meta.blocks() * 512;
        }
    }
    // Read after the files, so that a bus under creation counts as used.
    let used = used_buses();
    buses.retain(|bus, _| !used.contains(bus));
    buses
}

/// Returns the buses whose shared memory a process maps.
fn used_buses() -> BTreeSet<String> {
    let processes = fs::read_dir("/proc").into_iter().flatten().flatten();
    let maps = processes.filter_map(|process| fs::read_to_string(process.path().join("maps")).ok());
    let mut used = BTreeSet::new();
    for map in maps {
        let files = map.lines().filter_map(|line| line.split_once("/dev/shm/"));
        used.extend(
            files
                .filter_map(|(_, file)| checks::bus_of_file(file))
                .map(str::to_owned),
        );
    }
    used
}
