//! Random electronics of a simulated fingertip, unknown to the calibration: gain, axes, crosstalk,
//! offsets.

use atas_sensors::calibration::{AXES, Calibration, FORMAT, Model, Quality};
use nalgebra::{Matrix3, Rotation3, Vector3};
use sim_backend::random::Random;

/// Counts per newton (design choice: resolution of 5 mN to 0.5 mN).
const COUNTS_PER_N: [f64; 2] = [200.0, 2000.0];
/// Largest rotation of the axes from those of the element, rad (design choice: 10°, in addition to
/// permutation and sign).
const ROTATION_MAX_RAD: f64 = 0.17;
/// Crosstalk of all elements together, and of each element (same values as the error `crosstalk`).
const CROSSTALK: [f64; 2] = [0.08, 0.05];
/// Largest offset without contact, counts.
const OFFSET_MAX: f64 = 500.0;

pub(super) struct Electronics {
    /// Gain per element, counts per newton.
    counts_per_n: Vec<Matrix3<f64>>,
    /// Offset per element, counts.
    zero: Vec<Vector3<f64>>,
}

impl Electronics {
    pub(super) fn draw(elements: usize, random: &mut Random) -> Self {
        let [low, high] = COUNTS_PER_N.map(f64::ln);
        let gain = random.between(low, high).exp();
        let mut mixed = |half_width: f64| {
            let mixed = Matrix3::from_fn(|_, _| half_width * random.between(-1.0, 1.0));
            Matrix3::identity() + mixed - Matrix3::from_diagonal(&mixed.diagonal())
        };
        let (all, each): (_, Vec<_>) = (
            mixed(CROSSTALK[0]),
            (0..elements).map(|_| mixed(CROSSTALK[1])).collect(),
        );
        let mut small = || ROTATION_MAX_RAD * random.between(-1.0, 1.0) / (AXES as f64).sqrt();
        let turned = Rotation3::new(Vector3::new(small(), small(), small()));
        let axes = gain * turned.matrix() * random_permutation(random) * all;
        Self {
            counts_per_n: each.iter().map(|own| axes * own).collect(),
            zero: (0..elements)
                .map(|_| Vector3::from_fn(|_, _| OFFSET_MAX * random.between(-1.0, 1.0)))
                .collect(),
        }
    }

    /// Converts forces `[f_n, f_t1, f_t2]`, N, to whole counts.
    pub(super) fn counts(&self, readings_n: &[[f32; AXES]]) -> Vec<f64> {
        let elements = self.counts_per_n.iter().zip(&self.zero).zip(readings_n);
        elements
            .flat_map(|((matrix, zero), reading_n)| {
                let value = matrix * Vector3::from(reading_n.map(f64::from)) + zero;
                <[f64; AXES]>::from(value.map(f64::round))
            })
            .collect()
    }

    /// Returns the exact inverse calibration; `None` if a matrix is singular.
    pub(super) fn exact(&self) -> Option<Calibration> {
        let back = |matrix: &Matrix3<f64>| {
            let back = matrix.try_inverse()?;
            Some(core::array::from_fn(|row| {
                back.row(row).iter().copied().collect()
            }))
        };
        Some(Calibration {
            format: FORMAT,
            source: "exact inverse of the simulated electronics".to_owned(),
            model: Model::Matrix,
            zero: self
                .zero
                .iter()
                .flat_map(|zero| zero.iter().copied())
                .collect(),
            newtons: self.counts_per_n.iter().map(back).collect::<Option<_>>()?,
            quality: Quality::default(),
            drift: None,
        })
    }
}

fn random_permutation(random: &mut Random) -> Matrix3<f64> {
    let mut order = [0, 1, 2];
    for last in (1..AXES).rev() {
        order.swap(last, (random.uniform() * (last + 1) as f64) as usize);
    }
    Matrix3::from_fn(|row, column| f64::from(u8::from(order[row] == column)))
        * Matrix3::from_diagonal(&Vector3::from_fn(|_, _| {
            if random.uniform() < 0.5 { -1.0 } else { 1.0 }
        }))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exact_calibration_inverts_electronics_within_one_count() {
        for seed in 0..20 {
            let tip = Electronics::draw(2, &mut Random::new(seed, 1));
            let exact = tip.exact().expect("invertible");
            let readings_n = [[1.5, -0.2, 0.1], [0.0, 0.3, -0.4]];
            let counts = tip.counts(&readings_n);
            for (element, reading_n) in readings_n.iter().enumerate() {
                for (told_n, n) in exact.force_n(element, &counts).iter().zip(reading_n) {
                    assert!((told_n - f64::from(*n)).abs() < 0.006, "{told_n} {n}");
                }
            }
        }
    }
}
