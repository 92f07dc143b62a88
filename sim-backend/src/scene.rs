//! Scenes: objects and their poses, sensor quality, and the differences between reality and the
//! client's data.
//!
//! A scene has a nominal side, which a client may know ([`Scene::grasp_hint`]), and a true side,
//! which only the world knows. `tasks.rs` defines the scenes of the paper's tasks.
//! [`Scene::varied`] varies the true side within the seeded family of the evaluation.
//! [`Scene::with_errors`] adds deviations of robot, skin and objects from the controller's model.

use core::f64::consts::FRAC_PI_2;

use robot_model::{GraspPose, HandModel, HandSide, RobotModel, RobotVector, Unreachable};

use crate::object::Object;
use crate::pad::MissingElementPositions;
use crate::range::{OutOfRange, in_range};
use crate::sensor_model::{Rejection, SensorModel};
use crate::shape::Shape;
use crate::support::Plate;

mod error_spec;
mod errors;
mod family;
mod sensor_errors;
mod tasks;

pub use error_spec::ErrorSpecError;
pub use errors::{ErrorKind, Errors};
pub use sensor_errors::SensorErrors;

/// Largest number of objects, the capacity of [`shm_schemas::WorldTruth`].
pub const OBJECTS_MAX: usize = 4;
/// Default object position: x, and the distance from the midline towards the acting hand, m. Well
/// within the verified workspace, in a direction that keeps the wrist nearly straight.
const DEFAULT_PLACE_M: [f64; 2] = [0.32, 0.15];
/// Default closing axis: along y, so that both hands can work next to each other (robot design).
const DEFAULT_YAW_RAD: f64 = FRAC_PI_2;
/// Lowest grasp height, m (robot design: dome centre ≥ 16 mm, grasp height ≥ 25 mm).
const GRASP_HEIGHT_MIN_M: f64 = 0.025;
/// Grasp height over half height (prototype). Above the centre of mass, so that the object is
/// suspended stably.
const GRASP_HEIGHT_RATIO: f64 = 1.15;
/// Smallest distance of a grasp from the object's top, m (prototype): the dome's contact patch must
/// fit.
const GRASP_BELOW_TOP_M: f64 = 0.010;
/// Amplitude of the hand tremor, m (tactile design).
const VIBRATION_M: f64 = 1e-5;
/// Deepest grasp below an object's top, m. Design choice: the approach starts 60 mm above the
/// grasp, and domes (15 mm) must clear the top.
const GRASP_DEPTH_MAX_M: f64 = 0.040;
/// Clearance between an object's top and the palm, m. Design choice: the controller's clearance
/// margin plus 2 mm.
const GRASP_BELOW_PALM_M: f64 = 0.012;
/// Largest distance of an object from the robot along one axis, m. Design choice: the size of a
/// course's field.
const FARTHEST_M: f64 = 10.0;
/// Rate of a sensor with one sample per tick, Hz.
const FULL_RATE_HZ: u32 = 1000;

/// Object with its pose.
#[derive(Clone, Debug, PartialEq)]
pub struct Placed {
    /// True object.
    pub object: Object,
    /// True position on the table: x, y, base frame, m.
    pub position_m: [f64; 2],
    /// Direction of the object's x axis, rad from +x towards +y.
    pub yaw_rad: f64,
    /// Fixture of the object.
    pub mount: Mount,
    /// Data for clients.
    nominal: GraspHint,
}

/// Fixture of an object at the start.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Mount {
    /// Stands on the table or on a plate by its weight.
    #[default]
    Standing,
    /// Immovable clamp.
    Clamped,
    /// Cap on the neck of the scene's bottle, not turned yet, at the bottle's position.
    OnNeck,
}

/// Grasp goal from a client's nominal knowledge.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GraspHint {
    /// Point where the fingertips close, base frame, m.
    pub from_m: [f64; 3],
    /// Direction of the closing axis, rad from +x towards +y.
    pub yaw_rad: f64,
    /// Width along the closing axis, m.
    pub width_m: f64,
    /// Height of the object's top, base frame, m.
    pub height_m: f64,
}

