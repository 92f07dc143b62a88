//! Fields of goals and targets that a reason names, with the units of the command line and of
//! target files.

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

/// Number of a goal that a [`crate::Reason`] concerns: an index of [`GoalRequest::VALUE_NAMES`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct GoalField(pub u32);

/// Number of a target that a [`crate::Reason`] concerns: an index of [`GraspTarget::VALUE_NAMES`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TargetField(pub u32);

impl GoalField {
    /// Element 0 of [`GoalRequest::from_m`]; y and z follow.
    pub const FROM_X: Self = Self(0);
    /// [`GoalRequest::from_yaw_rad`].
    pub const FROM_YAW: Self = Self(3);
    /// Element 0 of [`GoalRequest::to_m`]; y and z follow.
    pub const TO_X: Self = Self(4);
    /// [`GoalRequest::to_yaw_rad`].
    pub const TO_YAW: Self = Self(7);
    /// [`GoalRequest::width_m`].
    pub const WIDTH: Self = Self(8);
    /// [`GoalRequest::lift_m`].
    pub const LIFT: Self = Self(9);
    /// [`GoalRequest::hold_s`].
    pub const HOLD: Self = Self(10);
    /// [`GoalRequest::helper_width_m`].
    pub const HELPER_WIDTH: Self = Self(11);
    /// [`GoalRequest::top_m`].
    pub const TOP: Self = Self(12);
    /// [`GoalRequest::max_force_n`].
    pub const MAX_FORCE: Self = Self(13);

    /// Returns the place (`from` or `to`) that the field belongs to, or an empty string.
    pub(crate) fn place(self) -> &'static str {
        match self.name().split_once(' ') {
            Some((place @ ("from" | "to"), _)) => place,
            _ => "",
        }
    }

    pub(crate) fn is_yaw(self) -> bool {
        matches!(self, Self::FROM_YAW | Self::TO_YAW)
    }

    /// Returns an SI value with the display unit of the field.
    pub(crate) fn with_unit(self, si: f64) -> WithUnit {
        with_unit(&GOAL_UNITS, self.0, si)
    }

    fn name(self) -> &'static str {
        name(&GoalRequest::VALUE_NAMES, self.0)
    }
}

impl TargetField {
    /// Returns an SI value with the display unit of the field.
    pub(crate) fn with_unit(self, si: f64) -> WithUnit {
        with_unit(&TARGET_UNITS, self.0, si)
    }
}

impl Display for GoalField {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl Display for TargetField {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        f.write_str(name(&GraspTarget::VALUE_NAMES, self.0))
    }
}

fn name(names: &[&'static str], index: u32) -> &'static str {
    names.get(index as usize).copied().unwrap_or("a value")
}

fn with_unit(units: &[Unit], index: u32, si: f64) -> WithUnit {
    let unit = units.get(index as usize).copied().unwrap_or(NONE);
    WithUnit { si, unit }
}
