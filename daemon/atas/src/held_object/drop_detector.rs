//! Drop detector: detects a sudden decrease of the load of a suspended object, without a friction
//! coefficient.
//!
//! Sliding friction is lower than static friction, so the load of an object that slides falls, but
//! not by half. A load that falls by more is carried by something else, such as a person's hand.

/// Decrease that counts as dropping: share, and minimum in N (design choice: well above hand
/// vibration).
const DROP_SHARE: f64 = 0.04;
const DROP_MIN_N: f64 = 0.02;
/// Decrease beyond which the object does not slide but is carried: share (design choice: kinetic
/// friction is more than half of static friction).
const CARRIED_SHARE: f64 = 0.5;
/// Standard deviations of its scatter that the decrease must exceed (design choice: at 3.5, light
/// objects give a false alarm in one of ten holds).
const SCATTER_MARGIN: f64 = 4.5;
/// Time constant of the present load, s (design choice: a few frames of noise).
const FILTER_S: f64 = 0.02;
/// Time constant of the reference load, s (design choice: longer than a drop).
const REFERENCE_S: f64 = 0.7;
/// Time until the load is known, s (design choice: swing after a pull-back).
const SETTLING_S: f64 = 0.3;

#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct DropDetector {
    load: Option<Load>,
}

#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
struct Load {
    filtered_n: f64,
    reference_n: f64,
    /// Variance of the present load around the reference while nothing drops, N².
    scatter_n2: f64,
    /// Time since the object is suspended, s.
    suspended_s: f64,
    dropping: bool,
}

impl DropDetector {
    /// Updates with the vertical load, N, and the sensor time, s; `None` without a suspended
    /// object. Returns true while it drops; a drop cannot start while the hand shakes it.
    pub(super) fn update(&mut self, down_n: Option<f64>, shaken: bool, step_s: f64) -> bool {
        let Some(down_n) = down_n else {
            self.load = None;
            return false;
        };
        let load = self.load.get_or_insert(Load::new(down_n));
        load.update(down_n, step_s);
        load.dropping = load.has_dropped() && (load.dropping || !shaken);
        load.dropping
    }
}

impl Load {
    fn new(down_n: f64) -> Self {
        let scatter_n = DROP_SHARE / 2.0 * down_n;
        Self {
            filtered_n: down_n,
            reference_n: down_n,
            scatter_n2: scatter_n * scatter_n,
            suspended_s: 0.0,
            dropping: false,
        }
    }

    fn update(&mut self, down_n: f64, step_s: f64) {
        self.suspended_s += step_s;
        // During the first time constant, all samples count equally.
        let hung_s = self.suspended_s;
        let share = |filter_s: f64| step_s / (filter_s.min(hung_s) + step_s);
        self.filtered_n += (down_n - self.filtered_n) * share(FILTER_S);
        self.reference_n += (down_n - self.reference_n) * share(REFERENCE_S);
        if !self.has_dropped() {
            let off_n = self.filtered_n - self.reference_n;
            self.scatter_n2 += (off_n * off_n - self.scatter_n2) * share(REFERENCE_S);
        }
    }

