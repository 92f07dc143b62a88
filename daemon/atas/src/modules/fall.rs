//! Drop detector: detects a sudden decrease of the load of a suspended object, without a friction
//! coefficient.

/// Decrease that counts as dropping: share, and minimum in N (design choice: well above hand
/// vibration).
const FALL_SHARE: f64 = 0.04;
const FALL_FLOOR_N: f64 = 0.02;
/// Standard deviations of its scatter that the decrease must exceed (design choice: at 3.5, light
/// objects give a false alarm in one of ten holds).
const SCATTER_MARGIN: f64 = 4.5;
/// Time constant of the present load, s (design choice: a few frames of noise).
const FELT_S: f64 = 0.02;
/// Time constant of the reference load, s (design choice: longer than a drop).
const BELIEVED_S: f64 = 0.7;
/// Time until the load is known, s (design choice: swing after a pull-back).
const SETTLING_S: f64 = 0.3;

#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Fall {
    load: Option<Load>,
}

#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
struct Load {
    felt_n: f64,
    believed_n: f64,
    /// Variance of the present load around the reference while nothing drops, N².
    scatter_n2: f64,
    /// Time since the object is suspended, s.
    hung_s: f64,
    falling: bool,
}

impl Fall {
    /// Updates with the vertical load, N, and the sensor time, s; `None` without a suspended
    /// object. Returns true while it drops; a drop cannot start while the hand shakes it.
    pub(super) fn follow(&mut self, down_n: Option<f64>, shaken: bool, step_s: f64) -> bool {
        let Some(down_n) = down_n else {
            self.load = None;
            return false;
        };
        let load = self.load.get_or_insert(Load::begin(down_n));
        load.follow(down_n, step_s);
        load.falling = load.has_fallen() && (load.falling || !shaken);
        load.falling
    }
}

impl Load {
    fn begin(down_n: f64) -> Self {
        let scatter_n = FALL_SHARE / 2.0 * down_n;
        Self {
            felt_n: down_n,
            believed_n: down_n,
            scatter_n2: scatter_n * scatter_n,
            hung_s: 0.0,
            falling: false,
        }
    }

    fn follow(&mut self, down_n: f64, step_s: f64) {
        self.hung_s += step_s;
        // During the first time constant, all samples count equally.
        let hung_s = self.hung_s;
        let share = |filter_s: f64| step_s / (filter_s.min(hung_s) + step_s);
        self.felt_n += (down_n - self.felt_n) * share(FELT_S);
        self.believed_n += (down_n - self.believed_n) * share(BELIEVED_S);
        if !self.has_fallen() {
            let off_n = self.felt_n - self.believed_n;
            self.scatter_n2 += (off_n * off_n - self.scatter_n2) * share(BELIEVED_S);
        }
    }

    fn has_fallen(&self) -> bool {
        let limit_n = FALL_FLOOR_N
            .max(FALL_SHARE * self.believed_n)
            .max(SCATTER_MARGIN * libm::sqrt(self.scatter_n2));
        self.hung_s > SETTLING_S && self.believed_n - self.felt_n > limit_n
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns the number of dropping ticks within 200 ms, after one second at 2 N.
    fn falls(shaken: bool, load_n: impl Fn(usize) -> f64) -> usize {
        let mut fall = Fall::default();
        for tick in 0..1000 {
            let before = fall.follow(Some(2.0 + 0.01 * (tick % 2) as f64), false, 1e-3);
            assert!(!before, "steady");
        }
        (0..200)
            .filter(|tick| fall.follow(Some(load_n(*tick)), shaken, 1e-3))
            .count()
    }

    #[test]
    fn what_the_hand_suddenly_carries_less_of_falls() {
        assert!(
            falls(false, |_| 1.8) > 150,
            "kinetic friction carries a tenth less"
        );
        assert_eq!(
            falls(false, |tick| 2.0 + 0.002 * tick as f64),
            0,
            "a growing load"
        );
        assert_eq!(falls(false, |_| 1.97), 0, "a tremble");
        assert_eq!(falls(true, |_| 1.8), 0, "the hand itself shakes it");
        assert!(!Fall::default().follow(None, false, 1e-3));
    }

    /// Sponge at twice the usual sensor noise: the load scatters by a tenth of the weight.
    #[test]
    fn the_noise_of_a_light_object_does_not_fall() {
        let falls_in = |seed: u64| {
            let (mut fall, mut state, mut filtered_n) = (Fall::default(), seed, 0.13);
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
                    fall.follow(Some(filtered_n), false, 1e-3)
                })
                .count()
        };
        for seed in 1..=100 {
            assert_eq!(falls_in(seed), 0, "seed {seed}");
        }
    }
}
