//! Transport of the frames of one hand: latency, jitter, loss and time stamps.
//!
//! Frames keep their order, as on a serial line or a socket, and at most one arrives per tick. The
//! stamp is the time of arrival for a device without a clock: `atas-sensor` stamps such frames when
//! it reads them. Their latency is then invisible to the daemon, and the readings are older than
//! the stamp says. A device with a clock sends the time of the sample.

use shm_schemas::HandFrame;

use crate::clock::{Clock, TICK_NS};
use crate::random::Random;
use crate::sensor_model::{FrameModel, FrameStamp};

/// Queue of one hand. Its capacity is fixed, also in a clone.
#[derive(Clone, Debug)]
pub(super) struct Transport {
    latency_ticks: f64,
    jitter_ticks: f64,
    loss: f64,
    stamp: FrameStamp,
    /// Draws jitter and loss; two draws per frame, so that neither changes the other.
    random: Random,
    /// Arrival tick and frame, from `first`, in a ring.
    queue: Box<[(u64, HandFrame)]>,
    first: usize,
    count: usize,
    /// Arrival tick of the newest frame, and one.
    free_tick: u64,
}

impl Transport {
    /// Returns the transport of a model; `None` if frames arrive at once.
    pub(super) fn new(model: &FrameModel, random: Random) -> Option<Self> {
        if model.is_immediate() {
            return None;
        }
        let ticks = |time_s: f64| time_s * 1e9 / TICK_NS as f64;
        let (latency_ticks, jitter_ticks) = (ticks(model.latency_s), ticks(model.jitter_s));
        // One frame per tick arrives at most this many ticks later.
        let capacity = (latency_ticks + jitter_ticks) as usize + 2;
        Some(Self {
            latency_ticks,
            jitter_ticks,
            loss: model.loss,
            stamp: model.stamp,
            random,
            queue: vec![(0, HandFrame::default()); capacity].into_boxed_slice(),
            first: 0,
            count: 0,
            free_tick: 0,
        })
    }

    /// Sends a frame that was sampled in this tick.
    pub(super) fn send(&mut self, tick: u64, frame: HandFrame) {
        let delay_ticks = self.latency_ticks + self.jitter_ticks * self.random.uniform();
        let is_lost = self.random.chance(self.loss);
        if is_lost || self.count == self.queue.len() {
            return;
        }
        let due = (tick + libm::round(delay_ticks) as u64).max(self.free_tick);
        self.free_tick = due + 1;
        let place = (self.first + self.count) % self.queue.len();
        self.queue[place] = (due, frame);
        self.count += 1;
    }

    /// Returns the sealed frame that arrives in this tick, if any.
    pub(super) fn receive(&mut self, clock: &Clock) -> Option<HandFrame> {
        let (due, mut frame) = self.queue[self.first];
        if self.count == 0 || due > clock.tick {
            return None;
        }
        self.first = (self.first + 1) % self.queue.len();
        self.count -= 1;
        if self.stamp == FrameStamp::Arrival {
            frame.stamp.captured_ns = clock.now_ns;
        }
        frame.seal();
        Some(frame)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Arrival tick, sequence number and stamp (in ticks) of each frame, sampled once per
    /// `period` ticks, 1000 frames.
    fn arrivals(model: &FrameModel, period: u64) -> Vec<(u64, u64, u64)> {
        let mut transport = Transport::new(model, Random::new(1, 2)).expect("not immediate");
        let mut clock = Clock::new(1);
        let (begin_ns, mut arrived) = (clock.now_ns, Vec::new());
        for tick in 0..1000 * period + 600 {
            if tick.is_multiple_of(period) && tick < 1000 * period {
                let stamp = clock.stamp(tick / period);
                let frame = HandFrame {
                    stamp,
                    ..HandFrame::default()
                };
                transport.send(tick, frame);
            }
            if let Some(frame) = transport.receive(&clock) {
                assert!(frame.is_intact());
                let stamp = (frame.stamp.captured_ns - begin_ns) / TICK_NS;
                arrived.push((tick, frame.stamp.sequence, stamp));
            }
            clock.advance();
        }
        arrived
    }

    #[test]
    fn latency_delays_every_frame_by_the_same_ticks() {
        for (stamp, hidden) in [(FrameStamp::Arrival, 7), (FrameStamp::Sample, 0)] {
            let model = FrameModel {
                latency_s: 0.007,
                stamp,
                ..FrameModel::default()
            };
            for period in [1, 10] {
                let arrived = arrivals(&model, period);
                assert_eq!(arrived.len(), 1000);
                for (tick, sequence, stamp) in arrived {
                    let sampled = sequence * period;
                    assert_eq!((tick, stamp), (sampled + 7, sampled + hidden));
                }
            }
        }
    }

    #[test]
    fn jitter_keeps_the_order_and_its_bounds() {
        for period in [1, 10] {
            let model = FrameModel {
                latency_s: 0.002,
                jitter_s: 0.005,
                ..FrameModel::default()
            };
            let arrived = arrivals(&model, period);
            assert_eq!(arrived.len(), 1000, "no frame is lost");
            let delays = arrived
                .iter()
                .map(|(tick, sequence, _)| tick - sequence * period);
            let (least, most) = (delays.clone().min(), delays.clone().max());
            assert!(least >= Some(2) && most == Some(7), "{least:?} to {most:?}");
            assert!(arrived.is_sorted_by(|a, b| a.0 < b.0 && a.1 < b.1 && a.2 < b.2));
            if period == 10 {
                let mean = delays.sum::<u64>() as f64 / 1000.0;
                assert!((mean - 4.5).abs() < 0.2, "{mean}");
            }
        }
    }

    #[test]
    fn lost_frames_leave_gaps() {
        let model = FrameModel {
            loss: 0.2,
            ..FrameModel::default()
        };
        let arrived = arrivals(&model, 1);
        assert!((750..850).contains(&arrived.len()), "{}", arrived.len());
        assert!(arrived.iter().all(|(tick, sequence, _)| tick == sequence));
    }

    #[test]
    fn immediate_transport_needs_no_queue() {
        assert!(Transport::new(&FrameModel::default(), Random::new(1, 2)).is_none());
    }
}
