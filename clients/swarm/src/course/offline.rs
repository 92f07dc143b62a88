//! Simulation of one course with a table; hands are reduced to time delays.

use atas_evaluation::hybrid::{Coordinator, Ended, HandState, HandTask, Say, Signs};
use sim_backend::course::{Course, FRAME_S, FRAME_STEPS, Layout, Light, Responses, Wheels};

/// Typical duration of grasp and lift, and of setting down, frames.
const GRASP_FRAMES: u32 = 130;
const SET_DOWN_FRAMES: u32 = 90;
/// Frames after which an offline run ends. Design choice: three times the duration of a good table.
pub const FRAMES_MAX: u32 = 2400;

/// Result of one robot.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Driven {
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
    from_m: f64,
    nearest_m: f64,
    driven: Driven,
}

/// Simulates a table on a course. Returns the result of every robot and the rows that were read.
#[must_use]
pub fn run_offline(layout: &Layout, table: Responses) -> (Vec<Driven>, u32) {
    let mut course = Course::new(layout, None);
    let mut rovers: Vec<Rover> = (0..course.robots()).map(|_| Rover::default()).collect();
    let mut rows_read = 0;
    for (robot, rover) in rovers.iter_mut().enumerate() {
        rover.aim(&course, robot);
    }
    for frame in 1..=FRAMES_MAX {
        for (robot, rover) in rovers.iter_mut().enumerate() {
            rows_read |= rover.frame(&mut course, robot, table, frame);
        }
        if rovers
            .iter()
            .all(|rover| rover.coordinator.ended().is_some())
        {
            break;
        }
        (0..FRAME_STEPS).for_each(|_| course.step());
    }
    (rovers.iter().map(|rover| rover.driven).collect(), rows_read)
}

impl Rover {
    fn aim(&mut self, course: &Course, robot: usize) {
        let light = self.coordinator.phase().light;
        self.from_m = distance_m(course, robot, light);
        self.nearest_m = self.from_m;
    }

    /// Simulates one frame; returns the row that was read as a bit mask.
    fn frame(&mut self, course: &mut Course, robot: usize, table: Responses, frame: u32) -> u32 {
        if self.coordinator.ended().is_some() {
            course.rest(robot);
            return 0;
        }
        self.driven.frames = frame;
        let light = self.coordinator.phase().light;
        let signs = Signs {
            light_m: course.sees(robot, light),
            stands: course.stands(robot),
            hand: self.work(),
            holds: self.holds,
            first_m: course.to_first_m(robot),
        };
        if course.mishap(robot).is_some() {
            self.driven.mishap = true;
            self.coordinator.fail("mishap");
        }
        if self.coordinator.look(&signs, FRAME_S) {
            self.begin(course, robot, light);
        }
        if self.coordinator.ended() == Some(Ended::Done) {
            // The object is set down at the goal light.
            let stands_at = course.sees(robot, Light::Goal);
            let place = course.place(robot);
            course.set_object(robot, stands_at.map(|seen_m| place.point_m(seen_m)));
        }
        self.measure(course, robot);
        let phase = self.coordinator.phase();
        let (light, pace) = (phase.light, phase.light.pace());
        if phase.say != Say::Table || self.coordinator.ended().is_some() {
            course.steer(robot, Wheels::STOP, pace);
            return 0;
        }
        let row = course.sense(robot, light);
        course.steer(robot, table.get(row), pace);
        1 << row
    }

    fn work(&mut self) -> HandState {
        let worked = self.hand;
        self.hand = worked.saturating_sub(1);
        if worked == 1 {
            HandState::Done
        } else {
            HandState::Busy
        }
    }

    fn begin(&mut self, course: &mut Course, robot: usize, before: Light) {
        match self.coordinator.phase().say {
            Say::Hand(HandTask::Grasp) => self.hand = GRASP_FRAMES,
            Say::Hand(HandTask::SetDown) => self.hand = SET_DOWN_FRAMES,
            Say::Table | Say::Nobody => {}
        }
        if self.coordinator.phase().light != before {
            self.holds = true;
            course.set_object(robot, None);
            self.aim(course, robot);
        }
    }

    fn measure(&mut self, course: &Course, robot: usize) {
        let light = self.coordinator.phase().light;
        self.nearest_m = self.nearest_m.min(distance_m(course, robot, light));
        let way = (1.0 - self.nearest_m / self.from_m) as f32;
        let fetched = if self.holds { 1.0 } else { 0.0 };
        self.driven.progress = match self.coordinator.ended() {
            Some(Ended::Done) => 2.0,
            _ => fetched + way.clamp(0.0, 0.99),
        };
    }
}

fn distance_m(course: &Course, robot: usize, light: Light) -> f64 {
    course
        .sees(robot, light)
        .map_or(0.0, |[ahead_m, left_m]| libm::hypot(ahead_m, left_m))
}
