//! Reduced perception for a symmetric pinch (`daemon/atas/src/perception/`). Constants without a
//! comment are the controller's defaults.

use crate::lanes::{Lanes, Mask};
use crate::skin::{ELEMENTS, RINGS};
use crate::trial::Bit;

/// Tick, s.
pub(crate) const TICK_S: f32 = 1e-3;
/// Sampling interval of the dF_t window, ticks, and its length.
const SAMPLE_TICKS: usize = 10;
const SAMPLES: usize = 10;
/// Standard deviation of a patch's filtered force noise, N. Derived from 3 mN per element, 5 ms,
/// ten elements.
const NOISE_N: f32 = 0.003;
/// Overestimate of the highest third of the elements: factor (gain spread), and N per N (noise).
/// Fitted to the full simulation's utilisation at gross slip.
const TOP_SHARE: f32 = 1.05;
const TOP_NOISE_N: f32 = 0.0003;

const FORCE_SHARE: f32 = TICK_S / (0.005 + TICK_S);
const FRICTION_SHARE: f32 = TICK_S / (0.02 + TICK_S);
const RELAX_SHARE: f32 = TICK_S / (0.05 + TICK_S);
const RATIO_SHARE: f32 = TICK_S / (0.03 + TICK_S);
const TOUCH_ON_N: f32 = 0.06;
const TOUCH_OFF_N: f32 = 0.03;
const ELEMENT_FLOOR_N: f32 = 0.012;
const TANGENTIAL_FLOOR_N: f32 = 0.04;
const DR_N: f32 = 0.06;
const SLIP_ON: f32 = 0.92;
const SLIP_OFF: f32 = 0.86;
const SLIP_GROSS: f32 = 0.955;
const SLIP_GROSS_S: f32 = 0.01;
const SLIP_LOADING: f32 = 0.8;
const SLIP_LATCH_S: f32 = 0.02;
const GROSS_SLIP_END: f32 = 0.9;
const SLIDING_SHARE: f32 = 0.96;
const RELEASE_SHARE_F2: f32 = 0.97;
const LIFTED_M: f32 = 0.003;
const LOW_UTILISATION: f32 = 0.91;
const LOW_UTILISATION_S: f32 = 0.1;

#[derive(Clone, Copy, Debug)]
pub(crate) struct Percept<const N: usize> {
    normal_by_ring_n: [Lanes<N>; RINGS],
    shear_by_ring_n: [Lanes<N>; RINGS],
    /// Ring forces after the friction filter.
    steady_normal_n: [Lanes<N>; RINGS],
    steady_shear_n: [Lanes<N>; RINGS],
    /// Measured F_n and F_t, N.
    pub(crate) normal_n: Lanes<N>,
    tangential_n: Lanes<N>,
    /// Highest friction estimate; utilisation relative to it and to the current estimate.
    friction_estimate: Lanes<N>,
    utilisation: Lanes<N>,
    utilisation_now: Lanes<N>,
    gross_s: Lanes<N>,
    /// Low-passed F_t/F_n, and its maximum during this gross slip.
    ratio: Lanes<N>,
    peak_ratio: Lanes<N>,
    window_n: [Lanes<N>; SAMPLES],
    oldest: usize,
    touching: Mask<N>,
    slipping: Mask<N>,
    latch_s: Lanes<N>,
    above_f2: Mask<N>,
    low_utilisation_s: Lanes<N>,
}

impl<const N: usize> Percept<N> {
    #[inline(always)]
    pub(crate) fn new() -> Self {
        let zero = Lanes::splat(0.0);
        Self {
            normal_by_ring_n: [zero; RINGS],
            shear_by_ring_n: [zero; RINGS],
            steady_normal_n: [zero; RINGS],
            steady_shear_n: [zero; RINGS],
            normal_n: zero,
            tangential_n: zero,
            friction_estimate: zero,
            utilisation: zero,
            utilisation_now: zero,
            gross_s: zero,
            ratio: zero,
            peak_ratio: zero,
            window_n: [zero; SAMPLES],
            oldest: 0,
            touching: Mask::NONE,
            slipping: Mask::NONE,
            latch_s: zero,
            above_f2: Mask::NONE,
            low_utilisation_s: zero,
        }
    }

    /// Updates from true forces; `noise` has a standard deviation of 1.
    #[inline(always)]
    pub(crate) fn update(
        &mut self,
        normal_n: &[Lanes<N>; RINGS],
        shear_n: &[Lanes<N>; RINGS],
        noise: [Lanes<N>; 2],
        tick: usize,
    ) {
        let zero = Lanes::splat(0.0);
        let (mut sum_n, mut sum_t) = (zero, zero);
        for (measured, normal_n) in self.normal_by_ring_n.iter_mut().zip(normal_n) {
            *measured = measured.towards(*normal_n, FORCE_SHARE);
            sum_n = sum_n + *measured;
        }
        for (measured, shear_n) in self.shear_by_ring_n.iter_mut().zip(shear_n) {
            *measured = measured.towards(*shear_n, FORCE_SHARE);
            sum_t = sum_t + *measured;
        }
        self.normal_n = sum_n + noise[0] * NOISE_N;
        self.tangential_n = (sum_t + noise[1] * NOISE_N).abs();
        self.touching =
            self.normal_n.above(TOUCH_ON_N) | (self.touching & self.normal_n.above(TOUCH_OFF_N));
        self.update_friction();
        if tick.is_multiple_of(SAMPLE_TICKS) {
            self.window_n[self.oldest] = self.tangential_n;
            self.oldest = (self.oldest + 1) % SAMPLES;
        }
    }

