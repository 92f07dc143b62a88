//! One episode: simulated world with the acting hand around an object, advanced tick by tick.

use robot_model::{GraspPose, HandSide, HandVector, PerSide, RobotModel, RobotVector};
use std::ops::Range;

use atas_core::kinematics::HandCommand;
use atas_core::safety::{Gate, GateContext};
use atas_core::{SensorSetup, Settings, Tick};
use nalgebra::Vector3;
use shm_schemas::{Hand, JointCommand, Mode, WorldTruth};
use sim_backend::{Object, Scene, Sensed, World, home};

use crate::error::LearningError;
use crate::hand::{ACTIONS, PermittedRegion, PolicyHand, TICK_S};
use crate::observation::{Layout, PERCEPT};
use crate::task::Task;

/// Distance of each fingertip from the object at the start, m (equal to the daemon's
/// `motion.clearance_m`).
pub(crate) const CLEARANCE_M: f64 = 0.008;
/// Permitted motion of the hand beside, below and above its grasp pose, m (design choice).
const SIDEWAYS_M: f64 = 0.03;
const BELOW_M: f64 = 0.012;
const ABOVE_M: f64 = 0.08;
/// Clearance between fingertips and table at the lowest position of the hand, m (design choice).
const TABLE_CLEARANCE_M: f64 = 0.003;

pub(crate) struct Episode {
    world: World,
    scene: Scene,
    side: HandSide,
    sensed: Sensed,
    gate: Gate,
    hand: PolicyHand,
    /// Joint positions of the resting hand, rad.
    resting_rad: HandVector,
    /// Joint range of the acting hand within the robot.
    joints: Range<usize>,
    settings: Settings,
    source_m: Vector3<f64>,
    place_m: Option<Vector3<f64>>,
    index: u64,
}

impl Episode {
    /// Sets up the scene: the hand is open around the nominal position of the object.
    pub(crate) fn begin(
        robot: &RobotModel,
        task: Task,
        object: Object,
        seed: u64,
        noise_factor: f64,
    ) -> Result<Self, LearningError> {
        let side = robot.acting_side();
        let model = robot.hand(side);
        let mut scene = task.scene(model, object, seed);
        scene.noise_factor = noise_factor;
        // The sensors of the resting hand are not observed.
        scene.sensor_rate_hz[1 - side.index()] = 1;
        let hint = scene.grasp_hint(0).ok_or(LearningError::NoObject)?;
        let place_m = task.place(&scene).map(|place| Vector3::from(place.from_m));
        let source_m = Vector3::from(hint.from_m);
        let frame = GraspPose {
            hand_azimuth_rad: model.bearing_rad(&source_m),
            ..GraspPose::from_above(
                source_m,
                model.closing_yaw_rad(&source_m, hint.yaw_rad),
                hint.width_m + 2.0 * CLEARANCE_M,
            )
        };
        let q = model.posture_for(&frame).map_err(LearningError::Reach)?.q;
        let mut start = home(robot)?;
        start[robot.joint_range(side)].copy_from_slice(&q);
        scene.start = Some(start);
        let mut gate = Gate::new(robot, 1);
        gate.synchronise(&start);
        let other = HandSide::BOTH[1 - side.index()];
        let wiring = SensorSetup::from_robot(robot).hands[side.index()];
        let lowest_m = model.tip_radius_m().iter().copied().fold(0.0, f64::max) + TABLE_CLEARANCE_M;
        let room = permitted_region(&source_m, place_m.as_ref(), lowest_m);
        let mut episode = Self {
            world: World::new(robot, &scene, seed)?,
            sensed: Sensed::default(),
            gate,
            hand: PolicyHand::new(Hand::BOTH[side.index()], *model, &wiring, q, room),
            joints: robot.joint_range(side),
            scene,
            side,
            resting_rad: HandVector::from_slice(&start[robot.joint_range(other)]),
            settings: Settings::default(),
            source_m,
            place_m,
            index: 0,
        };
        episode.sense();
        Ok(episode)
    }

    /// Runs one tick: executes the action, then reads the sensors.
    pub(crate) fn tick(&mut self, action: &[f64; ACTIONS]) -> Result<(), LearningError> {
        let acting = self.hand.act(action);
        let command = self.pass(acting);
        self.world.advance(Some(&command));
        if let Some(fault) = self.world.fault() {
            return Err(fault.into());
        }
        self.sense();
        Ok(())
    }

