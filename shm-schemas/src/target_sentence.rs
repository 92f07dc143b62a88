//! Formats reasons about streamed targets; see `sentence` for all others.

use crate::reason::{Cause, Reason};
use crate::stamp::Hand;
use crate::target::GraspTarget;
use crate::typed::of_target;
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
                "the last target of the {} hand has expired; the hand stands and keeps what it holds until the next one",
                Hand(index)
            ),
            Cause::TARGET_CORRUPT => f.write_str("a target failed its checksum; seal it last"),
            Cause::TARGET_FOREIGN => f.write_str(
                "a target comes from another writer than the client whose goal opened the stream; send the epoch of the goal's \
                 request",
            ),
            Cause::TARGET_STALE => write!(
                f,
                "a target came {:.1} ms too late, or out of turn; stamp it with CLOCK_MONOTONIC, count its sequence up, and let \
                 valid_until_ns lie ahead",
                value * 1e-6
            ),
            Cause::TARGET_UNKNOWN => write!(
                f,
                "a target names a hand or a grip order ({value}) that its goal does not have; see the goal's kind and hand"
            ),
            Cause::TARGET_NOT_FINITE => {
                write!(f, "{name} of a target is not finite; send finite numbers")
            }
            Cause::TARGET_OUT_OF_RANGE => write!(
                f,
                "{name} of a target is {}, the limit is {}; the hand keeps to the target before",
                of_target(index, value),
                of_target(index, limit)
            ),
            Cause::ACROSS_THE_MIDDLE => write!(
                f,
                "the {} arm comes within {:.1} mm of the middle between the arms, needs {:.1} mm while a client leads a hand; \
                 bring it home with `atas release --hand {0}`",
                Hand(index),
                value * 1e3,
                limit * 1e3
            ),
            _ => self.write_unknown(f),
        }
    }
}
