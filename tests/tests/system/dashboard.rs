//! The page, in a real browser, with a running robot: what it shows is what the bus says, also after the daemon's restart.
//!
//! In lock-step time goes on for the first ticks and then only while there is a goal: what is waited for while there is
//! none has stopped changing, so that it can be compared at leisure.

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
use system_tests::browser::{Browser, installed, request};
use system_tests::{Process, alone, binary, lacking, wait_for};

use crate::recorded;

/// Pictures that are held against the bus on the way to a grip.
const PICTURES: usize = 10;

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
        let name = bus.as_str();
        let simulate = ["run", "--lockstep", "--object", "wood", "--bus", name];
        let mut rig = Self {
            _robot: Process::start("atas-sim", &simulate),
            server: serve(&["--bus", name]),
            daemon: None,
            bus,
        };
        rig.start_daemon();
        rig
    }

    fn start_daemon(&mut self) {
        let name = self.bus.as_str();
        let control = ["--lockstep", "--config", "/dev/null", "--bus", name];
        self.daemon = Some(Process::start("atasd", &control));
    }

    fn end_daemon(&mut self) {
        let mut daemon = self.daemon.take().expect("running");
        daemon.signal(Signal::TERM);
        assert_eq!(daemon.wait().code(), Some(0));
    }

    /// A goal that lasts: the robot's time goes on.
    fn grasp(&self) -> Process {
        let goal = "grasp --at 0.32,-0.15,0.0345 --width 50 --hold 3600 --bus";
        let goal: Vec<&str> = goal.split(' ').chain([self.bus.as_str()]).collect();
        Process::start("atas", &goal)
    }
}

pub(crate) fn serve(arguments: &[&str]) -> Process {
    let words = [&["dashboard", "--port", "0", "--format", "json"], arguments].concat();
    Process::start("atas-live", &words)
}

/// The browser and axe-core, the judge of pages; `None`, with a word about it, where one is missing.
pub(crate) fn tools() -> Option<(PathBuf, String)> {
    let Some(program) = installed() else {
        lacking("no Chromium is installed: apt-get install chromium");
        return None;
    };
    let axe = target().join("axe/package/axe.min.js");
    let Ok(script) = std::fs::read_to_string(&axe) else {
        let folder = target().join("axe");
        let (axe, folder) = (axe.display(), folder.display());
        lacking(&format!(
            "{axe} is not there: in {folder}, npm pack axe-core@4.10.3 && tar -xzf axe-core-4.10.3.tgz"
        ));
        return None;
    };
    Some((program, script))
}

/// The folder of the build.
fn target() -> PathBuf {
    let program = binary("atas-live");
    let folder = program.ancestors().nth(2).unwrap_or(Path::new("."));
    folder.to_owned()
}

