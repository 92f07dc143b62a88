//! Observing thread: polls the bus at 60 Hz and sends messages to the pages.
//!
//! A missing, ended or restarted daemon is a displayed state, not an error.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use atas_client::histogram::EDGES_NS;
use atas_client::{ClientError, Observer, Session, json, standstill, text};
use robot_model::RobotFiles;
use serde_json::{Value, json};
use shm_bus::{BusName, now_ns};
use shm_schemas::capacity::HANDS;
use shm_schemas::{EventKind, ModuleEvent, TickReport};

use crate::arena::Arena;
use crate::displayed::RobotDisplay;
use crate::feed::Feed;
use crate::picture::Picture;
use crate::polling::poll_bus;
use crate::scene::scene;

/// Pictures per status: five statuses per second are readable.
const STATUS_EVERY: u64 = 12;

/// Polls the bus until `stop` is set. `selected` is the user's robot.
pub(crate) fn observe(
    bus: &BusName,
    feed: &Arc<Feed>,
    selected: Option<&RobotFiles>,
    stop: &AtomicBool,
) {
    poll_bus(
        bus,
        stop,
        |observer, session| BusPoller::new(observer, session, selected),
        |poller, session| poller.poll(session, feed),
        |error: &ClientError| report_lost_bus(feed, &error.to_string()),
    );
}

fn report_lost_bus(feed: &Feed, why: &str) {
    let selected = json!({ "alive": false, "why": why });
    feed.send("status", &selected);
    let mut past = feed.history();
    past.status = selected;
}

struct BusPoller<'a> {
    observer: Observer,
    showing: RobotDisplay<'a>,
    arena: Arena,
    polls: u64,
    pid: u32,
    has_report: bool,
    opened_pages: u64,
    /// Layout hash and number of elements of each hand's frames.
    layouts: [(u64, usize); HANDS],
}

impl<'a> BusPoller<'a> {
    fn new(
        observer: Observer,
        session: &Session,
        selected: Option<&'a RobotFiles>,
    ) -> Result<Self, ClientError> {
        Ok(Self {
            observer,
            showing: RobotDisplay::new(selected),
            arena: Arena::join(session)?,
            polls: 0,
            pid: 0,
            has_report: false,
            opened_pages: 0,
            layouts: [(0, 0); HANDS],
        })
    }

    fn poll(&mut self, session: &Session, feed: &Feed) -> Result<(), ClientError> {
        let (mut reports, mut events) = (Vec::new(), Vec::new());
        self.observer
            .poll(|report| reports.push(*report), |event| events.push(*event))?;
        if self.pid != self.observer.status.pid {
            self.pid = self.observer.status.pid;
            feed.history().clear_moments();
        }
        let is_other = self.send_scene(session, feed)?;
        self.send_events(feed, &reports, &events);
        // A new page, or one with a new robot, needs a picture even if time stands still.
        let before = std::mem::replace(&mut self.opened_pages, feed.opened_pages());
        let has_new_page = before != self.opened_pages || is_other;
        self.send_picture(feed, !reports.is_empty(), has_new_page);
        self.arena.poll(session, feed, has_new_page)?;
        if self.polls.is_multiple_of(STATUS_EVERY) {
            let status = self.status();
            feed.send("status", &status);
            feed.history().status = status;
        }
        self.polls += 1;
        Ok(())
    }

    /// Sends the scene if the robot has become known or has changed; returns true in that case.
    fn send_scene(&mut self, session: &Session, feed: &Feed) -> Result<bool, ClientError> {
        let is_news = self.showing.update(session.bus(), &self.observer.status)?;
        let Some(shown) = self.showing.shown().filter(|_| is_news) else {
            return Ok(false);
        };
        match scene(shown) {
            Ok(scene) => {
                feed.history().scene = scene.clone();
                feed.send("scene", &scene);
            }
            Err(error) => tracing::warn!("could not draw the robot: {error}"),
        }
        self.layouts = [(0, 0); HANDS];
        Ok(true)
    }

    fn send_picture(&mut self, feed: &Feed, is_new: bool, has_new_page: bool) {
        if is_new {
            self.has_report = true;
            feed.history().add_moment(&self.observer.report);
        }
        if !self.has_report || !(is_new || has_new_page) || feed.pages() == 0 {
            return;
        }
        // The number of fingertips is unknown before.
        let Some(shown) = self.showing.shown() else {
            return;
        };
        for (hand, known) in self.layouts.iter_mut().enumerate() {
            let hash = self.observer.view.frames[hand].layout_hash;
            if known.0 != hash {
                let layout = shown.layout(hand, hash);
                *known = (hash, layout.map_or(0, |layout| layout.count));
            }
        }
        let view = &self.observer.view;
        let frame = |hand: usize| (view.has_frame[hand] != 0).then_some(&view.frames[hand]);
        let joints = (view.has_joints != 0).then_some(&view.joints);
        let counts = self.layouts.map(|(_, count)| count);
        let picture = Picture::from_report(
            &self.observer.report,
            std::array::from_fn(frame),
            joints,
            shown.fingers,
            counts,
        );
        feed.send("picture", &picture);
    }

    fn send_events(&self, feed: &Feed, reports: &[TickReport], events: &[ModuleEvent]) {
        let fingers = self.showing.shown().map(|shown| shown.fingers);
        let fingers = fingers.unwrap_or_default();
        let mut past = feed.history();
        reports
            .iter()
            .for_each(|report| past.faults.store_report(report));
        let mut selected = Vec::new();
        let mut has_fault = false;
        for event in events {
            let value = event_json(event, past.faults.report_of(event.tick), fingers);
            past.add_event(value.clone());
            selected.push(value);
            has_fault |= past.faults.process_event(event);
        }
        let faults = has_fault.then(|| past.faults.list());
        drop(past);
        if !selected.is_empty() {
            feed.send("events", &selected);
        }
        if let Some(faults) = faults {
            feed.send("faults", &faults);
        }
    }

    fn status(&self) -> Value {
        if !self.observer.is_alive() {
            return json!({
                "alive": false,
                "why": "no reports from the daemon; it has ended or hangs",
            });
        }
        let mut value = json::status(&self.observer.status, json::CAPACITY);
        value["alive"] = true.into();
        let frozen = standstill(&self.observer.status, now_ns());
        value["standstill_s"] = frozen.map(|frozen| frozen.as_secs_f64()).into();
        value["histogram"] = json!({
            "edges_us": EDGES_NS.map(|ns| ns as f64 * 1e-3),
            "wake": self.observer.wake.counts(),
            "body": self.observer.body.counts(),
        });
        value
    }
}

/// Formats an event with its text and, for module switches, the percept of that tick.
pub(crate) fn event_json(
    event: &ModuleEvent,
    at: Option<&TickReport>,
    fingers: [usize; HANDS],
) -> Value {
    let mut value = json::event(event);
    value["t_s"] = (event.stamp.captured_ns as f64 * 1e-9).into();
    value["sentence"] = text::event(event).trim().into();
    let is_switch = matches!(event.kind, EventKind::MODULE_ON | EventKind::MODULE_OFF);
    if is_switch && let (Some(at), Some(hand)) = (at, event.hand.index()) {
        value["module_id"] = event.module.0.into();
        value["evidence"] = text::evidence(event.module, &at.hands[hand], fingers[hand]).into();
    }
    value
}
