//! Tests of the dashboard in a real browser with a running robot: the page shows the values of the
//! bus, also after a restart of the daemon.
//!
//! In lock-step, time advances for the first ticks and then only while a goal is active. Without a
//! goal the values are constant and can be compared.

use std::collections::BTreeMap;
use std::net::TcpStream;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};
use std::thread::JoinHandle;
use std::time::Duration;

use rustix::process::Signal;
use serde_json::{Value, json};
use shm_bus::{Bus, FreshBus, Realtime};
use shm_schemas::{TickReport, service};
use system_tests::browser::{Browser, installed, request};
use system_tests::{Process, binary, lock_exclusive, skip_or_fail, wait_for};

use crate::recorded;

/// Minimum number of pictures compared with the bus.
const PICTURES: usize = 10;

/// A robot, its daemon and a dashboard server.
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

    /// Starts a long grasp, so that time advances.
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

/// Returns the browser and the axe-core script; `None`, with a message, if one is missing.
pub(crate) fn browser_and_axe() -> Option<(PathBuf, String)> {
    let Some(program) = installed() else {
        skip_or_fail("Chromium is not installed; run `apt-get install chromium`");
        return None;
    };
    let axe = target().join("axe/package/axe.min.js");
    let Ok(script) = std::fs::read_to_string(&axe) else {
        let folder = target().join("axe");
        let (axe, folder) = (axe.display(), folder.display());
        skip_or_fail(&format!(
            "{axe} is missing; run `npm pack axe-core@4.10.3 && tar -xzf axe-core-4.10.3.tgz` in \
             {folder}"
        ));
        return None;
    };
    Some((program, script))
}

/// Returns the target folder.
fn target() -> PathBuf {
    let program = binary("atas-live");
    let folder = program.ancestors().nth(2).unwrap_or(Path::new("."));
    folder.to_owned()
}

/// Returns the server's address with token, its port, and the token.
pub(crate) fn address(server: &Process) -> (String, u16, String) {
    wait_for("the server to report its address", || {
        let log = server.log();
        let message: Value =
            serde_json::from_str(log.lines().find(|line| line.contains("url"))?).ok()?;
        let text = |key: &str| message[key].as_str().map(str::to_owned);
        Some((
            text("url")?,
            message["port"].as_u64()? as u16,
            text("token")?,
        ))
    })
}

/// Tick reports by tick, collected by a thread: in lock-step they arrive faster than the page can
/// be read.
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

    /// Returns the report of a tick that the page shows; `None` if this thread missed it.
    fn report(&self, tick: u64) -> Option<TickReport> {
        let what = format!("the report of tick {tick}, which the page shows, or a later one");
        wait_for(&what, || {
            let by_tick = self.by_tick.lock().expect("whole");
            let (newest, _) = by_tick.last_key_value()?;
            (*newest >= tick).then(|| by_tick.get(&tick).copied())
        })
    }

    /// Clears the reports: the next daemon starts at tick 0.
    fn clear(&self) {
        self.by_tick.lock().expect("whole").clear();
    }
}

impl Drop for Reports {
    fn drop(&mut self) {
        self.ended.store(true, Ordering::Relaxed);
        // A panic of the thread is already printed.
        let _ended = self.thread.take().map(JoinHandle::join);
    }
}

