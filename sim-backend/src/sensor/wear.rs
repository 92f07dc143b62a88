//! Slow changes of a fingertip's elements: thermal drift of the zero, wear of the gain, and
//! elements that fail.

use shm_schemas::capacity::ELEMENTS;

use crate::random::Random;
use crate::sensor_model::{DeadModel, DeadReading, DriftModel, SensorModel, WearModel};

const AXES: usize = 3;

/// Thermal drift of all elements.
#[derive(Clone, Debug)]
pub(super) struct Drift {
    model: DriftModel,
    /// Part of the fingertip's drift on each element.
    part: f64,
}

/// Wear of every element.
#[derive(Clone, Debug)]
pub(super) struct Wear {
    model: WearModel,
    /// Impulse of the normal force per element, N·s.
    impulse_n_s: Vec<f64>,
}

/// Failed elements.
#[derive(Clone, Debug)]
pub(super) struct Dead {
    model: DeadModel,
    /// One bit per element.
    mask: u64,
    /// Reading at the failure; `None` before it.
    last_n: Option<[[f32; AXES]; ELEMENTS]>,
}

impl Drift {
    pub(super) fn new(model: &SensorModel, elements: usize) -> Option<Self> {
        let model = model.drift.filter(|of| of.rate_n_s != [0.0; AXES])?;
        let part = 1.0 / elements.max(1) as f64;
        Some(Self { model, part })
    }

    /// Returns the drift of each element at a time, N.
    pub(super) fn element_n(&self, time_s: f64) -> [f64; AXES] {
        let DriftModel {
            rate_n_s,
            limit_n,
            from_s,
        } = self.model;
        let since_s = (time_s - from_s).max(0.0);
        rate_n_s.map(|rate_n_s| (rate_n_s * since_s).clamp(-limit_n, limit_n) * self.part)
    }
}

impl Wear {
    pub(super) fn new(model: &SensorModel, elements: usize) -> Option<Self> {
        let model = model
            .wear
            .filter(|of| of.loss > 0.0 || of.loss_per_n_s > 0.0)?;
        Some(Self {
            model,
            impulse_n_s: vec![0.0; elements],
        })
    }

    /// Adds a normal force of this duration to an element's use; returns its remaining gain, 0 to
    /// 1.
    #[inline]
    pub(super) fn remaining_gain(&mut self, element: usize, normal_n: f64, period_s: f64) -> f64 {
        let impulse_n_s = &mut self.impulse_n_s[element];
        *impulse_n_s += normal_n.max(0.0) * period_s;
        let loss = self.model.loss + self.model.loss_per_n_s * *impulse_n_s;
        1.0 - loss.min(self.model.loss_max)
    }
}

impl Dead {
    /// Draws the failing elements; `None` if none fails.
    pub(super) fn new(model: &SensorModel, elements: usize, random: &mut Random) -> Option<Self> {
        let model = model.dead?;
        let mut mask = 0;
        for element in 0..elements {
            mask |= u64::from(random.chance(model.share)) << element;
        }
        (mask != 0).then_some(Self {
            model,
            mask,
            last_n: None,
        })
    }

    /// Replaces the readings of the failed elements.
    pub(super) fn apply(&mut self, time_s: f64, reading_n: &mut [[f32; AXES]]) {
        if time_s < self.model.from_s {
            return;
        }
        let last_n = self.last_n.get_or_insert_with(|| {
            let mut last_n = [[0.0; AXES]; ELEMENTS];
            if self.model.reading == DeadReading::Last {
                last_n
                    .iter_mut()
                    .zip(&*reading_n)
                    .for_each(|(last, now)| *last = *now);
            }
            last_n
        });
        for (element, (reading_n, last_n)) in reading_n.iter_mut().zip(last_n).enumerate() {
            if self.mask >> element & 1 == 1 {
                *reading_n = *last_n;
            }
        }
    }
}
