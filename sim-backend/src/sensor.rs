//! Tactile sensor of one hand: converts true element forces to sealed frames.
//!
//! ```text
//!  element forces ─▶ TipSensor: hysteresis ─ creep ─ crosstalk ─ gain ─ wear ─ bias ─ drift ─
//!                    noise ─ quantisation ─ saturation ─ dead elements ─▶ Transport ─▶ frame
//! ```
//!
//! [`SensorModel`] has the parameters of every effect. [`Errors`] add crosstalk, offsets, gains and
//! further effects. A sensor may sample more slowly than the tick; ticks without an arriving frame
//! have none. An effect that is off costs one comparison per fingertip or hand.

use nalgebra::Vector3;
use robot_model::HandSide;
use shm_schemas::capacity::ELEMENTS;
use shm_schemas::{Hand, HandFrame, Layout};

use crate::clock::Clock;
use crate::random::Random;
use crate::scene::{Errors, stream};
use crate::sensor_model::SensorModel;
use transport::Transport;

mod creep;
mod hysteresis;
mod skin;
mod tip;
mod transport;
mod wear;

pub use creep::Creep;
pub use hysteresis::Hysteresis;
pub(crate) use tip::{TipSensor, quantised};

#[derive(Clone, Debug)]
pub(crate) struct HandSensor {
    hand: Hand,
    layout: Layout,
    layout_hash: u64,
    tips: Vec<TipSensor>,
    rate_hz: u64,
    sequence: u64,
    /// `None` if frames arrive at once.
    transport: Option<Transport>,
}

/// Sensor model with the seed of its draws.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SeededModel<'a> {
    pub(crate) model: &'a SensorModel,
    pub(crate) seed: u64,
    /// Index of the hand's first fingertip, left before right.
    pub(crate) first_tip: u64,
}

impl HandSensor {
    /// Each fingertip draws gains and noise from its stream in `random`, [`Errors`] from the
    /// streams of `errors`, and the further effects of its model from streams of their own.
    /// `noise_factor` scales the noise only.
    pub(crate) fn new(
        side: HandSide,
        layout: Layout,
        rate_hz: u32,
        noise_factor: f64,
        random: Vec<Random>,
        errors: (&Errors, Vec<Random>),
        seeded: SeededModel<'_>,
    ) -> Self {
        let SeededModel {
            model,
            seed,
            first_tip,
        } = seeded;
        let period_s = 1.0 / f64::from(rate_hz);
        let (errors, mut error_draws) = errors;
        let mut tips = Vec::with_capacity(random.len());
        for ((tip, random), draws) in (first_tip..).zip(random).zip(&mut error_draws) {
            let mut drift = Random::new(seed, stream::DRIFT_ERRORS + tip);
            let model = errors.sensor.apply(model, layout.count, &mut drift);
            let mut sensor = TipSensor::new(layout.count, &model, period_s, noise_factor, random);
            sensor.apply_errors(errors, draws);
            sensor.draw_model(&model, seed, tip);
            tips.push(sensor);
        }
        let frames = errors.sensor.apply_to_frames(&model.frames);
        let channel = stream::TRANSPORT + side.index() as u64;
        Self {
            hand: Hand::BOTH[side.index()],
            layout_hash: layout.hash(),
            layout,
            tips,
            rate_hz: rate_hz.into(),
            sequence: 0,
            transport: Transport::new(&frames, Random::new(seed, channel)),
        }
    }

    /// Samples if a sample is due and returns the frame that arrives in this tick; `None` if none
    /// arrives or no fingertip exists.
    ///
    /// `element_forces` writes the true forces on a fingertip's elements, tip frame, N.
    pub(crate) fn sample(
        &mut self,
        clock: &Clock,
        element_forces: impl Fn(usize, &mut [Vector3<f64>]),
        out: &mut Option<HandFrame>,
    ) {
        if self.tips.is_empty() {
            *out = None;
            return;
        }
        let is_due = self.is_due(clock.tick);
        let Some(mut transport) = self.transport.take() else {
            if is_due {
                let frame = out.insert(HandFrame::default());
                self.fill(clock, element_forces, frame);
                frame.seal();
            } else {
                *out = None;
            }
            return;
        };
        if is_due {
            let mut frame = HandFrame::default();
            self.fill(clock, element_forces, &mut frame);
            transport.send(clock.tick, frame);
        }
        *out = transport.receive(clock);
        self.transport = Some(transport);
    }

    /// Fills a frame, all but its seal.
    fn fill(
        &mut self,
        clock: &Clock,
        element_forces: impl Fn(usize, &mut [Vector3<f64>]),
        frame: &mut HandFrame,
    ) {
        frame.stamp = clock.stamp(self.sequence);
        self.sequence += 1;
        frame.layout_hash = self.layout_hash;
        frame.hand = self.hand;
        frame.finger_count = self.tips.len() as u32;
        let count = self.layout.count;
        let mut force_n = [Vector3::zeros(); ELEMENTS];
        let force_n = &mut force_n[..count];
        for (finger, tip) in self.tips.iter_mut().enumerate() {
            frame.valid_mask[finger] = u64::MAX >> (ELEMENTS - count);
            element_forces(finger, force_n);
            tip.sample(&self.layout, force_n, &mut frame.force_n[finger]);
        }
    }

    /// Returns a fingertip's electronics with another noise stream.
    pub(crate) fn tip(&self, finger: usize) -> Option<TipSensor> {
        self.tips.get(finger).map(TipSensor::on_bench)
    }

    /// Returns whether the sample count rises in this tick.
    fn is_due(&self, tick: u64) -> bool {
        let samples = |ticks: u64| ticks * self.rate_hz / 1000;
        tick == 0 || samples(tick) != samples(tick - 1)
    }
}
