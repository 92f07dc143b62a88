//! Fit of fingertip compression δ(F) = a·F^p to presses on a rigid block, where closing equals
//! compression.

use serde::Serialize;

/// Candidate exponents × 100; range accepted by the daemon.
const EXPONENTS: core::ops::RangeInclusive<u32> = 20..=100;
/// Minimum points of a press.
const POINTS_MIN: usize = 10;

/// Compression of a fingertip.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Block {
    /// Compression at 1 N, m.
    pub tip_compression_m: f64,
    /// Exponent p.
    pub tip_exponent: f64,
    /// Root mean square error of the closing, m.
    pub error_m: f64,
}

/// Fits (total closing in m, normal force in N) of `tips` fingertips pressed at once, for forces
/// above `from_n`. Returns `None` with too few points, or if closing does not grow with force.
#[must_use]
pub fn fit_block(points: &[(f64, f64)], from_n: f64, tips: u32) -> Option<Block> {
    let pressed: Vec<(f64, f64)> = points
        .iter()
        .copied()
        .filter(|(closing_m, force_n)| closing_m.is_finite() && *force_n > from_n)
        .collect();
    if pressed.len() < POINTS_MIN || tips == 0 {
        return None;
    }
    EXPONENTS
        .filter_map(|hundredths| fit_line(&pressed, f64::from(hundredths) / 100.0))
        .min_by(|a, b| a.error_m.total_cmp(&b.error_m))
        .map(|best| Block {
            tip_compression_m: best.tip_compression_m / f64::from(tips),
            ..best
        })
}

/// Fits closing = slope·F^p + offset; the offset is the unknown closing at first contact.
fn fit_line(pressed: &[(f64, f64)], exponent: f64) -> Option<Block> {
    let count = pressed.len() as f64;
    let powers: Vec<f64> = pressed.iter().map(|(_, f)| f.powf(exponent)).collect();
    let x = powers.iter().sum::<f64>() / count;
    let y = pressed.iter().map(|(c, _)| c).sum::<f64>() / count;
    let pairs = || powers.iter().zip(pressed).map(|(p, (c, _))| (p - x, c - y));
    let spread: f64 = pairs().map(|(p, _)| p * p).sum();
    let along: f64 = pairs().map(|(p, c)| p * c).sum();
    let slope = along / spread;
    let rest: f64 = pairs().map(|(p, c)| (c - slope * p).powi(2)).sum();
    (slope.is_finite() && slope > 0.0).then(|| Block {
        tip_compression_m: slope,
        tip_exponent: exponent,
        error_m: (rest / count).sqrt(),
    })
}
