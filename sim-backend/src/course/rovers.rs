//! Field of a course with its robots.

use field::Wheels;
use shm_schemas::Mishap;

use super::base::{Base, Pace, PlanarPose};
use super::collision_guard::{FrameCommand, Surroundings, are_apart};
use super::floor::Floor;
use super::layout::{BASE_M, HALF_SIDE_M, Layout, OBJECT_M, ROBOT_M};
use super::sensing::{Disc, row};
use crate::base_motion::BaseMotion;

/// Radius at which IR sensors detect another robot with its arms in front, m. Design choice: the
/// table turns before the collision guard acts. The sum of both radii, 0.9 m, would leave no
/// passage along a wall.
const DETECTED_ROBOT_M: f64 = 0.75;

/// Right of way, steps: 30 s, about one drive. Design choice. Without rotation, two robots could
/// block each other forever.
const RIGHT_OF_WAY_STEPS: u64 = 6000;

/// Light that the photo sensors detect.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Light {
    /// The robot's object.
    Object,
    /// The robot's goal.
    Goal,
}

impl Light {
    /// Returns the pace towards this light; reduced for the goal, because the hand then holds the
    /// object.
    #[must_use]
    pub fn pace(self) -> Pace {
        match self {
            Self::Object => Pace::Free,
            Self::Goal => Pace::Carrying,
        }
    }
}

#[derive(Clone, Debug)]
struct Rover {
    base: Base,
    command: FrameCommand,
    /// True after its course; it stays.
    is_finished: bool,
    /// Object on the floor; `None` while held.
    object_m: Option<[f64; 2]>,
    goal_m: [f64; 2],
    mishap: Option<Mishap>,
}

/// Field with its robots.
#[derive(Clone, Debug)]
pub struct Course {
    rovers: Vec<Rover>,
    steps: u64,
}

impl Course {
    /// Creates the course before its first step; without a seed the floor is even.
    #[must_use]
    pub fn new(layout: &Layout, floor_seed: Option<u64>) -> Self {
        let floor =
            |robot: usize| floor_seed.map_or_else(Floor::even, |seed| Floor::bumpy(seed, robot));
        let rovers = layout.lanes().iter().enumerate();
        let rovers = rovers.map(|(robot, lane)| Rover {
            base: Base::new(lane.start, floor(robot)),
            command: FrameCommand::default(),
            is_finished: false,
            object_m: Some(lane.object.position_m),
            goal_m: lane.goal_m,
            mishap: None,
        });
        Self {
            rovers: rovers.collect(),
            steps: 0,
        }
    }

    /// Returns the number of robots.
    #[must_use]
    pub fn robots(&self) -> usize {
        self.rovers.len()
    }

    /// Returns the table row of a robot. Its own object does not trigger its IR sensors.
    #[must_use]
    pub fn sense(&self, robot: usize, light: Light) -> u8 {
        let others = self.rovers.iter().enumerate().filter(|(k, _)| *k != robot);
        let discs = others.flat_map(|(_, other)| {
            // Radii include the size of the passing body.
            let body = Disc {
                position_m: other.base.pose().position_m,
                radius_m: DETECTED_ROBOT_M,
            };
            let object = other.object_m.map(|at_m| Disc {
                position_m: at_m,
                radius_m: BASE_M + OBJECT_M,
            });
            [Some(body), object].into_iter().flatten()
        });
        let place = self.pose(robot);
        row(&place, discs, self.light_m(robot, light))
    }

    fn light_m(&self, robot: usize, light: Light) -> Option<[f64; 2]> {
        let rover = &self.rovers[robot];
        match light {
            Light::Object => rover.object_m,
            Light::Goal => Some(rover.goal_m),
        }
    }

    /// Returns the light in the robot's frame: metres ahead and to the left; `None` while held.
    #[must_use]
    pub fn relative_m(&self, robot: usize, light: Light) -> Option<[f64; 2]> {
        let place = self.pose(robot);
        self.light_m(robot, light)
            .map(|at_m| place.relative_m(at_m))
    }

    /// Returns the distance to the base with the right of way, m; `None` for that robot and after
    /// its course.
    #[must_use]
    pub fn distance_to_priority_m(&self, robot: usize) -> Option<f64> {
        let first = (self.steps / RIGHT_OF_WAY_STEPS) as usize % self.rovers.len();
        let other = &self.rovers[first];
        if first == robot || other.is_finished {
            return None;
        }
        let [ahead_m, left_m] = self.pose(robot).relative_m(other.base.pose().position_m);
        Some(libm::hypot(ahead_m, left_m))
    }

