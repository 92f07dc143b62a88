//! Layout of an observation: one row of numbers in named parts.

use shm_schemas::ModuleId;

/// Three-axis elements of one fingertip (`dome-41`).
pub const TAXELS: usize = 41;
/// Percept values per fingertip: F_n, F_t, dF_t, N; friction utilisation, friction coefficient,
/// contact (0 or 1).
pub const PERCEPT: usize = 6;
/// Modules whose activity is observed, in order.
pub const MODULES: [ModuleId; 4] = [
    ModuleId::FIRST_TOUCH,
    ModuleId::SLIP,
    ModuleId::FORCE_LIMIT,
    ModuleId::RELAX,
];

/// Part of an observation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Part {
    /// Name.
    pub name: &'static str,
    /// Dimensions, outermost first.
    pub shape: &'static [usize],
    /// Bounds of the values of the last dimension, repeated cyclically; values beyond are clamped.
    pub bounds: &'static [(f32, f32)],
}

const FORCE_N: (f32, f32) = (-20.0, 20.0);
const OFFSET_M: (f32, f32) = (-0.5, 0.5);

/// Parts in order:
///
/// * taxels: forces `[fingertip][taxel][f_n, f_t1, f_t2]`, N
/// * joints: `[joint][position rad, velocity rad/s, effort N·m]`
/// * percept: [`PERCEPT`] values per fingertip
/// * modules: activity of [`MODULES`]
/// * hand: commanded centre relative to the nominal grasp position (x, y, z), half opening per
///   grasp side, target relative to that centre (zero without target), m
pub const PARTS: [Part; 5] = [
    Part {
        name: "taxels",
        shape: &[2, TAXELS, 3],
        bounds: &[FORCE_N],
    },
    Part {
        name: "joints",
        shape: &[11, 3],
        bounds: &[(-7.0, 7.0), (-50.0, 50.0), (-500.0, 500.0)],
    },
    Part {
        name: "percept",
        shape: &[2, PERCEPT],
        bounds: &[
            FORCE_N,
            (0.0, 20.0),
            (0.0, 20.0),
            (0.0, 10.0),
            (0.0, 2.0),
            (0.0, 1.0),
        ],
    },
    Part {
        name: "modules",
        shape: &[MODULES.len()],
        bounds: &[(0.0, 1.0)],
    },
    Part {
        name: "hand",
        shape: &[8],
        bounds: &[OFFSET_M],
    },
];

impl Part {
    /// Returns the number of values.
    #[must_use]
    pub const fn len(&self) -> usize {
        let (mut product, mut n) = (1, 0);
        while n < self.shape.len() {
            product *= self.shape[n];
            n += 1;
        }
        product
    }

    /// Returns true if it has no values.
    #[must_use]
    pub const fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Returns the bounds of each value.
    pub fn each_bound(&self) -> impl Iterator<Item = (f32, f32)> + use<> {
        self.bounds.iter().copied().cycle().take(self.len())
    }
}

/// Number of values of an observation.
pub const SIZE: usize = {
    let (mut sum, mut n) = (0, 0);
    while n < PARTS.len() {
        sum += PARTS[n].len();
        n += 1;
    }
    sum
};

/// Clamps all values to their bounds; NaN becomes 0.
pub(crate) fn bound(row: &mut [f32]) {
    let bounds = PARTS.iter().flat_map(Part::each_bound);
    for (value, (low, high)) in row.iter_mut().zip(bounds) {
        *value = if value.is_nan() {
            0.0
        } else {
            value.clamp(low, high)
        };
    }
}