/// Start state of a world, without the seed.
#[derive(Clone, Debug, PartialEq)]
pub struct Scene {
    /// Objects, at most [`OBJECTS_MAX`].
    pub objects: Vec<Placed>,
    /// Plates on the table.
    pub plates: Vec<Plate>,
    /// Nominal place of the first object: where the fingertips open. For a cap, the bottle's neck.
    pub place: Option<GraspHint>,
    /// Sensor rate of each hand, 1 to 1000 frames per second; left, right.
    pub sensor_rate_hz: [u32; 2],
    /// Factor on the noise of the fingertip sensors; 1 is the noise of the model, 0 is none.
    pub noise_factor: f64,
    /// Model of the fingertip sensors; the world's seed draws its random values.
    pub sensor_model: SensorModel,
    /// Amplitude of the hand tremor, m.
    pub vibration_m: f64,
    /// Joint positions at the start, rad; `None` is home.
    pub start: Option<RobotVector>,
    /// Deviations of robot and sensors from the controller's model; the world's seed draws them.
    /// Set with [`Scene::with_errors`], which also draws the object deviations.
    pub errors: Errors,
}

/// Reason why a scene is rejected.
#[derive(Debug, thiserror::Error)]
pub enum SceneError {
    /// Too many objects.
    #[error("scene rejected: it has {0} objects, needs at most {OBJECTS_MAX}; remove some")]
    TooManyObjects(usize),
    /// Value out of range.
    #[error(transparent)]
    OutOfRange(#[from] OutOfRange),
    /// Sensor model that cannot be simulated.
    #[error("scene rejected: in the sensor model, {0}; correct the model")]
    SensorModel(#[from] Rejection),
    /// Skin without element positions.
    #[error(transparent)]
    NoPlaces(#[from] MissingElementPositions),
    /// Cap on a neck without a bottle.
    #[error("scene rejected: a cap is on a neck, but no bottle has one; add a bottle with a neck")]
    NoBottle,
    /// Object on a neck without a thread.
    #[error(
        "scene rejected: {0:?} is on a bottle's neck but has no thread; add a thread or let the \
         object stand"
    )]
    NoThread(String),
    /// Failure of an external engine.
    #[error(transparent)]
    Engine(#[from] crate::engine::EngineError),
    /// Home posture out of reach.
    #[error("cannot move the {side:?} hand to its home posture: {source}")]
    HomeUnreachable {
        /// Hand.
        side: HandSide,
        /// Remaining error of the best posture.
        source: Unreachable,
    },
}

impl Default for Scene {
    /// Returns an empty table with full-rate sensors, the design's noise and tremor, and hands at
    /// home.
    fn default() -> Self {
        Self {
            objects: Vec::new(),
            plates: Vec::new(),
            place: None,
            sensor_rate_hz: [FULL_RATE_HZ; 2],
            noise_factor: 1.0,
            sensor_model: SensorModel::default(),
            vibration_m: VIBRATION_M,
            start: None,
            errors: Errors::NONE,
        }
    }
}

impl Placed {
    /// Returns an object whose pose clients know exactly.
    #[must_use]
    pub fn new(object: Object, position_m: [f64; 2], yaw_rad: f64) -> Self {
        let from_m = [position_m[0], position_m[1], grasp_height_m(&object.shape)];
        let nominal = GraspHint {
            from_m,
            yaw_rad,
            width_m: object.shape.width_m(),
            height_m: 2.0 * object.shape.half_height_m(),
        };
        Self {
            object,
            position_m,
            yaw_rad,
            mount: Mount::default(),
            nominal,
        }
    }

    /// Returns an object at the default position of one hand, its x axis along the default closing
    /// axis.
    #[must_use]
    pub fn in_front_of(object: Object, side: HandSide) -> Self {
        let [x_m, off_middle_m] = DEFAULT_PLACE_M;
        Self::new(object, [x_m, side.y_sign() * off_middle_m], DEFAULT_YAW_RAD)
    }
}

impl Scene {
    /// Returns a scene with one object in front of one hand.
    #[must_use]
    pub fn grasp(object: Object, side: HandSide) -> Self {
        Self {
            objects: vec![Placed::in_front_of(object, side)],
            ..Self::default()
        }
    }

    /// Sets the model of the fingertip sensors, and their rate if the model has one.
    pub fn set_sensor_model(&mut self, model: SensorModel) {
        if let Some(rate_hz) = model.rate_hz {
            self.sensor_rate_hz = [rate_hz; 2];
        }
        self.sensor_model = model;
    }

    /// Returns the scene moved to another robot's hand.
    ///
    /// The first object moves to that hand's object position; everything else moves with it and
    /// rotates with the hand's closing axis. Grasp heights keep the palm clear of the objects. For
    /// the two-hand arm nothing changes.
    #[must_use]
    pub fn moved_to_hand(mut self, hand: &HandModel) -> Self {
        let [x_m, off_middle_m] = DEFAULT_PLACE_M;
        let meant_m = [x_m, hand.side().y_sign() * off_middle_m];
        let turn_rad = hand.home_yaw_rad() - DEFAULT_YAW_RAD;
        if meant_m == hand.object_m() && turn_rad == 0.0 {
            return self;
        }
        let (sin, cos) = libm::sincos(turn_rad);
        let moved = |[x, y]: [f64; 2]| {
            let [dx, dy] = [x - meant_m[0], y - meant_m[1]];
            let [to_x, to_y] = hand.object_m();
            [to_x + cos * dx - sin * dy, to_y + sin * dx + cos * dy]
        };
        let room_m = hand.room_over_tips_m() - GRASP_BELOW_PALM_M;
        let move_hint = |hint: &mut GraspHint| {
            let [x, y, z] = hint.from_m;
            let [x, y] = moved([x, y]);
            hint.from_m = [x, y, z.max(hint.height_m - room_m)];
            hint.yaw_rad += turn_rad;
        };
        for placed in &mut self.objects {
            placed.position_m = moved(placed.position_m);
            placed.yaw_rad += turn_rad;
            move_hint(&mut placed.nominal);
        }
        for plate in &mut self.plates {
            plate.centre_m = moved(plate.centre_m);
        }
        self.place.iter_mut().for_each(move_hint);
        self.move_place_into_reach(hand);
        self
    }

    /// Returns the nominal grasp of the object with this index; `None` if it does not exist.
    #[must_use]
    pub fn grasp_hint(&self, index: usize) -> Option<GraspHint> {
        self.objects.get(index).map(|placed| placed.nominal)
    }

    /// Rejects scenes that cannot be simulated.
    pub(crate) fn check(&self) -> Result<(), SceneError> {
        if self.objects.len() > OBJECTS_MAX {
            return Err(SceneError::TooManyObjects(self.objects.len()));
        }
        in_range("the noise factor", self.noise_factor, 0.0, 100.0)?;
        in_range("the vibration in metres", self.vibration_m, 0.0, 1e-3)?;
        for rate_hz in self.sensor_rate_hz {
            in_range(
                "the sensor rate in hertz",
                f64::from(rate_hz),
                1.0,
                f64::from(FULL_RATE_HZ),
            )?;
        }
        self.sensor_model.check()?;
        self.errors.check()?;
        self.check_positions()?;
        for angle_rad in self.start.iter().flat_map(|start| start.iter()) {
            in_range("a start angle in radians", *angle_rad, -10.0, 10.0)?;
        }
        Ok(())
    }

    fn check_positions(&self) -> Result<(), SceneError> {
        for placed in &self.objects {
            let [x_m, y_m] = placed.position_m;
            in_range("an object's x in metres", x_m, -FARTHEST_M, FARTHEST_M)?;
            in_range("an object's y in metres", y_m, -FARTHEST_M, FARTHEST_M)?;
            in_range("an object's yaw in radians", placed.yaw_rad, -10.0, 10.0)?;
        }
        for plate in &self.plates {
            in_range("a plate's x in metres", plate.centre_m[0], -2.0, 2.0)?;
            in_range("a plate's y in metres", plate.centre_m[1], -2.0, 2.0)?;
            in_range("a plate's height in metres", plate.height_m, 0.0, 0.5)?;
        }
        let is_on_neck = |placed: &Placed| placed.mount == Mount::OnNeck;
        let has_neck = |placed: &Placed| placed.object.neck.is_some();
        let fits = |placed: &&Placed| is_on_neck(placed) && placed.object.thread.is_none();
        if self.objects.iter().any(is_on_neck) && !self.objects.iter().any(has_neck) {
            return Err(SceneError::NoBottle);
        }
        match self.objects.iter().find(fits) {
            Some(placed) => Err(SceneError::NoThread(placed.object.name.clone())),
            None => Ok(()),
        }
    }

    pub(crate) fn start(&self, robot: &RobotModel) -> Result<RobotVector, SceneError> {
        self.start.map_or_else(|| home(robot), Ok)
    }
}

/// Returns the home posture: every hand open, pointing down, at the rest position of its robot
/// file.
///
/// # Errors
/// [`SceneError::HomeUnreachable`] if the robot's dimensions do not allow this posture.
pub fn home(robot: &RobotModel) -> Result<RobotVector, SceneError> {
    let mut home = RobotVector::zeros(robot.joint_count());
    for side in robot.sides() {
        let hand = robot.hand(side);
        let centre_m = hand.home_m();
        let yaw_rad = hand.closing_yaw_rad(&centre_m, hand.home_yaw_rad());
        let posture = hand
            .posture_for(&GraspPose::from_above(
                centre_m,
                yaw_rad,
                hand.home_opening_m(),
            ))
            .map_err(|source| SceneError::HomeUnreachable { side, source })?;
        home[robot.joint_range(side)].copy_from_slice(&posture.q);
    }
    Ok(home)
}

fn grasp_height_m(shape: &Shape) -> f64 {
    let half_m = shape.half_height_m();
    let top_m = 2.0 * half_m;
    (GRASP_HEIGHT_RATIO * half_m)
        .max(top_m - GRASP_DEPTH_MAX_M)
        .min(top_m - GRASP_BELOW_TOP_M)
        .max(GRASP_HEIGHT_MIN_M)
}

/// Random streams of a seed. Separate streams keep draws independent of each other.
pub(crate) mod stream {
    pub(crate) const FAMILY: u64 = 1;
    pub(crate) const EPOCH: u64 = 2;
    /// Plus the channel's index.
    pub(crate) const FAULTS: u64 = 3;
    /// Plus the hand's index.
    pub(crate) const VIBRATION: u64 = 10;
    /// Plus the fingertip's index, left before right.
    pub(crate) const TIP_SENSOR: u64 = 20;
    /// Plus the fingertip's index, left before right.
    pub(crate) const TIP_ERRORS: u64 = 30;
    /// Plus the hand's index.
    pub(crate) const HAND_ERRORS: u64 = 40;
    /// A course's layout; `FLOOR` plus the robot's index: the floor under a robot.
    pub(crate) const COURSE: u64 = 90;
    pub(crate) const FLOOR: u64 = 91;
    /// Noise of a fingertip on the bench.
    pub(crate) const BENCH: u64 = 45;
    /// Errors of the first object; each further object adds five.
    pub(crate) const OBJECT_ERRORS: u64 = 50;
    /// Crosstalk and offsets of a sensor model, plus the fingertip's index, left before right.
    pub(crate) const MODEL_AXES: u64 = 100;
    /// Plus the fingertip's index, left before right.
    pub(crate) const DEAD_ELEMENTS: u64 = 110;
    /// Plus the fingertip's index, left before right.
    pub(crate) const DRIFT_ERRORS: u64 = 120;
    /// Latency, jitter and loss of frames, plus the hand's index.
    pub(crate) const TRANSPORT: u64 = 130;
}
