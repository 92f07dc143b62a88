//! A simulated object: a body with a surface, and what has happened to it so far.

use nalgebra::Vector3;
use shm_schemas::{ObjectTruth, Text};

use crate::body::Body;
use crate::contact::{Surface, Wrench};
use crate::hold::{Grip, Hold};
use crate::object::Object;
use crate::scene::{Mount, Placed, Scene};
use crate::support::Ground;
use crate::thread::{CapTruth, INERTIA_KG_M2};

/// Stiffness that remains of a crushed object (tactile design: 5 %).
const CRUSHED_STIFFNESS: f64 = 0.05;
/// Height above the table from which a fall counts as a drop, m (issue: none dropped from more than 2 mm).
const DROP_M: f64 = 0.002;
/// Speed after a free fall from [`DROP_M`], m/s: √(2·g·h). Landing faster is being dropped.
const DROP_M_S: f64 = 0.198;
/// Force with which a support truly carries an object, N, or the share of its weight, whichever is more (issue: Module 4
/// shall answer it).
const CARRIES_N: f64 = 0.2;
const CARRIES_SHARE: f64 = 0.1;
/// Share of the weight that is enough for what weighs less than [`CARRIES_N`]. Ours.
const CARRIES_MOST: f64 = 0.9;
/// How long it must do so without a break, ns. Ours: the spike of a corner that grazes is over after a tick.
const CARRIES_NS: u64 = 2_000_000;
/// Tilt beyond which an object has tipped over, rad (45°). Ours.
const TIPPED_RAD: f64 = core::f64::consts::FRAC_PI_4;

/// Tilt up to which an object counts as upright, rad (5°). Ours.
const UPRIGHT_RAD: f64 = 0.087;
/// Distance up to which an object stands where it was, m. Ours: twice what closing fingers push an object of the widest
/// family.
const PLACE_M: f64 = 0.010;
/// Tilt at which an open bottle spills, rad (30°). Ours.
const SPILT_RAD: f64 = core::f64::consts::FRAC_PI_6;

/// One object of the world with its history.
#[derive(Clone, Debug)]
pub(crate) struct WorldObject {
    spec: Object,
    pub(crate) body: Body,
    /// It is clamped to what it stands on.
    clamped: bool,
    /// Where its middle was at the start, m.
    rest_m: Vector3<f64>,
    hold: Hold,
    /// A fingertip pressed in the last millisecond.
    pressed: bool,
    max_force_n: f64,
    /// Fingertips that pressed since the last [`WorldObject::judge`].
    touched: bool,
    crushed: bool,
    lifted: bool,
    dropped: bool,
    tipped: bool,
    spilt: bool,
    landing: Landing,
}

/// How an object was set down.
#[derive(Clone, Copy, Debug, Default)]
struct Landing {
    /// When it first stood again after it had been lifted last, ns; 0 if never.
    landed_ns: u64,
    /// Since when its support has carried it without a break, ns; 0 while it does not.
    carrying_ns: u64,
    /// When its support first truly carried it again, ns; 0 if never.
    carried_ns: u64,
    /// When the last fingertip let go of it: for the first time after it landed, else most recently, ns; 0 if never.
    released_ns: u64,
    /// Its height above what is under it at that moment, m.
    released_above_m: f64,
    held: bool,
}

impl WorldObject {
    /// The objects of a scene in their places.
    pub(crate) fn all(scene: &Scene) -> Vec<Self> {
        let plates = &scene.plates;
        let ground = Ground {
            plates,
            ..Ground::default()
        };
        let objects = scene.objects.iter();
        objects.map(|placed| Self::new(placed, &ground)).collect()
    }

    /// An object as a scene places it.
    pub(crate) fn new(placed: &Placed, ground: &Ground<'_>) -> Self {
        let spec = placed.object.clone();
        let [x, y] = placed.position_m;
        let foot_m = ground.under(&Vector3::new(x, y, f64::MAX)).height_m;
        let mut body = Body::standing(spec.shape, spec.mass_kg, [x, y, foot_m], placed.yaw_rad);
        if spec.thread.is_some() {
            body = body.with_inertia_of(INERTIA_KG_M2);
        }
        body = body.with_centre_of_mass(spec.centre_of_mass_m);
        let rest_m = body.position_m;
        Self {
            spec,
            body,
            clamped: placed.mount == Mount::Clamped,
            rest_m,
            hold: Hold::default(),
            pressed: false,
            max_force_n: 0.0,
            touched: false,
            crushed: false,
            lifted: false,
            dropped: false,
            tipped: false,
            spilt: false,
            landing: Landing::default(),
        }
    }

    /// One step on its own; a clamped object stays.
    pub(crate) fn step(&mut self, ground: &Ground<'_>, dt_s: f64) {
        if self.clamped {
            self.body.take_load();
        } else {
            self.body.step(ground, dt_s);
        }
    }

