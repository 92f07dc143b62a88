//! Yield detection: detects that a pressed object gives way.
//!
//! Fruit flesh loses stiffness before it ruptures. The stiffness is computed over the last window
//! of *force*, not time, so it does not depend on closing speed or sensor rate. Below a share of
//! its maximum, the object yields; the peak force until then is the tolerated force. Detection
//! requires some yield, so it costs force (`atas eval recording` prints how much).

/// Levels of force within the window.
const LEVELS: usize = 20;
/// Smallest divisor of a force difference, m (design choice: resolution of a position sensor).
const CLOSING_MIN_M: f64 = 2e-5;

/// Parameters of yield detection.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct YieldRule {
    /// Force at which detection starts, N: a touch.
    pub from_n: f64,
    /// Window of force for the stiffness, N. Too small: skin roughness looks like rupture. Too
    /// large: a rupture within it is missed.
    pub window_n: f64,
    /// Share of the largest stiffness that means yielding.
    pub share: f64,
}

impl Default for YieldRule {
    /// Common fit to recorded presses of kiwis and mangos (`clients/evaluation/models/`).
    fn default() -> Self {
        Self {
            from_n: 0.3,
            window_n: 1.0,
            share: 0.3,
        }
    }
}

/// Largest force and stiffness of one press.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PressMaxima {
    /// Peak force, N.
    pub peak_n: f64,
    /// Largest stiffness, N/m.
    pub max_stiffness_n_m: f64,
}

/// Yield detector for one press, from touch to release.
#[derive(Clone, Copy, Debug)]
pub struct YieldDetector {
    rule: YieldRule,
    /// Closing at which each force level was first passed, m; a ring buffer.
    passed_m: [f64; LEVELS + 1],
    levels: usize,
    /// Newest force level, N.
    level_n: f64,
    peak_n: f64,
    max_stiffness_n_m: f64,
    yielded: Option<PressMaxima>,
}

impl YieldDetector {
    /// Creates a detector without samples.
    #[must_use]
    pub fn new(rule: YieldRule) -> Self {
        Self {
            rule,
            passed_m: [0.0; LEVELS + 1],
            levels: 0,
            level_n: 0.0,
            peak_n: 0.0,
            max_stiffness_n_m: 0.0,
            yielded: None,
        }
    }

    /// Adds total closing, m, and normal force, N, with equal delay. Values that are not finite are
    /// ignored.
    pub fn add(&mut self, closing_m: f64, force_n: f64) -> Option<PressMaxima> {
        let is_finite = closing_m.is_finite() && force_n.is_finite();
        if self.yielded.is_some() || !is_finite || force_n < self.rule.from_n {
            return self.yielded;
        }
        self.peak_n = self.peak_n.max(force_n);
        self.pass_levels(closing_m, force_n);
        if self.levels > LEVELS {
            let oldest_m = self.passed_m[self.levels % (LEVELS + 1)];
            let oldest_n = self.level_n - self.rule.window_n;
            let stiffness_n_m = (force_n - oldest_n) / (closing_m - oldest_m).max(CLOSING_MIN_M);
            self.max_stiffness_n_m = self.max_stiffness_n_m.max(stiffness_n_m);
            if stiffness_n_m < self.rule.share * self.max_stiffness_n_m {
                self.yielded = Some(self.maxima());
            }
        }
        self.yielded
    }

    /// Returns the maxima so far, with or without yield.
    #[must_use]
    pub fn maxima(&self) -> PressMaxima {
        PressMaxima {
            peak_n: self.peak_n,
            max_stiffness_n_m: self.max_stiffness_n_m,
        }
    }

    fn pass_levels(&mut self, closing_m: f64, force_n: f64) {
        let step_n = self.rule.window_n / LEVELS as f64;
        // A jump beyond the window has no usable stiffness.
        if self.levels == 0 || force_n - self.level_n > self.rule.window_n {
            self.levels = 0;
            self.level_n = force_n - step_n;
        }
        for _ in 0..=LEVELS {
            if force_n < self.level_n + step_n {
                break;
            }
            self.level_n += step_n;
            self.passed_m[self.levels % (LEVELS + 1)] = closing_m;
            self.levels += 1;
        }
    }
}
