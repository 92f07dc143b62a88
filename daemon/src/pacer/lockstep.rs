//! Ticks by the sensors.

use std::time::Duration;

use atas_core::Tick;

use super::TickStart;
use crate::link::TickEnd;
use crate::ports::InputPorts;

/// Ticks at the start, and after a recovery, in which the world settles and no goal is taken. Long enough for the mode
/// machine to become READY (20 ticks without doubt). Ours.
const SETTLE_TICKS: u64 = 100;
/// How often an empty port is asked again without a pause: about the time in which a simulator answers. Ours.
const EAGER_POLLS: u32 = 20_000;
/// Pause between later polls.
const PAUSE: Duration = Duration::from_micros(200);

/// Waits for sensors instead of the clock.
#[derive(Debug, Default)]
pub struct LockStep {
    index: u64,
    settled_at: u64,
}

impl LockStep {
    /// Begins with settling.
    #[must_use]
    pub fn new() -> Self {
        Self {
            index: 0,
            settled_at: SETTLE_TICKS,
        }
    }

    /// Lets the world settle anew, from the next tick on.
    pub fn settle(&mut self) {
        self.settled_at = self.index + SETTLE_TICKS;
    }

    /// Waits for a joint state while there is something to do, or a client lets time go on, and room to record it; else takes
    /// nothing from the bus, so that the sensors' process, which waits for an answer, stands still as well. `None` when the loop shall end.
    pub fn wait(
        &mut self,
        ports: &mut InputPorts,
        link: &TickEnd,
        pursues_goal: bool,
    ) -> Option<TickStart> {
        let mut polls = 0;
        ports.begin();
        while !link.is_quitting() {
            let settling = self.index < self.settled_at;
            let goes_on = self.index < link.advanced_to();
            let has_work = settling || pursues_goal || goes_on || link.has_orders();
            if has_work && link.has_room() && ports.look_for_joints() {
                return Some(self.begin(ports.joints_captured_ns(), settling));
            }
            polls += 1;
            if polls < EAGER_POLLS {
                std::thread::yield_now();
            } else {
                std::thread::sleep(PAUSE);
            }
        }
        None
    }

    fn begin(&mut self, now_ns: u64, settling: bool) -> TickStart {
        let tick = Tick {
            index: self.index,
            now_ns,
        };
        self.index += 1;
        TickStart {
            tick,
            settling,
            ..TickStart::default()
        }
    }
}
