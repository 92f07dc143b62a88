//! Physics of a process of its own, see [`crate::engine`].

use nalgebra::Vector3;
use robot_model::{HandModel, HandPose, HandSide, HandVector, RobotModel, RobotVector};
use shm_schemas::JointSetpoints;

use crate::body::Motion;
use crate::clock::{SUBSTEPS, TICK_S};
use crate::engine::{CapState, Engine, EngineError, EngineScene, PhysicsState, TickInput};
use crate::hand::{MOVING_RAD_S, TickStart};
use crate::hand_body::HandBody;
use crate::hold::Grip;
use crate::scene::Scene;
use crate::sensed_hand::{JointMotion, SensedHand};
use crate::thread::{CapTruth, Thread};
use crate::vibration::Vibration;
use crate::world_object::WorldObject;

pub(crate) struct External {
    engine: Box<dyn Engine>,
    pub(crate) hands: [ExternalHand; 2],
    input: TickInput,
    state: PhysicsState,
    cap: Option<(usize, Thread)>,
}

impl core::fmt::Debug for External {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.debug_struct("External")
            .field("state", &self.state)
            .finish_non_exhaustive()
    }
}

/// Hand whose motion the engine computes.
#[derive(Clone, Debug)]
pub(crate) struct ExternalHand {
    model: HandModel,
    position: HandVector,
    velocity: HandVector,
    effort: HandVector,
    vibration: Vibration,
    pose: HandPose,
    tips: Vec<ExternalTip>,
}

/// Contact of one fingertip.
#[derive(Clone, Debug, Default)]
pub(crate) struct ExternalTip {
    element_force_n: Vec<Vector3<f64>>,
    touched: Option<usize>,
    pub(crate) normal_n: f64,
    pub(crate) slip_m: f64,
}

impl External {
    /// Builds the scene in the engine; the hands start at rest.
    pub(crate) fn new(
        mut engine: Box<dyn Engine>,
        robot: &RobotModel,
        bodies: [HandBody; 2],
        scene: &Scene,
        start: &RobotVector,
        vibrations: [Vibration; 2],
        seed: u64,
    ) -> Result<Self, EngineError> {
        engine.begin(&EngineScene::new(&bodies, start, scene, TICK_S, seed))?;
        let cap = scene.objects.iter().enumerate();
        let mut cap = cap.filter_map(|(index, placed)| Some((index, placed.object.thread?)));
        let [left, right] = bodies.map(|body| body.model);
        let [of_left, of_right] = vibrations;
        let of = |side| HandVector::from_slice(&start[robot.joint_range(side)]);
        Ok(Self {
            engine,
            hands: [
                ExternalHand::new(left, of(HandSide::Left), of_left),
                ExternalHand::new(right, of(HandSide::Right), of_right),
            ],
            input: TickInput::new(robot, scene),
            state: PhysicsState::new(robot, scene),
            cap: cap.next_back(),
        })
    }

    /// Simulates one tick towards the set-points.
    pub(crate) fn simulate(
        &mut self,
        orders: &JointSetpoints,
        objects: &mut [WorldObject],
    ) -> Result<(), EngineError> {
        self.input.set(orders);
        for (tremor_m, hand) in self.input.tremor_m.iter_mut().zip(&mut self.hands) {
            *tremor_m = hand.tremor_m();
        }
        for (index, object) in objects.iter().enumerate() {
            self.input.pull_n[index] = object.body.pull_n.into();
            self.input.stiffness_n_m[index] = object.surface().stiffness_n_m;
        }
        self.engine.advance(&self.input, &mut self.state)?;
        self.take_state(objects);
        Ok(())
    }

