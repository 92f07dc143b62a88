//! Conversion of the typed values of a [`crate::Reason`] to numbers and back.

use crate::body::BodyPair;
use crate::fields::{GoalField, TargetField};
use crate::goal::GoalKind;
use crate::joints::Mode;
use crate::module::ModuleId;
use crate::stamp::Hand;

/// Conversion of a typed value to and from its number in a [`crate::ReasonRecord`]. Total, because
/// bytes from the bus may have any value: the nearest typed value replaces an impossible one.
pub(crate) trait WireValue<W> {
    fn from_wire(wire: W) -> Self;
    fn to_wire(self) -> W;
}

/// Implements [`WireValue`] by two conversions.
macro_rules! wire_values {
    ($($type:ty as $wire:ty: $from:expr, $to:expr;)*) => {$(
        impl WireValue<$wire> for $type {
            fn from_wire(wire: $wire) -> Self {
                ($from)(wire)
            }

            fn to_wire(self) -> $wire {
                ($to)(self)
            }
        }
    )*};
}

wire_values! {
    f64 as f64: |value| value, |value| value;
    u32 as f64: |value| value as u32, f64::from;
    u64 as f64: |value| value as u64, |count| count as f64;
    Mode as f64: |value| Mode(value as u32), |mode: Mode| f64::from(mode.0);
    // Infinite: nothing has arrived yet.
    Option<f64> as f64: |age: f64| age.is_finite().then_some(age),
        |age: Option<f64>| age.unwrap_or(f64::INFINITY);
    // Zero: the kind of the goal is not known.
    Option<GoalKind> as f64: |value| Some(GoalKind(value as u32)).filter(|kind| kind.is_known()),
        |kind: Option<GoalKind>| kind.map_or(0.0, |kind| f64::from(kind.0));
    u32 as u32: |index| index, |index| index;
    usize as u32: |index| index as usize, |index| u32::try_from(index).unwrap_or(u32::MAX);
    usize as f64: |value| value as usize, |index| index as f64;
    Hand as u32: Hand, |hand: Hand| hand.0;
    GoalField as u32: GoalField, |field: GoalField| field.0;
    TargetField as u32: TargetField, |field: TargetField| field.0;
    // Zero: the bodies are not known.
    Option<BodyPair> as u32: |index| (index != 0).then(|| BodyPair::from_index(index)),
        |bodies: Option<BodyPair>| bodies.map_or(0, BodyPair::index);
    ModuleId as ModuleId: |module| module, |module| module;
}