    /// Commands wheel levels and pace for the next frame. To avoid a collision, the robot turns
    /// about a wheel or brakes instead; without a new command it brakes after one frame.
    pub fn steer(&mut self, robot: usize, wheels: Wheels, pace: Pace) {
        let base = &self.rovers[robot].base;
        if let Some(order) = self.surroundings(robot).allow(base, wheels, pace) {
            self.rovers[robot].command = order;
        }
    }

    fn surroundings(&self, robot: usize) -> Surroundings {
        let others = self.rovers.iter().enumerate().filter(|(k, _)| *k != robot);
        let foreseen = |(_, other): (usize, &Rover)| (other.base.on_even_floor(), other.command);
        let objects_m = self.rovers.iter().filter_map(|rover| rover.object_m);
        Surroundings {
            others: others.map(foreseen).collect(),
            objects_m: objects_m.collect(),
        }
    }

    /// Ends a robot's course: it brakes, stays and gives up its right of way.
    pub fn finish(&mut self, robot: usize) {
        let rover = &mut self.rovers[robot];
        rover.command.stop();
        rover.is_finished = true;
    }

    /// Sets the position of a robot's object, m; `None` while held.
    pub fn set_object(&mut self, robot: usize, at_m: Option<[f64; 2]>) {
        self.rovers[robot].object_m = at_m;
    }

    /// Simulates one step of [`STEP_S`](super::STEP_S).
    pub fn step(&mut self) {
        self.steps += 1;
        for rover in &mut self.rovers {
            if rover.mishap.is_some() {
                rover.command.stop();
            }
            rover.command.step(&mut rover.base);
        }
        for robot in 0..self.rovers.len() {
            let mishap = self.mishap_of(robot);
            let rover = &mut self.rovers[robot];
            rover.mishap = rover.mishap.or(mishap);
        }
    }

    fn mishap_of(&self, robot: usize) -> Option<Mishap> {
        let at_m = self.pose(robot).position_m;
        let near = |other_m: [f64; 2], radius_m: f64| !are_apart(at_m, other_m, radius_m);
        if at_m.iter().any(|m| m.abs() > HALF_SIDE_M - ROBOT_M) {
            return Some(Mishap::LEFT_FIELD);
        }
        let meets = |(k, other): (usize, &Rover)| {
            k != robot && near(other.base.pose().position_m, 2.0 * ROBOT_M)
        };
        if self.rovers.iter().enumerate().any(meets) {
            return Some(Mishap::MET_ROBOT);
        }
        let mut objects = self.rovers.iter().filter_map(|rover| rover.object_m);
        let over = objects.any(|object_m| near(object_m, BASE_M + OBJECT_M));
        over.then_some(Mishap::MET_OBJECT)
    }

    /// Returns the pose of a base.
    #[must_use]
    pub fn pose(&self, robot: usize) -> PlanarPose {
        self.rovers[robot].base.pose()
    }

    /// Returns the motion of a base in the current step.
    #[must_use]
    pub fn base_motion(&self, robot: usize) -> BaseMotion {
        self.rovers[robot].base.motion()
    }

    /// Returns true if a base is at rest.
    #[must_use]
    pub fn is_at_rest(&self, robot: usize) -> bool {
        self.rovers[robot].base.is_at_rest()
    }

    /// Returns the mishap that ended a robot's course.
    #[must_use]
    pub fn mishap(&self, robot: usize) -> Option<Mishap> {
        self.rovers[robot].mishap
    }
}

#[cfg(test)]
mod tests {
    use super::super::FRAME_STEPS;
    use super::super::layout::{LANES_MAX, Lane};
    use super::*;
    use proptest::prelude::*;

    const AHEAD: Wheels = Wheels { left: 2, right: 2 };

    fn course(lanes: &[([f64; 2], f64, [f64; 2])]) -> Course {
        let lane = |(start_m, yaw_rad, object_m): &([f64; 2], f64, [f64; 2])| Lane {
            start: PlanarPose {
                position_m: *start_m,
                yaw_rad: *yaw_rad,
            },
            object: PlanarPose {
                position_m: *object_m,
                yaw_rad: 0.0,
            },
            goal_m: [object_m[0], -object_m[1]],
        };
        let layout = Layout::new(lanes.iter().map(lane).collect()).expect("a course");
        Course::new(&layout, None)
    }

    /// Bypasses the collision guard, which would prevent the mishap.
    fn ends(mut course: Course, expected: [Option<Mishap>; 2]) {
        for _ in 0..200 {
            for rover in &mut course.rovers {
                rover.command = FrameCommand::new(AHEAD, Pace::Free);
            }
            (0..FRAME_STEPS).for_each(|_| course.step());
        }
        for (robot, expected) in (0..course.robots()).zip(expected) {
            assert_eq!(course.mishap(robot), expected);
            assert!(
                course.is_at_rest(robot) || expected.is_none(),
                "base must stop after a mishap"
            );
            let at_m = course.pose(robot).position_m;
            assert!(
                at_m.iter().all(|m| m.abs() < HALF_SIDE_M),
                "base must brake before the wall: {at_m:?}"
            );
        }
    }