/// Compares the page with the report of its tick; returns the normal force of the right hand's
/// first fingertip.
fn compare(browser: &mut Browser, reports: &Reports) -> Option<f64> {
    let shown = browser.value(
        "Object.fromEntries(['tick', ...['left', 'right'].flatMap(h => [1, 2].flatMap(f => ['normal', 'tangential']\
         .map(w => `${h}-${f}-${w}`)))].map(id => [id, document.getElementById(id).textContent]))",
    );
    let number = |id: &str| shown[id].as_str().and_then(|text| text.parse::<f64>().ok());
    let tick = number("tick").expect("a tick") as u64;
    let report = reports.report(tick)?;
    for (hand, side) in ["left", "right"].iter().enumerate() {
        for (finger, measured) in report.hands[hand].fingers.iter().take(2).enumerate() {
            for (what, value) in [
                ("normal", measured.normal_n),
                ("tangential", measured.tangential_n),
            ] {
                let id = format!("{side}-{}-{what}", finger + 1);
                let output = number(&id).unwrap_or_else(|| panic!("{id}: {shown}"));
                // Page: two decimals, rounded from a value with four.
                let error = (output - f64::from(value)).abs();
                assert!(
                    error <= 0.00506,
                    "tick {tick}, {id}: page shows {output}, report has {value}"
                );
            }
        }
    }
    number("right-1-normal")
}

/// Compares at least `PICTURES` pictures, until the right hand's first fingertip shows a grip.
fn compare_until_gripped(browser: &mut Browser, reports: &Reports) {
    let mut compared = 0;
    wait_for("pictures of a grip on the page", || {
        let pressed_n = compare(browser, reports)?;
        compared += 1;
        (compared >= PICTURES && pressed_n > 1.0).then_some(())
    });
}

/// Waits until the displayed tick is accepted; returns it.
fn wait_tick(browser: &mut Browser, what: &str, accept: impl Fn(u64) -> bool) -> u64 {
    browser.wait_text(what, "tick", |text| {
        text.parse().ok().filter(|tick| accept(*tick))
    })
}

#[test]
fn page_shows_bus_values_after_daemon_restart() {
    let Some((program, axe)) = browser_and_axe() else {
        return;
    };
    let _alone = lock_exclusive();
    let mut rig = Rig::new();
    let reports = Reports::new(&rig.bus);
    let (url, _, _) = address(&rig.server);
    let mut browser = open_without_token(&program, &url);
    let goal = rig.grasp();
    wait_tick(&mut browser, "a picture", |_| true);
    compare_until_gripped(&mut browser, &reports);
    check_layout(&mut browser);
    for part in ["step lift", "module 1, first touch on", "F_1"] {
        browser.wait_contains("events", part);
    }
    stop_and_recover(&mut browser);
    drop(goal);
    reload(&mut browser);
    restart(&mut rig, &mut browser, &reports);
    check_themes(&mut browser, &axe);
    let foreign = browser.value(
        "performance.getEntriesByType('resource').map(e => e.name).filter(n => !n.startsWith(location.origin))",
    );
    let nobody = Value::Array(vec![]);
    assert_eq!(foreign, nobody, "the page requested a foreign origin");
    assert_eq!(browser.page_errors(), &[] as &[String]);
}

/// Without a token, the page shows everything and its buttons are disabled. The full address
/// enables them.
fn open_without_token(program: &Path, url: &str) -> Browser {
    let (bare, _) = url.split_once('#').expect("a token behind #");
    let mut browser = Browser::open(program, bare);
    browser.wait_contains("mode", "ready");
    let is_off = "['stop', 'recover'].every(id => document.getElementById(id).disabled)";
    assert_eq!(browser.value(is_off), Value::Bool(true), "without a token");
    browser.navigate(url);
    browser.wait_true("an enabled stop button", "!stop.disabled");
    let left = browser.value("location.href");
    assert_eq!(left, bare, "the token is removed from the address");
    browser
}

