//! Scenes: which objects stand where, how good the sensors are, and how reality differs from what a client is told.
//!
//! A scene has a nominal side, which a client may know ([`Scene::grasp_hint`]), and a true side, which only the world
//! knows. `tasks.rs` sets the scenes of the paper's tasks. [`Scene::varied`] moves the true side within the seeded family of
//! the evaluation and leaves the nominal alone; [`Scene::with_errors`] goes further, to robots, skins and objects that
//! are not as the controller was made for.

use core::f64::consts::FRAC_PI_2;

use robot_model::{GraspFrame, HandModel, RobotModel, RobotVector, Side, Unreachable};

use crate::object::Object;
use crate::pad::NoPlaces;
use crate::range::{OutOfRange, in_range};
use crate::shape::Shape;
use crate::support::Plate;

mod error_spec;
mod errors;
mod family;
mod tasks;

pub use error_spec::ErrorSpecError;
pub use errors::{ErrorKind, Errors};

/// Objects in one scene, the capacity of [`shm_schemas::WorldTruth`].
pub const OBJECTS_MAX: usize = 4;
/// Where objects stand by default: x, and the distance from the middle towards the acting hand, m. Well inside the proved
/// workspace, and on a bearing that leaves the wrist nearly straight.
const DEFAULT_PLACE_M: [f64; 2] = [0.32, 0.15];
/// Default closing axis: along y, so that both hands may work side by side (robot design).
const DEFAULT_YAW_RAD: f64 = FRAC_PI_2;
/// Lowest grasp height, m (robot design: dome centre ≥ 16 mm, grasp height ≥ 25 mm).
const GRASP_HEIGHT_MIN_M: f64 = 0.025;
/// A grasp aims a little above the centre of mass, so that the object hangs: height over half height (prototype).
const GRASP_HEIGHT_RATIO: f64 = 1.15;
/// Distance that a grasp keeps from the object's top, m (prototype): the dome's contact patch must fit.
const GRASP_BELOW_TOP_M: f64 = 0.010;
/// Amplitude of the hands' tremble, m (tactile design).
const VIBRATION_M: f64 = 1e-5;
/// Deepest grasp below an object's top, m. Ours: the hand comes in 60 mm above its grasp, and its domes (15 mm) must clear
/// the top of what it shall grasp.
const GRASP_DEPTH_MAX_M: f64 = 0.040;
/// Distance that an object's top keeps from what carries a hand's fingers, m (ours: what the controller asks for, and 2 mm).
const GRASP_BELOW_PALM_M: f64 = 0.012;
/// Farthest that an object may stand from the robot along one axis, m. Ours: across the field of a course.
const FARTHEST_M: f64 = 10.0;
/// Rate of a sensor that keeps up with the tick, Hz.
const FULL_RATE_HZ: u32 = 1000;

/// An object with its place.
#[derive(Clone, Debug, PartialEq)]
pub struct Placed {
    /// What it truly is.
    pub object: Object,
    /// Where it truly stands on the table: x, y, base frame, m.
    pub position_m: [f64; 2],
    /// Direction of its x axis, rad from +x towards +y.
    pub yaw_rad: f64,
    /// What holds it there.
    pub mount: Mount,
    /// What a client is told.
    nominal: GraspHint,
}

/// What holds an object in its place at the start.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Mount {
    /// Its weight: it stands on the table or on a plate.
    #[default]
    Standing,
    /// A clamp that never gives way.
    Clamped,
    /// The neck of the scene's bottle: a cap put on, not turned yet. Its position is the bottle's.
    OnNeck,
}

/// Where a client would grasp an object, from nominal knowledge: the fields of a goal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GraspHint {
    /// Where the fingertips shall close, base frame, m.
    pub from_m: [f64; 3],
    /// Direction of the closing axis, rad from +x towards +y.
    pub yaw_rad: f64,
    /// Width along the closing axis, m.
    pub width_m: f64,
    /// Height of the object's top, base frame, m.
    pub height_m: f64,
}

/// Everything that a world starts from, but the seed.
#[derive(Clone, Debug, PartialEq)]
pub struct Scene {
    /// The objects, at most [`OBJECTS_MAX`].
    pub objects: Vec<Placed>,
    /// What stands on the table for objects to stand on.
    pub plates: Vec<Plate>,
    /// Where a client is told to put the first object: where the fingertips shall open. For a cap that is the bottle's neck.
    pub place: Option<GraspHint>,
    /// Frames per second of each hand's sensor, 1 to 1000; left, right.
    pub sensor_rate_hz: [u32; 2],
    /// Scales the noise of the fingertip sensors; 1 is the design's, 0 is none.
    pub noise_factor: f64,
    /// Amplitude of the hands' tremble, m.
    pub vibration_m: f64,
    /// Joints at the start, rad; `None` is home.
    pub start_rad: Option<RobotVector>,
    /// How far robot and sensors may lie from what the controller was made for; the world draws them by its seed. Set it
    /// with [`Scene::with_errors`], which draws those of the objects as well.
    pub errors: Errors,
}

