//! Facts for `atas doctor`, from kernel, files and bus. Unreadable facts are empty; the checks
//! interpret them.

use std::collections::BTreeSet;
use std::fs;
use std::io;
use std::path::Path;
use std::process::{Command, Stdio};

use atas_client::{ClientError, Session, standstill};
use atas_process::scheduling;
use rustix::process::{Resource, geteuid, getrlimit};
use rustix::time::{ClockId, clock_getres};
use shm_bus::{Bus, BusError, BusName, Owner, Peer, now_ns};
use shm_schemas::Status;

use super::checks::{self, Confinement, PowerMode, RealtimeLimits, Versions};
use super::finding::Finding;
use super::root::Root;
use super::stale::Stale;
use crate::companions::path_next_to_this_program;

/// Folder of the installed service.
const SERVICE: &str = "run/atas";
/// Idle latency device. Opening it changes nothing; only writing does.
const IDLE_LATENCY: &str = "dev/cpu_dma_latency";
/// One of these files exists if control groups limit real-time time (only cgroup v1).
const RT_GROUPS: [&str; 2] = [
    "sys/fs/cgroup/cpu/cpu.rt_runtime_us",
    "sys/fs/cgroup/cpu,cpuacct/cpu.rt_runtime_us",
];
/// Programs that must have the version of this one.
const PROGRAMS: [&str; 5] = ["atasd", "atas-demo", "atas-lab", "atas-live", "atas-sim"];

/// Checks the computer, independent of a bus.
pub(super) fn machine(root: &Root) -> Vec<Finding> {
    let mut findings = system(root).to_vec();
    findings.extend(limits(root));
    findings.extend(processor(root));
    findings.push(checks::container(&confinement(root)));
    findings.push(shared_memory(root));
    findings
}

/// Checks user, kernel and clock.
fn system(root: &Root) -> [Finding; 3] {
    let uname = rustix::system::uname();
    let text = |part: &std::ffi::CStr| part.to_string_lossy().into_owned();
    let resolution = clock_getres(ClockId::Monotonic);
    let resolution_ns = resolution.tv_sec as u64 * 1_000_000_000 + resolution.tv_nsec as u64;
    let source = "sys/devices/system/clocksource/clocksource0/current_clocksource";
    [
        checks::user(geteuid().as_raw(), root.owner(SERVICE)),
        checks::kernel(&text(uname.release()), &text(uname.version())),
        checks::clock(resolution_ns, &root.read(source)),
    ]
}

/// Checks the limits of real-time scheduling and locked memory.
fn limits(root: &Root) -> [Finding; 4] {
    let has_rt_groups = RT_GROUPS.iter().any(|file| root.exists(file));
    let process_status = root.read("proc/self/status");
    let limits = RealtimeLimits {
        priority: getrlimit(Resource::Rtprio).current,
        time_us: getrlimit(Resource::Rttime).current,
    };
    [
        checks::scheduling(&try_fifo(), has_rt_groups),
        checks::realtime_limits(limits, &process_status),
        checks::throttling(&root.read("proc/sys/kernel/sched_rt_runtime_us")),
        checks::memory_lock(getrlimit(Resource::Memlock).current, &process_status),
    ]
}

/// Checks frequency, power, idle states and cores.
fn processor(root: &Root) -> [Finding; 5] {
    let latency = fs::OpenOptions::new()
        .write(true)
        .open(root.path(IDLE_LATENCY));
    let (isolated, present) = (root.cores("isolated"), root.cores("present"));
    [
        checks::governor(&root.frequency_settings("scaling_governor")),
        checks::power_mode(&PowerMode {
            profile: root.read("sys/firmware/acpi/platform_profile"),
            preferences: root.frequency_settings("energy_performance_preference"),
            is_on_battery: root.is_on_battery(),
        }),
        checks::idle_states(&root.cores("cpuidle/current_driver"), &latency.map(drop)),
        checks::isolated_cores(&isolated, &present),
        checks::interrupts(&root.interrupts(), &isolated, &present),
    ]
}

fn confinement(root: &Root) -> Confinement {
    let allowed = root.control_group_settings("cpuset.cpus.effective");
    Confinement {
        container: root.container(),
        quotas: root.processor_quotas(),
        memory: root.control_group_settings("memory.max"),
        // The innermost group comes first.
        allowed: allowed.into_iter().next().unwrap_or_default(),
        isolated: root.cores("isolated"),
    }
}

fn shared_memory(root: &Root) -> Finding {
    let bytes = rustix::fs::statvfs(root.path(super::stale::SHM)).map_or((0, 0), |stat| {
        let bytes = |blocks: u64| blocks.saturating_mul(stat.f_frsize);
        (bytes(stat.f_bavail), bytes(stat.f_blocks))
    });
    checks::shared_memory(bytes.0, bytes.1)
}