    /// Copies the engine's state to hands and objects.
    fn take_state(&mut self, objects: &mut [WorldObject]) {
        let state = &self.state;
        let (mut joint, mut tip) = (0, 0);
        for hand in &mut self.hands {
            let joints = joint..joint + hand.model.joints().len();
            joint = joints.end;
            hand.position = HandVector::from_slice(&state.position[joints.clone()]);
            hand.velocity = HandVector::from_slice(&state.velocity[joints.clone()]);
            hand.effort = HandVector::from_slice(&state.effort[joints]);
            hand.model.place(&mut hand.pose, &hand.position);
            for (finger, of_tip) in hand.tips.iter_mut().enumerate() {
                for (to, from) in of_tip
                    .element_force_n
                    .iter_mut()
                    .zip(&state.element_force_n[tip])
                {
                    *to = Vector3::from(*from);
                }
                of_tip.touched = state.touched[tip];
                of_tip.normal_n = state.normal_n[tip];
                of_tip.slip_m = state.slip_m[tip];
                if let Some(index) = of_tip.touched {
                    let on_tip_n: Vector3<f64> = of_tip.element_force_n.iter().sum();
                    let on_tip_n = hand.pose.base_from_tip()[finger].rotation * on_tip_n;
                    objects[index].record_contact(of_tip.normal_n, -on_tip_n.z);
                }
                tip += 1;
            }
        }
        for (object, state) in objects.iter_mut().zip(&state.objects) {
            object.body.set_motion(&Motion {
                position_m: state.position_m.into(),
                orientation: state.orientation,
                velocity_m_s: state.velocity_m_s.into(),
                angular_rad_s: state.angular_rad_s.into(),
            });
            object.body.table_n = state.support_n;
        }
    }

    /// Returns true if the thread determines the motion of this object.
    pub(crate) fn constrains(&self, index: usize) -> bool {
        self.state.cap.engaged && self.cap.is_some_and(|(cap, _)| cap == index)
    }

    pub(crate) fn is_closed(&self) -> bool {
        let CapState {
            engaged, angle_rad, ..
        } = self.state.cap;
        engaged
            && self
                .cap
                .is_some_and(|(_, thread)| angle_rad >= thread.closing_rad)
    }

    pub(crate) fn cap_truth(&self, index: usize) -> Option<CapTruth> {
        let (_, thread) = self.cap.filter(|(cap, _)| *cap == index)?;
        let cap = self.state.cap;
        Some(CapTruth {
            engaged: cap.engaged,
            angle_rad: cap.angle_rad,
            torque_n_m: cap.torque_n_m,
            holding_n_m: thread.torque_limit_n_m(cap.angle_rad),
            thread,
        })
    }
}

impl ExternalHand {
    fn new(model: HandModel, position: HandVector, vibration: Vibration) -> Self {
        let rest = HandVector::zeros(position.len());
        let elements = model.skin().layout.layout().count;
        let tip = || ExternalTip {
            element_force_n: vec![Vector3::zeros(); elements],
            ..ExternalTip::default()
        };
        Self {
            pose: model.forward(&position),
            position,
            velocity: rest,
            effort: rest,
            vibration,
            tips: (0..model.fingertip_count()).map(|_| tip()).collect(),
            model,
        }
    }

    /// Starts a bump of the hand's fingertips.
    pub(crate) fn bump(&mut self, height_m: f64, duration_s: f64) {
        self.vibration.bump(height_m, duration_s);
    }

    /// Returns tremor and bump at the end of the tick, m.
    fn tremor_m(&mut self) -> f64 {
        let arm_rad_s = self
            .model
            .arm_joints()
            .map(|joint| self.velocity[joint].abs() / self.model.joints()[joint].radian())
            .fold(0.0, f64::max);
        self.vibration.blend(arm_rad_s > MOVING_RAD_S, TICK_S);
        let last = (0..SUBSTEPS).map(|_| self.vibration.step().0).last();
        last.unwrap_or(0.0)
    }

    /// Returns the grip if fingertips of both grasp sides press this object.
    pub(crate) fn grip_on(&self, object: usize) -> Option<Grip> {
        let presses = |finger: usize| {
            let tip = &self.tips[finger];
            tip.touched == Some(object) && tip.normal_n > 0.0
        };
        let grip = TickStart::from_pose(&self.pose).grip(&self.model, presses)?;
        Some(grip.raised(self.vibration.bump_m()))
    }

    pub(crate) fn tips(&self) -> &[ExternalTip] {
        &self.tips
    }

    pub(crate) fn bodies(&self) -> robot_model::Capsules {
        self.model.capsules(&self.pose)
    }
}

impl SensedHand for ExternalHand {
    fn model(&self) -> &HandModel {
        &self.model
    }

    fn joints(&self) -> JointMotion<'_> {
        JointMotion {
            position: &self.position,
            velocity: &self.velocity,
            effort: &self.effort,
        }
    }

    fn element_forces(&self, finger: usize, force_n: &mut [Vector3<f64>]) {
        force_n.copy_from_slice(&self.tips[finger].element_force_n);
    }
}
