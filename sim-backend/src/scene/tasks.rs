//! Scenes of the paper's tasks with their nominal data.
//!
//! * [`Scene::pick_place`]: an object stands on a plate; its place is another plate of nominally
//!   the same height.
//! * [`Scene::screw`]: a cap is on the neck of a clamped bottle.
//! * [`Scene::assembly`]: a cap is on a stand, a bottle stands free.
//!
//! The cap is the first object, the bottle the second. Clients get nominal sizes and places, but no
//! thread, friction or mass.

use nalgebra::Vector3;
use robot_model::{GraspPose, HandModel, HandSide};

use super::{DEFAULT_YAW_RAD, GraspHint, Mount, Placed, Scene};
use crate::object::Object;
use crate::support::Plate;

/// Place of pick and place: x, and the distance from the midline towards the acting hand, m. Design
/// choice: 12 cm from the start.
const PLACE_M: [f64; 2] = [0.32, 0.27];
/// Height of the object's plate, m. Leaves 10 mm for a lower place.
const STEP_M: f64 = 0.010;
/// Extra opening over the object's width at the place, and approach height, m (the controller's
/// defaults).
const OPEN_M: f64 = 0.010;
const LIFT_M: f64 = 0.060;
/// Half edge of the plates of pick and place, m. Design choice: larger than every built-in object
/// with its error.
const STEP_HALF_M: f64 = 0.055;
/// Clamped bottle: x, and the distance from the midline towards the acting hand, m (task
/// specification).
const SCREW_M: [f64; 2] = [0.34, 0.12];
/// Free bottle of assembly, m (robot design).
const BOTTLE_M: [f64; 2] = [0.38, 0.0];
/// Cap of assembly: x, and the distance from the midline towards the screwing hand, m (robot
/// design).
const STAND_M: [f64; 2] = [0.32, 0.18];
/// Height of the cap's stand, m (robot design).
const STAND_HEIGHT_M: f64 = 0.040;
/// Half edge of the cap's stand, m. Design choice: larger than every cap.
const STAND_HALF_M: f64 = 0.025;
/// Closing axis on the cap of assembly, rad: 60° for the right hand (robot design).
const ASSEMBLY_YAW_RAD: f64 = core::f64::consts::FRAC_PI_3;
/// Height of the other hand's grasp on the bottle, m (robot design).
const HOLD_HEIGHT_M: f64 = 0.045;

/// Default objects of the tasks.
impl Scene {
    /// Object of grasping and of pick and place.
    pub const OBJECT: &'static str = "wood";
    /// Cap of screwing and assembly.
    pub const CAP: &'static str = "cap";
    /// Bottle of screwing and assembly.
    pub const BOTTLE: &'static str = "open-bottle";
}

impl Scene {
    /// Returns a scene with an object in front of one hand, to be placed 12 cm farther out.
    #[must_use]
    pub fn pick_place(object: Object, side: HandSide) -> Self {
        let plate = |centre_m| Plate {
            centre_m,
            half_m: [STEP_HALF_M; 2],
            height_m: STEP_M,
        };
        let mut placed = Placed::in_front_of(object, side);
        placed.nominal.from_m[2] += STEP_M;
        placed.nominal.height_m += STEP_M;
        let to_m = off_midline(PLACE_M, side);
        let place = GraspHint {
            from_m: [to_m[0], to_m[1], placed.nominal.from_m[2]],
            ..placed.nominal
        };
        Self {
            plates: vec![plate(placed.position_m), plate(to_m)],
            place: Some(place),
            objects: vec![placed],
            ..Self::default()
        }
    }