    /// Passes the command through the safety gate; the resting hand does not move.
    fn pass(&mut self, acting: HandCommand) -> JointCommand {
        let resting = HandCommand::new(self.resting_rad, PerSide::repeat(0.0));
        let mut raw = [resting; 2];
        raw[self.side.index()] = acting;
        let mut grips = [self.hand.grip(); 2];
        grips[1 - self.side.index()].normal_n = PerSide::repeat(0.0);
        let joints = &self.sensed.joints;
        let measured = RobotVector::from_slice(&joints.position[..joints.joint_count as usize]);
        let safe = self.gate.pass(
            &raw,
            &grips,
            &GateContext {
                tick: self.now(),
                step_s: TICK_S,
                mode: Mode::RUN,
                measured: Some(&measured),
                joint_sequence: self.sensed.joints.stamp.sequence,
                grip_limit_n: [0.0; 2],
                settings: &self.settings.safety,
            },
        );
        let own = &self.gate.requested()[self.joints.clone()];
        self.hand.adopt(HandVector::from_slice(own));
        *safe.command()
    }

    fn sense(&mut self) {
        self.world.sense(&mut self.sensed);
        let tick = self.now();
        let frame = self.sensed.frames[self.side.index()].as_ref();
        self.hand.process_frame(frame, tick, &self.settings);
        let measured = self.measured();
        self.hand.evaluate_modules(&self.settings, &measured);
        self.index += 1;
    }

    fn now(&self) -> Tick {
        Tick {
            index: self.index,
            now_ns: self.world.now_ns(),
        }
    }

    fn measured(&self) -> HandVector {
        HandVector::from_slice(&self.sensed.joints.position[self.joints.clone()])
    }

    pub(crate) fn truth(&self) -> WorldTruth {
        self.world.truth()
    }

    /// Returns the nominal target of the object at grasp height, if the task has one.
    pub(crate) fn place_m(&self) -> Option<Vector3<f64>> {
        self.place_m
    }

    /// Returns the scene of the episode.
    pub(crate) fn scene(&self) -> &Scene {
        &self.scene
    }

    /// Returns the measured positions of all joints, rad or m.
    pub(crate) fn positions(&self) -> &[f64] {
        let joints = &self.sensed.joints;
        &joints.position[..joints.joint_count as usize]
    }

    /// Writes the observation; `row` has the size of `layout`.
    pub(crate) fn observe(&self, layout: &Layout, row: &mut [f32]) {
        let parts = layout.parts();
        let (taxels, row_rest) = row.split_at_mut(parts[0].len());
        let (joints, row_rest) = row_rest.split_at_mut(parts[1].len());
        let (percept, row_rest) = row_rest.split_at_mut(parts[2].len());
        let (modules, hand) = row_rest.split_at_mut(parts[3].len());
        if let Some(frame) = &self.sensed.frames[self.side.index()] {
            for (tip, force_n) in taxels
                .chunks_exact_mut(3 * layout.taxels)
                .zip(&frame.force_n)
            {
                tip.copy_from_slice(force_n[..layout.taxels].as_flattened());
            }
        }
        let state = &self.sensed.joints;
        for (values, joint) in joints.chunks_exact_mut(3).zip(self.joints.clone()) {
            values[0] = state.position[joint] as f32;
            values[1] = state.velocity[joint] as f32;
            values[2] = state.effort[joint] as f32;
        }
        let fingers = &self.hand.percept().fingertips;
        for (values, finger) in percept.chunks_exact_mut(PERCEPT).zip(fingers) {
            values.copy_from_slice(&[
                finger.normal_n as f32,
                finger.tangential_n as f32,
                finger.increment_n as f32,
                finger.utilisation as f32,
                finger.friction as f32,
                f32::from(u8::from(finger.in_contact)),
            ]);
        }
        for (value, active) in modules.iter_mut().zip(self.hand.active) {
            *value = f32::from(u8::from(active));
        }
        let frame = self.hand.grasp_pose();
        let from_source_m = frame.centre_m - self.source_m;
        let to_place_m = self
            .place_m
            .map_or(Vector3::zeros(), |place_m| place_m - frame.centre_m);
        let [first_m, second_m] = frame.half_opening_m.into_array();
        let reported = from_source_m
            .iter()
            .chain([&first_m, &second_m])
            .chain(to_place_m.iter());
        hand.iter_mut()
            .zip(reported)
            .for_each(|(value, reported)| *value = *reported as f32);
        layout.bound(row);
    }
}

/// Returns the permitted region of the hand around object and target.
fn permitted_region(
    source_m: &Vector3<f64>,
    place_m: Option<&Vector3<f64>>,
    lowest_m: f64,
) -> PermittedRegion {
    let place_m = place_m.unwrap_or(source_m);
    let beside = Vector3::new(SIDEWAYS_M, SIDEWAYS_M, 0.0);
    let mut low_m = source_m.inf(place_m) - beside;
    let mut high_m = source_m.sup(place_m) + beside;
    low_m.z = (low_m.z - BELOW_M).max(lowest_m);
    high_m.z += ABOVE_M;
    PermittedRegion { low_m, high_m }
}
