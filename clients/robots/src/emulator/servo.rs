//! One emulated servo: registers, shaft and faults.

use super::family::{Error, Family, Table};
use super::shaft::Shaft;

/// Encoder steps per radian.
const STEPS_PER_RAD: f64 = 4096.0 / core::f64::consts::TAU;

/// An emulated servo.
pub struct Servo {
    family: &'static dyn Family,
    pub(super) table: Table,
    shaft: Shaft,
    powered: bool,
    silent: bool,
}

impl std::fmt::Debug for Servo {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "Servo({:?})", self.shaft)
    }
}

impl Servo {
    pub(super) fn new(family: &'static dyn Family, table: Table, position: f64) -> Self {
        Self {
            family,
            table,
            shaft: Shaft::new(position * STEPS_PER_RAD),
            powered: true,
            silent: false,
        }
    }

    pub(super) fn answers(&self) -> bool {
        self.powered && !self.silent
    }

    pub(super) fn is_powered(&self) -> bool {
        self.powered
    }

    /// Advances the shaft and updates the registers.
    pub(super) fn advance(&mut self, elapsed_s: f64) {
        let mut orders = self.family.setpoints(&self.table);
        orders.torque_on &= self.powered;
        self.shaft.advance(&orders, elapsed_s);
        self.family.write_shaft(&self.shaft, &mut self.table);
    }

    pub(super) fn write(&mut self, address: usize, bytes: &[u8]) -> Result<(), Error> {
        self.family.write(&mut self.table, address, bytes)
    }

    /// Resets the volatile registers to their power-on values.
    pub(super) fn boot(&mut self) {
        self.family.boot(&mut self.table);
        self.family.write_shaft(&self.shaft, &mut self.table);
    }

    /// Returns the shaft angle, rad.
    #[must_use]
    pub fn position(&self) -> f64 {
        self.shaft.position_steps / STEPS_PER_RAD
    }

    /// Returns the goal of the shaft, rad.
    #[must_use]
    pub fn goal_rad(&self) -> f64 {
        self.family.setpoints(&self.table).goal_steps / STEPS_PER_RAD
    }

    /// Returns whether the servo has power and torque.
    #[must_use]
    pub fn holds(&self) -> bool {
        self.powered && self.family.setpoints(&self.table).torque_on
    }

    /// Returns the current limit, A.
    #[must_use]
    pub fn current_max_a(&self) -> f64 {
        self.family.setpoints(&self.table).current_max_a
    }

    /// Returns the maximum speed since the last call, rad/s.
    pub fn fastest_rad_s(&mut self) -> f64 {
        core::mem::take(&mut self.shaft.fastest_steps_s) / STEPS_PER_RAD
    }

    /// Turns the shaft to an angle, rad, as by an external force.
    pub fn turn_to(&mut self, position: f64) {
        self.shaft.position_steps = position * STEPS_PER_RAD;
        self.shaft.speed_steps_s = 0.0;
        self.family.write_shaft(&self.shaft, &mut self.table);
    }

    /// Places an obstacle at a shaft angle, rad, or removes it.
    pub fn block_at(&mut self, wall_rad: Option<f64>) {
        self.shaft.wall_steps = wall_rad.map(|wall| wall * STEPS_PER_RAD);
    }

    /// Sets the temperature, °C.
    pub fn set_temperature(&mut self, temperature_c: f64) {
        self.shaft.temperature_c = temperature_c;
        self.family.write_shaft(&self.shaft, &mut self.table);
    }

    /// Breaks or restores the reply line.
    pub fn set_silent(&mut self, silent: bool) {
        self.silent = silent;
    }

    /// Switches the power supply.
    pub fn set_power(&mut self, powered: bool) {
        if powered && !self.powered {
            self.boot();
        }
        self.powered = powered;
    }

    /// Switches the torque.
    pub fn set_torque(&mut self, on: bool) {
        self.family.set_torque(&mut self.table, on);
    }

    /// Sets error bits; any error switches the torque off.
    pub fn set_errors(&mut self, bits: u8) {
        self.family.set_errors(&mut self.table, bits);
        if bits != 0 {
            self.set_torque(false);
        }
    }
}
