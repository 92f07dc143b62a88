//! Yielding: whether what is pressed gives way.
//!
//! Flesh that is about to rupture loses its stiffness first. The stiffness is read over the last window of *force*, not of
//! time, so that it means the same at every closing speed and sensor rate. Once it has fallen below a share of the stiffest
//! that was felt, the object yields, and the greatest force before tells how much it could bear.
//!
//! It costs force: it is known only after the object has begun to give way (`atas eval recording` says how far beyond).

/// Levels of force within the window.
const LEVELS: usize = 20;
/// Least closing that a stiffness is divided by, m (ours: what a position sensor resolves).
const CLOSING_MIN_M: f64 = 2e-5;

/// When something counts as giving way.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct YieldRule {
    /// Force at which watching begins, N: a touch.
    pub from_n: f64,
    /// Window of force over which the stiffness is read, N. Too small: the roughness of a skin looks like a rupture. Too
    /// large: what ruptures within it is missed.
    pub window_n: f64,
    /// Share of the stiffest below which the object yields.
    pub share: f64,
}

impl Default for YieldRule {
    /// Fitted on recorded presses of kiwis and mangos; what they share (`clients/evaluation/models/`).
    fn default() -> Self {
        Self {
            from_n: 0.3,
            window_n: 1.0,
            share: 0.3,
        }
    }
}

/// What an object bore before it gave way.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Yielded {
    /// Greatest force until then, N.
    pub peak_n: f64,
    /// The stiffest that was felt, N/m.
    pub stiffest_n_m: f64,
}

/// The memory of one press, from touch to letting go.
#[derive(Clone, Copy, Debug)]
pub struct YieldWatch {
    rule: YieldRule,
    /// Closing at which each level of force was passed first, m; a ring.
    passed_m: [f64; LEVELS + 1],
    levels: usize,
    /// Force of the newest level, N.
    level_n: f64,
    peak_n: f64,
    stiffest_n_m: f64,
    yielded: Option<Yielded>,
}

impl YieldWatch {
    /// Nothing is pressed yet.
    #[must_use]
    pub fn new(rule: YieldRule) -> Self {
        Self {
            rule,
            passed_m: [0.0; LEVELS + 1],
            levels: 0,
            level_n: 0.0,
            peak_n: 0.0,
            stiffest_n_m: 0.0,
            yielded: None,
        }
    }

    /// Takes in one frame: total closing, m, and normal force, N, both as late as each other. What is not finite is left out.
    pub fn add(&mut self, closing_m: f64, force_n: f64) -> Option<Yielded> {
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
            self.stiffest_n_m = self.stiffest_n_m.max(stiffness_n_m);
            if stiffness_n_m < self.rule.share * self.stiffest_n_m {
                self.yielded = Some(self.borne());
            }
        }
        self.yielded
    }

    /// What it bore so far, whether it gave way or not.
    #[must_use]
    pub fn borne(&self) -> Yielded {
        Yielded {
            peak_n: self.peak_n,
            stiffest_n_m: self.stiffest_n_m,
        }
    }

    fn pass_levels(&mut self, closing_m: f64, force_n: f64) {
        let step_n = self.rule.window_n / LEVELS as f64;
        // A jump beyond the whole window says nothing about stiffness: the window begins anew.
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