    fn has_dropped(&self) -> bool {
        let limit_n = DROP_MIN_N
            .max(DROP_SHARE * self.reference_n)
            .max(SCATTER_MARGIN * libm::sqrt(self.scatter_n2));
        let decrease_n = self.reference_n - self.filtered_n;
        let slides = decrease_n > limit_n && decrease_n < CARRIED_SHARE * self.reference_n;
        self.suspended_s > SETTLING_S && slides
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns the number of dropping ticks within 200 ms, after one second at 2 N.
    fn dropping_ticks(shaken: bool, load_n: impl Fn(usize) -> f64) -> usize {
        let mut fall = DropDetector::default();
        for tick in 0..1000 {
            let before = fall.update(Some(2.0 + 0.01 * (tick % 2) as f64), false, 1e-3);
            assert!(!before, "steady");
        }
        (0..200)
            .filter(|tick| fall.update(Some(load_n(*tick)), shaken, 1e-3))
            .count()
    }

    #[test]
    fn sudden_load_loss_is_dropping() {
        assert!(
            dropping_ticks(false, |_| 1.8) > 150,
            "kinetic friction is a tenth lower"
        );
        assert_eq!(
            dropping_ticks(false, |tick| 2.0 + 0.002 * tick as f64),
            0,
            "growing load"
        );
        assert_eq!(dropping_ticks(false, |_| 1.97), 0, "vibration");
        assert_eq!(dropping_ticks(true, |_| 1.8), 0, "load shaken by the hand");
        let lifted_off = dropping_ticks(false, |_| 0.0);
        assert!(lifted_off < 20, "carried by something else: {lifted_off}");
        assert!(!DropDetector::default().update(None, false, 1e-3));
    }

    /// Sponge at twice the usual sensor noise: the load scatters by a tenth of the weight.
    #[test]
    fn light_object_noise_is_not_dropping() {
        let falls_in = |seed: u64| {
            let (mut fall, mut state, mut filtered_n) = (DropDetector::default(), seed, 0.13);
            let mut random = || {
                state = state
                    .wrapping_mul(6_364_136_223_846_793_005)
                    .wrapping_add(seed | 1);
                (state >> 33) as f64 / f64::from(1_u32 << 31) - 0.5
            };
            (0..10_000)
                .filter(|_| {
                    let noise_n = 0.05 * (0..4).map(|_| random()).sum::<f64>();
                    filtered_n += (0.13 + noise_n - filtered_n) / 6.0;
                    fall.update(Some(filtered_n), false, 1e-3)
                })
                .count()
        };
        for seed in 1..=100 {
            assert_eq!(falls_in(seed), 0, "seed {seed}");
        }
    }

    #[test]
    fn filters_average_all_samples_at_first() {
        let mut load = Load::new(2.0);
        let (mut filtered_n, mut reference_n, mut scatter_n2) = (2.0, 2.0, 0.0016);
        for tick in 1..=1500_u32 {
            let down_n = if tick < 800 {
                2.0 + 0.1 * f64::from(tick % 3)
            } else {
                1.7
            };
            let before_drops = load.has_dropped();
            load.update(down_n, 1e-3);
            let hung_s = f64::from(tick) * 1e-3;
            let toward = |value: f64, to: f64, filter_s: f64| {
                let weight = 1e-3 / (hung_s.min(filter_s) + 1e-3);
                value * (1.0 - weight) + to * weight
            };
            filtered_n = toward(filtered_n, down_n, FILTER_S);
            reference_n = toward(reference_n, down_n, REFERENCE_S);
            assert!((load.filtered_n - filtered_n).abs() < 1e-9, "{tick}");
            assert!((load.reference_n - reference_n).abs() < 1e-9, "{tick}");
            let off_n = filtered_n - reference_n;
            let after_n2 = toward(scatter_n2, off_n * off_n, REFERENCE_S);
            // The scatter does not grow during a drop.
            let kept = (load.scatter_n2 - scatter_n2).abs() < 1e-12;
            let updated = (load.scatter_n2 - after_n2).abs() < 1e-9;
            assert!(kept || updated, "{tick}");
            assert!(updated || before_drops || load.has_dropped(), "{tick}");
            scatter_n2 = load.scatter_n2;
        }
        assert!(load.has_dropped());
    }

    #[test]
    fn drop_is_a_decrease_between_its_limits() {
        for (reference_n, filtered_n, scatter_n, suspended_s, drops) in [
            // At least 0.02 N, 4 % and 4.5 standard deviations, but less than half.
            (0.25, 0.23, 0.0, 1.0, false),
            (0.25, 0.22, 0.0, 1.0, true),
            (2.0, 1.925, 0.0, 1.0, false),
            (2.0, 1.91, 0.0, 1.0, true),
            (2.0, 1.5, 0.125, 1.0, false),
            (2.0, 1.5, 0.1, 1.0, true),
            (2.0, 1.4375, 0.125, 1.0, false),
            (2.0, 1.43, 0.125, 1.0, true),
            (2.0, 1.0, 0.0, 1.0, false),
            (2.0, 1.01, 0.0, 1.0, true),
            (2.0, 1.5, 0.0, 0.3, false),
            (2.0, 1.5, 0.0, 0.31, true),
        ] {
            let load = Load {
                reference_n,
                filtered_n,
                scatter_n2: scatter_n * scatter_n,
                suspended_s,
                dropping: false,
            };
            assert_eq!(load.has_dropped(), drops, "{load:?}");
        }
    }
}
