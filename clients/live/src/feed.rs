//! Distribution of messages from the observing thread to all open pages, and the history for new
//! pages.

use std::collections::VecDeque;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};

use axum::extract::ws::Utf8Bytes;
use serde_json::{Value, json};
use shm_schemas::TickReport;
use shm_schemas::capacity::{FINGERS, HANDS};
use tokio::sync::broadcast;

use crate::faults::Faults;

/// Messages queued per page; a page that lags further starts over (design choice: 3 s).
const QUEUE_LENGTH: usize = 256;
/// Points of the traces in the history: 30 s at 60 Hz.
const MOMENTS: usize = 1800;
const EVENTS: usize = 500;

#[derive(Debug)]
pub(crate) struct Feed {
    messages: broadcast::Sender<Utf8Bytes>,
    history: Mutex<History>,
    opened_pages: AtomicU64,
}

/// History for a new page.
#[derive(Debug, Default)]
pub(crate) struct History {
    moments: VecDeque<Moment>,
    events: VecDeque<Value>,
    pub(crate) scene: Value,
    /// Newest status and histograms, or the reason why there are none.
    pub(crate) status: Value,
    pub(crate) faults: Faults,
}

/// Point of the traces: time, then per hand the thresholds, the active modules, F_n and F_t of each
/// possible fingertip.
type Moment = [f64; 1 + HANDS * PER_HAND];
const PER_HAND: usize = 3 + 2 * FINGERS;

impl Default for Feed {
    fn default() -> Self {
        Self {
            messages: broadcast::Sender::new(QUEUE_LENGTH),
            history: Mutex::default(),
            opened_pages: AtomicU64::new(0),
        }
    }
}

impl Feed {
    pub(crate) fn send(&self, kind: &str, value: &impl serde::Serialize) {
        // Serialisation does not fail for the types used here.
        if self.pages() > 0
            && let Ok(text) = serde_json::to_string(value)
        {
            let _ = self.messages.send(format!("{{\"{kind}\":{text}}}").into());
        }
    }

    pub(crate) fn pages(&self) -> usize {
        self.messages.receiver_count()
    }

    /// Returns the number of pages opened so far; an increase means that a new page needs a
    /// picture.
    pub(crate) fn opened_pages(&self) -> u64 {
        self.opened_pages.load(Ordering::Relaxed)
    }

    pub(crate) fn history(&self) -> MutexGuard<'_, History> {
        self.history.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Subscribes a page; the first message is the history.
    pub(crate) fn subscribe(&self) -> (Utf8Bytes, broadcast::Receiver<Utf8Bytes>) {
        // Under the lock, so that no message is lost between history and first message.
        let past = self.history();
        let receiver = self.messages.subscribe();
        self.opened_pages.fetch_add(1, Ordering::Relaxed);
        (past.to_json().to_string().into(), receiver)
    }
}

impl History {
    pub(crate) fn add_moment(&mut self, report: &TickReport) {
        if self.moments.len() == MOMENTS {
            self.moments.pop_front();
        }
        self.moments.push_back(moment(report));
    }

    pub(crate) fn add_event(&mut self, event: Value) {
        if self.events.len() == EVENTS {
            self.events.pop_front();
        }
        self.events.push_back(event);
    }

    /// Clears the traces of a daemon that has ended; the next one may have another clock.
    pub(crate) fn clear_moments(&mut self) {
        self.moments.clear();
    }

    fn to_json(&self) -> Value {
        json!({
            "past": {
                "scene": self.scene,
                "moments": self.moments.iter().map(|m| &m[..]).collect::<Vec<_>>(),
                "events": self.events,
                "status": self.status,
                "faults": self.faults.list(),
            }
        })
    }
}

pub(crate) fn moment(report: &TickReport) -> Moment {
    let mut moment = [0.0; 1 + HANDS * PER_HAND];
    moment[0] = report.stamp.captured_ns as f64 * 1e-9;
    for (hand, out) in report
        .hands
        .iter()
        .zip(moment[1..].chunks_exact_mut(PER_HAND))
    {
        out[0] = rounded(hand.f1_n);
        out[1] = rounded(hand.f2_n);
        out[2] = hand.modules_active.into();
        for (finger, out) in hand.fingers.iter().zip(out[3..].chunks_exact_mut(2)) {
            out.copy_from_slice(&[rounded(finger.normal_n), rounded(finger.tangential_n)]);
        }
    }
    moment
}

fn rounded(value: f32) -> f64 {
    (f64::from(value) * 1e4).round() / 1e4
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn new_page_receives_history_and_next_message() {
        let feed = Feed::default();
        feed.send("picture", &1);
        let mut report = TickReport::default();
        report.hands[1].fingers[0].normal_n = 1.5;
        for _ in 0..MOMENTS + 5 {
            feed.history().add_moment(&report);
        }
        feed.history().add_event(json!("a"));
        assert_eq!(feed.opened_pages(), 0);
        let (past, mut receiver) = feed.subscribe();
        assert_eq!(feed.opened_pages(), 1);
        feed.send("picture", &2);
        let past: Value = serde_json::from_str(&past).expect("JSON");
        let moments = past["past"]["moments"].as_array().expect("moments");
        assert_eq!(
            (moments.len(), &past["past"]["events"]),
            (MOMENTS, &json!(["a"]))
        );
        assert_eq!(moments[0][1 + PER_HAND + 3], 1.5);
        assert_eq!(
            receiver.try_recv().expect("a message").as_str(),
            "{\"picture\":2}"
        );
    }
}
