//! One servo that is not there: its registers, its shaft, and what is wrong with it.

use super::family::{Error, Family, Table};
use super::shaft::Shaft;

/// Steps of the encoder per radian.
const STEPS_PER_RAD: f64 = 4096.0 / core::f64::consts::TAU;

/// A servo.
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
    pub(super) fn new(family: &'static dyn Family, table: Table, position_rad: f64) -> Self {
        Self {
            family,
            table,
            shaft: Shaft::at(position_rad * STEPS_PER_RAD),
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

    /// Lets time pass, and shows it in the registers.
    pub(super) fn advance(&mut self, elapsed_s: f64) {
        let mut orders = self.family.orders(&self.table);
        orders.torque_on &= self.powered;
        self.shaft.advance(&orders, elapsed_s);
        self.family.show(&self.shaft, &mut self.table);
    }

    pub(super) fn write(&mut self, address: usize, bytes: &[u8]) -> Result<(), Error> {
        self.family.write(&mut self.table, address, bytes)
    }

    /// As after the power came.
    pub(super) fn boot(&mut self) {
        self.family.boot(&mut self.table);
        self.family.show(&self.shaft, &mut self.table);
    }

    /// Angle of the shaft, rad.
    #[must_use]
    pub fn position_rad(&self) -> f64 {
        self.shaft.position_steps / STEPS_PER_RAD
    }

    /// Its goal, rad.
    #[must_use]
    pub fn goal_rad(&self) -> f64 {
        self.family.orders(&self.table).goal_steps / STEPS_PER_RAD
    }

    /// Whether it holds.
    #[must_use]
    pub fn holds(&self) -> bool {
        self.powered && self.family.orders(&self.table).torque_on
    }

    /// Most current that it may take, A.
    #[must_use]
    pub fn current_max_a(&self) -> f64 {
        self.family.orders(&self.table).current_max_a
    }

    /// Fastest that it turned since the last call, rad/s.
    pub fn fastest_rad_s(&mut self) -> f64 {
        core::mem::take(&mut self.shaft.fastest_steps_s) / STEPS_PER_RAD
    }

    /// Somebody turns the shaft to this angle, rad.
    pub fn turn_to(&mut self, position_rad: f64) {
        self.shaft.position_steps = position_rad * STEPS_PER_RAD;
        self.shaft.speed_steps_s = 0.0;
        self.family.show(&self.shaft, &mut self.table);
    }

    /// Something is in its way at this angle, rad, or no longer.
    pub fn block_at(&mut self, wall_rad: Option<f64>) {
        self.shaft.wall_steps = wall_rad.map(|wall| wall * STEPS_PER_RAD);
    }

    /// It has this temperature now, °C.
    pub fn heat_to(&mut self, temperature_c: f64) {
        self.shaft.temperature_c = temperature_c;
        self.family.show(&self.shaft, &mut self.table);
    }

    /// Its cable for answers breaks, or is mended.
    pub fn set_silent(&mut self, silent: bool) {
        self.silent = silent;
    }

    /// It loses its power, or gets it back.
    pub fn set_power(&mut self, powered: bool) {
        if powered && !self.powered {
            self.boot();
        }
        self.powered = powered;
    }

    /// Somebody switches its torque.
    pub fn set_torque(&mut self, on: bool) {
        self.family.set_torque(&mut self.table, on);
    }

    /// It complains with these bits, and lets go.
    pub fn complain(&mut self, bits: u8) {
        self.family.complain(&mut self.table, bits);
        if bits != 0 {
            self.set_torque(false);
        }
    }
}
