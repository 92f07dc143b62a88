//! Simulated hand: joints, fingertip contacts, tremor.
//!
//! Kinematics run in every substep while a fingertip is near an object: at contact stiffnesses of
//! several thousand N/m, nanometres matter. A hand in free air only moves its joints.

use nalgebra::{Matrix3, Vector3};
use robot_model::{Capsules, GraspSide, HandModel, HandPose, HandVector};

use crate::contact::{Approach, Contact, Wrench};
use crate::hand_body::HandBody;
use crate::hold::Grip;
use crate::pad::Pad;
use crate::plant::Plant;
use crate::sensed_hand::{JointMotion, SensedHand};
use crate::vibration::Vibration;
use crate::world_object::WorldObject;

/// Distance of a skin from an object's bounding sphere that counts as near, m. No part of the robot
/// moves 5 mm in a tick.
const NEAR_M: f64 = 0.005;
/// Arm speed above which a hand is moving, rad/s: 1 mm/s at 0.25 m.
pub(crate) const MOVING_RAD_S: f64 = 0.004;

#[derive(Clone, Debug)]
pub(crate) struct Hand {
    model: HandModel,
    pub(crate) plant: Plant,
    /// Current command interpolation, rad.
    reference: HandVector,
    /// Per fingertip, as all following vectors except the joint torques.
    pub(crate) contacts: Vec<Contact>,
    nearest_object: Vec<usize>,
    vibration: Vibration,
    contact_n_m: HandVector,
    near: bool,
    /// Pose at the start of the tick, and of the substep while a fingertip is near an object.
    pose: HandPose,
    /// Palm and grasp sides at the start of the tick.
    tick_start: TickStart,
    pads: Vec<Pad>,
}

/// Palm, midpoint between the grasp sides, and vector from the second to the first, base frame, m.
#[derive(Clone, Debug)]
pub(crate) struct TickStart {
    base_from_hand: Matrix3<f64>,
    middle_m: Vector3<f64>,
    across_m: Vector3<f64>,
}

struct Tip {
    base_from_tip: robot_model::Transform,
    velocity_m_s: Vector3<f64>,
    angular_rad_s: Vector3<f64>,
}

impl Hand {
    /// Returns a hand at rest.
    pub(crate) fn new(body: HandBody, start: HandVector, vibration: Vibration) -> Self {
        let HandBody {
            model,
            servo_factor,
            pads,
        } = body;
        let pose = model.forward(&start);
        Self {
            plant: Plant::at_rest(&model, start, &servo_factor),
            tick_start: TickStart::from_pose(&pose),
            pose,
            reference: start,
            // Not cloned: a clone would lose the reserved capacity of `Contact`.
            contacts: pads.iter().map(Contact::new).collect(),
            nearest_object: vec![0; pads.len()],
            pads,
            vibration,
            contact_n_m: HandVector::zeros(model.joints().len()),
            near: false,
            model,
        }
    }

    /// Finds the near fingertips at the start of a tick of `dt_s`.
    pub(crate) fn begin_tick(&mut self, objects: &[WorldObject], dt_s: f64) {
        let arm = self.model.arm_joints();
        let arm_rad_s = arm
            .map(|joint| self.plant.velocity[joint].abs() / self.model.joints()[joint].radian())
            .fold(0.0, f64::max);
        self.vibration.blend(arm_rad_s > MOVING_RAD_S, dt_s);
        self.model.place(&mut self.pose, &self.plant.position);
        let pose = &self.pose;
        self.tick_start = TickStart::from_pose(pose);
        self.near = objects.iter().any(|object| {
            let object_m = object.body.shape.bounding_radius_m();
            let is_near = |(finger, pad): (usize, &Pad)| {
                let reach_m = object_m + pad.reach_m + NEAR_M;
                (pose.tip_m(finger) - object.body.position_m).norm_squared() < reach_m * reach_m
            };
            self.pads.iter().enumerate().any(is_near)
        });
    }

    /// Computes contacts: wrenches on the objects, torques on the joints.
    pub(crate) fn compute_contacts(&mut self, objects: &mut [WorldObject], dt_s: f64) {
        let (tremble_m, tremble_m_s) = self.vibration.step();
        self.contact_n_m.fill(0.0);
        if !self.near {
            self.contacts
                .iter_mut()
                .for_each(|contact| contact.step_free(dt_s));
            return;
        }
        self.model.place(&mut self.pose, &self.plant.position);
        for finger in 0..self.model.fingertip_count() {
            let mut tip = self.tip(finger);
            tip.base_from_tip.translation_m.z += tremble_m;
            tip.velocity_m_s.z += tremble_m_s;
            let object = &mut objects[self.nearest_object_index(finger, &tip, objects)];
            let contact = &mut self.contacts[finger];
            let pad = &self.pads[finger];
            let wrench = contact.press(pad, &object.surface(), &tip.approach(object), dt_s);
            if contact.is_touching() {
                object.apply_contact(&wrench, contact.normal_n);
                self.add_joint_torques(finger, &tip.wrench_from(object, &wrench));
            }
        }
    }

    /// Starts a bump of the hand's fingertips.
    pub(crate) fn bump(&mut self, height_m: f64, duration_s: f64) {
        self.vibration.bump(height_m, duration_s);
    }

    pub(crate) fn bodies(&self) -> Capsules {
        self.model.capsules(&self.pose)
    }

    pub(crate) fn pads(&self) -> &[Pad] {
        &self.pads
    }