/// What the server says at first: its address with the token, its port, the token.
pub(crate) fn address(server: &Process) -> (String, u16, String) {
    wait_for("the server to say its address", || {
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

    /// The report of a tick that the page shows; `None` if this thread, unlike the page's server, came too late for it.
    fn of(&self, tick: u64) -> Option<TickReport> {
        let what = format!("the report of tick {tick}, which the page shows, or a later one");
        wait_for(&what, || {
            let by_tick = self.by_tick.lock().expect("whole");
            let (newest, _) = by_tick.last_key_value()?;
            (*newest >= tick).then(|| by_tick.get(&tick).copied())
        })
    }

    /// Forgets a daemon that has ended: its successor counts from the beginning.
    fn forget(&self) {
        self.by_tick.lock().expect("whole").clear();
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
fn compare(browser: &mut Browser, reports: &Reports) -> Option<f64> {
    let shown = browser.value(
        "Object.fromEntries(['tick', ...['left', 'right'].flatMap(h => [1, 2].flatMap(f => ['normal', 'tangential']\
         .map(w => `${h}-${f}-${w}`)))].map(id => [id, document.getElementById(id).textContent]))",
    );
    let number = |id: &str| shown[id].as_str().and_then(|text| text.parse::<f64>().ok());
    let tick = number("tick").expect("a tick") as u64;
    let report = reports.of(tick)?;
    for (hand, side) in ["left", "right"].iter().enumerate() {
        for (finger, felt) in report.hands[hand].fingers.iter().take(2).enumerate() {
            for (what, value) in [("normal", felt.normal_n), ("tangential", felt.tangential_n)] {
                let id = format!("{side}-{}-{what}", finger + 1);
                let told = number(&id).unwrap_or_else(|| panic!("{id}: {shown}"));
                // Two digits, made of four.
                let error = (told - f64::from(value)).abs();
                assert!(error <= 0.00506, "tick {tick}, {id}: {told} is {value}");
            }
        }
    }
    number("right-1-normal")
}

/// Compares pictures, at least so many, until the first right finger shows a grip.
fn compare_until_gripped(browser: &mut Browser, reports: &Reports) {
    let mut compared = 0;
    wait_for("pictures of a grip on the page", || {
        let pressed_n = compare(browser, reports)?;
        compared += 1;
        (compared >= PICTURES && pressed_n > 1.0).then_some(())
    });
}

/// The tick that the page shows, as soon as it is accepted.
fn wait_tick(browser: &mut Browser, what: &str, accept: impl Fn(u64) -> bool) -> u64 {
    browser.wait_text(what, "tick", |text| {
        text.parse().ok().filter(|tick| accept(*tick))
    })
}

#[test]
fn the_page_shows_what_the_bus_says_and_survives_the_daemons_restart() {
    let Some((program, axe)) = tools() else {
        return;
    };
    let _alone = alone();
    let mut rig = Rig::new();
    let reports = Reports::new(&rig.bus);
    let (url, _, _) = address(&rig.server);
    let mut browser = begin_without_token(&program, &url);
    let goal = rig.grasp();
    wait_tick(&mut browser, "a picture", |_| true);
    compare_until_gripped(&mut browser, &reports);
    for part in ["step lift", "module 1, first touch on", "F_1"] {
        browser.wait_part("events", part);
    }
    stop_and_recover(&mut browser);
    drop(goal);
    load_anew(&mut browser);
    restart(&mut rig, &mut browser, &reports);
    looks(&mut browser, &axe);
    let foreign = browser.value(
        "performance.getEntriesByType('resource').map(e => e.name).filter(n => !n.startsWith(location.origin))",
    );
    let nobody = Value::Array(vec![]);
    assert_eq!(foreign, nobody, "the page asked somebody else");
    assert_eq!(browser.troubles(), &[] as &[String]);
}

/// Whoever has no token sees everything and can stop nothing; the whole address, typed later, gives it.
fn begin_without_token(program: &Path, url: &str) -> Browser {
    let (bare, _) = url.split_once('#').expect("a token behind #");
    let mut browser = Browser::open(program, bare);
    browser.wait_part("mode", "ready");
    let is_off = "['stop', 'recover'].every(id => document.getElementById(id).disabled)";
    assert_eq!(browser.value(is_off), Value::Bool(true), "without a token");
    browser.go(url);
    browser.wait_true("a stop for who has the token", "!stop.disabled");
    let left = browser.value("location.href");
    assert_eq!(left, bare, "the token stays in no address");
    browser
}

/// By keyboard: the stop reaches the robot, the fault can be opened, and recovering ends it.
fn stop_and_recover(browser: &mut Browser) {
    browser.tab_to("#stop");
    browser.press("Enter");
    browser.wait_part("mode", "safe-stop");
    browser.wait_part("faults", "atas estop");
    browser.tab_to("#faults button");
    browser.press("Enter");
    browser.wait_true("the ticks before the fault", "!flight.hidden");
    browser.tab_to("#recover");
    browser.press("Enter");
    wait_mode(browser, "the recovery");
    assert_eq!(browser.text("answer"), "");
}

/// A page that is loaded anew shows where time stands, and the tab still has the token.
fn load_anew(browser: &mut Browser) {
    browser.value("window.isOld = true");
    browser.ask("Page.reload", serde_json::json!({}));
    browser.wait_true("the page anew", "window.isOld === undefined");
    wait_tick(browser, "a picture after loading anew", |_| true);
    browser.wait_true("a stop after loading anew", "!stop.disabled");
}

/// What a dead daemon showed last stays until its successor's pictures come; that one finds the hand gripping and goes on.
fn restart(rig: &mut Rig, browser: &mut Browser, reports: &Reports) {
    rig.end_daemon();
    browser.wait_part("mode", "no daemon");
    let last = wait_tick(browser, "the last tick", |_| true);
    reports.forget();
    rig.start_daemon();
    wait_mode(browser, "the new daemon");
    wait_tick(browser, "the new daemon's ticks", |tick| tick != last);
    let mut compared = 0;
    wait_for("pictures of the new daemon", || {
        compare(browser, reports)?;
        compared += 1;
        (compared >= PICTURES).then_some(())
    });
}

/// Waits until the page shows a robot that can work.
fn wait_mode(browser: &mut Browser, what: &str) {
    browser.wait_text(what, "mode", |text| {
        ["ready", "run"].contains(&text).then_some(())
    });
}

/// Light and dark differ, everything is drawn, and neither has a serious finding of axe-core.
fn looks(browser: &mut Browser, axe: &str) {
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
        accessible(browser, axe, theme);
    }
    assert_ne!(grounds[0], grounds[1]);
}

/// axe-core without a serious finding.
pub(crate) fn accessible(browser: &mut Browser, axe: &str, theme: &str) {
    browser.value(&format!("{axe}; 0"));
    let found = browser.value(
        "axe.run().then(r => r.violations.filter(v => ['serious', 'critical'].includes(v.impact))\
         .map(v => `${v.id}: ${v.nodes.map(n => n.html).join(' ')}`))",
    );
    assert_eq!(found, Value::Array(vec![]), "{theme}");
}

/// Keeps a picture of the page for people, where somebody asked for one.
pub(crate) fn keep(name: &str, base64: &str) {
    if let Some(folder) = std::env::var_os("ATAS_PICTURES") {
        let file = PathBuf::from(folder).join(format!("{name}.png.base64"));
        std::fs::write(file, base64).expect("written");
    }
}

#[test]
fn a_recording_is_scrubbed_by_keyboard() {
    let Some((program, axe)) = tools() else {
        return;
    };
    let _alone = alone();
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("run.mcap");
    let name = file.to_str().expect("UTF-8");
    // A picture needs no complete recording: what a starved recorder has lost is told, and left out.
    assert_eq!(recorded::record("wood", name).goal, Some(0));
    let server = serve(&["--recording", name]);
    let mut browser = Browser::open(&program, &address(&server).0);
    let first = wait_tick(&mut browser, "the first picture", |_| true);
    browser.tab_to("#scrub");
    for _ in 0..3 {
        browser.press("ArrowRight");
    }
    wait_tick(&mut browser, "a later picture", |tick| tick > first);
    browser.press("End");
    browser.wait_true("the end", "+scrub.value > 0 && scrub.value === scrub.max");
    browser.wait_text("a grip at the end", "right-1-normal", |text| {
        text.parse().ok().filter(|normal_n: &f64| *normal_n > 0.5)
    });
    browser.wait_part("events", "goal");
    let hidden = browser.value("document.getElementById('controls').hidden");
    assert_eq!(hidden, Value::Bool(true), "a recording cannot be stopped");
    accessible(&mut browser, &axe, "a recording");
    assert_eq!(browser.troubles(), &[] as &[String]);
}

#[test]
fn other_sites_and_whoever_has_no_token_change_nothing() {
    let bus = FreshBus::new("guard");
    let server = serve(&["--bus", bus.as_str(), "--robot", "two-hand-arm"]);
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
    let policy = request(port, "GET", "/scene.json", &[])
        .expect("an answer")
        .1;
    assert!(
        policy.contains("left_finger1_tip"),
        "the robot that is drawn"
    );
}
