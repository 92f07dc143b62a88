//! Hysteresis of one axis: a Prandtl–Ishlinskii model, which does not depend on the rate.
//!
//! `y = g·((1 − Kw)·x + w·Σ (P_k − p_k))`. P_k is a play operator with threshold r_k: its output
//! follows the force x at a distance of r_k. Reasons for this model:
//!
//! * Play and Maxwell-slip operators are the two equivalent forms of the standard discrete model
//!   of rate-independent hysteresis. The state of an operator is one number.
//! * With r_k = F/4, F/8, F/16, F/32 (F: full scale), the width of a cycle between zero and A, over
//!   A, depends little on A: 0.8 of the full cycle's at F/4, 0.5 at F/8. Below F/16 the axis is
//!   linear. Loss in filled elastomers also depends little on amplitude.
//! * The normal axis begins in the state after a cycle to full scale (P_k = r_k), as in an
//!   exercised and zeroed sensor. Then every cycle of a non-negative force is closed: an unloaded
//!   element reads zero. Shear has both signs and begins at P_k = 0.
//!
//! The gain g makes the reading exact at full scale. A reversal has a lower slope than the full
//! cycle, as in every hysteresis loop. Small forces therefore read less: by about 3·w below F/16.

/// Number of play operators. Design choice: hysteresis over a factor of 16 in amplitude. Every
/// further operator lowers the slope after a reversal by w.
pub(crate) const OPERATORS: usize = 4;
/// Thresholds relative to full scale.
const THRESHOLDS: [f64; OPERATORS] = [0.25, 0.125, 0.0625, 0.03125];

/// State of the operators of one axis, N.
pub(crate) type State = [f64; OPERATORS];

/// Parameters of one axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hysteresis {
    threshold_n: State,
    /// Reading of the initial state, N; it is subtracted.
    offset_n: f64,
    /// Weight of each operator, and of the force itself, both with the gain.
    weight: f64,
    direct: f64,
}

impl Hysteresis {
    /// Returns the model of an axis whose loop at half of a full-scale cycle is `share` of full
    /// scale wide. `is_normal` selects the initial state.
    #[must_use]
    pub fn new(share: f64, full_scale_n: f64, is_normal: bool) -> Self {
        // Width of the loop at half load per weight, and twice the sum of the thresholds.
        let mut width = 0.0;
        let mut lag = 0.0;
        for threshold in THRESHOLDS {
            width += (2.0 * threshold).min(1.0 - 2.0 * threshold);
            lag += 2.0 * threshold;
        }
        // share = g·w·width and g = 1 / (1 − w·lag).
        let weight = share / (width + share * lag);
        let gain = 1.0 / (1.0 - weight * lag);
        let threshold_n = THRESHOLDS.map(|threshold| threshold * full_scale_n);
        let mut of = Self {
            threshold_n,
            offset_n: 0.0,
            weight: gain * weight,
            direct: gain * (1.0 - OPERATORS as f64 * weight),
        };
        if is_normal {
            of.offset_n = of.weight * threshold_n.iter().sum::<f64>();
        }
        of
    }

    /// Returns the state before the first load.
    #[must_use]
    pub fn initial(&self) -> [f64; OPERATORS] {
        if self.offset_n > 0.0 {
            self.threshold_n
        } else {
            [0.0; OPERATORS]
        }
    }

    /// Advances the state to a force; returns the reading, N.
    #[inline]
    pub fn advance(&self, state: &mut [f64; OPERATORS], force_n: f64) -> f64 {
        let mut sum_n = 0.0;
        for (play_n, threshold_n) in state.iter_mut().zip(self.threshold_n) {
            *play_n = play_n.max(force_n - threshold_n).min(force_n + threshold_n);
            sum_n += *play_n;
        }
        self.direct * force_n + self.weight * sum_n - self.offset_n
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns the readings while the force moves from `from_n` to `to_n` in small steps.
    fn sweep(of: &Hysteresis, state: &mut State, from_n: f64, to_n: f64) -> Vec<f64> {
        let at = |step: u32| from_n + (to_n - from_n) * f64::from(step) / 1000.0;
        (0..=1000).map(|step| of.advance(state, at(step))).collect()
    }

    #[test]
    fn loop_width_is_the_given_share() {
        for (share, full_scale_n) in [(0.05, 1.0), (0.02, 40.0), (0.2, 0.5)] {
            let of = Hysteresis::new(share, full_scale_n, true);
            let width = |peak_n: f64| {
                let mut state = of.initial();
                let loading = sweep(&of, &mut state, 0.0, peak_n);
                let unloading = sweep(&of, &mut state, peak_n, 0.0);
                assert!(unloading[1000].abs() < 1e-12, "closed at zero");
                (
                    (unloading[500] - loading[500]) / peak_n,
                    loading[1000] / peak_n,
                )
            };
            let (full, peak) = width(full_scale_n);
            assert!(
                (full - share).abs() < 1e-9 && (peak - 1.0).abs() < 1e-12,
                "{full} {peak}"
            );
            // Closed form: each threshold adds 2r up to A/4, and A − 2r up to A/2.
            for divisor in [2.0, 3.0, 4.0, 6.0, 8.0, 16.0] {
                let sum = |peak: f64| {
                    let widths = THRESHOLDS.map(|r| (2.0 * r).min(peak - 2.0 * r).max(0.0));
                    widths.iter().sum::<f64>() / peak
                };
                let expected = share * sum(1.0 / divisor) / sum(1.0);
                let (part, _) = width(full_scale_n / divisor);
                assert!(
                    (part - expected).abs() < 1e-9,
                    "1/{divisor}: {part} {expected}"
                );
            }
        }
    }

    #[test]
    fn readings_do_not_depend_on_the_rate() {
        let of = Hysteresis::new(0.05, 1.0, true);
        let (mut fast, mut slow) = (of.initial(), of.initial());
        for (from_n, to_n) in [(0.0, 0.8), (0.8, 0.3), (0.3, 0.5), (0.5, 0.0)] {
            let reading_n = sweep(&of, &mut slow, from_n, to_n)[1000];
            assert!((of.advance(&mut fast, to_n) - reading_n).abs() < 1e-12);
        }
    }

    /// An inner loop that closes leaves no trace (return-point memory).
    #[test]
    fn closed_inner_loops_leave_the_state_unchanged() {
        let of = Hysteresis::new(0.1, 1.0, true);
        let mut state = of.initial();
        let before_n = of.advance(&mut state, 0.7);
        for force_n in [0.4, 0.6, 0.45] {
            of.advance(&mut state, force_n);
        }
        assert!((of.advance(&mut state, 0.7) - before_n).abs() < 1e-12);
    }

    #[test]
    fn shear_is_symmetric_in_sign() {
        let of = Hysteresis::new(0.05, 1.0, false);
        let (mut up, mut down) = (of.initial(), of.initial());
        for force_n in [0.3, -0.5, 0.2, 0.9, 0.0] {
            let sum_n = of.advance(&mut up, force_n) + of.advance(&mut down, -force_n);
            assert!(sum_n.abs() < 1e-12);
        }
    }

    #[test]
    fn zero_share_changes_nothing() {
        let of = Hysteresis::new(0.0, 1.0, true);
        let mut state = of.initial();
        for force_n in [0.0, 0.3, 0.1, 2.0, -1.0] {
            assert!((of.advance(&mut state, force_n) - force_n).abs() < 1e-15);
        }
    }
}
