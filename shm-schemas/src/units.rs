//! Formats SI values in the unit that the command line or a target file uses.

use crate::goal::GoalRequest;
use crate::target::GraspTarget;
use core::fmt::{self, Display, Formatter};

/// Display unit and its conversion from SI.
#[derive(Clone, Copy, Debug)]
struct Unit {
    /// Unit name, with a leading space if required.
    name: &'static str,
    /// Factor from the SI unit to this unit.
    per_si: f64,
    digits: usize,
}

const fn unit(name: &'static str, per_si: f64, digits: usize) -> Unit {
    Unit {
        name,
        per_si,
        digits,
    }
}

const M: Unit = unit(" m", 1.0, 4);
const MM: Unit = unit(" mm", 1e3, 1);
const DEG: Unit = unit("°", 180.0 / core::f64::consts::PI, 1);
const RAD: Unit = unit(" rad", 1.0, 4);
const S: Unit = unit(" s", 1.0, 1);
const N: Unit = unit(" N", 1.0, 2);
/// Unit of an unnamed value.
const NONE: Unit = unit("", 1.0, 4);

/// Units in the order of [`GoalRequest::VALUE_NAMES`].
const GOAL_UNITS: [Unit; GoalRequest::VALUE_NAMES.len()] =
    [M, M, M, DEG, M, M, M, DEG, MM, MM, S, MM, MM, N];
/// Units in the order of [`GraspTarget::VALUE_NAMES`].
const TARGET_UNITS: [Unit; GraspTarget::VALUE_NAMES.len()] = [M, M, M, RAD, M];

/// SI value that prints in its display unit.
#[derive(Clone, Copy, Debug)]
pub(crate) struct WithUnit {
    si: f64,
    unit: Unit,
}

impl Display for WithUnit {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let Unit {
            name,
            per_si,
            digits,
        } = self.unit;
        write!(f, "{:.digits$}{name}", self.si * per_si)
    }
}

/// Returns an SI value with the display unit of the goal value at this index.
pub(crate) fn goal_value_with_unit(index: u32, si: f64) -> WithUnit {
    with_unit(&GOAL_UNITS, index, si)
}

/// Returns an SI value with the display unit of the target value at this index.
pub(crate) fn target_value_with_unit(index: u32, si: f64) -> WithUnit {
    with_unit(&TARGET_UNITS, index, si)
}

fn with_unit(units: &[Unit], index: u32, si: f64) -> WithUnit {
    let unit = units.get(index as usize).copied().unwrap_or(NONE);
    WithUnit { si, unit }
}
