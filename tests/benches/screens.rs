//! Benchmark of the user interfaces: the `atas dashboard` page in a real browser, the response
//! times of `atas status`, `topic list` and `top`, and `atas export` of a recorded grasp.
//!
//! Bounds are ratios and sizes (`system_tests::gates::SCREENS`); times are only printed.
//!
//! `cargo bench --profile dev --workspace --bench screens` after `cargo build --workspace`; needs
//! Chromium.

#![expect(
    clippy::print_stdout,
    reason = "figures are the product of a benchmark"
)]

use std::path::Path;
use std::process::{Command, ExitCode};
use std::time::{Duration, Instant};

use serde_json::{Value, json};
use shm_bus::FreshBus;
use system_tests::browser::{Browser, installed};
use system_tests::figures::median;
use system_tests::gates::{SCREENS, evaluate};
use system_tests::terminal::Terminal;
use system_tests::{Process, binary, wait_for};

/// Time for which the open page is measured.
const MEASUREMENT_TIME: Duration = Duration::from_secs(10);
/// Number of page loads, and of runs of each program.
const REPEATS: usize = 5;
/// Script that the page runs: records the time of the first displayed picture and counts pictures.
const PAGE_SCRIPT: &str = "window.pictures = 0; window.WebSocket = class extends WebSocket { constructor(...all) { super(...all); \
    this.addEventListener('message', ({ data }) => { if (!data.startsWith('{\"picture\"')) return; \
    if (!window.pictures++) requestAnimationFrame(() => setTimeout(() => window.firstMs = performance.now())); }); } };";
/// Expression for the decoded size of all resources of the page, bytes.
const PAGE_BYTES: &str = "['navigation', 'resource'].flatMap(t => performance.getEntriesByType(t)).reduce((n, e) => n + e.decodedBodySize, 0)";

fn main() -> ExitCode {
    let bus = FreshBus::new("screens");
    let name = bus.as_str();
    let _robot = Process::start("atas-sim", &["run", "--object", "wood", "--bus", name]);
    let _daemon = Process::start("atasd", &["--config", "/dev/null", "--bus", name]);
    wait_until_ready(name);
    let figures = json!({
        "dashboard": dashboard(name),
        "answers_ms": {
            "status": command_ms(&["status", "--bus", name]),
            "topic list": command_ms(&["topic", "list", "--bus", name]),
            "top": median((0..REPEATS).map(|_| top_ms(name)).collect()),
        },
        "export_times": exports(),
    });
    println!("{figures:#}");
    match evaluate(SCREENS, &figures) {
        0 => ExitCode::SUCCESS,
        _ => ExitCode::FAILURE,
    }
}

fn wait_until_ready(bus: &str) {
    wait_for("the daemon", || {
        let mut asked = Process::start("atas", &["status", "--bus", bus]);
        (asked.wait().code() == Some(0)).then_some(())
    });
}

/// Measures the page of a running robot in a browser; null without a browser.
fn dashboard(bus: &str) -> Value {
    let Some(browser) = installed() else {
        println!(
            "dashboard not measured: Chromium is not installed; run `apt-get install chromium`"
        );
        return Value::Null;
    };
    let words = ["dashboard", "--port", "0", "--format", "json", "--bus", bus];
    let server = Process::start("atas-live", &words);
    let url = wait_for("the server to report its address", || {
        let log = server.log();
        let message: Value =
            serde_json::from_str(log.lines().find(|line| line.contains("url"))?).ok()?;
        message["url"].as_str().map(str::to_owned)
    });
    let mut browser = Browser::open(&browser, "about:blank");
    let noted = json!({ "source": PAGE_SCRIPT });
    browser.request("Page.addScriptToEvaluateOnNewDocument", noted);
    let first_ms = (0..REPEATS).map(|_| {
        browser.navigate("about:blank");
        browser.navigate(&url);
        browser.wait_true("a picture", "window.firstMs > 0");
        browser.value("window.firstMs").as_f64().unwrap_or(f64::NAN)
    });
    let first_ms = median(first_ms.collect());
    let before = (browser.value("window.pictures"), cpu_s(server.pid()));
    let begin = Instant::now();
    std::thread::sleep(MEASUREMENT_TIME);
    let after = (browser.value("window.pictures"), cpu_s(server.pid()));
    let watched_s = begin.elapsed().as_secs_f64();
    let pictures = |value: &Value| value.as_f64().unwrap_or(f64::NAN);
    json!({
        "first_picture_ms": first_ms,
        "pictures_hz": (pictures(&after.0) - pictures(&before.0)) / watched_s,
        "cpu_percent": 100.0 * (after.1 - before.1) / watched_s,
        "memory_mb": memory_mb(server.pid()),
        "page_mb": browser.value(PAGE_BYTES).as_f64().unwrap_or(f64::NAN) * 1e-6,
    })
}