/// Checks the bus and its daemon. Does not join a bus that no process uses: joining removes files.
pub(super) fn bus(root: &Root, name: &BusName) -> Vec<Finding> {
    let stale = Stale::find(root, geteuid().as_raw());
    let mut findings = vec![checks::leftovers(&stale.bytes())];
    let mut versions = Versions {
        own: env!("CARGO_PKG_VERSION"),
        installed: installed_versions(),
        ..Versions::default()
    };
    let has_no_process = stale.is_abandoned(name.as_str()) && Owner::find(name).is_none();
    if has_no_process && Bus::find(name).is_ok() {
        findings.push(checks::unused_bus(name.as_str()));
        findings.push(checks::daemon(None, None, name.as_str()));
    } else {
        match Session::existing(name) {
            Ok(session) => findings.extend(session_findings(root, &session, &mut versions)),
            Err(error) => findings.extend(absence(error, name)),
        }
    }
    findings.push(checks::versions(&versions));
    findings
}

/// Checks peers and daemon of a joined bus, and adds their versions.
fn session_findings(root: &Root, session: &Session, versions: &mut Versions) -> [Finding; 2] {
    let status: Option<Status> = session.watch_status().ok().map(|(_, status)| status);
    let frozen = status.as_ref().and_then(|s| standstill(s, now_ns()));
    versions.daemon = status.as_ref().map(|status| status.version.to_string());
    let peers = peers(session);
    if let Ok(peers) = &peers {
        let replaced = peers.iter().filter(|peer| root.is_replaced(peer.pid));
        versions.replaced = names(replaced);
    }
    let name = session.bus().name().as_str();
    [
        peers_finding(session, peers),
        checks::daemon(status.as_ref(), frozen, name),
    ]
}

/// Checks a bus that cannot be joined.
fn absence(error: ClientError, name: &BusName) -> Vec<Finding> {
    match error {
        ClientError::Bus(BusError::Absent {
            bus,
            folder,
            unseen,
        }) => {
            let found = format!(
                "{bus:?} is not there: {} does not exist{unseen}",
                folder.display()
            );
            vec![
                checks::absent_bus(&found),
                checks::daemon(None, None, name.as_str()),
            ]
        }
        ClientError::Bus(error @ BusError::OtherUser { .. }) => {
            vec![checks::foreign_bus(
                &error.to_string(),
                atas_gate::missing(),
            )]
        }
        error => vec![Finding::fail(
            "bus",
            error.to_string(),
            fix(&error),
            BUS_FAILURE,
        )],
    }
}

/// Cost of a bus that cannot be joined.
const BUS_FAILURE: &str = "every command on this bus fails";

fn fix(error: &ClientError) -> &'static str {
    match error {
        ClientError::Bus(BusError::NoSpace { .. }) => {
            "free space in /dev/shm, see the shared \
            memory finding"
        }
        ClientError::Bus(BusError::OtherVersion { .. }) => {
            "install the same version of daemon and clients, then restart them"
        }
        _ => "follow the message; daemon and clients must run as the same user",
    }
}

/// Returns the other living processes on the bus.
fn peers(session: &Session) -> Result<Vec<Peer>, BusError> {
    let own = std::process::id();
    let mut peers = session.bus().peers()?;
    peers.retain(|peer| peer.alive && peer.pid != own);
    Ok(peers)
}

/// Lists the other processes on the bus.
fn peers_finding(session: &Session, peers: Result<Vec<Peer>, BusError>) -> Finding {
    let bus = session.bus();
    let place = format!(
        "{:?} in {}, prefix {} in /dev/shm",
        bus.name().as_str(),
        bus.folder().display(),
        bus.prefix()
    );
    match peers {
        Ok(peers) if peers.is_empty() => {
            Finding::ok("bus", format!("{place}; other processes: none"))
        }
        Ok(peers) => {
            let others = names(peers.iter()).join(", ");
            Finding::ok("bus", format!("{place}; other processes: {others}"))
        }
        Err(error) => Finding::fail("bus", error.to_string(), "follow the message", BUS_FAILURE),
    }
}

/// Returns role and process id of each process once.
fn names<'a>(peers: impl Iterator<Item = &'a Peer>) -> Vec<String> {
    let names: BTreeSet<String> = peers.map(ToString::to_string).collect();
    names.into_iter().collect()
}

/// Returns names and versions of the programs next to this one.
fn installed_versions() -> Vec<(String, String)> {
    let versions = PROGRAMS.iter().filter_map(|name| {
        let version = version_of(&path_next_to_this_program(name)?)?;
        Some(((*name).to_owned(), version))
    });
    versions.collect()
}

/// Runs `PROGRAM --version`, which prints name and version.
fn version_of(program: &Path) -> Option<String> {
    let mut command = Command::new(program);
    command.arg("--version").stdin(Stdio::null());
    let output = command.stderr(Stdio::null()).output().ok()?;
    let text = String::from_utf8(output.stdout).ok()?;
    text.split_whitespace().nth(1).map(str::to_owned)
}

/// Tries to make a short-lived thread `SCHED_FIFO`.
fn try_fifo() -> io::Result<()> {
    std::thread::spawn(|| scheduling::enter_fifo(scheduling::TICK_PRIORITY))
        .join()
        .unwrap_or_else(|_| Err(io::Error::other("the test thread panicked")))
}