/// Why a world could not be made from a scene.
#[derive(Debug, thiserror::Error)]
pub enum SceneError {
    /// More objects than fit.
    #[error(
        "could not set the scene because it has {0} objects, needs at most {OBJECTS_MAX}; take some away"
    )]
    TooManyObjects(usize),
    /// A number is out of range.
    #[error(transparent)]
    OutOfRange(#[from] OutOfRange),
    /// A skin whose elements nobody has placed cannot touch.
    #[error(transparent)]
    NoPlaces(#[from] NoPlaces),
    /// A cap has no neck to be on.
    #[error(
        "could not put a cap on because the scene has no bottle, needs one with a neck; add it"
    )]
    NoBottle,
    /// What is on the neck is no cap.
    #[error(
        "could not put {0:?} on the bottle because it has no thread; give it one or let it stand"
    )]
    NoThread(String),
    /// The home posture is out of this robot's reach.
    #[error("could not bring the {side:?} hand home: {source}")]
    HomeUnreachable {
        /// Which hand.
        side: Side,
        /// How far off the best posture is.
        source: Unreachable,
    },
}

impl Default for Scene {
    /// An empty table, full-rate sensors, the design's noise and tremble, hands at home.
    fn default() -> Self {
        Self {
            objects: Vec::new(),
            plates: Vec::new(),
            place: None,
            sensor_rate_hz: [FULL_RATE_HZ; 2],
            noise_factor: 1.0,
            vibration_m: VIBRATION_M,
            start_rad: None,
            errors: Errors::NONE,
        }
    }
}

impl Placed {
    /// An object at a place, known to clients exactly.
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

    /// An object at the default place of one hand, its x axis along the default closing axis.
    #[must_use]
    pub fn before(object: Object, side: Side) -> Self {
        let [x_m, off_middle_m] = DEFAULT_PLACE_M;
        Self::new(object, [x_m, side.y_sign() * off_middle_m], DEFAULT_YAW_RAD)
    }
}

impl Scene {
    /// One object in front of one hand.
    #[must_use]
    pub fn grasp(object: Object, side: Side) -> Self {
        Self {
            objects: vec![Placed::before(object, side)],
            ..Self::default()
        }
    }

    /// The same scene before another robot's hand: its first object where that hand has its objects, all else beside it as it
    /// was, everything turned as that hand closes, and grasped so high that the hand's palm keeps clear of it. For the two-hand
    /// arm nothing changes.
    #[must_use]
    pub fn before(mut self, hand: &HandModel) -> Self {
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
        self.place_in_reach(hand);
        self
    }

    /// Where a client would grasp the object with this index; `None` if there is none.
    #[must_use]
    pub fn grasp_hint(&self, index: usize) -> Option<GraspHint> {
        self.objects.get(index).map(|placed| placed.nominal)
    }

    /// Refuses what cannot be simulated.
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
        self.errors.check()?;
        self.check_places()?;
        for angle_rad in self.start_rad.iter().flat_map(|start_rad| start_rad.iter()) {
            in_range("a start angle in radians", *angle_rad, -10.0, 10.0)?;
        }
        Ok(())
    }

    fn check_places(&self) -> Result<(), SceneError> {
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

    /// Joint angles at the start.
    pub(crate) fn start(&self, robot: &RobotModel) -> Result<RobotVector, SceneError> {
        self.start_rad.map_or_else(|| home_rad(robot), Ok)
    }
}

/// The home posture: every hand where its robot file has it rest, pointing down, open.
///
/// # Errors
/// [`SceneError::HomeUnreachable`] for a robot of other dimensions that cannot get there.
pub fn home_rad(robot: &RobotModel) -> Result<RobotVector, SceneError> {
    let mut home_rad = RobotVector::zeros(robot.joint_count());
    for side in robot.sides() {
        let hand = robot.hand(side);
        let centre_m = hand.home_m();
        let yaw_rad = hand.closing_yaw_rad(&centre_m, hand.home_yaw_rad());
        let posture = hand
            .posture_for(&GraspFrame::from_above(
                centre_m,
                yaw_rad,
                hand.home_opening_m(),
            ))
            .map_err(|source| SceneError::HomeUnreachable { side, source })?;
        home_rad[robot.joint_range(side)].copy_from_slice(&posture.q_rad);
    }
    Ok(home_rad)
}

/// Height of a grasp on an object of this shape above what it stands on, m.
fn grasp_height_m(shape: &Shape) -> f64 {
    let half_m = shape.half_height_m();
    let top_m = 2.0 * half_m;
    (GRASP_HEIGHT_RATIO * half_m)
        .max(top_m - GRASP_DEPTH_MAX_M)
        .min(top_m - GRASP_BELOW_TOP_M)
        .max(GRASP_HEIGHT_MIN_M)
}

/// Streams of a seed, so that adding a draw in one place changes nothing in another.
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
    /// A course's layout, and the floor under its robots, plus the robot's index.
    pub(crate) const COURSE: u64 = 90;
    pub(crate) const FLOOR: u64 = 91;
    /// The noise of a fingertip off its hand.
    pub(crate) const BENCH: u64 = 45;
    /// Plus five for every object before it.
    pub(crate) const OBJECT_ERRORS: u64 = 50;
}
