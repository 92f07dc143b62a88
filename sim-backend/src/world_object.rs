//! Simulated object: body, surface and history (slip, damage, drop, spill, landing).

use nalgebra::Vector3;
use shm_schemas::{ObjectTruth, Text};

use crate::body::Body;
use crate::clock::SUBSTEPS;
use crate::contact::{Surface, Wrench};
use crate::hold::{Grip, Hold};
use crate::object::Object;
use crate::scene::{Mount, Placed, Scene};
use crate::support::Ground;
use crate::thread::{CapTruth, INERTIA_KG_M2};

/// Remaining stiffness share of a crushed object (tactile design: 5 %).
const CRUSHED_STIFFNESS: f64 = 0.05;
/// Drop height above the support that counts as a drop, m (limit of the grasp tests).
const DROP_M: f64 = 0.002;
/// Speed after a free fall from [`DROP_M`], m/s: √(2·g·h). Faster landings count as drops.
const DROP_M_S: f64 = 0.198;
/// Share of a tick in the low-passed downward force: time constant 10 ms. Design choice: the impact
/// of a block that tips flat lasts a few milliseconds.
const PRESSING_SHARE: f64 = 1.0 / 11.0;
/// Smallest force, N, and smallest share of the weight of a support that carries an object; the
/// larger one applies. Module 4 must detect it.
const CARRIES_N: f64 = 0.2;
const CARRIES_SHARE: f64 = 0.1;
/// Largest required share of the weight; applies to objects lighter than [`CARRIES_N`]. Design
/// choice.
const CARRIES_SHARE_MAX: f64 = 0.9;
/// Shortest uninterrupted time of support, ns. Design choice: force spikes of a grazing corner last
/// one tick.
const CARRIES_NS: u64 = 2_000_000;
/// Tilt from which an object has tipped over, rad (45°). Design choice.
const TIPPED_RAD: f64 = core::f64::consts::FRAC_PI_4;

/// Largest tilt of an upright object, rad (5°). Design choice.
const UPRIGHT_RAD: f64 = 0.087;
/// Largest displacement of an unmoved object, m. Design choice: twice that by closing fingers in
/// the widest family.
const DISPLACED_MAX_M: f64 = 0.010;
/// Tilt at which an open bottle spills, rad (30°). Design choice.
const SPILT_RAD: f64 = core::f64::consts::FRAC_PI_6;

#[derive(Clone, Debug)]
pub(crate) struct WorldObject {
    spec: Object,
    pub(crate) body: Body,
    clamped: bool,
    /// Middle of the object at the start, m.
    start_m: Vector3<f64>,
    hold: Hold,
    /// A fingertip pressed during the last tick.
    pressed: bool,
    max_force_n: f64,
    /// A fingertip pressed since the last [`WorldObject::evaluate`].
    touched: bool,
    /// Upward force of the fingertips, mean of the current tick, base frame, N.
    hand_up_n: f64,
    crushed: bool,
    lifted: bool,
    dropped: bool,
    tipped: bool,
    spilt: bool,
    landing: Landing,
}

/// Course of setting an object down.
#[derive(Clone, Copy, Debug, Default)]
struct Landing {
    /// First support contact after the last lift, ns; 0 if never.
    landed_ns: u64,
    /// Start of the current uninterrupted support, ns; 0 without support.
    carrying_ns: u64,
    /// Time from which the support carries the object, ns; 0 if never.
    carried_ns: u64,
    /// First release after landing, otherwise the latest release, ns; 0 if never.
    released_ns: u64,
    /// Height above the support at the release, m.
    released_above_m: f64,
    /// Low-passed downward force of the fingertips, and its maximum until the release, N. The
    /// impact of a tilted object that falls flat when it is released does not count.
    hand_down_n: f64,
    pressed_down_n: f64,
    held: bool,
}

impl WorldObject {
    pub(crate) fn from_scene(scene: &Scene) -> Vec<Self> {
        let plates = &scene.plates;
        let ground = Ground {
            plates,
            ..Ground::default()
        };
        let objects = scene.objects.iter();
        objects.map(|placed| Self::new(placed, &ground)).collect()
    }

