//! Formats reasons about streamed targets; see `reason_text` for all others.

use crate::reason::{Cause, Reason};
use crate::stamp::Hand;
use crate::target::GraspTarget;
use crate::units::target_value_with_unit;
use core::fmt::{self, Formatter};

impl Reason {
    /// Formats a fault of a target stream.
    pub(crate) fn write_target(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let Self {
            value,
            limit,
            index,
            ..
        } = *self;
        let name = GraspTarget::VALUE_NAMES.get(index as usize).copied();
        let name = name.unwrap_or("a value");
        match self.cause {
            Cause::TARGETS_STOPPED => write!(
                f,
                "the last target of the {} hand has expired; the hand stops and keeps its grip \
                 until the next one",
                Hand(index)
            ),
            Cause::TARGET_CORRUPT => f.write_str(
                "a target failed its checksum; compute the \
                checksum last",
            ),
            Cause::TARGET_FOREIGN => f.write_str(
                "a target comes from a writer other than the client of the goal; send the writer \
                 epoch of the goal request",
            ),
            Cause::TARGET_STALE => write!(
                f,
                "a target came {:.1} ms too late, or out of order; stamp it with CLOCK_MONOTONIC, \
                 increase its sequence, and set valid_until_ns in the future",
                value * 1e-6
            ),
            Cause::TARGET_UNKNOWN => write!(
                f,
                "a target names a hand or a grip command ({value}) that its goal does not have; \
                 check the goal's kind and hand"
            ),
            Cause::TARGET_NOT_FINITE => {
                write!(f, "{name} of a target is not finite; send finite numbers")
            }
            Cause::TARGET_OUT_OF_RANGE => write!(
                f,
                "{name} of a target is {}, the limit is {}; the hand keeps its previous target",
                target_value_with_unit(index, value),
                target_value_with_unit(index, limit)
            ),
            Cause::ACROSS_THE_MIDDLE => write!(
                f,
                "the {} arm comes within {:.1} mm of the middle plane, needs {:.1} mm during \
                 teleoperation; move it home with `atas release --hand {0}`",
                Hand(index),
                value * 1e3,
                limit * 1e3
            ),
            _ => self.write_unknown(f),
        }
    }
}
