//! From the list of modules to everything that must know all of them: their number, their names, their roles, their
//! memories and their evaluation.

/// Declares the modules, each by its file and its type. The order carries no meaning.
macro_rules! modules {
    ($($file:ident::$Type:ident,)*) => {
        /// Number of modules.
        pub const COUNT: usize = IDS.len();

        /// The modules in the order of their proposals. The order carries no meaning.
        pub const IDS: [shm_schemas::ModuleId; [$(stringify!($file)),*].len()] =
            [$(<$file::$Type as Module>::ID),*];

        /// What the rules of tasks must know of each, in the same order.
        pub const ROLES: [Roles; COUNT] = [$(<$file::$Type as Module>::ROLES),*];

        /// The modules of one hand, with their memories.
        #[derive(Clone, Copy, Debug, Default)]
        #[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
        pub struct Modules {
            $($file: $file::$Type,)*
        }

        impl Modules {
            /// Evaluates every selected module; the others propose nothing.
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

            /// Forgets the present object.
            pub fn reset(&mut self) {
                *self = Self::default();
            }

            /// A new step begins: what moves the hand, or waits for the end of the step, starts afresh.
            pub fn restart_step(&mut self) {
                $(if <$file::$Type as Module>::ROLES.forgets_each_step {
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
    fn every_named_module_is_in_the_list_once() {
        for id in ModuleId::ALL.iter().filter(|id| **id != ModuleId::NONE) {
            let times = IDS.iter().filter(|known| *known == id).count();
            assert_eq!(times, 1, "{id}: add its type to the list in modules/mod.rs");
        }
        assert_eq!(IDS.len() + 1, ModuleId::ALL.len());
        assert!(
            IDS.iter().all(|id| id.0 < u32::BITS),
            "a selection has a bit for each"
        );
        // What follows a stream has no path that a step could begin: it goes on from where it is, as fast as it is.
        let walks =
            |id: ModuleId, roles: crate::modules::Roles| roles.moves_hand && id != ModuleId::FOLLOW;
        let movers = IDS
            .iter()
            .zip(ROLES)
            .filter(|(id, roles)| walks(**id, *roles));
        assert!(
            movers.clone().count() > 0
                && movers.into_iter().all(|(_, roles)| roles.forgets_each_step)
        );
    }
}