/// Checks a screen of 1280 x 800 during a grasp: the chart of the working hand is above the fold,
/// the held object is drawn, and texts of any length leave the buttons in place.
fn check_layout(browser: &mut Browser) {
    let size = json!({ "width": 1280, "height": 800, "deviceScaleFactor": 1, "mobile": false });
    browser.request("Emulation.setDeviceMetricsOverride", size);
    let chart = "document.querySelector('#traces canvas.working')";
    browser.wait_true("the chart of the working hand", &format!("!!{chart}"));
    let label = browser.value(&format!("{chart}.getAttribute('aria-label')"));
    assert!(label.to_string().contains("right hand"), "{label}");
    let bottom = browser.value(&format!("{chart}.getBoundingClientRect().bottom"));
    assert!(
        bottom.as_f64() <= Some(800.0),
        "the chart ends at {bottom} px"
    );
    browser.wait_true(
        "the held object",
        "(() => { const c = document.getElementById('robot'); const d = c.getContext('2d').getImageData(0, 0, c.width, c.height).data; \
         let n = 0; for (let i = 0; i < d.length; i += 4) n += d[i + 2] > 90 && d[i] < 0.6 * d[i + 2] && d[i + 1] > 0.7 * d[i + 2] \
         && d[i + 1] < 0.95 * d[i + 2]; return n > 20; })()",
    );
    let place = "JSON.stringify(['stop', 'recover'].map(id => document.getElementById(id).getBoundingClientRect()))";
    let before = browser.value(place);
    for text in [
        "x",
        "a long sentence about a goal, its reason and its remedy; "
            .repeat(9)
            .as_str(),
    ] {
        browser.value(&format!(
            "for (const id of ['goal', 'answer', 'where']) document.getElementById(id).textContent = {text:?}"
        ));
        assert_eq!(browser.value(place), before, "{text}");
    }
    browser.value("document.getElementById('answer').textContent = ''");
    browser.request("Emulation.clearDeviceMetricsOverride", json!({}));
}

/// Tests the keyboard: the stop button, opening a fault, and the recover button.
fn stop_and_recover(browser: &mut Browser) {
    browser.tab_to("#stop");
    browser.press("Enter");
    browser.wait_contains("mode", "safe-stop");
    browser.wait_contains("faults", "atas estop");
    browser.tab_to("#faults button");
    browser.press("Enter");
    browser.wait_true("the ticks before the fault", "!flight.hidden");
    browser.tab_to("#recover");
    browser.press("Enter");
    wait_mode(browser, "the recovery");
    assert_eq!(browser.text("answer"), "");
}

/// Checks that a reloaded page shows the current values and keeps its token.
fn reload(browser: &mut Browser) {
    browser.value("window.isOld = true");
    browser.request("Page.reload", json!({}));
    browser.wait_true("the reloaded page", "window.isOld === undefined");
    wait_tick(browser, "a picture after the reload", |_| true);
    browser.wait_true("an enabled stop button after the reload", "!stop.disabled");
}

