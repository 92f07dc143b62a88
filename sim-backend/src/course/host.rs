//! Host of a course, used in process and on the bus: publishes states and executes commands.
//!
//! ```text
//!  every frame:  BaseState ─▶ coordinator ─ BaseCommand ─▶ row ─▶ table ─ Wheels ─▶ base
//!  every tick:   step ─ base motion ─▶ world of the robot's hands ─▶ measurement
//! ```

use field::Wheels;
use robot_model::{GraspSides, RobotModel};
use serde::{Deserialize, Serialize};
use shm_schemas::layout::{FNV_OFFSET, fnv1a};
use shm_schemas::{BaseCommand, BaseState, ControlOwner, Light, Mishap, WorldTruth};

use super::drive::{Drive, DriveFigures};
use super::rovers::{self, Course};
use super::scenario::{SIDE, Scenario};
use super::{FRAME_STEPS, STEP_TICKS};
use crate::base_motion::BaseMotion;

/// Ticks per frame.
pub const FRAME_TICKS: u64 = FRAME_STEPS * STEP_TICKS;
/// Ticks before the first frame, until the controllers are ready (`atas_core`: 20 fault-free
/// ticks).
pub const SETTLE_TICKS: u64 = 20;

/// Course in progress.
#[derive(Clone, Debug)]
pub struct Host {
    course: Course,
    robots: Vec<Robot>,
    /// Grasp sides of the working hand of every robot.
    sides: GraspSides,
    ticks: u64,
}

/// Final result of a robot.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RobotResult {
    /// Name of its object.
    pub object: String,
    /// Mishap that ended its course, as text.
    pub mishap: Option<String>,
    /// Grip measurements of the drive, if any.
    pub drive: Option<DriveFigures>,
    /// True distance of the object from the goal, m.
    pub off_goal_m: f64,
    /// Simulated time since the first frame, s.
    pub simulated_s: f64,
}

#[derive(Clone, Copy, Debug, Default)]
struct Robot {
    command: BaseCommand,
    drive: Option<Drive>,
}

impl Host {
    /// Creates the course before its first frame, with the model of its robots.
    #[must_use]
    pub fn new(cast: &Scenario, robot: &RobotModel) -> Self {
        Self {
            sides: robot.hand(SIDE).grasp_sides(),
            course: Course::new(&cast.layout, Some(cast.floor_seed)),
            robots: vec![Robot::default(); cast.robots.len()],
            ticks: 0,
        }
    }

    /// Hash of the fixed parameters of all courses; tables reject another field.
    #[must_use]
    pub fn field_hash() -> u64 {
        fnv1a(FNV_OFFSET, b"atas course v2")
    }

    /// Returns the number of ticks since the first frame.
    #[must_use]
    pub fn ticks(&self) -> u64 {
        self.ticks
    }

    /// Returns true if a frame starts in this tick.
    #[must_use]
    pub fn frame_begins(&self) -> bool {
        self.ticks.is_multiple_of(FRAME_TICKS)
    }

    /// Returns true if a robot's course is over.
    #[must_use]
    pub fn is_over(&self, robot: usize) -> bool {
        self.robots[robot].command.owner == ControlOwner::OVER
    }

    /// Returns the state of a base, with the object's position from the world of the hands.
    pub fn base_state(&mut self, robot: usize, truth: &WorldTruth) -> BaseState {
        let (place, object) = (self.course.pose(robot), &truth.objects[0]);
        let [x_m, y_m, _] = object.position_m;
        let stands = object.table_n > 0.0;
        self.course
            .set_object(robot, stands.then(|| place.point_m([x_m, y_m])));
        let sees = |light| self.course.relative_m(robot, light).unwrap_or_default();
        BaseState {
            frame: self.ticks / FRAME_TICKS,
            object_m: sees(rovers::Light::Object),
            goal_m: sees(rovers::Light::Goal),
            right_of_way_m: self
                .course
                .distance_to_priority_m(robot)
                .unwrap_or(f64::INFINITY),
            object_stands: stands.into(),
            wheels_stopped: self.course.is_at_rest(robot).into(),
            mishap: self.course.mishap(robot).unwrap_or(Mishap::NONE),
            ..BaseState::default()
        }
    }

    /// Returns the table row; `None` if the table does not control the base.
    #[must_use]
    pub fn row(&self, robot: usize, command: &BaseCommand) -> Option<u8> {
        let drives = command.owner == ControlOwner::TABLE;
        drives.then(|| self.course.sense(robot, light(command.light)))
    }

    /// Executes a command for this frame, with the table's response.
    pub fn execute(
        &mut self,
        robot: usize,
        command: &BaseCommand,
        wheels: Option<Wheels>,
        truth: &WorldTruth,
    ) {
        let robot_state = &mut self.robots[robot];
        robot_state.command = *command;
        let carries = command.light == Light::GOAL && command.owner == ControlOwner::TABLE;
        if carries && robot_state.drive.is_none() {
            robot_state.drive = Some(Drive::begin(truth, self.sides));
        }
        if command.owner == ControlOwner::OVER {
            return self.course.finish(robot);
        }
        let wheels = wheels.unwrap_or(Wheels::STOP);
        let pace = light(command.light).pace();
        self.course.steer(robot, wheels, pace);
    }

    /// Simulates one tick of the bases; the worlds of the hands follow.
    pub fn step(&mut self) {
        if self.ticks.is_multiple_of(STEP_TICKS) {
            self.course.step();
        }
        self.ticks += 1;
    }

    /// Returns the motion of a base in the current tick.
    #[must_use]
    pub fn base_motion(&self, robot: usize) -> BaseMotion {
        self.course.base_motion(robot)
    }

    /// Measures the grip during a drive; calls `truth` only then.
    pub fn measure(&mut self, robot: usize, truth: impl FnOnce() -> WorldTruth) {
        let ride = self.course.base_motion(robot);
        let Robot { command, drive } = &mut self.robots[robot];
        if let Some(drive) = drive
            .as_mut()
            .filter(|_| command.owner != ControlOwner::HAND)
        {
            drive.record(&truth(), &ride);
        }
    }

    /// Returns the result of a robot.
    #[must_use]
    pub fn result(&self, robot: usize, truth: &WorldTruth) -> RobotResult {
        let object = &truth.objects[0];
        let [x_m, y_m, _] = object.position_m;
        let goal_m = self.course.relative_m(robot, rovers::Light::Goal);
        let [goal_x_m, goal_y_m] = goal_m.unwrap_or_default();
        RobotResult {
            object: object.name.as_str().to_owned(),
            mishap: self.course.mishap(robot).map(|mishap| mishap.to_string()),
            drive: self.robots[robot].drive.as_ref().map(Drive::figures),
            off_goal_m: libm::hypot(x_m - goal_x_m, y_m - goal_y_m),
            simulated_s: self.ticks as f64 * 1e-3,
        }
    }
}

/// An unknown code selects the object, as at the start.
fn light(code: Light) -> rovers::Light {
    match code {
        Light::GOAL => rovers::Light::Goal,
        _ => rovers::Light::Object,
    }
}
