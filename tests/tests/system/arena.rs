//! Tests of the swarm's arena on the dashboard, in a real browser: the page shows the values of the
//! bus while a field appears, waits, runs, ends and restarts.

use std::collections::BTreeMap;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};
use std::thread::JoinHandle;
use std::time::Duration;

use serde_json::Value;
use shm_bus::{Bus, BusName, FreshBus, Realtime};
use shm_schemas::{ArenaTruth, service};
use system_tests::browser::Browser;
use system_tests::{Process, lock_exclusive, wait_for};

use crate::dashboard::{address, assert_accessible, browser_and_axe, save_screenshot, serve};

/// Frames compared with the bus.
const FRAMES_COMPARED: usize = 8;

/// Frames by trial and frame number.
type Taken = BTreeMap<(u64, u64), Box<ArenaTruth>>;

/// All frames of the bus, collected by a thread.
struct Frames {
    taken: Arc<Mutex<Taken>>,
    ended: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

impl Frames {
    fn new(name: &BusName) -> Self {
        let (taken, ended) = (Arc::<Mutex<Taken>>::default(), Arc::default());
        let (name, all, end) = (name.clone(), Arc::clone(&taken), Arc::clone(&ended));
        let thread = std::thread::spawn(move || {
            let bus = Bus::open(&name, "watch", Realtime::No).expect("a bus");
            let mut port = bus.subscriber(service::ARENA_TRUTH).expect("a place");
            let end: Arc<AtomicBool> = end;
            while !end.load(Ordering::Relaxed) {
                let take = |frame: &ArenaTruth| {
                    let key = (u64::from(frame.trial), frame.frame);
                    all.lock().expect("whole").insert(key, Box::new(*frame));
                };
                port.drain(16, take).expect("readable");
                std::thread::sleep(Duration::from_millis(1));
            }
        });
        Self {
            taken,
            ended,
            thread: Some(thread),
        }
    }

