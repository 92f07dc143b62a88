//! Reader of sensor data on the bus.
#![allow(dead_code, reason = "each test program uses its own part")]

use shm_bus::{Bus, FreshBus, Realtime, Subscriber};
use shm_schemas::service::{HAND_FRAME, SENSOR_STATUS};
use shm_schemas::{Hand, HandFrame, SensorStatus};

use crate::process::wait_until;

/// Reader of one hand's frames and of sensor statuses.
pub(crate) struct Reader {
    frames: Subscriber<HandFrame>,
    statuses: Subscriber<SensorStatus>,
    pub(crate) received: Vec<HandFrame>,
    pub(crate) status: SensorStatus,
}

impl Reader {
    pub(crate) fn new(bus: &FreshBus, hand: Hand) -> Self {
        let node = Bus::open(bus, "test", Realtime::No).unwrap();
        Self {
            frames: node.subscriber(HAND_FRAME[hand.index().unwrap()]).unwrap(),
            statuses: node.subscriber(SENSOR_STATUS).unwrap(),
            received: Vec::new(),
            status: SensorStatus::default(),
        }
    }

    pub(crate) fn poll(&mut self) {
        let received = &mut self.received;
        self.frames
            .drain(64, |frame| received.push(*frame))
            .unwrap();
        self.statuses.newest(&mut self.status).unwrap();
    }

    pub(crate) fn wait_for_frames(&mut self, count: u64) {
        wait_until(&format!("frame {count}"), || {
            self.poll();
            self.status.frames >= count
        });
        self.poll();
    }

    pub(crate) fn wait_for_start(&mut self) {
        wait_until("the first status", || {
            self.poll();
            self.status.stamp.captured_ns > 0
        });
    }
}
