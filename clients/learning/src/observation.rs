//! Layout of an observation: one row of numbers in named parts. The hand determines their sizes.

use robot_model::HandModel;
use shm_schemas::ModuleId;

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
#[derive(Clone, Debug, PartialEq)]
pub struct Part {
    /// Name.
    pub name: &'static str,
    /// Dimensions, outermost first.
    pub shape: Vec<usize>,
    /// Bounds of the values of the last dimension, repeated cyclically; values beyond are clamped.
    pub bounds: &'static [(f32, f32)],
}

const FORCE_N: (f32, f32) = (-20.0, 20.0);
const OFFSET_M: (f32, f32) = (-0.5, 0.5);
const JOINT: [(f32, f32); 3] = [(-7.0, 7.0), (-50.0, 50.0), (-500.0, 500.0)];
const PERCEPT_BOUNDS: [(f32, f32); PERCEPT] = [
    FORCE_N,
    (0.0, 20.0),
    (0.0, 20.0),
    (0.0, 10.0),
    (0.0, 2.0),
    (0.0, 1.0),
];

/// Parts of the observation of a hand.
#[derive(Clone, Debug, PartialEq)]
pub struct Layout {
    parts: [Part; 5],
    /// Three-axis elements of one fingertip.
    pub(crate) taxels: usize,
}

impl Layout {
    /// Returns the layout for a hand. Parts in order:
    ///
    /// * taxels: forces `[fingertip][taxel][f_n, f_t1, f_t2]`, N
    /// * joints: `[joint][position, velocity, effort]`; rad, rad/s and N·m, or m, m/s and N
    /// * percept: [`PERCEPT`] values per fingertip
    /// * modules: activity of [`MODULES`]
    /// * hand: commanded centre relative to the nominal grasp position (x, y, z), half opening per
    ///   grasp side, target relative to that centre (zero without target), m
    #[must_use]
    pub fn from_hand(hand: &HandModel) -> Self {
        let taxels = hand.skin().layout.layout().count;
        let fingertips = hand.fingertip_count();
        let part = |name, shape, bounds| Part {
            name,
            shape,
            bounds,
        };
        let parts = [
            part("taxels", vec![fingertips, taxels, 3], &[FORCE_N][..]),
            part("joints", vec![hand.joints().len(), 3], &JOINT),
            part("percept", vec![fingertips, PERCEPT], &PERCEPT_BOUNDS),
            part("modules", vec![MODULES.len()], &[(0.0, 1.0)]),
            part("hand", vec![8], &[OFFSET_M]),
        ];
        Self { parts, taxels }
    }

    /// Returns the parts in order.
    #[must_use]
    pub fn parts(&self) -> &[Part; 5] {
        &self.parts
    }

    /// Returns the number of values of an observation.
    #[must_use]
    pub fn size(&self) -> usize {
        self.parts.iter().map(Part::len).sum()
    }

    /// Clamps all values to their bounds; NaN becomes 0.
    pub(crate) fn bound(&self, row: &mut [f32]) {
        let bounds = self.parts.iter().flat_map(Part::each_bound);
        for (value, (low, high)) in row.iter_mut().zip(bounds) {
            *value = if value.is_nan() {
                0.0
            } else {
                value.clamp(low, high)
            };
        }
    }
}

impl Part {
    /// Returns the number of values.
    #[must_use]
    pub fn len(&self) -> usize {
        self.shape.iter().product()
    }

    /// Returns true if it has no values.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Returns the bounds of each value.
    pub fn each_bound(&self) -> impl Iterator<Item = (f32, f32)> + use<> {
        self.bounds.iter().copied().cycle().take(self.len())
    }
}