    /// Returns the frame that the page shows; `None` if this thread missed it.
    fn frame(&self, trial: u64, frame: u64) -> Option<Box<ArenaTruth>> {
        wait_for("the frame that the page shows, or a later one", || {
            let taken = self.taken.lock().expect("whole");
            let (newest, _) = taken.last_key_value()?;
            (*newest >= (trial, frame)).then(|| taken.get(&(trial, frame)).cloned())
        })
    }
}

impl Drop for Frames {
    fn drop(&mut self) {
        self.ended.store(true, Ordering::Relaxed);
        // A panic of the thread is already printed.
        let _ended = self.thread.take().map(JoinHandle::join);
    }
}

fn field(bus: &FreshBus, arguments: &str) -> Process {
    let words = ["field", "--bus", bus.as_str()].into_iter();
    Process::start(
        "atas-sim",
        &words.chain(arguments.split(' ')).collect::<Vec<_>>(),
    )
}

fn agents(bus: &FreshBus) -> Process {
    let words = ["agents", "--bus", bus.as_str(), "--table", "r3-two-agents"];
    Process::start("ebts", &words)
}

/// Expression for all texts of one frame on the page.
const SHOWN_TEXTS: &str = "({ \
    of: ['trial', 'frame', 'goal', 'phase', 'distance', 'e1'].map(what => document.getElementById(`arena-${what}`).textContent), \
    robots: [...document.getElementById('arena-robots').rows].map(row => [...row.cells].map(cell => cell.textContent)) })";

/// Compares one frame of the page with the bus; returns trial and frame.
fn compare(browser: &mut Browser, frames: &Frames) -> Option<(u64, u64)> {
    let shown = browser.value(SHOWN_TEXTS);
    let text = |what: usize| shown["of"][what].as_str().unwrap_or_default().to_owned();
    let count = |what: usize| text(what).split(' ').next()?.parse::<u64>().ok();
    let (trial, frame) = (count(0)? - 1, count(1)?);
    let arena = frames.frame(trial, frame)?;
    let phase = match frame {
        0..180 => "execution",
        180..270 => "evaluation",
        _ => "over",
    };
    assert_eq!((count(2), &*text(3)), (Some(arena.goal.into()), phase));
    let near = |printed: &str, value: f32| {
        let printed = printed
            .trim_end_matches(" px")
            .parse::<f32>()
            .expect("a number");
        assert!(
            (printed - value).abs() <= 0.0501,
            "frame {frame}: page shows {printed}, bus has {value}, in {shown}"
        );
    };
    near(&text(4), arena.fields[0].distance_px);
    near(&text(5), arena.fields[0].e1_points);
    let robots = shown["robots"].as_array().expect("rows");
    assert_eq!(robots.len(), arena.agent_count as usize);
    for (cells, agent) in robots.iter().zip(&arena.agents) {
        let cell = |index: usize| cells[index].as_str().expect("a text");
        near(cell(1), agent.position_px[0]);
        near(cell(2), agent.position_px[1]);
        near(cell(3), agent.heading_steps as f32 * 5.625);
        let senses = (0..5).filter(|bit| agent.row >> bit & 1 == 1);
        let senses: Vec<String> = senses.map(|bit| format!("S{}", bit + 1)).collect();
        let expected = if senses.is_empty() {
            "nothing".to_owned()
        } else {
            senses.join(" ")
        };
        assert_eq!(cell(4), expected, "frame {frame}");
        assert_eq!(cell(5), agent.row.to_string());
        let level = |bits: u32| (bits & 0b11).count_ones();
        let expected = format!("{} {}", level(agent.output), level(agent.output >> 2));
        assert_eq!(cell(6), expected, "frame {frame}: wheels");
        assert_eq!(cell(7), if agent.touches != 0 { "yes" } else { "" });
    }
    Some((trial, frame))
}

#[test]
fn page_shows_arena_of_the_bus() {
    let Some((program, axe)) = browser_and_axe() else {
        return;
    };
    let _alone = lock_exclusive();
    let bus = FreshBus::new("arena");
    let frames = Frames::new(&bus);
    let server = serve(&["--bus", bus.as_str()]);
    let mut browser = Browser::open(&program, &address(&server).0);
    browser.wait_contains("mode", "no daemon");
    let hidden = browser.value("document.getElementById('arena').hidden");
    assert_eq!(
        hidden,
        Value::Bool(true),
        "the arena is hidden without a swarm"
    );

    let mut host = field(&bus, "--frame-rate-hz 60 --goal 3 --trials 2");
    browser.wait_contains("mode", "swarm");
    browser.wait_contains("goal", "waits for `ebts agents`");
    assert!(
        compare(&mut browser, &frames).is_some(),
        "a waiting field is shown"
    );

    let driving = agents(&bus);
    let mut compared = std::collections::BTreeSet::new();
    wait_for("frames on the page", || {
        compared.insert(compare(&mut browser, &frames)?);
        (compared.len() >= FRAMES_COMPARED).then_some(())
    });
    check_themes(&mut browser, &axe);
    assert!(host.wait().success(), "{}", host.log());
    browser.wait_contains("goal", "was closed after goal 3, trial 2 of 2");
    let trials =
        "[...document.getElementById('arena-trials').rows].map(row => row.cells[0].textContent)";
    assert_eq!(browser.value(trials), serde_json::json!(["3", "3"]));
    assert_eq!(
        compare(&mut browser, &frames),
        Some((1, 270)),
        "the last frame remains"
    );

    // A second field on the same bus, with other parameters, replaces the first on the page.
    drop((driving, host));
    let _next = field(&bus, "--frame-rate-hz 60 --preset LB3 --agents 3 --goal 1");
    browser.wait_contains("arena-preset", "field LB3");
    assert_eq!(browser.value(trials), serde_json::json!([]));
    assert_eq!(browser.page_errors(), &[] as &[String]);
}

/// Checks both themes: they differ, the field is drawn, and axe-core has no serious finding.
fn check_themes(browser: &mut Browser, axe: &str) {
    let mut drawn = Vec::new();
    for theme in ["light", "dark"] {
        browser.theme(theme);
        browser.value("new Promise(done => setTimeout(done, 400))");
        save_screenshot(&format!("arena-{theme}"), &browser.screenshot());
        drawn.push(browser.value("document.getElementById('arena-fields').toDataURL()"));
        assert_accessible(browser, axe, theme);
    }
    assert_ne!(drawn[0], drawn[1]);
    let outside = browser.value(
        "[...document.querySelectorAll('main > section')].filter(s => s.id !== 'arena' && s.offsetParent !== null).length",
    );
    assert_eq!(outside, Value::from(0), "no robot panels without a robot");
}
