//! Pacer that follows the sensors.

use std::time::Duration;

use atas_core::Tick;

use super::TickStart;
use crate::link::RealtimeSide;
use crate::ports::InputPorts;

/// Ticks without goals after the start and after a recovery, while the world settles. Design
/// choice: enough for the mode machine to become READY (20 fault-free ticks).
const SETTLE_TICKS: u64 = 100;
/// Polls of an empty port without a pause: about the response time of a simulator. Design choice.
const YIELD_POLLS: u32 = 20_000;
const PAUSE: Duration = Duration::from_micros(200);

/// Waits for sensors instead of the clock.
#[derive(Debug, Default)]
pub struct LockStep {
    index: u64,
    settling_until: u64,
}

impl LockStep {
    /// Starts with settling.
    #[must_use]
    pub fn new() -> Self {
        Self {
            index: 0,
            settling_until: SETTLE_TICKS,
        }
    }

    /// Restarts settling with the next tick.
    pub fn restart_settling(&mut self) {
        self.settling_until = self.index + SETTLE_TICKS;
    }

    /// Waits for a joint state while there is work, or time may advance, and there is room to
    /// record it. Otherwise takes nothing from the bus: the sensor process waits for an answer and
    /// stands still too. `None` when the loop must end.
    pub fn wait(
        &mut self,
        ports: &mut InputPorts,
        link: &RealtimeSide,
        pursues_goal: bool,
    ) -> Option<TickStart> {
        let mut polls = 0;
        ports.begin_tick();
        while !link.is_quitting() {
            let settling = self.index < self.settling_until;
            let goes_on = self.index < link.advanced_to();
            let has_work = settling || pursues_goal || goes_on || link.has_requests();
            if has_work && link.has_room() && ports.poll_joints() {
                return Some(self.begin(ports.joints_captured_ns(), settling));
            }
            polls += 1;
            if polls < YIELD_POLLS {
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
