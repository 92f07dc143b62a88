//! Faults with their flight recorder: reason of a hold or stop, and the ticks before it.

use std::collections::VecDeque;

use atas_client::{body_ns, text};
use serde_json::{Value, json};
use shm_schemas::capacity::FINGERS;
use shm_schemas::{EventKind, Mode, ModuleEvent, TickReport};

/// Stored ticks before a fault, equal to the daemon's flight recorder.
const TICKS: usize = 256;
const FAULTS: usize = 32;

#[derive(Debug, Default)]
pub(crate) struct Faults {
    reports: VecDeque<TickReport>,
    faults: VecDeque<Fault>,
    count: u64,
}

#[derive(Debug)]
struct Fault {
    number: u64,
    event: ModuleEvent,
    reports: Vec<TickReport>,
}

impl Faults {
    pub(crate) fn store_report(&mut self, report: &TickReport) {
        if self.reports.len() == TICKS {
            self.reports.pop_front();
        }
        self.reports.push_back(*report);
    }

    pub(crate) fn report_of(&self, tick: u64) -> Option<&TickReport> {
        self.reports.iter().rev().find(|report| report.tick == tick)
    }

    /// Stores the preceding ticks if this event is a fault; returns true in that case.
    pub(crate) fn process_event(&mut self, event: &ModuleEvent) -> bool {
        if !is_fault(event) {
            return false;
        }
        if self.faults.len() == FAULTS {
            self.faults.pop_front();
        }
        self.count += 1;
        let before = self.reports.iter().filter(|r| r.tick <= event.tick);
        self.faults.push_back(Fault {
            number: self.count,
            event: *event,
            reports: before.copied().collect(),
        });
        true
    }

    pub(crate) fn list(&self) -> Value {
        let listed = self.faults.iter().rev().map(|fault| {
            json!({
                "number": fault.number,
                "tick": fault.event.tick,
                "t_s": fault.event.stamp.captured_ns as f64 * 1e-9,
                "mode": fault.event.mode.name(),
                "sentence": text::event(&fault.event).trim(),
                "ticks": fault.reports.len(),
            })
        });
        listed.collect()
    }

    /// Returns the ticks before a fault as columns; `None` if the fault is no longer stored.
    pub(crate) fn flight(&self, number: u64) -> Option<Value> {
        let fault = self.faults.iter().find(|fault| fault.number == number)?;
        let column = |value: &dyn Fn(&TickReport) -> f64| -> Vec<f64> {
            fault.reports.iter().map(value).collect()
        };
        let end_ns = fault.event.stamp.captured_ns as f64;
        let hands = (0..2).map(|hand| {
            let fingers = (0..FINGERS)
                .map(|finger| column(&|r| f64::from(r.hands[hand].fingers[finger].normal_n)));
            json!({
                "normal_n": fingers.collect::<Vec<_>>(),
                "f1_n": column(&|r| f64::from(r.hands[hand].f1_n)),
                "f2_n": column(&|r| f64::from(r.hands[hand].f2_n)),
                "age_ms": column(&|r| r.hands[hand].frame_age_ns as f64 * 1e-6),
            })
        });
        Some(json!({
            "sentence": text::event(&fault.event).trim(),
            "before_ms": column(&|r| (r.stamp.captured_ns as f64 - end_ns) * 1e-6),
            "late_us": column(&|r| f64::from(r.wake_late_ns) * 1e-3),
            "body_us": column(&|r| body_ns(r) as f64 * 1e-3),
            "hands": hands.collect::<Vec<_>>(),
        }))
    }
}

fn is_fault(event: &ModuleEvent) -> bool {
    event.kind == EventKind::MODE
        && matches!(event.mode, Mode::HOLD | Mode::SAFE_STOP | Mode::FAULT)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fault_stores_previous_ticks_and_oldest_is_dropped() {
        let mut faults = Faults::default();
        for tick in 0..1000 {
            faults.store_report(&TickReport {
                tick,
                ..TickReport::default()
            });
        }
        let fault = |tick, mode| ModuleEvent {
            tick,
            mode,
            kind: EventKind::MODE,
            ..ModuleEvent::default()
        };
        assert!(!faults.process_event(&fault(900, Mode::RUN)));
        assert!(faults.process_event(&fault(900, Mode::HOLD)));
        let flight = faults.flight(1).expect("stored");
        let ticks = flight["before_ms"].as_array().expect("a column").len();
        assert_eq!(ticks, 900 - (1000 - TICKS) + 1);
        for _ in 0..FAULTS {
            faults.process_event(&fault(999, Mode::SAFE_STOP));
        }
        assert!(faults.flight(1).is_none());
        let listed = faults.list();
        assert_eq!(listed.as_array().map(Vec::len), Some(FAULTS));
        assert_eq!(listed[0]["number"], FAULTS as u64 + 1);
    }
}
