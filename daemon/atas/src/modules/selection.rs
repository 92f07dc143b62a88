//! Sets of modules.

use shm_schemas::ModuleId;

/// Modules that a step of a task selects.
///
/// ```
/// use atas_core::modules::Selection;
/// use shm_schemas::ModuleId;
///
/// let grip = Selection::from_modules(&[ModuleId::SLIP, ModuleId::FORCE_LIMIT]);
/// assert!(grip.contains(ModuleId::SLIP) && !grip.contains(ModuleId::RELAX));
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Selection(u32);

impl Selection {
    /// Creates a selection from module names.
    #[must_use]
    pub const fn from_modules(modules: &[ModuleId]) -> Self {
        let mut bits = 0;
        let mut i = 0;
        while i < modules.len() {
            bits |= 1 << modules[i].0;
            i += 1;
        }
        Self(bits)
    }

    /// No modules.
    pub const NONE: Self = Self(0);

    /// Returns the union of both selections.
    #[must_use]
    pub const fn union(self, more: Self) -> Self {
        Self(self.0 | more.0)
    }

    /// Returns whether the selection contains a module.
    #[must_use]
    pub const fn contains(self, module: ModuleId) -> bool {
        self.0 >> module.0 & 1 == 1
    }
}
