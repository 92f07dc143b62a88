//! What a policy is told, as one row of numbers in parts with names.

use shm_schemas::ModuleId;

/// Three-axis elements of one fingertip (`dome-41`).
pub const TAXELS: usize = 41;
/// What perception says of one finger: F_n N, F_t N, dF_t N, friction utilisation, friction coefficient, 1 while it touches.
pub const PERCEPT: usize = 6;
/// The modules whose activity is told, in order.
pub const MODULES: [ModuleId; 4] = [
    ModuleId::FIRST_TOUCH,
    ModuleId::SLIP,
    ModuleId::FORCE_LIMIT,
    ModuleId::RELAX,
];

/// A part of an observation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Part {
    /// Its name.
    pub name: &'static str,
    /// Its dimensions, from the outermost.
    pub shape: &'static [usize],
    /// Bounds of its last dimension's numbers, in turn; what is beyond is told as the bound.
    pub bounds: &'static [(f32, f32)],
}

/// Force of one element along one axis, N.
const FORCE_N: (f32, f32) = (-20.0, 20.0);
/// An offset of the hand, m.
const OFFSET_M: (f32, f32) = (-0.5, 0.5);

/// The parts, in order: forces of the taxels `[finger][taxel][f_n, f_t1, f_t2]`, N; joints of the hand `[position rad,
/// velocity rad/s, effort N·m][joint]`; [`PERCEPT`]; activity of [`MODULES`]; the commanded centre of the hand from the nominal
/// place of the grasp (x, y, z, m), the half opening of each finger, m, and the object's place from that centre, m (zero
/// where it has none).
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
    /// How many numbers it has.
    #[must_use]
    pub const fn len(&self) -> usize {
        let (mut product, mut n) = (1, 0);
        while n < self.shape.len() {
            product *= self.shape[n];
            n += 1;
        }
        product
    }

    /// Whether it has none.
    #[must_use]
    pub const fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The bounds of each of its numbers.
    pub fn each_bound(&self) -> impl Iterator<Item = (f32, f32)> + use<> {
        self.bounds.iter().copied().cycle().take(self.len())
    }
}

/// Numbers of one observation.
pub const SIZE: usize = {
    let (mut sum, mut n) = (0, 0);
    while n < PARTS.len() {
        sum += PARTS[n].len();
        n += 1;
    }
    sum
};

/// Cuts every number to its bounds; what is not a number is told as zero.
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