    /// Takes the present place for where it started.
    pub(crate) fn rest(&mut self) {
        self.rest_m = self.body.position_m;
    }

    /// What a fingertip meets; a crushed object is soft for good.
    pub(crate) fn surface(&self) -> Surface {
        let remaining = if self.crushed { CRUSHED_STIFFNESS } else { 1.0 };
        Surface {
            shape: self.spec.shape,
            friction: self.spec.friction,
            mass_kg: self.spec.mass_kg,
            stiffness_n_m: self.spec.stiffness_n_m * remaining,
        }
    }

    /// Takes a fingertip's wrench, body frame, and its normal force.
    pub(crate) fn apply_contact(&mut self, wrench: &Wrench, normal_n: f64) {
        self.body.apply(wrench);
        self.touched = true;
        self.max_force_n = self.max_force_n.max(normal_n);
        self.crushed |= normal_n > self.spec.crush_n;
    }

    /// Distance from its surface to a point, m, by its faces' planes; negative inside.
    pub(crate) fn gap_m(&self, point_m: &Vector3<f64>) -> f64 {
        let local_m = self
            .body
            .base_from_body
            .tr_mul(&(point_m - self.body.position_m));
        let face = self.spec.shape.face_towards(&local_m);
        face.normal.dot(&local_m) - face.offset_m
    }

    /// Looks at what became of it in the millisecond up to `now_ns`. An object that is `carried` by another one cannot
    /// fall by itself; one that is `open` can spill.
    pub(crate) fn judge(&mut self, ground: &Ground<'_>, carried: bool, open: bool, now_ns: u64) {
        let held = core::mem::take(&mut self.touched);
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
            self.landing.lift(held);
        }
        self.dropped |= self.lifted && !held && clearance_m > DROP_M;
        self.dropped |= self.lifted && !in_the_air && self.body.velocity_m_s.z < -DROP_M_S;
        if self.lifted {
            self.landing.look(in_the_air, held, clearance_m, now_ns);
            let weight_n = self.body.weight_n();
            let carries_n = CARRIES_N
                .max(CARRIES_SHARE * weight_n)
                .min(CARRIES_MOST * weight_n);
            self.landing.bear(self.body.table_n >= carries_n, now_ns);
        }
    }

    /// Looks at how it is held by the hand that has both fingertips on it, if one has. An object that is `carried` by another
    /// one, as a cap on its thread, is turned on purpose.
    pub(crate) fn watch_hold(&mut self, grip: Option<&Grip>, carried: bool) {
        if !carried {
            self.hold.follow(grip, &self.body);
        }
    }

    /// How far it is from where it stood at the start, over the table, m.
    fn displaced_m(&self) -> f64 {
        (self.body.position_m - self.rest_m).xy().norm()
    }

    /// Whether it stands by itself, upright and where it was.
    fn stands(&self) -> bool {
        let carried = self.body.table_n >= CARRIES_MOST * self.body.weight_n();
        let upright = self.body.tilt_rad() < UPRIGHT_RAD;
        carried && upright && !self.pressed && self.displaced_m() < PLACE_M
    }

    /// The judge's view of it; `cap` is what its thread says if it is a cap.
    pub(crate) fn truth(&self, cap: Option<CapTruth>) -> ObjectTruth {
        let body = &self.body;
        let mut truth = ObjectTruth {
            name: Text::new(&self.spec.name),
            position_m: body.position_m.into(),
            orientation: body.orientation(),
            lifted_m: body.position_m.z - self.rest_m.z,
            tilt_rad: body.tilt_rad(),
            needed_n: self.spec.needed_n(),
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
            slip_in_hand_m: self.hold.slip_m,
            turn_in_hand_rad: self.hold.turn_rad,
            displaced_m: self.displaced_m(),
            stands: self.stands().into(),
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

    /// Whether it is a bottle.
    pub(crate) fn has_neck(&self) -> bool {
        self.spec.neck.is_some()
    }
}

impl Landing {
    /// It hangs in a hand: however it was set down before, it is not now.
    fn lift(&mut self, held: bool) {
        if held && self.landed_ns > 0 {
            *self = Self {
                held: self.held,
                ..Self::default()
            };
        }
    }

    /// Looks at whether its support carries it.
    fn bear(&mut self, carries: bool, now_ns: u64) {
        self.carrying_ns = match self.carrying_ns {
            _ if !carries => 0,
            0 => now_ns,
            since_ns => since_ns,
        };
        if self.carried_ns == 0 && carries && now_ns >= self.carrying_ns + CARRIES_NS {
            self.carried_ns = self.carrying_ns;
        }
    }

    /// Looks at a lifted object.
    fn look(&mut self, in_the_air: bool, held: bool, clearance_m: f64, now_ns: u64) {
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
