//! Mechanical memory of a fingertip's skin: hysteresis, then creep, of every element and axis.

use nalgebra::Vector3;

use super::creep::{self, Creep};
use super::hysteresis::{self, Hysteresis};
use crate::sensor_model::{HysteresisModel, SensorModel};

const AXES: usize = 3;

/// Skin with memory; the effects that are off have no state.
#[derive(Clone, Debug)]
pub(super) struct Skin {
    hysteresis: Option<HystereticSkin>,
    creep: Option<CreepingSkin>,
}

#[derive(Clone, Debug)]
struct HystereticSkin {
    /// Per axis.
    axes: [Hysteresis; AXES],
    /// Per element and axis.
    states: Vec<[hysteresis::State; AXES]>,
}

#[derive(Clone, Debug)]
struct CreepingSkin {
    creep: Creep,
    states: Vec<[creep::State; AXES]>,
}

impl Skin {
    /// Returns the skin of a model; `None` if it has no memory.
    pub(super) fn new(model: &SensorModel, elements: usize, period_s: f64) -> Option<Self> {
        let hysteresis = model.hysteresis.filter(|of| of.share > 0.0);
        let creep = model.creep.filter(|of| of.per_decade != 0.0);
        if hysteresis.is_none() && creep.is_none() {
            return None;
        }
        Some(Self {
            hysteresis: hysteresis.map(|of| HystereticSkin::new(&of, elements)),
            creep: creep.map(|of| {
                let creep = Creep::new(of.per_decade, period_s);
                CreepingSkin {
                    states: vec![[creep.initial(); AXES]; elements],
                    creep,
                }
            }),
        })
    }

    /// Advances one element by one sample; returns the forces that its transducer measures.
    #[inline]
    pub(super) fn advance(&mut self, element: usize, mut force_n: Vector3<f64>) -> Vector3<f64> {
        if let Some(HystereticSkin { axes, states }) = &mut self.hysteresis {
            for ((force_n, axis), state) in force_n.iter_mut().zip(axes).zip(&mut states[element]) {
                *force_n = axis.advance(state, *force_n);
            }
        }
        if let Some(CreepingSkin { creep, states }) = &mut self.creep {
            for (force_n, state) in force_n.iter_mut().zip(&mut states[element]) {
                *force_n = creep.advance(state, *force_n);
            }
        }
        force_n
    }
}

impl HystereticSkin {
    fn new(model: &HysteresisModel, elements: usize) -> Self {
        let [normal_n, shear_n] = model.full_scale_n;
        let normal = Hysteresis::new(model.share, normal_n, true);
        let shear = Hysteresis::new(model.share, shear_n, false);
        let axes = [normal, shear, shear];
        let initial = axes.each_ref().map(Hysteresis::initial);
        Self {
            axes,
            states: vec![initial; elements],
        }
    }
}
