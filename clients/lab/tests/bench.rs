//! `atas bench latency` removes its processes and buses after any kind of end.

use std::io::Write;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use rustix::process::{Pid, Signal, kill_process};

/// Timeout that suffices for every machine; not measured.
const TIMEOUT: Duration = Duration::from_secs(60);

fn wait_for<T>(what: &str, mut ask: impl FnMut() -> Option<T>) -> T {
    let begin = Instant::now();
    loop {
        if let Some(answer) = ask() {
            return answer;
        }
        assert!(
            begin.elapsed() < TIMEOUT,
            "timeout while waiting for {what}"
        );
        std::thread::sleep(Duration::from_millis(5));
    }
}

/// Starts a bench and waits for its daemon; returns `None` if the daemon has not been built.
fn measuring(folder: &Path) -> Option<Child> {
    let atas = Path::new(env!("CARGO_BIN_EXE_atas-lab"));
    if !atas.with_file_name("atasd").is_file() || !atas.with_file_name("atas-sim").is_file() {
        let why = "atasd and atas-sim are not built; use `cargo test --workspace`";
        // Written directly, as the test harness captures the output of passing tests.
        let _ = writeln!(std::io::stderr(), "SKIPPED: the bench's tests: {why}");
        return None;
    }
    let mut bench = Command::new(atas)
        .args(["bench", "latency", "--seconds", "1", "--repeats", "1000"])
        // Without other programs, to save time.
        .env("PATH", "")
        .env("TMPDIR", folder)
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .expect("it starts");
    wait_for("its daemon", || {
        assert!(bench.try_wait().expect("waitable").is_none(), "it ended");
        let children = children_of(bench.id());
        children
            .iter()
            .any(|(_, name)| name == "atasd")
            .then_some(())
    });
    Some(bench)
}

/// Returns process ids and names of a process's children.
fn children_of(id: u32) -> Vec<(u32, String)> {
    let path = format!("/proc/{id}/task/{id}/children");
    let text = std::fs::read_to_string(path).unwrap_or_default();
    let ids = text
        .split_whitespace()
        .filter_map(|child| child.parse().ok());
    ids.map(|child: u32| (child, name_of(child))).collect()
}

fn name_of(id: u32) -> String {
    let name = std::fs::read_to_string(format!("/proc/{id}/comm"));
    name.unwrap_or_default().trim().to_owned()
}

fn end(mut bench: Child, signal: Signal) -> Option<i32> {
    kill_process(Pid::from_child(&bench), signal).expect("it runs");
    bench.wait().expect("it ends").code()
}

fn shared_memory_of(id: u32) -> usize {
    let entries = std::fs::read_dir("/dev/shm")
        .expect("shared memory")
        .flatten();
    let name = format!("fbench-{id}-");
    entries
        .filter(|entry| entry.file_name().to_string_lossy().starts_with(&name))
        .count()
}

fn wait_until_gone(children: &[(u32, String)]) {
    for (child, name) in children {
        wait_for(name, || (name_of(*child) != *name).then_some(()));
    }
}

#[test]
fn an_interrupted_bench_leaves_nothing_behind() {
    let folder = tempfile::tempdir().expect("a folder");
    for signal in [Signal::INT, Signal::TERM] {
        let Some(bench) = measuring(folder.path()) else {
            return;
        };
        let (id, children) = (bench.id(), children_of(bench.id()));
        assert_eq!(end(bench, signal), Some(5));
        wait_until_gone(&children);
        assert_eq!(shared_memory_of(id), 0, "{signal:?}");
        let left = std::fs::read_dir(folder.path()).expect("readable").count();
        assert_eq!(left, 0, "{signal:?}");
    }
}

#[test]
fn next_bench_removes_remains_of_killed_one() {
    let folder = tempfile::tempdir().expect("a folder");
    let Some(bench) = measuring(folder.path()) else {
        return;
    };
    let (id, children) = (bench.id(), children_of(bench.id()));
    assert_eq!(end(bench, Signal::KILL), None);
    wait_until_gone(&children);
    let next = measuring(folder.path()).expect("built");
    assert_eq!(end(next, Signal::INT), Some(5));
    assert_eq!(shared_memory_of(id), 0);
}
