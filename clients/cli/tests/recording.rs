//! Process tests of recording and replay: recordings replay bit for bit, and changes are located.

use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::time::{Duration, Instant};

use rustix::process::{Pid, Signal, kill_process};
use shm_bus::FreshBus;

/// Timeout, long enough for any computer; no measurement depends on it.
const PATIENCE: Duration = Duration::from_secs(60);

/// Returns a program next to `atas`, or `None` if it was not built.
fn program(name: &str) -> Option<PathBuf> {
    let path = Path::new(env!("CARGO_BIN_EXE_atas")).with_file_name(name);
    if path.is_file() {
        return Some(path);
    }
    let why = "is not built; use `cargo test --workspace`";
    // Standard error directly, because the test harness captures output of passing tests.
    let _ = writeln!(
        std::io::stderr(),
        "SKIPPED: recording and replay: {name} {why}"
    );
    None
}

/// Process that is killed on drop.
struct Running(Child);

impl Running {
    fn start(program: &Path, arguments: &[&str]) -> Self {
        let mut command = Command::new(program);
        command
            .args(arguments)
            .env_remove("RUST_LOG")
            .stdin(Stdio::null())
            .stdout(Stdio::null())
            .stderr(Stdio::null());
        Self(command.spawn().expect("it starts"))
    }

    fn end(mut self, signal: Signal) -> Option<i32> {
        kill_process(Pid::from_child(&self.0), signal).expect("it runs");
        self.0.wait().expect("it ends").code()
    }
}

impl Drop for Running {
    fn drop(&mut self) {
        // Both calls do nothing if the process has ended.
        let _ended = self.0.kill();
        let _status = self.0.wait();
    }
}

fn atas(arguments: &[&str]) -> (i32, String) {
    let output = Command::new(env!("CARGO_BIN_EXE_atas"))
        .args(arguments)
        .output();
    let Output {
        status,
        stdout,
        stderr,
    } = output.expect("it starts");
    let text = String::from_utf8_lossy(&stdout) + String::from_utf8_lossy(&stderr);
    (status.code().expect("a code"), text.into_owned())
}

/// Records one goal from the daemon's first to last tick; returns false if the programs are not
/// built.
fn record(file: &Path, clock: &[&str]) -> bool {
    let needed = ["atas-sim", "atasd", "atas-lab"].map(program);
    let [Some(simulator), Some(daemon), Some(_)] = needed else {
        return false;
    };
    let bus = FreshBus::new("record");
    let (bus, out) = (bus.as_str(), file.to_str().expect("UTF-8"));
    let itself = Path::new(env!("CARGO_BIN_EXE_atas"));
    let recorder = Running::start(itself, &["record", "--bus", bus, "--out", out]);
    // The file is created after the ports are open.
    wait_until(|| file.exists());
    let simulate = [&["run", "--bus", bus, "--object", "wood"], clock].concat();
    let _simulator = Running::start(&simulator, &simulate);
    let control = ["--bus", bus, "--config", "/dev/null", "--record-stream"];
    let daemon = Running::start(&daemon, &[&control, clock].concat());
    wait_until(|| atas(&["status", "--bus", bus]).1.contains("mode ready"));
    let goal = [
        "grasp",
        "--bus",
        bus,
        "--at",
        "0.32,-0.15,0.035",
        "--width",
        "40",
    ];
    let (_, printed) = atas(&goal);
    assert!(printed.contains("grasp"), "{printed}");
    assert_eq!(daemon.end(Signal::TERM), Some(0), "the daemon");
    assert_eq!(
        recorder.end(Signal::INT),
        Some(0),
        "the recorder: data was lost"
    );
    true
}

fn wait_until(mut is_so: impl FnMut() -> bool) {
    let begin = Instant::now();
    while !is_so() {
        assert!(begin.elapsed() < PATIENCE, "timed out");
        std::thread::sleep(Duration::from_millis(5));
    }
}

fn number(json: &str, key: &str) -> u64 {
    let value: serde_json::Value =
        serde_json::from_str(json.lines().next().unwrap_or_default()).expect("JSON");
    value[key]
        .as_u64()
        .unwrap_or_else(|| panic!("{key} in {json}"))
}

#[test]
fn lockstep_run_replays_and_changes_are_located() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("run.mcap");
    if !record(&file, &["--lockstep"]) {
        return;
    }
    let path = file.to_str().expect("UTF-8");
    let (code, printed) = atas(&["replay", path, "--format", "json"]);
    assert_eq!((code, number(&printed, "different")), (0, 0), "{printed}");
    assert!(number(&printed, "ticks") > 1000, "{printed}");
    let (code, printed) = atas(&["diff", path, path]);
    assert_eq!(code, 0, "{printed}");

    let changed = folder.path().join("changed.mcap");
    change_one_byte(&file, &changed);
    let changed = changed.to_str().expect("UTF-8");
    let (code, printed) = atas(&["replay", changed]);
    assert_eq!(code, 1, "{printed}");
    assert!(
        printed.contains("tick 500: command.position[3]"),
        "{printed}"
    );
    let (code, printed) = atas(&["diff", path, changed]);
    assert_eq!(code, 1, "{printed}");
    assert!(
        printed.contains("tick 500: command.position[3]"),
        "{printed}"
    );
}

#[test]
fn realtime_run_replays() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("run.mcap");
    if !record(&file, &[]) {
        return;
    }
    let (code, printed) = atas(&["replay", file.to_str().expect("UTF-8")]);
    assert_eq!(code, 0, "{printed}");
}

#[test]
fn truncated_recording_is_detected_and_repaired() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("run.mcap");
    if !record(&file, &["--lockstep"]) {
        return;
    }
    let bytes = std::fs::read(&file).expect("readable");
    std::fs::write(&file, &bytes[..bytes.len() * 3 / 4]).expect("writable");
    let (path, whole) = (
        file.to_str().expect("UTF-8"),
        folder.path().join("whole.mcap"),
    );
    let whole = whole.to_str().expect("UTF-8");
    let (code, printed) = atas(&["record", "check", path]);
    assert!(
        code == 1 && printed.contains("atas record repair"),
        "{printed}"
    );
    let (code, printed) = atas(&["record", "repair", path, "--out", whole]);
    assert_eq!(code, 0, "{printed}");
    let (code, printed) = atas(&["record", "check", whole]);
    assert_eq!(code, 0, "{printed}");
    let (code, printed) = atas(&["replay", whole, "--format", "json"]);
    assert_eq!((code, number(&printed, "different")), (0, 0), "{printed}");
}

/// Copies a recording and changes one byte of one command.
fn change_one_byte(from: &Path, to: &Path) {
    use shm_schemas::{JointCommand, TickInputs, service};
    let offset = std::mem::offset_of!(TickInputs, command)
        + std::mem::offset_of!(JointCommand, position)
        + 3 * size_of::<f64>();
    let bytes = std::fs::read(from).expect("readable");
    let file = std::fs::File::create_new(to).expect("new");
    let mut copy = mcap::Writer::new(file).expect("writable");
    let mut ticks = 0;
    for message in mcap::MessageStream::new(&bytes).expect("MCAP") {
        let mut message = message.expect("whole");
        if message.channel.topic == service::TICK_INPUTS {
            // In lock-step every tick takes at most one frame per hand: one part.
            if ticks == 500 {
                message.data.to_mut()[offset] ^= 1;
            }
            ticks += 1;
        }
        copy.write(&message).expect("written");
    }
    copy.finish().expect("finished");
}