    /// Utilisation S from the ring with the highest ratio (`friction.rs`), without the single
    /// centre element.
    #[inline(always)]
    fn update_friction(&mut self) {
        let zero = Lanes::splat(0.0);
        for (steady, measured) in [
            (&mut self.steady_normal_n, &self.normal_by_ring_n),
            (&mut self.steady_shear_n, &self.shear_by_ring_n),
        ] {
            for (steady, measured) in steady.iter_mut().zip(measured) {
                *steady = steady.towards(*measured, FRICTION_SHARE);
            }
        }
        let (mut top, mut pressed) = (zero, Mask::NONE);
        let rings = self.steady_normal_n.iter().zip(&self.steady_shear_n);
        for ((n, t), elements) in rings.zip(ELEMENTS).skip(1) {
            let (n, t) = (*n, t.abs());
            let presses = n.above(ELEMENT_FLOOR_N * elements);
            let element_n = n * (1.0 / elements);
            let ratio = t / (n + f32::MIN_POSITIVE) * TOP_SHARE
                + Lanes::splat(TOP_NOISE_N) / (element_n + ELEMENT_FLOOR_N);
            top = presses.select(ratio.greater(top), top);
            pressed = pressed | presses;
        }
        let known = pressed & self.tangential_n.above(TANGENTIAL_FLOOR_N);
        let ratio = self.tangential_n / (self.normal_n.greater(zero) + 0.01);
        let reading = top.lesser(Lanes::splat(1.2));
        let now = ratio / reading.greater(Lanes::splat(0.03));
        let now = self.utilisation_now.towards(now, FRICTION_SHARE);
        self.utilisation_now = known.select(now, self.utilisation_now);
        let measured = self.ratio.towards(ratio, RATIO_SHARE);
        self.ratio = known.select(measured, self.ratio);
        let alike = known & self.utilisation_now.above(SLIP_GROSS);
        let ended = known & self.utilisation_now.below(GROSS_SLIP_END);
        let slid_from = alike.select(self.peak_ratio.greater(self.ratio), self.peak_ratio);
        self.peak_ratio = ended.select(zero, slid_from);
        let gross = alike & self.ratio.gt(self.peak_ratio * SLIDING_SHARE);
        self.gross_s = gross.select(self.gross_s + TICK_S, zero);
        let reading = known.select(reading, zero);
        let remembered = self.friction_estimate.greater(reading);
        let relaxed = remembered.towards(ratio, RELAX_SHARE);
        let remembered = self.gross_s.above(SLIP_GROSS_S).select(relaxed, remembered);
        // Reset after loss of contact.
        self.friction_estimate = self.touching.select(remembered, zero);
        let utilisation = ratio / self.friction_estimate.greater(Lanes::splat(0.05));
        self.utilisation = known.select(utilisation.lesser(Lanes::splat(1.2)), zero);
    }

    /// Updates bits with memory. Without lift verification the object never counts as suspended.
    #[inline(always)]
    pub(crate) fn update_bits(&mut self, f2_n: Lanes<N>) {
        let zero = Lanes::splat(0.0);
        let released_n = self.above_f2.select(f2_n * RELEASE_SHARE_F2, f2_n);
        self.above_f2 = self.normal_n.gt(released_n);
        let limit = self
            .slipping
            .select(Lanes::splat(SLIP_OFF), Lanes::splat(SLIP_ON));
        self.slipping = self.utilisation.gt(limit);
        let increment_n = (self.tangential_n - self.window_n[self.oldest]).abs();
        let loads = increment_n.above(DR_N) & self.utilisation.above(SLIP_LOADING);
        let slips = self.slipping | self.gross_s.above(SLIP_GROSS_S) | loads;
        self.latch_s = slips.select(Lanes::splat(SLIP_LATCH_S), self.latch_s - TICK_S);
        let spares = self.utilisation.above(0.0)
            & self.utilisation.below(LOW_UTILISATION)
            & !self.gross_s.above(0.0)
            & !slips;
        self.low_utilisation_s = spares.select(self.low_utilisation_s + TICK_S, zero);
    }

    #[inline(always)]
    pub(crate) fn bit(&self, bit: Bit, f1_n: Lanes<N>, carried_m: Lanes<N>) -> Mask<N> {
        match bit {
            Bit::Touching => self.touching,
            Bit::AboveF1 => self.normal_n.gt(f1_n),
            Bit::Slipping => self.latch_s.above(0.0),
            Bit::AboveF2 => self.above_f2,
            Bit::Lifted => carried_m.above(LIFTED_M),
            Bit::Spare => self.low_utilisation_s.above(LOW_UTILISATION_S),
        }
    }

    /// Lanes in which F_n exceeds F_2, with Module 3's hysteresis.
    #[inline(always)]
    pub(crate) fn is_above_f2(&self) -> Mask<N> {
        self.above_f2
    }
}
