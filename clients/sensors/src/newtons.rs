//! From the values of a fingertip to the forces of its elements: by the scale of a data sheet, or by a calibration.

use shm_schemas::capacity::ELEMENTS;

use crate::calibration::{AXES, Calibration};
use crate::mapping::Mapping;
use crate::reading::{Quantity, Shape};

/// Taxels of one fingertip at most. Ours: more than any sensor here has; a calibration makes of them what fits a frame.
pub const TAXELS: usize = 256;

/// How one device's values become newtons.
#[derive(Clone, Debug, PartialEq)]
pub enum Newtons {
    /// Scale and axes, the same for every element.
    Scaled(Mapping),
    /// Fitted to presses: one calibration per fingertip of the device.
    Fitted(Vec<Calibration>),
}

impl Newtons {
    /// Elements that each fingertip would fill; by a scale these may be more than a frame has.
    #[must_use]
    pub fn elements(&self, shape: Shape) -> usize {
        match self {
            Self::Scaled(_) => shape.taxels,
            Self::Fitted(tips) => tips
                .iter()
                .map(Calibration::elements_out)
                .max()
                .unwrap_or(0)
                .min(ELEMENTS),
        }
    }

    /// Writes `[f_n, f_t1, f_t2]`, N, of every element of one of the device's fingertips; returns how many there are. As finite
    /// as the values are.
    pub fn write(
        &self,
        tip: usize,
        quantity: Quantity,
        values: &[f64],
        forces_n: &mut [[f32; AXES]; ELEMENTS],
    ) -> usize {
        let taxels = values.chunks_exact(quantity.axes().len());
        match self {
            Self::Scaled(mapping) => {
                let count = taxels.len().min(ELEMENTS);
                for (force_n, taxel) in forces_n.iter_mut().zip(taxels) {
                    *force_n = mapping.force_n(quantity.vector(taxel));
                }
                count
            }
            Self::Fitted(tips) => {
                let Some(calibration) = tips.get(tip) else {
                    return 0;
                };
                let mut vectors = [[f64::NAN; AXES]; TAXELS];
                for (vector, taxel) in vectors.iter_mut().zip(taxels) {
                    *vector = quantity.vector(taxel);
                }
                let count = calibration.elements_out().min(ELEMENTS);
                for (element, force_n) in forces_n.iter_mut().enumerate().take(count) {
                    *force_n = calibration
                        .force_n(element, vectors.as_flattened())
                        .map(|n| n as f32);
                }
                count
            }
        }
    }
}
