//! Macro that generates the module count, names, roles, state and evaluation from one list.

/// Declares the modules by file and type. The order has no effect.
macro_rules! modules {
    ($($file:ident::$Type:ident,)*) => {
        /// Number of modules.
        pub const COUNT: usize = IDS.len();

        /// Module names in the order of their proposals.
        pub const IDS: [shm_schemas::ModuleId; [$(stringify!($file)),*].len()] =
            [$(<$file::$Type as Module>::ID),*];

        /// Roles in the order of `IDS`.
        pub const ROLES: [Roles; COUNT] = [$(<$file::$Type as Module>::ROLES),*];

        /// State of all modules of one hand.
        #[derive(Clone, Copy, Debug, Default)]
        #[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
        pub struct Modules {
            $($file: $file::$Type,)*
        }

        impl Modules {
            /// Evaluates every selected module; the others return an empty proposal.
            pub fn evaluate(
                &mut self,
                selection: Selection,
                percept: &crate::perception::Percept,
                context: &Context<'_>,
            ) -> [Proposal; COUNT] {
                [$(if selection.contains(<$file::$Type as Module>::ID) {
                    self.$file.evaluate(percept, context)
                } else {
                    Proposal::default()
                }),*]
            }

            /// Resets all modules.
            pub fn reset(&mut self) {
                *self = Self::default();
            }

            /// Resets the modules whose role is `resets_each_step`.
            pub fn restart_step(&mut self) {
                $(if <$file::$Type as Module>::ROLES.resets_each_step {
                    self.$file = $file::$Type::default();
                })*
            }
        }
    };
}
pub(super) use modules;

#[cfg(test)]
mod tests {
    use crate::modules::{IDS, ROLES};
    use shm_schemas::ModuleId;

    #[test]
    fn every_module_id_is_listed_once() {
        for id in ModuleId::ALL.iter().filter(|id| **id != ModuleId::NONE) {
            let times = IDS.iter().filter(|known| *known == id).count();
            assert_eq!(times, 1, "{id}: add its type to the list in modules/mod.rs");
        }
        assert_eq!(IDS.len() + 1, ModuleId::ALL.len());
        assert!(
            IDS.iter().all(|id| id.0 < u32::BITS),
            "a selection has one bit per module"
        );
        // Teleoperation has no path and continues its motion across steps.
        let walks =
            |id: ModuleId, roles: crate::modules::Roles| roles.moves_hand && id != ModuleId::TELEOP;
        let movers = IDS
            .iter()
            .zip(ROLES)
            .filter(|(id, roles)| walks(**id, *roles));
        assert!(
            movers.clone().count() > 0
                && movers.into_iter().all(|(_, roles)| roles.resets_each_step)
        );
    }
}