    /// Returns the grip if fingertips of both grasp sides press this object.
    pub(crate) fn grip_on(&self, object: usize) -> Option<Grip> {
        let presses = |finger: usize| {
            self.nearest_object[finger] == object && self.contacts[finger].is_touching()
        };
        let grip = self.tick_start.grip(&self.model, presses)?;
        Some(grip.raised(self.vibration.bump_m()))
    }

    /// Returns the nearest object; a fingertip touches one object at a time.
    fn nearest_object_index(&mut self, finger: usize, tip: &Tip, objects: &[WorldObject]) -> usize {
        let gap_m = |index: &usize| objects[*index].gap_m(&tip.base_from_tip.translation_m);
        let nearest = (0..objects.len())
            .min_by(|a, b| gap_m(a).total_cmp(&gap_m(b)))
            .unwrap_or(0);
        if core::mem::replace(&mut self.nearest_object[finger], nearest) != nearest {
            self.contacts[finger].clear_shear();
        }
        nearest
    }

    /// Moves the joints by one of `left` remaining substeps, this one included.
    pub(crate) fn step(
        &mut self,
        target: &HandVector,
        feed_forward_rad_s: &HandVector,
        left: usize,
        dt_s: f64,
    ) {
        self.plant
            .step(&self.reference, feed_forward_rad_s, &self.contact_n_m, dt_s);
        let way_rad = *target - self.reference;
        self.reference += way_rad.map(|way_rad| way_rad / left as f64);
    }

    fn tip(&self, finger: usize) -> Tip {
        let pose = &self.pose;
        let base_from_tip = pose.base_from_tip()[finger];
        let (mut velocity_m_s, mut angular_rad_s) = (Vector3::zeros(), Vector3::zeros());
        for mover in self.model.movers(finger) {
            let speed = mover.ratio * self.plant.velocity[mover.joint];
            let moving = pose.frame_axis(mover.frame) * speed;
            if mover.slides {
                velocity_m_s += moving;
                continue;
            }
            let lever_m = base_from_tip.translation_m - pose.frame_origin_m(mover.frame);
            velocity_m_s += moving.cross(&lever_m);
            angular_rad_s += moving;
        }
        Tip {
            base_from_tip,
            velocity_m_s,
            angular_rad_s,
        }
    }

    /// Adds the joint torques Jᵀ·w of a wrench about the dome's centre, base frame.
    fn add_joint_torques(&mut self, finger: usize, wrench: &Wrench) {
        let pose = &self.pose;
        let tip_m = pose.tip_m(finger);
        for mover in self.model.movers(finger) {
            let along = if mover.slides {
                wrench.force_n
            } else {
                let arm_m = tip_m - pose.frame_origin_m(mover.frame);
                arm_m.cross(&wrench.force_n) + wrench.moment_n_m
            };
            let effort = pose.frame_axis(mover.frame).dot(&along);
            self.contact_n_m[mover.joint] += mover.ratio * effort;
        }
    }
}

impl SensedHand for Hand {
    fn model(&self) -> &HandModel {
        &self.model
    }

    fn joints(&self) -> JointMotion<'_> {
        JointMotion {
            position: &self.plant.position,
            velocity: &self.plant.velocity,
            effort: &self.plant.effort,
        }
    }

    fn element_forces(&self, finger: usize, force_n: &mut [Vector3<f64>]) {
        self.contacts[finger].element_forces(&self.pads[finger], force_n);
    }
}

impl TickStart {
    pub(crate) fn from_pose(pose: &HandPose) -> Self {
        Self {
            base_from_hand: pose.base_from_hand().rotation,
            middle_m: pose.middle_m(),
            across_m: pose.across_m(),
        }
    }

    /// Returns the grip if fingertips of both grasp sides press; `presses` states it of one.
    pub(crate) fn grip(&self, model: &HandModel, presses: impl Fn(usize) -> bool) -> Option<Grip> {
        let from = |side| model.fingertips_of(side).any(&presses);
        GraspSide::BOTH.into_iter().all(from).then(|| Grip {
            hand: model.side().index(),
            base_from_hand: self.base_from_hand,
            middle_m: self.middle_m,
            closing: -self.across_m.normalize(),
        })
    }
}

impl Tip {
    /// Returns the tip's pose and velocity in the object's frame.
    fn approach(&self, object: &WorldObject) -> Approach {
        let body = &object.body;
        let body_from_base = body.base_from_body.transpose();
        let centre_m = body_from_base * (self.base_from_tip.translation_m - body.position_m);
        let angular = body_from_base * self.angular_rad_s;
        let velocity = body_from_base * (self.velocity_m_s - body.velocity_m_s);
        Approach {
            object_from_tip: body_from_base * self.base_from_tip.rotation,
            centre_m,
            velocity_m_s: velocity - angular.cross(&centre_m),
            angular_rad_s: angular - body_from_base * body.angular_rad_s,
        }
    }
    /// Converts the wrench on the object to that on the tip, about the dome's centre, base frame.
    fn wrench_from(&self, object: &WorldObject, on_object: &Wrench) -> Wrench {
        let body = &object.body;
        let force_n = -(body.base_from_body * on_object.force_n);
        let about_object_n_m = -(body.base_from_body * on_object.moment_n_m);
        let arm_m = self.base_from_tip.translation_m - body.position_m;
        Wrench {
            force_n,
            moment_n_m: about_object_n_m - arm_m.cross(&force_n),
        }
    }
}
