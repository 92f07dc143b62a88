//! A rigid block, pressed: what closes is the fingertips' own compression, δ(F) = a·F^p.

use serde::Serialize;

/// Exponents that a fingertip can have: the daemon's own range.
const EXPONENTS: core::ops::RangeInclusive<u32> = 20..=100;
/// Fewest points of a press.
const POINTS_MIN: usize = 10;

/// How fingertips compress.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Block {
    /// Compression of one fingertip at 1 N, m.
    pub tip_compression_m: f64,
    /// Exponent of its compression over force.
    pub tip_exponent: f64,
    /// Root mean square error of the closing, m.
    pub error_m: f64,
}

/// From total closing, m, and normal force, N, of presses on something rigid by so many fingertips at once. `None` if that is
/// too little, or does not get stiffer as a fingertip does.
#[must_use]
pub fn press_block(points: &[(f64, f64)], from_n: f64, tips: u32) -> Option<Block> {
    let pressed: Vec<(f64, f64)> = points
        .iter()
        .copied()
        .filter(|(closing_m, force_n)| closing_m.is_finite() && *force_n > from_n)
        .collect();
    if pressed.len() < POINTS_MIN || tips == 0 {
        return None;
    }
    EXPONENTS
        .filter_map(|hundredths| line(&pressed, f64::from(hundredths) / 100.0))
        .min_by(|a, b| a.error_m.total_cmp(&b.error_m))
        .map(|best| Block {
            tip_compression_m: best.tip_compression_m / f64::from(tips),
            ..best
        })
}

/// The best line of closing over F^p; where the fingers first touched is not known, so it has an offset.
fn line(pressed: &[(f64, f64)], exponent: f64) -> Option<Block> {
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
