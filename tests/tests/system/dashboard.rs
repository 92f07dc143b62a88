//! The page, in a real browser, with a running robot: what it shows is what the bus says, also after the daemon's restart.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};
use std::thread::JoinHandle;
use std::time::Duration;

use rustix::process::Signal;
use serde_json::Value;
use shm_bus::{Bus, FreshBus, Realtime};
use shm_schemas::{TickReport, service};
use system_tests::browser::{Browser, get, installed, request};
use system_tests::{Process, alone, binary, wait_for};

use crate::recorded;

/// A robot, its daemon, a server of the page.
struct Rig {
    server: Process,
    daemon: Option<Process>,
    _robot: Process,
    bus: FreshBus,
}

impl Rig {
    fn new() -> Self {
        let bus = FreshBus::new("page");
        let robot = Process::start(
            "atas-sim",
            &[
                "run",
                "--lockstep",
                "--object",
                "wood",
                "--bus",
                bus.as_str(),
            ],
        );
        let mut rig = Self {
            server: serve(&["--bus", bus.as_str()]),
            daemon: None,
            _robot: robot,
            bus,
        };
        rig.start_daemon();
        rig
    }

    fn start_daemon(&mut self) {
        let arguments = [
            "--lockstep",
            "--config",
            "/dev/null",
            "--bus",
            self.bus.as_str(),
        ];
        self.daemon = Some(Process::start("atasd", &arguments));
    }

    fn end_daemon(&mut self) {
        let mut daemon = self.daemon.take().expect("running");
        daemon.signal(Signal::TERM);
        assert_eq!(daemon.wait().code(), Some(0));
    }
}

fn serve(arguments: &[&str]) -> Process {
    let words = [&["dashboard", "--port", "0", "--format", "json"], arguments].concat();
    Process::start("atas-live", &words)
}

/// What the server says at first: its address with the token, its port.
fn address(server: &Process) -> (String, u16, String) {
    wait_for("the server", || {
        let log = server.log();
        let said: Value =
            serde_json::from_str(log.lines().find(|line| line.contains("url"))?).ok()?;
        let text = |key: &str| said[key].as_str().map(str::to_owned);
        Some((text("url")?, said["port"].as_u64()? as u16, text("token")?))
    })
}

/// Reports of the bus, by tick, taken by a thread of its own: in lock-step they come faster than a page is asked.
struct Reports {
    by_tick: Arc<Mutex<BTreeMap<u64, TickReport>>>,
    ended: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

impl Reports {
    fn new(bus: &FreshBus) -> Self {
        let (by_tick, ended) = (
            Arc::<Mutex<BTreeMap<_, _>>>::default(),
            Arc::<AtomicBool>::default(),
        );
        let (name, taken, end) = ((**bus).clone(), Arc::clone(&by_tick), Arc::clone(&ended));
        let thread = std::thread::spawn(move || {
            let bus = Bus::open(&name, "watch", Realtime::No).expect("a bus");
            let mut port = bus.subscriber(service::TICK_REPORT).expect("a place");
            while !end.load(Ordering::Relaxed) {
                let mut by_tick = taken.lock().expect("whole");
                let take = |report: &TickReport| {
                    by_tick.insert(report.tick, *report);
                };
                port.drain(1024, take).expect("readable");
                drop(by_tick);
                std::thread::sleep(Duration::from_millis(1));
            }
        });
        Self {
            by_tick,
            ended,
            thread: Some(thread),
        }
    }

