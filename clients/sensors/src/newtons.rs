//! Conversion of a fingertip's values to element forces, by data-sheet scale or by calibration.

use shm_schemas::capacity::ELEMENTS;

use crate::calibration::{AXES, Calibration};
use crate::mapping::Mapping;
use crate::reading::{Quantity, Shape};

/// Maximum taxels per fingertip. Design choice: exceeds every supported sensor.
pub const TAXELS: usize = 256;

/// Conversion of one device's values to newtons.
#[derive(Clone, Debug, PartialEq)]
pub enum Newtons {
    /// Scale and axes, common to all elements.
    Scaled(Mapping),
    /// Fitted calibrations, one per fingertip of the device.
    Fitted(Vec<Calibration>),
}

impl Newtons {
    /// Returns the elements per fingertip; with a scale, possibly more than a frame holds.
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

    /// Writes `[f_n, f_t1, f_t2]`, N, of every element of one fingertip; returns the element count.
    /// Forces are finite if the values are.
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
