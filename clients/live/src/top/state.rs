//! State of the screen: newest data, and recent modules and events.

use std::collections::VecDeque;
use std::time::{Duration, Instant};

use atas_client::{Observer, Run, Session, text};
use shm_bus::BusError;
use shm_schemas::capacity::HANDS;
use shm_schemas::{EventKind, Mode, ModuleEvent, ModuleId, Status};

/// Duration of one column of a module lane. Design choice: 40 columns show 20 s.
const COLUMN: Duration = Duration::from_millis(500);
const COLUMNS: usize = 240;
const EVENTS: usize = 100;
/// Averaging time of the rates.
const RATE_WINDOW: Duration = Duration::from_secs(1);

pub(super) struct ScreenState {
    pub(super) watch: Observer,
    pub(super) run: Run,
    pub(super) bus: String,
    /// Active modules per hand and column, newest last.
    pub(super) lanes: [VecDeque<u32>; HANDS],
    /// Time, s, text and fault flag of each event, newest last.
    pub(super) events: VecDeque<(f64, String, bool)>,
    pub(super) rates: Rates,
    column_start: Instant,
}

/// Rates of the streams over the last second, Hz; negative if unknown.
#[derive(Clone, Copy, Debug)]
pub(super) struct Rates {
    pub(super) frames_hz: [f64; HANDS],
    pub(super) joints_hz: f64,
    pub(super) ticks_hz: f64,
    /// Status at the start of the averaging time.
    pub(super) before: Status,
}

impl Rates {
    fn new(before: Status) -> Self {
        Self {
            frames_hz: [-1.0; HANDS],
            joints_hz: -1.0,
            ticks_hz: -1.0,
            before,
        }
    }

    fn update(&mut self, now: &Status) {
        let before = &self.before;
        let elapsed_ns = now
            .stamp
            .captured_ns
            .saturating_sub(before.stamp.captured_ns);
        if before.pid != now.pid || now.stamp.captured_ns < before.stamp.captured_ns {
            *self = Self::new(*now);
        } else if elapsed_ns >= RATE_WINDOW.as_nanos() as u64 {
            let hz = |now: u64, before: u64| {
                now.saturating_sub(before) as f64 / (elapsed_ns as f64 * 1e-9)
            };
            *self = Self {
                frames_hz: std::array::from_fn(|h| hz(now.hands[h].frames, before.hands[h].frames)),
                joints_hz: hz(now.joints.states, before.joints.states),
                ticks_hz: hz(now.ticks, before.ticks),
                before: *now,
            };
        }
    }
}

impl ScreenState {
    pub(super) fn new(watch: Observer, bus: &str) -> Self {
        Self {
            watch,
            run: Run::default(),
            bus: bus.to_owned(),
            lanes: std::array::from_fn(|_| VecDeque::from([0])),
            events: VecDeque::new(),
            rates: Rates::new(Status::default()),
            column_start: Instant::now(),
        }
    }

    /// Reads all data since the last call.
    pub(super) fn poll(&mut self, session: &Session) -> Result<(), BusError> {
        let mut active = [0; HANDS];
        let mut events = Vec::new();
        self.watch.poll(
            |report| {
                for (bits, hand) in active.iter_mut().zip(&report.hands) {
                    *bits |= hand.modules_active;
                }
            },
            |event| events.push(*event),
        )?;
        self.run.poll(session.bus(), &self.watch.status)?;
        for (hand, bit) in events.iter().filter_map(switched_on) {
            active[hand] |= bit;
        }
        self.rates.update(&self.watch.status);
        for (lane, bits) in self.lanes.iter_mut().zip(active) {
            if let Some(newest) = lane.back_mut() {
                *newest |= bits;
            }
        }
        if self.column_start.elapsed() >= COLUMN {
            self.column_start = Instant::now();
            self.lanes.iter_mut().for_each(start_column);
        }
        events.iter().for_each(|event| self.add_event(event));
        Ok(())
    }

    fn add_event(&mut self, event: &ModuleEvent) {
        // The module lanes show these events.
        if matches!(event.kind, EventKind::MODULE_ON | EventKind::MODULE_OFF) {
            return;
        }
        if self.events.len() == EVENTS {
            self.events.pop_front();
        }
        let started_ns = self.watch.status.started_ns;
        let at_s = event.stamp.captured_ns.saturating_sub(started_ns) as f64 * 1e-9;
        self.events
            .push_back((at_s, text::event(event), is_fault(event)));
    }

    /// Returns the present hands with their numbers of fingertips, or both hands if none is known.
    pub(super) fn hands(&self) -> Vec<(usize, usize)> {
        let fingers = self.run.fingertips(&self.watch.status);
        let hands = fingers.into_iter().enumerate();
        let there: Vec<_> = hands.clone().filter(|(_, fingers)| *fingers > 0).collect();
        if there.is_empty() {
            hands.collect()
        } else {
            there
        }
    }

    /// Returns the modules of a hand that were active in the last columns.
    pub(super) fn modules(&self, hand: usize, columns: usize) -> Vec<ModuleId> {
        let shown = self.lanes[hand].iter().rev().take(columns);
        let ever = shown.fold(0, |bits, column| bits | column);
        let known = ModuleId::ALL
            .iter()
            .filter(|id| id.0 < u32::BITS && **id != ModuleId::NONE);
        known.filter(|id| ever >> id.0 & 1 == 1).copied().collect()
    }
}

fn start_column(lane: &mut VecDeque<u32>) {
    if lane.len() == COLUMNS {
        lane.pop_front();
    }
    lane.push_back(0);
}

/// Returns the hand and the bit of a module that was switched on. This covers short activity whose
/// reports were lost, for example in fast lock-step runs.
fn switched_on(event: &ModuleEvent) -> Option<(usize, u32)> {
    if event.kind != EventKind::MODULE_ON {
        return None;
    }
    Some((event.hand.index()?, 1_u32.checked_shl(event.module.0)?))
}

fn is_fault(event: &ModuleEvent) -> bool {
    event.kind == EventKind::WARNING
        || (event.kind == EventKind::MODE
            && matches!(event.mode, Mode::HOLD | Mode::SAFE_STOP | Mode::FAULT))
}

#[cfg(test)]
mod tests {
    use shm_schemas::Hand;

    use super::*;

    #[test]
    fn module_on_event_marks_its_lane() {
        let event = |kind, hand, module| ModuleEvent {
            kind,
            hand,
            module,
            ..ModuleEvent::default()
        };
        for (event, expected) in [
            (
                event(EventKind::MODULE_ON, Hand::RIGHT, ModuleId::FIRST_TOUCH),
                Some((1, 1 << 3)),
            ),
            (
                event(EventKind::MODULE_OFF, Hand::RIGHT, ModuleId::FIRST_TOUCH),
                None,
            ),
            (
                event(EventKind::STEP, Hand::RIGHT, ModuleId::FIRST_TOUCH),
                None,
            ),
            (event(EventKind::MODULE_ON, Hand(2), ModuleId::CARRY), None),
            (event(EventKind::MODULE_ON, Hand::LEFT, ModuleId(32)), None),
        ] {
            assert_eq!(switched_on(&event), expected, "{event:?}");
        }
    }
}