    /// Moves the place into the hand's reach, if necessary: at the same distance on the circle
    /// about the arm's base, rotated accordingly. A five-joint arm rotates its hand only with its
    /// base.
    pub(super) fn move_place_into_reach(&mut self, hand: &HandModel) {
        let ([_], [_, plate], Some(place)) =
            (&self.objects[..], &mut self.plates[..], &mut self.place)
        else {
            return;
        };
        let [from_x_m, from_y_m] = self.objects[0].position_m;
        let [to_x_m, to_y_m, to_z_m] = place.from_m;
        let far_m = libm::hypot(to_x_m - from_x_m, to_y_m - from_y_m);
        let by_rad = far_m / libm::hypot(from_x_m, from_y_m);
        let outward = hand.side().y_sign();
        let turned = [outward, -outward].map(|sign| {
            let (sin, cos) = libm::sincos(sign * by_rad);
            let [x_m, y_m] = [
                cos * from_x_m - sin * from_y_m,
                sin * from_x_m + cos * from_y_m,
            ];
            GraspHint {
                from_m: [x_m, y_m, to_z_m],
                yaw_rad: place.yaw_rad + sign * by_rad,
                ..*place
            }
        });
        let mut candidates = core::iter::once(*place).chain(turned);
        if let Some(reached) = candidates.find(|hint| reaches(hand, hint)) {
            plate.centre_m = [reached.from_m[0], reached.from_m[1]];
            *place = reached;
        }
    }

    /// Returns a scene with a cap on the neck of a clamped bottle in front of one hand, not turned
    /// yet.
    #[must_use]
    pub fn screw(cap: Object, bottle: Object, side: HandSide) -> Self {
        let at_m = off_midline(SCREW_M, side);
        let mounted = |object, mount| Placed {
            mount,
            ..Placed::new(object, at_m, DEFAULT_YAW_RAD)
        };
        let mut scene = Self {
            objects: vec![mounted(cap, Mount::OnNeck), mounted(bottle, Mount::Clamped)],
            ..Self::default()
        };
        scene.update_nominal_cap_and_bottle();
        scene
    }

    /// Returns a scene with a cap on a stand in front of the screwing hand and a free bottle
    /// between the hands.
    #[must_use]
    pub fn assembly(cap: Object, bottle: Object, screws: HandSide) -> Self {
        let stand = Plate {
            centre_m: off_midline(STAND_M, screws),
            half_m: [STAND_HALF_M; 2],
            height_m: STAND_HEIGHT_M,
        };
        let yaw_rad = -screws.y_sign() * ASSEMBLY_YAW_RAD;
        let mut scene = Self {
            objects: vec![
                Placed::new(cap, stand.centre_m, yaw_rad),
                Placed::new(bottle, BOTTLE_M, yaw_rad),
            ],
            plates: vec![stand],
            ..Self::default()
        };
        scene.objects[1].nominal.from_m[2] = HOLD_HEIGHT_M;
        scene.update_nominal_cap_and_bottle();
        scene
    }

    /// Sets the nominal sizes and heights of cap and bottle to their true values.
    pub(super) fn update_nominal_cap_and_bottle(&mut self) {
        let [cap, bottle] = &mut self.objects[..] else {
            return;
        };
        let Some(neck) = bottle.object.neck else {
            return;
        };
        let half_m = cap.object.shape.half_height_m();
        let on_neck_m = neck.rim_m + half_m;
        bottle.nominal.width_m = bottle.object.shape.width_m();
        cap.nominal.width_m = cap.object.shape.width_m();
        cap.nominal.from_m[2] = match cap.mount {
            Mount::OnNeck => on_neck_m,
            _ => STAND_HEIGHT_M + half_m,
        };
        cap.nominal.height_m = cap.nominal.from_m[2] + half_m;
        let [x, y, _] = bottle.nominal.from_m;
        self.place = Some(GraspHint {
            from_m: [x, y, on_neck_m],
            height_m: on_neck_m + half_m,
            ..cap.nominal
        });
    }
}

/// Returns whether a hand reaches the place and the approach above it, opened for release.
fn reaches(hand: &HandModel, hint: &GraspHint) -> bool {
    let [x_m, y_m, z_m] = hint.from_m;
    let opening_m = (hint.width_m + OPEN_M).min(hand.max_opening_m());
    [z_m, z_m + LIFT_M].into_iter().all(|z_m| {
        let centre_m = Vector3::new(x_m, y_m, z_m);
        let yaw_rad = hand.closing_yaw_rad(&centre_m, hint.yaw_rad);
        hand.reaches(&GraspPose::from_above(centre_m, yaw_rad, opening_m))
    })
}

fn off_midline([x_m, off_middle_m]: [f64; 2], side: HandSide) -> [f64; 2] {
    [x_m, side.y_sign() * off_middle_m]
}
