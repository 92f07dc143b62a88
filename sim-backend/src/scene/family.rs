//! Seeded families: random variations of the true scene.

use core::f64::consts::PI;

use super::{Mount, Placed, Scene, stream};
use crate::object::{Neck, Object};
use crate::random::Random;
use crate::shape::Shape;
use crate::thread::Thread;

/// Half width of mass, friction and stiffness, relative (grasp test specification: ±20 %).
const SCALE: f64 = 0.2;
/// Half width of an object's x and y, m (grasp test specification).
const POSITION_M: f64 = 0.002;
/// Half width of an object's yaw, rad (grasp test specification).
const YAW_RAD: f64 = 5.0 * PI / 180.0;
/// Half width of x and y of caps and bottles, m. Design choice: they are in fixtures, and a neck
/// captures within 2 mm.
const FIXTURE_M: f64 = 0.0005;
/// Half width of the height of the place, m (task specification).
const PLACE_M: f64 = 0.010;

/// Caps (task specification). The pitch is a design choice, around that of drink bottles.
mod cap {
    pub(super) const RADIUS_M: [f64; 2] = [0.012, 0.020];
    pub(super) const FRICTION: [f64; 2] = [0.4, 0.8];
    pub(super) const THREAD_N_M: [f64; 2] = [0.005, 0.030];
    pub(super) const CLOSING_DEG: [f64; 2] = [120.0, 400.0];
    pub(super) const PITCH_M: [f64; 2] = [0.002, 0.004];
}

mod bottle {
    pub(super) const RADIUS_M: [f64; 2] = [0.025, 0.035];
    pub(super) const MASS_KG: [f64; 2] = [0.2, 0.5];
    /// Height of the rim. A cap of 20 mm on it has its middle at 100 to 160 mm.
    pub(super) const RIM_M: [f64; 2] = [0.09, 0.15];
    /// Height of the rim above the shoulder. Leaves 20 mm between shoulder and middle of the lowest
    /// closed cap.
    pub(super) const NECK_M: f64 = 0.016;
}

impl Scene {
    /// Returns the scene with true values drawn from its family: mass, friction, stiffness and pose
    /// of every object, size and thread of cap and bottle, height of a place. Nominal data stay,
    /// except the sizes of cap and bottle, which clients know exactly.
    ///
    /// ```
    /// use robot_model::HandSide;
    /// use sim_backend::{Object, Scene};
    ///
    /// let scene = Scene::grasp(Object::built_in("sponge").expect("built in"), HandSide::Right);
    /// let mass_kg = |seed| scene.varied(seed).objects[0].object.mass_kg;
    /// assert_eq!(mass_kg(7), mass_kg(7), "one seed gives one object");
    /// assert_ne!(mass_kg(7), mass_kg(8));
    /// ```
    #[must_use]
    pub fn varied(&self, seed: u64) -> Self {
        let mut random = Random::new(seed, stream::FAMILY);
        let mut scene = self.clone();
        for placed in &mut scene.objects {
            placed.vary(&mut random);
        }
        if let [from, to] = &mut scene.plates[..] {
            to.height_m = from.height_m + random.between(-PLACE_M, PLACE_M);
        }
        scene.align_cap_with_bottle();
        if scene.place.is_some() {
            scene.update_nominal_cap_and_bottle();
        }
        scene
    }

    /// Moves a cap on a neck to its bottle's position.
    pub(super) fn align_cap_with_bottle(&mut self) {
        let [cap, bottle] = &mut self.objects[..] else {
            return;
        };
        if bottle.object.neck.is_some() && cap.mount == Mount::OnNeck {
            cap.position_m = bottle.position_m;
        }
    }
}

impl Placed {
    fn vary(&mut self, random: &mut Random) {
        let object = &mut self.object;
        let position_m = if object.thread.is_some() {
            object.vary_cap(random);
            FIXTURE_M
        } else if object.neck.is_some() {
            object.vary_bottle(random);
            FIXTURE_M
        } else {
            object.vary_in_scale(random);
            POSITION_M
        };
        let mut shift = |half_width: f64| random.between(-half_width, half_width);
        self.position_m[0] += shift(position_m);
        self.position_m[1] += shift(position_m);
        self.yaw_rad += shift(YAW_RAD);
    }
}

impl Object {
    fn vary_in_scale(&mut self, random: &mut Random) {
        let mut scale = || random.between(1.0 - SCALE, 1.0 + SCALE);
        self.mass_kg *= scale();
        self.friction *= scale();
        self.stiffness_n_m *= scale();
    }

    fn vary_cap(&mut self, random: &mut Random) {
        let draw = &mut |[low, high]: [f64; 2]| random.between(low, high);
        self.shape = Shape::Cylinder {
            radius_m: draw(cap::RADIUS_M),
            half_height_m: self.shape.half_height_m(),
        };
        self.friction = draw(cap::FRICTION);
        self.mass_kg *= draw([1.0 - SCALE, 1.0 + SCALE]);
        self.thread = self.thread.map(|thread| Thread {
            friction_n_m: draw(cap::THREAD_N_M),
            closing_rad: draw(cap::CLOSING_DEG).to_radians(),
            pitch_m: draw(cap::PITCH_M),
            ..thread
        });
    }

    fn vary_bottle(&mut self, random: &mut Random) {
        let draw = &mut |[low, high]: [f64; 2]| random.between(low, high);
        let scales = [1.0 - SCALE, 1.0 + SCALE];
        self.mass_kg = draw(bottle::MASS_KG);
        self.friction *= draw(scales);
        self.stiffness_n_m *= draw(scales);
        let rim_m = draw(bottle::RIM_M);
        self.neck = Some(Neck { rim_m });
        self.shape = Shape::Cylinder {
            radius_m: draw(bottle::RADIUS_M),
            half_height_m: (rim_m - bottle::NECK_M) / 2.0,
        };
    }
}
