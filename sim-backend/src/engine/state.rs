//! Data that an engine receives and returns each tick.

use robot_model::{HandSide, RobotModel};
use shm_schemas::JointSetpoints;

use crate::scene::Scene;

/// Input of one tick.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TickInput {
    /// Set-points of the drives: positions are reached at the end of the tick, rad or m.
    pub position: Vec<f64>,
    /// Velocities that the drives feed forward, rad/s or m/s.
    pub velocity: Vec<f64>,
    /// Vertical displacement of each hand by tremor and bumps, invisible to the encoders, m.
    pub tremor_m: [f64; 2],
    /// External force at the centre of mass of each object, base frame, N.
    pub pull_n: Vec<[f64; 3]>,
    /// Present stiffness of each object under one fingertip, N/m; infinite if rigid.
    pub stiffness_n_m: Vec<f64>,
}

/// State at the end of a tick.
#[derive(Clone, Debug, PartialEq)]
pub struct PhysicsState {
    /// True position of each joint, rad or m.
    pub position: Vec<f64>,
    /// True velocity of each joint, rad/s or m/s.
    pub velocity: Vec<f64>,
    /// Torque of each drive, N·m or N.
    pub effort: Vec<f64>,
    /// Force of objects on each element, tip frame, N; fingertips of the left hand first.
    pub element_force_n: Vec<Vec<[f64; 3]>>,
    /// Normal force of objects on each fingertip, N.
    pub normal_n: Vec<f64>,
    /// Distance that the surface has slid under each fingertip since its touch, m.
    pub slip_m: Vec<f64>,
    /// Object that each fingertip touches.
    pub touched: Vec<Option<usize>>,
    /// Objects in the order of the scene.
    pub objects: Vec<ObjectState>,
    /// Cap of the scene, if it has one.
    pub cap: CapState,
}

/// State of one object, base frame.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ObjectState {
    /// Middle of the shape, m.
    pub position_m: [f64; 3],
    /// Unit quaternion w, x, y, z.
    pub orientation: [f64; 4],
    /// Velocity of the middle, m/s.
    pub velocity_m_s: [f64; 3],
    /// Angular velocity, rad/s or m/s.
    pub angular_rad_s: [f64; 3],
    /// Vertical force of table, plates and rims on the object, N.
    pub support_n: f64,
}

/// State of a cap on its thread.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct CapState {
    /// True if the threads of cap and bottle are engaged.
    pub engaged: bool,
    /// Angle from engagement in the closing direction, rad.
    pub angle_rad: f64,
    /// Torque of the cap on the bottle in the closing direction, N·m.
    pub torque_n_m: f64,
}

impl TickInput {
    /// Returns an input of the right size for a scene, without set-points.
    pub(crate) fn new(robot: &RobotModel, scene: &Scene) -> Self {
        let (joints, objects) = (robot.joint_count(), scene.objects.len());
        Self {
            position: vec![0.0; joints],
            velocity: vec![0.0; joints],
            tremor_m: [0.0; 2],
            pull_n: vec![[0.0; 3]; objects],
            stiffness_n_m: vec![f64::INFINITY; objects],
        }
    }

    pub(crate) fn set(&mut self, setpoints: &JointSetpoints) {
        let joints = self.position.len();
        self.position.copy_from_slice(&setpoints.position[..joints]);
        self.velocity.copy_from_slice(&setpoints.velocity[..joints]);
    }

    /// Appends the message: positions, velocities, tremor, pulls, stiffnesses.
    pub(crate) fn write(&self, out: &mut Vec<u8>) {
        let values = self
            .position
            .iter()
            .chain(&self.velocity)
            .chain(&self.tremor_m);
        let values = values
            .chain(self.pull_n.as_flattened())
            .chain(&self.stiffness_n_m);
        values.for_each(|value| out.extend(value.to_le_bytes()));
    }
}

impl PhysicsState {
    /// Returns a state of the right size for a scene.
    pub(crate) fn new(robot: &RobotModel, scene: &Scene) -> Self {
        let joints = robot.joint_count();
        let elements = HandSide::BOTH.into_iter().flat_map(|side| {
            let hand = robot.hand(side);
            let elements = hand.skin().layout.layout().count;
            core::iter::repeat_n(vec![[0.0; 3]; elements], hand.fingertip_count())
        });
        let element_force_n: Vec<_> = elements.collect();
        let tips = element_force_n.len();
        Self {
            position: vec![0.0; joints],
            velocity: vec![0.0; joints],
            effort: vec![0.0; joints],
            element_force_n,
            normal_n: vec![0.0; tips],
            slip_m: vec![0.0; tips],
            touched: vec![None; tips],
            objects: vec![ObjectState::default(); scene.objects.len()],
            cap: CapState::default(),
        }
    }

    /// Returns the size of the message, bytes.
    pub(crate) fn message_bytes(&self) -> usize {
        let elements: usize = self.element_force_n.iter().map(Vec::len).sum();
        let (tips, joints) = (self.element_force_n.len(), self.position.len());
        size_of::<f64>() * (3 * joints + 3 * elements + 3 * tips + 14 * self.objects.len() + 3)
    }

    /// Reads the message. `None` if its size is wrong or a value is not finite.
    pub(crate) fn read(&mut self, message: &[u8]) -> Option<()> {
        if message.len() != self.message_bytes() {
            return None;
        }
        let (values, _) = message.as_chunks::<8>();
        let mut values = values.iter().map(|bytes| f64::from_le_bytes(*bytes));
        let mut next = || values.next().filter(|value| value.is_finite());
        let forces = self.element_force_n.iter_mut().flatten().flatten();
        let joints = self.position.iter_mut().chain(&mut self.velocity);
        let joints = joints.chain(&mut self.effort);
        let tips = self.normal_n.iter_mut().chain(&mut self.slip_m);
        for value in joints.chain(forces).chain(tips) {
            *value = next()?;
        }
        let objects = self.objects.len();
        for touched in &mut self.touched {
            let index = next()?;
            *touched = (index >= 0.0).then_some(index as usize);
            if touched.is_some_and(|index| index >= objects) {
                return None;
            }
        }
        for object in &mut self.objects {
            let vectors = object.position_m.iter_mut().chain(&mut object.orientation);
            let vectors = vectors
                .chain(&mut object.velocity_m_s)
                .chain(&mut object.angular_rad_s);
            for value in vectors.chain([&mut object.support_n]) {
                *value = next()?;
            }
        }
        self.cap = CapState {
            engaged: next()? != 0.0,
            angle_rad: next()?,
            torque_n_m: next()?,
        };
        Some(())
    }
}
