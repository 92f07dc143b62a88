//! Simulation of one course with a table; hands are reduced to time delays.

use atas_evaluation::hybrid::{Conditions, ControlOwner, Coordinator, Ended, HandState, HandTask};
use sim_backend::course::{Course, FRAME_S, FRAME_STEPS, Layout, Light, Responses, Wheels};

/// Typical duration of grasp and lift, and of setting down, frames.
const GRASP_FRAMES: u32 = 130;
const SET_DOWN_FRAMES: u32 = 90;
/// Frames after which an offline run ends. Design choice: three times the duration of a good table.
pub const FRAMES_MAX: u32 = 2400;

/// Result of one robot.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RobotResult {
    /// Progress: 0 at the start, 1 with the object in the hand, 2 when done at the goal. Fractions
    /// are the covered share of the way to the light.
    pub progress: f32,
    /// True after a mishap.
    pub mishap: bool,
    /// Duration, frames.
    pub frames: u32,
}

#[derive(Default)]
struct Rover {
    coordinator: Coordinator,
    /// Frames until the hand is done.
    hand: u32,
    holds: bool,
    /// Distance to the current light at its selection, and the smallest since then, m.
    start_distance_m: f64,
    nearest_m: f64,
    result: RobotResult,
}

/// Simulates a table on a course. Returns the result of every robot and the rows that were read.
#[must_use]
pub fn run_offline(layout: &Layout, table: Responses) -> (Vec<RobotResult>, u32) {
    let mut course = Course::new(layout, None);
    let mut rovers: Vec<Rover> = (0..course.robots()).map(|_| Rover::default()).collect();
    let mut rows_read = 0;
    for (robot, rover) in rovers.iter_mut().enumerate() {
        rover.set_target(&course, robot);
    }
    for frame in 1..=FRAMES_MAX {
        for (robot, rover) in rovers.iter_mut().enumerate() {
            rows_read |= rover.step(&mut course, robot, table, frame);
        }
        if rovers
            .iter()
            .all(|rover| rover.coordinator.ended().is_some())
        {
            break;
        }
        (0..FRAME_STEPS).for_each(|_| course.step());
    }
    (rovers.iter().map(|rover| rover.result).collect(), rows_read)
}

impl Rover {
    fn set_target(&mut self, course: &Course, robot: usize) {
        let light = self.coordinator.phase().light;
        self.start_distance_m = distance_m(course, robot, light);
        self.nearest_m = self.start_distance_m;
    }

    /// Simulates one frame; returns the row that was read as a bit mask.
    fn step(&mut self, course: &mut Course, robot: usize, table: Responses, frame: u32) -> u32 {
        if self.coordinator.ended().is_some() {
            course.finish(robot);
            return 0;
        }
        self.result.frames = frame;
        let light = self.coordinator.phase().light;
        let signs = Conditions {
            light_m: course.relative_m(robot, light),
            stands: course.is_at_rest(robot),
            hand: self.step_hand(),
            holds: self.holds,
            first_m: course.distance_to_priority_m(robot),
        };
        if course.mishap(robot).is_some() {
            self.result.mishap = true;
            self.coordinator.fail("mishap");
        }
        if self.coordinator.update(&signs, FRAME_S) {
            self.begin(course, robot, light);
        }
        if self.coordinator.ended() == Some(Ended::Done) {
            // The object is set down at the goal light.
            let stands_at = course.relative_m(robot, Light::Goal);
            let place = course.pose(robot);
            course.set_object(robot, stands_at.map(|seen_m| place.point_m(seen_m)));
        }
        self.measure(course, robot);
        let phase = self.coordinator.phase();
        let (light, pace) = (phase.light, phase.light.pace());
        if phase.owner != ControlOwner::Table || self.coordinator.ended().is_some() {
            course.steer(robot, Wheels::STOP, pace);
            return 0;
        }
        let row = course.sense(robot, light);
        course.steer(robot, table.get(row), pace);
        1 << row
    }

    fn step_hand(&mut self) -> HandState {
        let worked = self.hand;
        self.hand = worked.saturating_sub(1);
        if worked == 1 {
            HandState::Done
        } else {
            HandState::Busy
        }
    }

    fn begin(&mut self, course: &mut Course, robot: usize, before: Light) {
        match self.coordinator.phase().owner {
            ControlOwner::Hand(HandTask::Grasp) => self.hand = GRASP_FRAMES,
            ControlOwner::Hand(HandTask::SetDown) => self.hand = SET_DOWN_FRAMES,
            ControlOwner::Table | ControlOwner::Brake => {}
        }
        if self.coordinator.phase().light != before {
            self.holds = true;
            course.set_object(robot, None);
            self.set_target(course, robot);
        }
    }

    fn measure(&mut self, course: &Course, robot: usize) {
        let light = self.coordinator.phase().light;
        self.nearest_m = self.nearest_m.min(distance_m(course, robot, light));
        let way = (1.0 - self.nearest_m / self.start_distance_m) as f32;
        let fetched = if self.holds { 1.0 } else { 0.0 };
        self.result.progress = match self.coordinator.ended() {
            Some(Ended::Done) => 2.0,
            _ => fetched + way.clamp(0.0, 0.99),
        };
    }
}

fn distance_m(course: &Course, robot: usize, light: Light) -> f64 {
    course
        .relative_m(robot, light)
        .map_or(0.0, |[ahead_m, left_m]| libm::hypot(ahead_m, left_m))
}
