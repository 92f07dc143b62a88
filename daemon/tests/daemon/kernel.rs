//! Kernel use of a tick: one system call, its sleep, and no page fault.

use std::fs;
use std::io::{ErrorKind, Write as _};
use std::path::Path;
use std::process::Command;

use atas_process::stat::Stat;
use rustix::process::Signal;
use shm_bus::FreshBus;
use shm_schemas::{Mode, StatusFlags};

use crate::support::{Daemon, TOLERANT, World};

/// Sleeps before counting: connections are made and memory is touched.
const WARM_UP: usize = 100;
const TICKS: u64 = 1_000;

fn tick_thread(pid: u32) -> String {
    let tasks = fs::read_dir(format!("/proc/{pid}/task")).expect("the daemon lives");
    let is_tick = |path: &std::path::PathBuf| {
        fs::read_to_string(path.join("comm")).is_ok_and(|name| name.trim() == "atasd-tick")
    };
    let mut paths = tasks.filter_map(|task| Some(task.ok()?.path()));
    let path = paths.find(is_tick).expect("there is a tick thread");
    let name = path.file_name().expect("a thread id");
    name.to_str().expect("a number").to_owned()
}

fn print(line: &str) {
    // A closed standard error is not a failure.
    let _ = writeln!(std::io::stderr(), "{line}");
}

/// Checks that `strace` (Debian package of that name) is installed and permitted.
fn can_trace() -> bool {
    let tried = Command::new("strace")
        .args(["-D", "-f", "-qq", "-o", "/dev/null", "true"])
        .status();
    match tried {
        Ok(status) if status.success() => true,
        Ok(_) => {
            print("SKIPPED: strace may not trace here; the tick's system calls were not counted");
            false
        }
        Err(error) if error.kind() == ErrorKind::NotFound => {
            print("SKIPPED: strace is not installed; the tick's system calls were not counted");
            false
        }
        Err(error) => panic!("strace does not start: {error}"),
    }
}

#[test]
fn tick_makes_one_system_call() {
    if !can_trace() {
        return;
    }
    let bus = FreshBus::new("strace");
    let mut world = World::open(&bus);
    let folder = tempfile::TempDir::new().expect("a temporary folder");
    let trace = folder.path().join("trace");
    let out = trace.display().to_string();
    // -D: the daemon stays our child, strace is its grandchild.
    let strace = ["strace", "-D", "-f", "-qq", "-o", &out];
    // Slow enough for a traced process; recording is included.
    let flags = [
        "--set=realtime.rate_hz=200",
        "--set=safety.valid_s=0.02",
        "--record-stream",
    ];
    let mut daemon = Daemon::start_under(&strace, &bus, TOLERANT, &flags, |_| ());
    let begin = world.until_mode(Mode::READY).ticks;
    world.until("ticks", |s| s.ticks > begin + WARM_UP as u64 + TICKS / 2);
    let thread = tick_thread(daemon.pid());
    let text = fs::read_to_string(&trace).expect("strace writes");
    daemon.signal(Signal::TERM);
    assert!(daemon.wait().success());

    let calls: Vec<&str> = text
        .lines()
        .filter_map(|line| line.strip_prefix(&thread)?.trim_start().split_once('('))
        .map(|(name, _)| name)
        .filter(|name| !name.contains("resumed"))
        .collect();
    let is_sleep = |call: &&str| *call == "clock_nanosleep";
    let mut sleeps = calls.iter().enumerate().filter(|(_, call)| is_sleep(call));
    let (steady, _) = sleeps.nth(WARM_UP).expect("many sleeps");
    let others: Vec<_> = calls[steady..]
        .iter()
        .filter(|call| !is_sleep(call))
        .collect();
    assert!(others.is_empty(), "{others:?}");
    let counted = calls.len() - steady;
    assert!(counted as u64 >= TICKS / 4, "{counted} sleeps");
    print(&format!(
        "{counted} ticks: {counted} clock_nanosleep, nothing else"
    ));
}

/// Page faults of a thread so far.
fn page_faults(pid: u32, thread: &str) -> u64 {
    let folder = format!("/proc/{pid}/task/{thread}");
    let stat = Stat::read(Path::new(&folder));
    stat.expect("the daemon lives").page_faults
}

#[test]
fn tick_makes_no_page_fault() {
    let bus = FreshBus::new("faults");
    let mut world = World::open(&bus);
    let daemon = Daemon::start_with(&bus, TOLERANT, &["--record-stream"], |_| ());
    let begin = world.until_mode(Mode::READY);
    world.until("warm", |s| s.ticks > begin.ticks + TICKS);
    let thread = tick_thread(daemon.pid());
    let before = page_faults(daemon.pid(), &thread);
    let since = world.newest.ticks;
    world.until("ticks", |s| s.ticks > since + TICKS);
    let faults = page_faults(daemon.pid(), &thread) - before;
    if begin.flags & StatusFlags::MEMORY_LOCKED == 0 {
        return print(&format!(
            "SKIPPED: memory may not be locked here; {faults} page faults"
        ));
    }
    assert_eq!(faults, 0, "in {TICKS} ticks");
}