    pub(crate) fn new(placed: &Placed, ground: &Ground<'_>) -> Self {
        let spec = placed.object.clone();
        let [x, y] = placed.position_m;
        let foot_m = ground.under(&Vector3::new(x, y, f64::MAX)).height_m;
        let mut body = Body::standing(spec.shape, spec.mass_kg, [x, y, foot_m], placed.yaw_rad);
        if spec.thread.is_some() {
            body = body.with_min_inertia(INERTIA_KG_M2);
        }
        body = body.with_centre_of_mass(spec.centre_of_mass_m);
        let rest_m = body.position_m;
        Self {
            spec,
            body,
            clamped: placed.mount == Mount::Clamped,
            start_m: rest_m,
            hold: Hold::default(),
            pressed: false,
            max_force_n: 0.0,
            touched: false,
            hand_up_n: 0.0,
            crushed: false,
            lifted: false,
            dropped: false,
            tipped: false,
            spilt: false,
            landing: Landing::default(),
        }
    }

    /// Integrates one step; a clamped object does not move.
    pub(crate) fn step(&mut self, ground: &Ground<'_>, dt_s: f64) {
        if self.clamped {
            self.body.take_load();
        } else {
            self.body.step(ground, dt_s);
        }
    }

    /// Takes the current position as the start position.
    pub(crate) fn set_start_position(&mut self) {
        self.start_m = self.body.position_m;
    }

    /// Returns the surface for the contact model; a crushed object stays soft.
    pub(crate) fn surface(&self) -> Surface {
        let remaining = if self.crushed { CRUSHED_STIFFNESS } else { 1.0 };
        Surface {
            shape: self.spec.shape,
            friction: self.spec.friction,
            mass_kg: self.spec.mass_kg,
            stiffness_n_m: self.spec.stiffness_n_m * remaining,
        }
    }

    /// Adds the wrench of a fingertip for one substep, body frame, and its normal force.
    pub(crate) fn apply_contact(&mut self, wrench: &Wrench, normal_n: f64) {
        self.body.apply(wrench);
        let up_n = (self.body.base_from_body * wrench.force_n).z;
        self.record_contact(normal_n, up_n / SUBSTEPS as f64);
    }

    /// Records the normal force of a fingertip, and its contribution to the mean upward force of
    /// the tick, base frame, N.
    pub(crate) fn record_contact(&mut self, normal_n: f64, up_n: f64) {
        self.touched = true;
        self.hand_up_n += up_n;
        self.max_force_n = self.max_force_n.max(normal_n);
        self.crushed |= normal_n > self.spec.crush_n;
    }

    /// Returns the distance of a point from the faces' planes, m; negative inside.
    pub(crate) fn gap_m(&self, point_m: &Vector3<f64>) -> f64 {
        let local_m = self
            .body
            .base_from_body
            .tr_mul(&(point_m - self.body.position_m));
        let face = self.spec.shape.face_towards(&local_m);
        face.normal.dot(&local_m) - face.offset_m
    }

    /// Updates the history with the tick that ends at `now_ns`. An object `carried` by another one
    /// cannot drop; an `open` one can spill.
    pub(crate) fn evaluate(&mut self, ground: &Ground<'_>, carried: bool, open: bool, now_ns: u64) {
        let held = core::mem::take(&mut self.touched);
        let hand_up_n = core::mem::take(&mut self.hand_up_n);
        self.pressed = held;
        let tilt_rad = self.body.tilt_rad();
        self.tipped |= tilt_rad > TIPPED_RAD;
        self.spilt |= open && tilt_rad > SPILT_RAD;
        let in_the_air = self.body.table_n == 0.0 && !carried && !self.clamped;
        let clearance_m = if in_the_air {
            self.body.clearance_m(ground)
        } else {
            0.0
        };
        if clearance_m > DROP_M {
            self.lifted = true;
            self.landing.reset_if_lifted(held);
        }
        self.dropped |= self.lifted && !held && clearance_m > DROP_M;
        self.dropped |= self.lifted && !in_the_air && self.body.velocity_m_s.z < -DROP_M_S;
        if self.lifted {
            self.landing
                .update_contact(in_the_air, held, clearance_m, now_ns);
            let weight_n = self.body.weight_n();
            let carries_n = CARRIES_N
                .max(CARRIES_SHARE * weight_n)
                .min(CARRIES_SHARE_MAX * weight_n);
            self.landing
                .update_carrying(self.body.table_n >= carries_n, now_ns);
            self.landing.update_pressing(-hand_up_n, held);
        }
    }

