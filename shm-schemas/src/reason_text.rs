//! Formats a [`Reason`] as one sentence: what failed, value and limit, what to do.

use crate::module::ModuleId;
use crate::reason::Reason;
use crate::reason_parts::{JointLabel, Joints};
use crate::reason_record::ReasonRecord;
use core::fmt::{self, Display, Formatter};

/// Text of a reason, with the label of its joint if known; otherwise with the joint's index.
#[derive(Clone, Copy, Debug)]
pub struct ReasonText<'a> {
    record: ReasonRecord,
    joints: Joints<'a>,
}

impl ReasonRecord {
    /// Returns the text of the reason; `joint` labels the joint of [`Reason::joint`].
    #[must_use]
    pub fn text<'a>(&self, joint: Option<JointLabel<'a>>) -> ReasonText<'a> {
        ReasonText {
            record: *self,
            joints: Joints(joint),
        }
    }
}

impl Display for Reason {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        ReasonRecord::from(*self).fmt(f)
    }
}

impl Display for ReasonRecord {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        self.text(None).fmt(f)
    }
}

impl Display for ReasonText<'_> {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        Reason::from(self.record).write(self.joints, f)?;
        // The record, because a newer daemon may attribute further reasons to modules.
        match self.record.module {
            ModuleId::NONE => Ok(()),
            module => write!(f, " ({module})"),
        }
    }
}
