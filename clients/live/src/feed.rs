//! From the observing thread to every open page: messages as they come, and what a page that opens later must know.

use std::collections::VecDeque;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};

use axum::extract::ws::Utf8Bytes;
use serde_json::{Value, json};
use shm_schemas::TickReport;
use shm_schemas::capacity::{FINGERS, HANDS};
use tokio::sync::broadcast;

use crate::faults::Faults;

/// Messages that may wait for a page; one that falls further behind begins anew. Ours: three seconds.
const WAITING: usize = 256;
/// Moments of the traces that a page begins with: 30 s of 60 pictures a second.
const MOMENTS: usize = 1800;
/// Events that a page begins with.
const EVENTS: usize = 500;

/// What the pages share.
#[derive(Debug)]
pub(crate) struct Feed {
    messages: broadcast::Sender<Utf8Bytes>,
    past: Mutex<Past>,
    /// Pages that have begun, ever.
    begun: AtomicU64,
}

/// What a page that opens must know.
#[derive(Debug, Default)]
pub(crate) struct Past {
    moments: VecDeque<Moment>,
    events: VecDeque<Value>,
    /// The robot that is shown.
    pub(crate) scene: Value,
    /// Newest status and histograms; what is wrong where there is none.
    pub(crate) status: Value,
    /// Faults and the ticks before them.
    pub(crate) faults: Faults,
}

/// One moment of the traces: time, then per hand the thresholds, the modules, F_n and F_t of each finger that there could be.
type Moment = [f64; 1 + HANDS * PER_HAND];
const PER_HAND: usize = 3 + 2 * FINGERS;

impl Default for Feed {
    fn default() -> Self {
        Self {
            messages: broadcast::Sender::new(WAITING),
            past: Mutex::default(),
            begun: AtomicU64::new(0),
        }
    }
}

impl Feed {
    /// Sends a message of one kind to every page.
    pub(crate) fn tell(&self, kind: &str, value: &impl serde::Serialize) {
        // Nobody listens, or the value has no JSON form, which none of ours lacks.
        if self.pages() > 0
            && let Ok(text) = serde_json::to_string(value)
        {
            let _ = self.messages.send(format!("{{\"{kind}\":{text}}}").into());
        }
    }

    /// Pages that listen.
    pub(crate) fn pages(&self) -> usize {
        self.messages.receiver_count()
    }

    /// Pages that have begun, ever: more than before means that one has seen no picture yet.
    pub(crate) fn begun(&self) -> u64 {
        self.begun.load(Ordering::Relaxed)
    }

    /// What a page that opens must know.
    pub(crate) fn past(&self) -> MutexGuard<'_, Past> {
        self.past.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Begins to listen; the first message tells the past.
    pub(crate) fn listen(&self) -> (Utf8Bytes, broadcast::Receiver<Utf8Bytes>) {
        // Under the lock, so that nothing falls between the past and the first message.
        let past = self.past();
        let receiver = self.messages.subscribe();
        self.begun.fetch_add(1, Ordering::Relaxed);
        (past.told().to_string().into(), receiver)
    }
}

impl Past {
    /// Remembers a moment.
    pub(crate) fn note(&mut self, report: &TickReport) {
        if self.moments.len() == MOMENTS {
            self.moments.pop_front();
        }
        self.moments.push_back(moment(report));
    }

    /// Remembers an event.
    pub(crate) fn happened(&mut self, event: Value) {
        if self.events.len() == EVENTS {
            self.events.pop_front();
        }
        self.events.push_back(event);
    }

    /// Forgets a daemon that is gone: its successor's clock and sequence may be others.
    pub(crate) fn forget(&mut self) {
        self.moments.clear();
    }

    fn told(&self) -> Value {
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

/// The moment of a report.
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
    fn a_page_that_opens_later_is_told_the_past_and_misses_nothing() {
        let feed = Feed::default();
        feed.tell("picture", &1);
        let mut report = TickReport::default();
        report.hands[1].fingers[0].normal_n = 1.5;
        for _ in 0..MOMENTS + 5 {
            feed.past().note(&report);
        }
        feed.past().happened(json!("a"));
        assert_eq!(feed.begun(), 0);
        let (past, mut receiver) = feed.listen();
        assert_eq!(feed.begun(), 1);
        feed.tell("picture", &2);
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