    #[test]
    fn mishaps_are_reported_and_stop_the_base() {
        let left = Some(Mishap::LEFT_FIELD);
        ends(course(&[([0.0, 0.0], 0.0, [0.0, 1.5])]), [left, None]);
        let over = Some(Mishap::MET_OBJECT);
        ends(course(&[([0.0, 1.5], 0.0, [1.5, 1.5])]), [over, None]);
        let met = Some(Mishap::MET_ROBOT);
        let pi = core::f64::consts::PI;
        let opposite = [([-1.5, 0.0], 0.0, [0.0, 1.9]), ([1.5, 0.0], pi, [1.8, 1.0])];
        ends(course(&opposite), [met, met]);
    }

    /// Obstacles: a wall, an object, another base. Tables cannot reverse, so a base at rest must
    /// turn.
    #[test]
    fn driving_straight_neither_collides_nor_gets_stuck() {
        let pi = core::f64::consts::PI;
        for lanes in [
            &[([0.0, 0.0], 0.0, [0.0, 1.5])][..],
            &[([0.0, 1.5], 0.0, [1.5, 1.5])],
            &[([-1.5, 0.0], 0.0, [0.0, 1.9]), ([1.5, 0.0], pi, [1.8, 1.0])],
        ] {
            let mut course = course(lanes);
            let mut stood = vec![0; course.robots()];
            for _ in 0..600 {
                for (robot, stood) in stood.iter_mut().enumerate() {
                    course.steer(robot, AHEAD, Pace::Free);
                    *stood = if course.is_at_rest(robot) {
                        *stood + 1
                    } else {
                        0
                    };
                    assert!(*stood < 20, "{lanes:?}: robot {robot} is stuck");
                }
                (0..FRAME_STEPS).for_each(|_| course.step());
            }
            let mishaps = (0..course.robots()).map(|robot| course.mishap(robot));
            assert_eq!(mishaps.flatten().next(), None, "{lanes:?}");
        }
    }

    proptest! {
        /// Holds for any commands, also interrupted ones.
        #[test]
        fn guard_prevents_collisions_for_any_commands(
            seed in 0_u64..1 << 40,
            robots in 1..=LANES_MAX,
            reported in proptest::collection::vec((0_u8..4, 0_u8..3, 0_u8..3, 1_u8..30), 1..60),
        ) {
            let layout = Layout::random(robots, seed).expect("a course");
            let mut course = Course::new(&layout, Some(seed));
            for (robot, (pace, left, right, frames)) in (0..robots).cycle().zip(reported) {
                let pace = if pace == 0 { Pace::Carrying } else { Pace::Free };
                for _ in 0..frames {
                    course.steer(robot, Wheels { left, right }, pace);
                    course.steer(robots - 1 - robot, AHEAD, Pace::Free);
                    (0..FRAME_STEPS).for_each(|_| course.step());
                }
                for robot in 0..robots {
                    prop_assert_eq!(course.mishap(robot), None, "robot {}", robot);
                }
                (0..FRAME_STEPS).for_each(|_| course.step());
            }
        }
    }

    #[test]
    fn right_of_way_rotates_among_active_robots() {
        let mut course = course(&[
            ([-1.5, 0.0], 0.0, [0.0, 1.9]),
            ([1.5, 0.0], 0.0, [1.8, 1.0]),
        ]);
        let check = |course: &Course, expected: [Option<f64>; 2]| {
            assert_eq!(
                [0, 1].map(|robot| course.distance_to_priority_m(robot)),
                expected
            );
        };
        check(&course, [None, Some(3.0)]);
        (0..RIGHT_OF_WAY_STEPS).for_each(|_| course.step());
        check(&course, [Some(3.0), None]);
        course.finish(1);
        check(&course, [None, None]);
        (0..RIGHT_OF_WAY_STEPS).for_each(|_| course.step());
        check(&course, [None, Some(3.0)]);
    }

    #[test]
    fn held_object_has_no_light_and_no_obstacle() {
        let mut course = course(&[([0.0, 1.5], 0.0, [1.0, 1.4])]);
        assert_eq!(course.sense(0, Light::Object), 24);
        assert_eq!(course.sense(0, Light::Goal), 16);
        let [ahead_m, left_m] = course.relative_m(0, Light::Object).expect("it stands");
        assert!((ahead_m - 1.0).abs() < 1e-12 && (left_m + 0.1).abs() < 1e-12);
        course.set_object(0, None);
        assert_eq!(course.sense(0, Light::Object), 0);
        assert_eq!(course.relative_m(0, Light::Object), None);
    }
}