/// Returns the processor time of all threads of a process, s.
fn cpu_s(pid: u32) -> f64 {
    let threads = std::fs::read_dir(format!("/proc/{pid}/task")).expect("the process runs");
    let all_ns = threads.map(|thread| {
        let path = thread.expect("readable").path().join("schedstat");
        let text = std::fs::read_to_string(path).unwrap_or_default();
        let first = text.split_whitespace().next();
        first.and_then(|word| word.parse().ok()).unwrap_or(f64::NAN)
    });
    all_ns.sum::<f64>() * 1e-9
}

/// Returns the peak resident memory of a process so far, MB.
fn memory_mb(pid: u32) -> f64 {
    let status = std::fs::read_to_string(format!("/proc/{pid}/status")).unwrap_or_default();
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"));
    let kib = line.and_then(|rest| rest.split_whitespace().next()?.parse::<f64>().ok());
    kib.map_or(f64::NAN, |kib| kib * 1.024e-3)
}

/// Returns the median run time of an `atas` command, ms.
fn command_ms(words: &[&str]) -> f64 {
    let times = (0..REPEATS).map(|_| {
        let begin = Instant::now();
        let output = Command::new(binary("atas")).args(words).output();
        assert!(output.is_ok_and(|output| output.status.success()));
        begin.elapsed().as_secs_f64() * 1e3
    });
    median(times.collect())
}

/// Returns the time from start to the first screen that shows the mode, ms.
fn top_ms(bus: &str) -> f64 {
    let begin = Instant::now();
    let terminal = Terminal::start(&["top", "--bus", bus], false);
    while !terminal.text().contains("READY") {
        std::thread::sleep(Duration::from_micros(200));
    }
    let took_ms = begin.elapsed().as_secs_f64() * 1e3;
    terminal.quit();
    took_ms
}

/// Returns, by format, the ratio of the duration of a recorded grasp to its export time.
fn exports() -> Value {
    let folder = tempfile::TempDir::new().expect("a temporary folder");
    let file = folder.path().join("run.mcap");
    let recorded_s = record(&file);
    let times = ["mcap", "csv", "parquet"].map(|to| {
        let out = folder.path().join(format!("exported.{to}"));
        let begin = Instant::now();
        let mut command = Command::new(binary("atas"));
        command
            .arg("export")
            .arg(&file)
            .args(["--to", to, "--out"])
            .arg(&out);
        assert!(command.output().is_ok_and(|output| output.status.success()));
        (
            to.to_owned(),
            json!(recorded_s / begin.elapsed().as_secs_f64()),
        )
    });
    Value::Object(times.into_iter().collect())
}

/// Records a grasp in lock-step; returns its simulated duration, s.
fn record(file: &Path) -> f64 {
    let bus = FreshBus::new("exported");
    let name = bus.as_str();
    let path = file.display().to_string();
    let mut recorder = Process::start("atas", &["record", "--bus", name, "--out", &path]);
    wait_for("the recorder", || file.exists().then_some(()));
    let simulate = ["run", "--lockstep", "--object", "wood", "--bus", name];
    let _robot = Process::start("atas-sim", &simulate);
    let control = "--lockstep --record-stream --config /dev/null --bus";
    let control: Vec<&str> = control.split(' ').chain([name]).collect();
    let mut daemon = Process::start("atasd", &control);
    wait_until_ready(name);
    let goal = "grasp --at 0.32,-0.15,0.0345 --width 50 --hold 10 --bus";
    let goal: Vec<&str> = goal.split(' ').chain([name]).collect();
    assert_eq!(Process::start("atas", &goal).wait().code(), Some(0));
    daemon.signal(rustix::process::Signal::TERM);
    daemon.wait();
    recorder.signal(rustix::process::Signal::INT);
    assert_eq!(recorder.wait().code(), Some(0), "{}", recorder.log());
    let check = ["record", "check", &path, "--format", "json"];
    let output = Command::new(binary("atas")).args(check).output();
    let message: Value =
        serde_json::from_slice(&output.expect("atas starts").stdout).expect("one JSON value");
    // One part per tick of 1 ms, because a 1 kHz sensor sends one frame per tick.
    message["parts"].as_f64().expect("parts") * 1e-3
}
