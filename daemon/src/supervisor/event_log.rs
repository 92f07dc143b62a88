//! Log lines for modes, goals and warnings; never one per tick.

use std::collections::HashMap;
use std::time::{Duration, Instant};

use robot_model::{Joint, RobotModel};
use shm_schemas::{Cause, EventKind, GoalState, Hand, JointLabel, Mode, ModuleEvent, Reason};

use crate::link::TickRecord;

/// Minimum time between two lines with the same topic.
const REPEAT_INTERVAL: Duration = Duration::from_secs(1);

#[derive(Debug, Default)]
pub(super) struct EventLog {
    repeated: HashMap<Topic, Repeated>,
    bus_failures: u64,
    missed: u64,
    dropped: u64,
}

/// Topic of a line; each hand has its own.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
enum Topic {
    Hand(Hand, Cause),
    Missed,
    Bus,
    Dropped,
}

#[derive(Debug)]
struct Repeated {
    since: Instant,
    suppressed: u64,
}

impl EventLog {
    pub(super) fn write_event(&mut self, event: &ModuleEvent, robot: &RobotModel) {
        let tick = event.tick;
        let given = Reason::from(event.reason);
        let joint = given.joint().and_then(|index| robot.joint(index));
        let reason = event.reason.text(joint.map(label));
        match event.kind {
            EventKind::MODE if event.mode == Mode::FAULT => {
                let panic = crate::panics::take_message().unwrap_or_default();
                tracing::error!(tick, mode = %event.mode, panic, "{reason}");
            }
            EventKind::MODE if given == Reason::Shutdown => {
                tracing::info!(tick, mode = %event.mode, "{reason}");
            }
            EventKind::MODE if matches!(event.mode, Mode::HOLD | Mode::SAFE_STOP) => {
                tracing::warn!(tick, mode = %event.mode, "{reason}");
            }
            EventKind::MODE => tracing::info!(tick, mode = %event.mode, "mode"),
            EventKind::GOAL => {
                let state = GoalState(event.value as u32);
                if given.is_some() {
                    tracing::info!(tick, hand = %event.hand, "goal {state}: {reason}");
                } else {
                    tracing::info!(tick, hand = %event.hand, "goal {state}");
                }
            }
            EventKind::WARNING => {
                let topic = Topic::Hand(event.hand, event.reason.cause);
                if let Some(suppressed) = self.take_suppressed(topic) {
                    tracing::warn!(tick, suppressed, "{reason}");
                }
            }
            _ => {
                tracing::debug!(tick, kind = %event.kind, module = %event.module, text = %event.text, "event")
            }
        }
    }

    pub(super) fn check_record(&mut self, record: &TickRecord) {
        let missed = record.report.missed_ticks;
        if missed > self.missed
            && let Some(suppressed) = self.take_suppressed(Topic::Missed)
        {
            tracing::warn!(
                tick = record.report.tick,
                missed,
                suppressed,
                "ticks missed so far"
            );
        }
        self.missed = missed;
        if record.bus_failures > self.bus_failures
            && let Some(suppressed) = self.take_suppressed(Topic::Bus)
        {
            tracing::error!(
                failures = record.bus_failures,
                suppressed,
                "bus calls of the tick failed"
            );
        }
        self.bus_failures = record.bus_failures;
    }

    pub(super) fn check_dropped(&mut self, dropped: u64) {
        if dropped > self.dropped
            && let Some(suppressed) = self.take_suppressed(Topic::Dropped)
        {
            tracing::warn!(
                dropped,
                suppressed,
                "records dropped: the supervisor is too slow"
            );
        }
        self.dropped = dropped;
    }

    /// Number of suppressed lines with this topic, if another line is due.
    fn take_suppressed(&mut self, about: Topic) -> Option<u64> {
        let now = Instant::now();
        match self.repeated.get_mut(&about) {
            Some(repeated) if now.duration_since(repeated.since) < REPEAT_INTERVAL => {
                repeated.suppressed += 1;
                None
            }
            _ => {
                let fresh = Repeated {
                    since: now,
                    suppressed: 0,
                };
                Some(
                    self.repeated
                        .insert(about, fresh)
                        .map_or(0, |old| old.suppressed),
                )
            }
        }
    }
}

fn label(joint: &Joint) -> JointLabel<'_> {
    JointLabel {
        name: joint.name.as_str(),
        unit: joint.unit(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn repetitions_are_counted_not_logged() {
        let mut event_log = EventLog::default();
        let held = |hand| Topic::Hand(hand, Cause::GRIP_FOUND);
        assert_eq!(event_log.take_suppressed(held(Hand::LEFT)), Some(0));
        assert_eq!(event_log.take_suppressed(held(Hand::LEFT)), None);
        assert_eq!(event_log.take_suppressed(Topic::Missed), Some(0));
        // A restart with an object in each hand logs both.
        assert_eq!(event_log.take_suppressed(held(Hand::RIGHT)), Some(0));
    }
}
