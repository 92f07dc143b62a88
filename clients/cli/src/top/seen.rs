//! What the screen shows: the newest of everything, and the last seconds of modules and events.

use std::collections::VecDeque;
use std::time::{Duration, Instant};

use atas_client::{Run, Session, Watch, words};
use shm_bus::BusError;
use shm_schemas::capacity::HANDS;
use shm_schemas::{EventKind, Mode, ModuleEvent, ModuleId, Status};

/// Time of one column of a module's lane, s; a lane of 40 columns is 20 s (ours).
const COLUMN: Duration = Duration::from_millis(500);
/// Columns that are kept.
const COLUMNS: usize = 240;
/// Events that are kept.
const EVENTS: usize = 100;
/// Time over which rates are taken.
const RATES: Duration = Duration::from_secs(1);

/// What the screen shows.
pub(super) struct Seen {
    pub(super) watch: Watch,
    pub(super) run: Run,
    pub(super) bus: String,
    /// Per hand and column, newest last, the modules that were active in it.
    pub(super) lanes: [VecDeque<u32>; HANDS],
    /// Sentences, newest last, and whether they tell a fault.
    pub(super) events: VecDeque<(f64, String, bool)>,
    pub(super) rates: Rates,
    turned: Instant,
}

/// How often the streams spoke over the last second, Hz; negative where it is not known yet.
#[derive(Clone, Copy, Debug)]
pub(super) struct Rates {
    pub(super) frames_hz: [f64; HANDS],
    pub(super) joints_hz: f64,
    pub(super) ticks_hz: f64,
    /// What they are taken since.
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

    fn learn(&mut self, now: &Status) {
        let before = &self.before;
        let elapsed_ns = now
            .stamp
            .captured_ns
            .saturating_sub(before.stamp.captured_ns);
        if before.pid != now.pid || now.stamp.captured_ns < before.stamp.captured_ns {
            *self = Self::new(*now);
        } else if elapsed_ns >= RATES.as_nanos() as u64 {
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

impl Seen {
    pub(super) fn new(watch: Watch, bus: &str) -> Self {
        Self {
            watch,
            run: Run::default(),
            bus: bus.to_owned(),
            lanes: std::array::from_fn(|_| VecDeque::from([0])),
            events: VecDeque::new(),
            rates: Rates::new(Status::default()),
            turned: Instant::now(),
        }
    }

    /// Takes in what has come since the last look.
    pub(super) fn look(&mut self, session: &Session) -> Result<(), BusError> {
        let mut active = [0; HANDS];
        let mut events = Vec::new();
        self.watch.look(
            |report| {
                for (bits, hand) in active.iter_mut().zip(&report.hands) {
                    *bits |= hand.modules_active;
                }
            },
            |event| events.push(*event),
        )?;
        self.run.look(session.bus(), &self.watch.status)?;
        for (hand, bit) in events.iter().filter_map(switched_on) {
            active[hand] |= bit;
        }
        self.rates.learn(&self.watch.status);
        for (lane, bits) in self.lanes.iter_mut().zip(active) {
            if let Some(newest) = lane.back_mut() {
                *newest |= bits;
            }
        }
        if self.turned.elapsed() >= COLUMN {
            self.turned = Instant::now();
            self.lanes.iter_mut().for_each(turn);
        }
        events.iter().for_each(|event| self.happened(event));
        Ok(())
    }

    fn happened(&mut self, event: &ModuleEvent) {
        // Their lanes tell when modules were switched.
        if matches!(event.kind, EventKind::MODULE_ON | EventKind::MODULE_OFF) {
            return;
        }
        if self.events.len() == EVENTS {
            self.events.pop_front();
        }
        let started_ns = self.watch.status.started_ns;
        let at_s = event.stamp.captured_ns.saturating_sub(started_ns) as f64 * 1e-9;
        self.events
            .push_back((at_s, words::event(event), is_fault(event)));
    }

    /// The hands that are there, each with its fingers: both where none is known yet.
    pub(super) fn hands(&self) -> Vec<(usize, usize)> {
        let fingers = self.run.fingers(&self.watch.status);
        let hands = fingers.into_iter().enumerate();
        let there: Vec<_> = hands.clone().filter(|(_, fingers)| *fingers > 0).collect();
        if there.is_empty() {
            hands.collect()
        } else {
            there
        }
    }

    /// Modules that were active in the last columns, of this hand.
    pub(super) fn modules(&self, hand: usize, columns: usize) -> Vec<ModuleId> {
        let shown = self.lanes[hand].iter().rev().take(columns);
        let ever = shown.fold(0, |bits, column| bits | column);
        let known = ModuleId::ALL
            .iter()
            .filter(|id| id.0 < u32::BITS && **id != ModuleId::NONE);
        known.filter(|id| ever >> id.0 & 1 == 1).copied().collect()
    }
}

fn turn(lane: &mut VecDeque<u32>) {
    if lane.len() == COLUMNS {
        lane.pop_front();
    }
    lane.push_back(0);
}

/// The hand and the bit of a module that was switched on: reports that nobody took in time are gone, and where a lock-step
/// runs faster than it is drawn, that can be all of those in which the module was active.
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
    fn a_module_that_no_report_showed_has_its_mark() {
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
