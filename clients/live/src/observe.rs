//! Observing thread: polls the bus at 60 Hz and sends messages to the pages.
//!
//! A missing, ended or restarted daemon is a displayed state, not an error.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use atas_client::histogram::EDGES_NS;
use atas_client::{ClientError, Session, Watch, json, standstill, words};
use robot_model::RobotFiles;
use serde_json::{Value, json};
use shm_bus::{BusName, now_ns};
use shm_schemas::capacity::HANDS;
use shm_schemas::{EventKind, ModuleEvent, TickReport};

use crate::arena::Arena;
use crate::feed::Feed;
use crate::picture::Picture;
use crate::rounds::rounds;
use crate::scene::scene;
use crate::shown::Showing;

/// Pictures per status: five statuses per second are readable.
const STATUS_EVERY: u64 = 12;

/// Polls the bus until `stop` is set. `selected` is the user's robot.
pub(crate) fn observe(
    bus: &BusName,
    feed: &Arc<Feed>,
    told: Option<&RobotFiles>,
    stop: &AtomicBool,
) {
    rounds(
        bus,
        stop,
        |watch, session| Observer::new(watch, session, told),
        |observer, session| observer.look(session, feed),
        |error: &ClientError| gone(feed, &error.to_string()),
    );
}

fn gone(feed: &Feed, why: &str) {
    let told = json!({ "alive": false, "why": why });
    feed.tell("status", &told);
    let mut past = feed.past();
    past.status = told;
}

struct Observer<'a> {
    watch: Watch,
    showing: Showing<'a>,
    arena: Arena,
    looks: u64,
    pid: u32,
    has_report: bool,
    begun: u64,
    /// Layout hash and number of elements of each hand's frames.
    layouts: [(u64, usize); HANDS],
}

impl<'a> Observer<'a> {
    fn new(
        watch: Watch,
        session: &Session,
        told: Option<&'a RobotFiles>,
    ) -> Result<Self, ClientError> {
        Ok(Self {
            watch,
            showing: Showing::new(told),
            arena: Arena::join(session)?,
            looks: 0,
            pid: 0,
            has_report: false,
            begun: 0,
            layouts: [(0, 0); HANDS],
        })
    }

    fn look(&mut self, session: &Session, feed: &Feed) -> Result<(), ClientError> {
        let (mut reports, mut events) = (Vec::new(), Vec::new());
        self.watch
            .look(|report| reports.push(*report), |event| events.push(*event))?;
        if self.pid != self.watch.status.pid {
            self.pid = self.watch.status.pid;
            feed.past().forget();
        }
        let is_other = self.tell_scene(session, feed)?;
        self.tell_events(feed, &reports, &events);
        // A new page, or one with a new robot, needs a picture even if time stands still.
        let before = std::mem::replace(&mut self.begun, feed.begun());
        let anew = before != self.begun || is_other;
        self.tell_picture(feed, !reports.is_empty(), anew);
        self.arena.look(session, feed, anew)?;
        if self.looks.is_multiple_of(STATUS_EVERY) {
            let status = self.status();
            feed.tell("status", &status);
            feed.past().status = status;
        }
        self.looks += 1;
        Ok(())
    }

    /// Sends the scene if the robot has become known or has changed; returns true in that case.
    fn tell_scene(&mut self, session: &Session, feed: &Feed) -> Result<bool, ClientError> {
        let is_news = self.showing.look(session.bus(), &self.watch.status)?;
        let Some(shown) = self.showing.shown().filter(|_| is_news) else {
            return Ok(false);
        };
        match scene(shown) {
            Ok(scene) => {
                feed.past().scene = scene.clone();
                feed.tell("scene", &scene);
            }
            Err(error) => tracing::warn!("could not draw the robot: {error}"),
        }
        self.layouts = [(0, 0); HANDS];
        Ok(true)
    }

    fn tell_picture(&mut self, feed: &Feed, is_new: bool, anew: bool) {
        if is_new {
            self.has_report = true;
            feed.past().note(&self.watch.report);
        }
        if !self.has_report || !(is_new || anew) || feed.pages() == 0 {
            return;
        }
        // The number of fingertips is unknown before.
        let Some(shown) = self.showing.shown() else {
            return;
        };
        for (hand, known) in self.layouts.iter_mut().enumerate() {
            let hash = self.watch.view.frames[hand].layout_hash;
            if known.0 != hash {
                let layout = shown.layout(hand, hash);
                *known = (hash, layout.map_or(0, |layout| layout.count));
            }
        }
        let view = &self.watch.view;
        let frame = |hand: usize| (view.has_frame[hand] != 0).then_some(&view.frames[hand]);
        let joints = (view.has_joints != 0).then_some(&view.joints);
        let counts = self.layouts.map(|(_, count)| count);
        let picture = Picture::of(
            &self.watch.report,
            std::array::from_fn(frame),
            joints,
            shown.fingers,
            counts,
        );
        feed.tell("picture", &picture);
    }

    fn tell_events(&self, feed: &Feed, reports: &[TickReport], events: &[ModuleEvent]) {
        let fingers = self.showing.shown().map(|shown| shown.fingers);
        let fingers = fingers.unwrap_or_default();
        let mut past = feed.past();
        reports.iter().for_each(|report| past.faults.note(report));
        let mut told = Vec::new();
        let mut has_fault = false;
        for event in events {
            let value = described(event, past.faults.report_of(event.tick), fingers);
            past.happened(value.clone());
            told.push(value);
            has_fault |= past.faults.watch(event);
        }
        let faults = has_fault.then(|| past.faults.list());
        drop(past);
        if !told.is_empty() {
            feed.tell("events", &told);
        }
        if let Some(faults) = faults {
            feed.tell("faults", &faults);
        }
    }

    fn status(&self) -> Value {
        if !self.watch.is_alive() {
            return json!({
                "alive": false,
                "why": "the daemon does not report; it ended or hangs",
            });
        }
        let mut value = json::status(&self.watch.status, json::ROOM);
        value["alive"] = true.into();
        let frozen = standstill(&self.watch.status, now_ns());
        value["standstill_s"] = frozen.map(|frozen| frozen.as_secs_f64()).into();
        value["histogram"] = json!({
            "edges_us": EDGES_NS.map(|ns| ns as f64 * 1e-3),
            "wake": self.watch.wake.counts(),
            "body": self.watch.body.counts(),
        });
        value
    }
}

/// Formats an event with its text and, for module switches, the percept of that tick.
pub(crate) fn described(
    event: &ModuleEvent,
    at: Option<&TickReport>,
    fingers: [usize; HANDS],
) -> Value {
    let mut value = json::event(event);
    value["t_s"] = (event.stamp.captured_ns as f64 * 1e-9).into();
    value["sentence"] = words::event(event).trim().into();
    let is_switch = matches!(event.kind, EventKind::MODULE_ON | EventKind::MODULE_OFF);
    if is_switch && let (Some(at), Some(hand)) = (at, event.hand.index()) {
        value["module_id"] = event.module.0.into();
        value["evidence"] = words::evidence(event.module, &at.hands[hand], fingers[hand]).into();
    }
    value
}