    /// Updates slip and rotation in the hand. Skips a `carried` object, such as a cap on its
    /// thread: its rotation is intended.
    pub(crate) fn update_hold(&mut self, grip: Option<&Grip>, carried: bool) {
        if !carried {
            self.hold.update(grip, &self.body);
        }
    }

    /// Restarts the measurement of slip and rotation.
    pub(crate) fn restart_hold(&mut self) {
        self.hold = Hold::default();
    }

    fn displaced_m(&self) -> f64 {
        (self.body.position_m - self.start_m).xy().norm()
    }

    /// Returns whether the object stands unsupported by hands, upright, at its start position.
    fn stands_at_start(&self) -> bool {
        let carried = self.body.table_n >= CARRIES_SHARE_MAX * self.body.weight_n();
        let upright = self.body.tilt_rad() < UPRIGHT_RAD;
        carried && upright && !self.pressed && self.displaced_m() < DISPLACED_MAX_M
    }

    /// Returns the ground truth; `cap` is the state of the thread if the object is a cap.
    pub(crate) fn truth(&self, cap: Option<CapTruth>) -> ObjectTruth {
        let body = &self.body;
        let mut truth = ObjectTruth {
            name: Text::new(&self.spec.name),
            position_m: body.position_m.into(),
            orientation: body.orientation(),
            lifted_m: body.position_m.z - self.start_m.z,
            tilt_rad: body.tilt_rad(),
            needed_n: self.spec.required_normal_n(),
            crush_n: self.spec.crush_n,
            max_force_n: self.max_force_n,
            table_n: body.table_n,
            crushed: self.crushed.into(),
            dropped: self.dropped.into(),
            tipped: self.tipped.into(),
            spilt: self.spilt.into(),
            landed_ns: self.landing.landed_ns,
            carried_ns: self.landing.carried_ns,
            released_ns: self.landing.released_ns,
            released_above_m: self.landing.released_above_m,
            pressed_down_n: self.landing.pressed_down_n,
            slip_in_hand_m: self.hold.slip_m,
            turn_in_hand_rad: self.hold.turn_rad,
            displaced_m: self.displaced_m(),
            stands: self.stands_at_start().into(),
            pressed: self.pressed.into(),
            ..ObjectTruth::default()
        };
        if let Some(cap) = cap {
            truth.cap_angle_rad = cap.angle_rad;
            truth.cap_closing_rad = cap.thread.closing_rad;
            truth.cap_friction_n_m = cap.thread.friction_n_m;
            truth.cap_torque_n_m = cap.torque_n_m;
            truth.cap_holding_n_m = cap.holding_n_m;
            truth.cap_engaged = cap.engaged.into();
            truth.cap_closed = (cap.engaged && cap.angle_rad >= cap.thread.closing_rad).into();
        }
        truth
    }

    pub(crate) fn has_neck(&self) -> bool {
        self.spec.neck.is_some()
    }
}

impl Landing {
    /// Resets the landing of an object that a hand has lifted again.
    fn reset_if_lifted(&mut self, held: bool) {
        if held && self.landed_ns > 0 {
            *self = Self {
                held: self.held,
                ..Self::default()
            };
        }
    }

    /// Updates whether the support carries the object.
    fn update_carrying(&mut self, carries: bool, now_ns: u64) {
        self.carrying_ns = match self.carrying_ns {
            _ if !carries => 0,
            0 => now_ns,
            since_ns => since_ns,
        };
        if self.carried_ns == 0 && carries && now_ns >= self.carrying_ns + CARRIES_NS {
            self.carried_ns = self.carrying_ns;
        }
    }

    fn update_pressing(&mut self, hand_down_n: f64, held: bool) {
        self.hand_down_n += (hand_down_n - self.hand_down_n) * PRESSING_SHARE;
        if held && self.landed_ns > 0 && self.hand_down_n > self.pressed_down_n {
            self.pressed_down_n = self.hand_down_n;
        }
    }

    fn update_contact(&mut self, in_the_air: bool, held: bool, clearance_m: f64, now_ns: u64) {
        if !in_the_air && self.landed_ns == 0 {
            self.landed_ns = now_ns;
        }
        let let_go = core::mem::replace(&mut self.held, held) && !held;
        let is_known = self.landed_ns > 0 && self.released_ns >= self.landed_ns;
        if let_go && !is_known {
            (self.released_ns, self.released_above_m) = (now_ns, clearance_m);
        }
    }
}

#[cfg(test)]
mod tests;
