//! Wire form of a [`crate::Reason`].

use crate::cause::Cause;
use crate::module::ModuleId;
use crate::payload::payload;
use iceoryx2_bb_elementary_traits::zero_copy_send::ZeroCopySend;

payload! {
    /// A cause with its module, value and limit.
    ReasonRecord as "atas.Reason.v1" {
        /// The cause.
        pub cause: Cause,
        /// The module that reports it; [`ModuleId::NONE`] outside the modules.
        pub module: ModuleId,
        /// Value that violates the limit, in the unit that [`crate::Reason`]'s `Display` prints.
        pub value: f64,
        /// The violated limit.
        pub limit: f64,
        /// Index of the field, joint, fingertip or hand; the meaning depends on the cause.
        pub index: u32,
        /// Written as zero.
        pub pad: u32,
    }
}

impl ReasonRecord {
    /// Returns true if the cause is not [`Cause::NONE`].
    #[must_use]
    pub fn is_some(&self) -> bool {
        self.cause != Cause::NONE
    }
}