/// Restarts the daemon. The page keeps the last values until the new daemon, which takes over the
/// grip, reports.
fn restart(rig: &mut Rig, browser: &mut Browser, reports: &Reports) {
    rig.end_daemon();
    browser.wait_contains("mode", "no daemon");
    let last = wait_tick(browser, "the last tick", |_| true);
    reports.clear();
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

/// Waits until the page shows the mode ready or run.
fn wait_mode(browser: &mut Browser, what: &str) {
    browser.wait_text(what, "mode", |text| {
        ["ready", "run"].contains(&text).then_some(())
    });
}

/// Checks both themes: they differ, everything is drawn, and axe-core has no serious finding.
fn check_themes(browser: &mut Browser, axe: &str) {
    let mut grounds = Vec::new();
    for theme in ["light", "dark"] {
        browser.theme(theme);
        browser.value("new Promise(done => setTimeout(done, 300))");
        grounds.push(browser.value("getComputedStyle(document.body).backgroundColor"));
        save_screenshot(theme, &browser.screenshot());
        let blank = browser.value(
            "['#robot', '#histogram', '#skin canvas', '#traces canvas'].filter(name => { const c = document.querySelector(name); \
             return !c.getContext('2d').getImageData(0, 0, c.width, c.height).data.some(v => v > 0); })",
        );
        assert_eq!(blank, Value::Array(vec![]), "{theme}: empty canvas");
        assert_accessible(browser, axe, theme);
    }
    assert_ne!(grounds[0], grounds[1]);
}

/// Asserts that axe-core has no serious finding.
pub(crate) fn assert_accessible(browser: &mut Browser, axe: &str, theme: &str) {
    browser.value(&format!("{axe}; 0"));
    let found = browser.value(
        "axe.run().then(r => r.violations.filter(v => ['serious', 'critical'].includes(v.impact))\
         .map(v => `${v.id}: ${v.nodes.map(n => n.html).join(' ')}`))",
    );
    assert_eq!(found, Value::Array(vec![]), "{theme}");
}

/// Saves a screenshot if `ATAS_PICTURES` names a folder.
pub(crate) fn save_screenshot(name: &str, base64: &str) {
    if let Some(folder) = std::env::var_os("ATAS_PICTURES") {
        let file = PathBuf::from(folder).join(format!("{name}.png.base64"));
        std::fs::write(file, base64).expect("written");
    }
}

#[test]
fn recording_is_scrubbed_by_keyboard() {
    let Some((program, axe)) = browser_and_axe() else {
        return;
    };
    let _alone = lock_exclusive();
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("run.mcap");
    let name = file.to_str().expect("UTF-8");
    // Playback works with an incomplete recording: frames lost by a slow recorder are reported and
    // skipped.
    assert_eq!(recorded::record("wood", name).goal, Some(0));
    let server = serve(&["--recording", name]);
    let mut browser = Browser::open(&program, &address(&server).0);
    let first = wait_tick(&mut browser, "the first picture", |_| true);
    check_opening(&mut browser);
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
    browser.wait_contains("events", "goal");
    let hidden = browser.value("document.getElementById('controls').hidden");
    assert_eq!(hidden, Value::Bool(true), "a recording cannot be stopped");
    assert_accessible(&mut browser, &axe, "a recording");
    assert_eq!(browser.page_errors(), &[] as &[String]);
}

/// Checks that a recording opens at its first touch.
fn check_opening(browser: &mut Browser) {
    let late_s = browser.value(
        "fetch('/recording.json').then(r => r.json()).then(({ events, moments }) => { \
         const touch = Math.min(...events.filter(e => e.kind === 'touch-on').map(e => e.t_s)); \
         return moments[+scrub.value][0] - touch; })",
    );
    let late_s = late_s.as_f64().expect("a touch was recorded");
    assert!(
        (0.0..0.1).contains(&late_s),
        "opened {late_s} s after the first touch"
    );
    let forces = ["right-1-normal", "right-2-normal"].map(|id| browser.text(id));
    let is_pressed = |text: &String| text.parse::<f64>().is_ok_and(|normal_n| normal_n > 0.05);
    assert!(forces.iter().any(is_pressed), "{forces:?}");
}

#[test]
fn sixteen_pages_are_admitted_and_closed_ones_free_their_places() {
    let bus = FreshBus::new("places");
    let server = serve(&["--bus", bus.as_str(), "--robot", "two-hand-arm"]);
    let (_, port, _) = address(&server);
    let open = || {
        let stream = TcpStream::connect(("127.0.0.1", port)).expect("connects");
        let page = tungstenite::client(format!("ws://127.0.0.1:{port}/feed"), stream);
        page.ok().map(|(socket, _)| socket)
    };
    for round in 0..2 {
        let pages: Vec<_> = std::thread::scope(|threads| {
            let all: Vec<_> = (0..40).map(|_| threads.spawn(open)).collect();
            let opened = all.into_iter().map(|page| page.join().expect("no panic"));
            opened.flatten().collect()
        });
        assert!(
            pages.len() == 16 || round > 0 && pages.len() < 16,
            "{}",
            pages.len()
        );
        drop(pages);
        wait_for("all places", || {
            let pages: Vec<_> = (0..16).map_while(|_| open()).collect();
            (pages.len() == 16).then_some(())
        });
    }
}

#[test]
fn foreign_origin_or_missing_token_is_rejected() {
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
        // Authorised; fails because no daemon runs.
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
    assert!(policy.contains("left_finger1_tip"), "the robot of --robot");
}