    fn of(&self, tick: u64) -> TickReport {
        wait_for(
            &format!("the report of tick {tick}, which the page shows"),
            || self.by_tick.lock().expect("whole").get(&tick).copied(),
        )
    }
}

impl Drop for Reports {
    fn drop(&mut self) {
        self.ended.store(true, Ordering::Relaxed);
        // A thread that panicked has said so.
        let _ended = self.thread.take().map(JoinHandle::join);
    }
}

/// Holds one moment of the page against the report of its tick; what it shows of the right hand's first finger.
fn compare(browser: &mut Browser, reports: &Reports) -> f64 {
    let shown = browser.value(
        "Object.fromEntries(['tick', ...['left', 'right'].flatMap(h => [1, 2].flatMap(f => ['normal', 'tangential']\
         .map(w => `${h}-${f}-${w}`)))].map(id => [id, document.getElementById(id).textContent]))",
    );
    let number = |id: &str| shown[id].as_str().and_then(|text| text.parse::<f64>().ok());
    let tick = number("tick").expect("a tick") as u64;
    let report = reports.of(tick);
    for (hand, side) in ["left", "right"].iter().enumerate() {
        for finger in 0..2 {
            let felt = &report.hands[hand].fingers[finger];
            for (what, value) in [("normal", felt.normal_n), ("tangential", felt.tangential_n)] {
                let id = format!("{side}-{}-{what}", finger + 1);
                let told = number(&id).unwrap_or_else(|| panic!("{id}: {shown}"));
                assert!(
                    (told - f64::from(value)).abs() <= 0.00506,
                    "tick {tick}, {id}: {told} is {value}"
                );
            }
        }
    }
    number("right-1-normal").expect("compared")
}

#[test]
fn the_page_shows_what_the_bus_says_and_survives_the_daemons_restart() {
    let Some(program) = installed() else { return };
    let _alone = alone();
    let mut rig = Rig::new();
    let (url, _, _) = address(&rig.server);
    let reports = Reports::new(&rig.bus);
    let mut browser = Browser::open(&program, &url);
    wait_for("the daemon on the page", || {
        (browser.text("mode") == "ready").then_some(())
    });
    wait_for("a picture", || browser.text("tick").parse::<u64>().ok());
    let goal = [
        "grasp",
        "--at",
        "0.32,-0.15,0.0345",
        "--width",
        "50",
        "--hold",
        "3600",
        "--bus",
        rig.bus.as_str(),
    ];
    let _goal = Process::start("atas", &goal);
    let mut compared = 0;
    wait_for("a grip on the page", || {
        let pressed_n = compare(&mut browser, &reports);
        compared += 1;
        (pressed_n > 1.0).then_some(())
    });
    for _ in 0..10 {
        compare(&mut browser, &reports);
    }
    assert!(compared > 10, "compared {compared} pictures on the way");
    let events = browser.text("events");
    for part in ["step lift", "module 1, first touch on", "F_1"] {
        wait_for(part, || browser.text("events").contains(part).then_some(()));
    }
    assert!(!events.is_empty());
    stop_and_recover(&mut browser);
    restart(&mut rig, &mut browser);
    looks(&mut browser);
    let foreign = browser.value(
        "performance.getEntriesByType('resource').map(e => e.name).filter(n => !n.startsWith(location.origin))",
    );
    assert_eq!(
        foreign,
        Value::Array(vec![]),
        "the page asked somebody else"
    );
    assert_eq!(browser.troubles, Vec::<String>::new());
}

/// By keyboard: the stop reaches the robot, the fault can be opened, and recovering ends it.
fn stop_and_recover(browser: &mut Browser) {
    browser.value("document.getElementById('stop').focus()");
    browser.press("Enter", 13);
    wait_for("the stop", || {
        (browser.text("mode") == "safe-stop").then_some(())
    });
    wait_for("the fault", || {
        browser.text("faults").contains("atas estop").then_some(())
    });
    browser.value("document.querySelector('#faults button').focus()");
    browser.press("Enter", 13);
    wait_for("its flight", || {
        let open = browser.value("!document.getElementById('flight').hidden");
        (open == Value::Bool(true)).then_some(())
    });
    browser.value("document.getElementById('recover').focus()");
    browser.press("Enter", 13);
    wait_for("the recovery", || {
        ["ready", "run"]
            .contains(&browser.text("mode").as_str())
            .then_some(())
    });
    assert_eq!(browser.text("answer"), "");
}

fn restart(rig: &mut Rig, browser: &mut Browser) {
    rig.end_daemon();
    wait_for("the end on the page", || {
        (browser.text("mode") == "no daemon").then_some(())
    });
    rig.start_daemon();
    wait_for("the daemon again", || {
        (browser.text("mode") != "no daemon").then_some(())
    });
    let before: Option<u64> = browser.text("tick").parse().ok();
    wait_for("pictures again", || {
        let now: Option<u64> = browser.text("tick").parse().ok();
        (now.is_some() && now != before).then_some(())
    });
}

/// Light and dark differ, everything is drawn, and neither has a serious finding of axe-core.
fn looks(browser: &mut Browser) {
    let mut grounds = Vec::new();
    for theme in ["light", "dark"] {
        browser.theme(theme);
        browser.value("new Promise(done => setTimeout(done, 300))");
        grounds.push(browser.value("getComputedStyle(document.body).backgroundColor"));
        keep(theme, &browser.picture());
        let blank = browser.value(
            "['#robot', '#histogram', '#skin canvas', '#traces canvas'].filter(name => { const c = document.querySelector(name); \
             return !c.getContext('2d').getImageData(0, 0, c.width, c.height).data.some(v => v > 0); })",
        );
        assert_eq!(blank, Value::Array(vec![]), "{theme}: nothing is drawn");
        accessible(browser, theme);
    }
    assert_ne!(grounds[0], grounds[1]);
}

/// axe-core without a serious finding; it lies where `.ci/run` puts it.
#[expect(clippy::print_stderr, reason = "a check that cannot run here says so")]
fn accessible(browser: &mut Browser, theme: &str) {
    let axe = target().join("axe/package/axe.min.js");
    let Ok(script) = std::fs::read_to_string(&axe) else {
        eprintln!(
            "SKIPPED: {} is not there: `npm pack axe-core`, unpacked",
            axe.display()
        );
        return;
    };
    browser.value(&format!("{script}; 0"));
    let found = browser.value(
        "axe.run().then(r => r.violations.filter(v => ['serious', 'critical'].includes(v.impact))\
         .map(v => `${v.id}: ${v.nodes.map(n => n.html).join(' ')}`))",
    );
    assert_eq!(found, Value::Array(vec![]), "{theme}");
}

/// The folder of the build.
fn target() -> PathBuf {
    let program = binary("atas-live");
    program
        .ancestors()
        .nth(2)
        .unwrap_or(Path::new("."))
        .to_owned()
}

/// Keeps a picture of the page for people, where somebody asked for one.
fn keep(name: &str, base64: &str) {
    if let Some(folder) = std::env::var_os("ATAS_PICTURES") {
        let file = PathBuf::from(folder).join(format!("{name}.png.base64"));
        std::fs::write(file, base64).expect("written");
    }
}

#[test]
fn a_recording_is_scrubbed_by_keyboard() {
    let Some(program) = installed() else { return };
    let _alone = alone();
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("run.mcap");
    let name = file.to_str().expect("UTF-8");
    assert_eq!(recorded::grasp("wood", name), Some(0));
    let server = serve(&["--recording", name]);
    let mut browser = Browser::open(&program, &address(&server).0);
    let first: u64 = wait_for("the first picture", || browser.text("tick").parse().ok());
    browser.value("document.getElementById('scrub').focus()");
    for _ in 0..3 {
        browser.press("ArrowRight", 39);
    }
    wait_for("a later picture", || {
        let now: u64 = browser.text("tick").parse().ok()?;
        (now > first).then_some(())
    });
    browser.press("End", 35);
    wait_for("the end", || {
        let (at, last) = (browser.value("+scrub.value"), browser.value("+scrub.max"));
        let normal: f64 = browser.text("right-1-normal").parse().ok()?;
        (at == last && normal > 0.5).then_some(())
    });
    assert!(
        browser.text("events").contains("goal"),
        "its events are listed"
    );
    let hidden = browser.value("document.getElementById('controls').hidden");
    assert_eq!(hidden, Value::Bool(true), "a recording cannot be stopped");
    assert_eq!(browser.troubles, Vec::<String>::new());
}

#[test]
fn other_sites_and_whoever_has_no_token_change_nothing() {
    let bus = FreshBus::new("guard");
    let server = serve(&["--bus", bus.as_str()]);
    let (_, port, token) = address(&server);
    let origin = format!("http://127.0.0.1:{port}");
    let bearer = format!("Bearer {token}");
    let check = |method: &str, path: &str, headers: &[(&str, &str)], expected: u16| {
        let (status, body) = request(port, method, path, headers).expect("an answer");
        assert_eq!(status, expected, "{method} {path} {headers:?}: {body}");
    };
    check("GET", "/", &[], 200);
    check("GET", "/", &[("Host", "rebound.example")], 403);
    check(
        "GET",
        "/scene.json",
        &[("Origin", "http://other.example")],
        403,
    );
    check("GET", "/nothing", &[], 404);
    check("GET", "/flight/1", &[], 404);
    let upgrade = [
        ("Upgrade", "websocket"),
        ("Origin", "http://other.example"),
        ("Sec-WebSocket-Version", "13"),
        ("Sec-WebSocket-Key", "dGhlIHNhbXBsZSBub25jZQ=="),
    ];
    check("GET", "/feed", &upgrade, 403);
    for path in ["/stop", "/recover"] {
        check("GET", path, &[], 405);
        check("POST", path, &[], 403);
        check("POST", path, &[("Origin", &origin)], 403);
        check("POST", path, &[("Authorization", &bearer)], 403);
        check(
            "POST",
            path,
            &[
                ("Origin", "http://other.example"),
                ("Authorization", &bearer),
            ],
            403,
        );
        // Trusted, and told that there is no daemon to stop.
        check(
            "POST",
            path,
            &[("Origin", &origin), ("Authorization", &bearer)],
            502,
        );
    }
    let policy = get(port, "/scene.json", &[]).expect("an answer").1;
    assert!(
        policy.contains("left_finger1_tip"),
        "the robot that is drawn"
    );
}
