//! A simulated object: a body with a surface, and what has happened to it so far.

use nalgebra::Vector3;
use shm_schemas::{ObjectTruth, Text};

use crate::body::Body;
use crate::contact::{Surface, Wrench};
use crate::object::Object;
use crate::scene::Placed;

/// Stiffness that remains of a crushed object (tactile design: 5 %).
const CRUSHED_STIFFNESS: f64 = 0.05;
/// Height above the table from which a fall counts as a drop, m (issue: none dropped from more than 2 mm).
const DROP_M: f64 = 0.002;
/// Speed after a free fall from [`DROP_M`], m/s: √(2·g·h). Landing faster is being dropped.
const DROP_M_S: f64 = 0.198;
/// Tilt beyond which an object has tipped over, rad (45°). Ours.
const TIPPED_RAD: f64 = core::f64::consts::FRAC_PI_4;

/// One object of the world with its history.
#[derive(Clone, Debug)]
pub(crate) struct Thing {
    object: Object,
    pub(crate) body: Body,
    /// Height of the centre of mass at the start, m.
    rest_m: f64,
    max_force_n: f64,
    /// Fingertips that pressed since the last [`Thing::judge`].
    touched: bool,
    crushed: bool,
    lifted: bool,
    dropped: bool,
    tipped: bool,
}

impl Thing {
    pub(crate) fn new(placed: &Placed) -> Self {
        let object = placed.object.clone();
        let body = Body::standing(
            object.shape,
            object.mass_kg,
            placed.position_m,
            placed.yaw_rad,
        );
        let rest_m = body.position_m.z;
        Self {
            object,
            body,
            rest_m,
            max_force_n: 0.0,
            touched: false,
            crushed: false,
            lifted: false,
            dropped: false,
            tipped: false,
        }
    }

    /// What a fingertip meets; a crushed object is soft for good.
    pub(crate) fn surface(&self) -> Surface {
        let remaining = if self.crushed { CRUSHED_STIFFNESS } else { 1.0 };
        Surface {
            shape: self.object.shape,
            friction: self.object.friction,
            mass_kg: self.object.mass_kg,
            stiffness_n_m: self.object.stiffness_n_m * remaining,
        }
    }

    /// Takes a fingertip's wrench, body frame, and its normal force.
    pub(crate) fn feel(&mut self, wrench: &Wrench, normal_n: f64) {
        self.body.apply(wrench);
        self.touched = true;
        self.max_force_n = self.max_force_n.max(normal_n);
        self.crushed |= normal_n > self.object.crush_n;
    }

    /// Distance from its surface to a point, m, by its faces' planes; negative inside.
    pub(crate) fn gap_m(&self, point_m: &Vector3<f64>) -> f64 {
        let local_m = self
            .body
            .base_from_body
            .tr_mul(&(point_m - self.body.position_m));
        let face = self.object.shape.face_towards(&local_m);
        face.normal.dot(&local_m) - face.offset_m
    }

    /// Looks at what became of it, once per millisecond.
    pub(crate) fn judge(&mut self) {
        let held = core::mem::take(&mut self.touched);
        self.tipped |= self.body.tilt_rad() > TIPPED_RAD;
        let in_the_air = self.body.table_n == 0.0;
        if in_the_air && !self.dropped {
            let clearance_m = self.body.clearance_m();
            self.lifted |= clearance_m > DROP_M;
            self.dropped |= self.lifted && !held && clearance_m > DROP_M;
        }
        self.dropped |= self.lifted && !in_the_air && self.body.velocity_m_s.z < -DROP_M_S;
    }

    pub(crate) fn truth(&self) -> ObjectTruth {
        let body = &self.body;
        ObjectTruth {
            name: Text::new(&self.object.name),
            position_m: body.position_m.into(),
            orientation: body.orientation(),
            lifted_m: body.position_m.z - self.rest_m,
            tilt_rad: body.tilt_rad(),
            needed_n: self.object.needed_n(),
            crush_n: self.object.crush_n,
            max_force_n: self.max_force_n,
            table_n: body.table_n,
            crushed: self.crushed.into(),
            dropped: self.dropped.into(),
            tipped: self.tipped.into(),
            ..ObjectTruth::default()
        }
    }
}
