//! Layout of a course.

use core::f64::consts::PI;

use super::base::PlanarPose;
use crate::random::Random;
use crate::scene::stream;

/// Half the side of the field, m.
pub const HALF_SIDE_M: f64 = 3.0;
/// Largest number of robots on one course.
pub const LANES_MAX: usize = 2;
/// Radius of a robot with its arms in front, m: farthest corner of the held object.
pub(super) const ROBOT_M: f64 = 0.45;
/// Radii of the base without arms and of objects on the floor, m.
pub(super) const BASE_M: f64 = 0.16;
pub(super) const OBJECT_M: f64 = 0.05;
/// Smallest wall distance of objects and goals, and of starts, m: room to pass and to turn.
const WALL_DISTANCE_MIN_M: f64 = 1.0;
const START_WALL_DISTANCE_MIN_M: f64 = 0.7;
/// Smallest distance from object to start and goal of one lane, m.
const LANE_DISTANCE_MIN_M: f64 = 1.0;
/// Smallest distance between places that two robots may use at once, m: their arms do not touch.
const ROBOT_DISTANCE_MIN_M: f64 = 1.6;
/// Attempts of a random draw; one in ten is valid.
const TRIES: usize = 10_000;

/// Task of one robot.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lane {
    /// Start pose of the base.
    pub start: PlanarPose,
    /// Pose of the object.
    pub object: PlanarPose,
    /// Position of the goal, m.
    pub goal_m: [f64; 2],
}

/// Invalid course.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum CourseError {
    /// Unsupported number of robots.
    #[error("course rejected: {0} robots, needs 1 to {LANES_MAX}; choose another number")]
    Robots(usize),
    /// Unreachable place.
    #[error(
        "course rejected: {what} of robot {robot} is at {value_m} m, needs at most {limit_m} m \
         from the centre in x and y; move it inwards"
    )]
    Outside {
        /// Kind of place.
        what: &'static str,
        /// Number of the robot, from 1.
        robot: usize,
        /// Rejected coordinate.
        value_m: f64,
        /// Largest allowed magnitude.
        limit_m: f64,
    },
    /// Two places too close to each other.
    #[error("course rejected: {what} are {value_m:.2} m apart, needs {least_m} m; move them apart")]
    TooClose {
        /// Names of the two places.
        what: &'static str,
        /// Distance.
        value_m: f64,
        /// Smallest allowed distance.
        least_m: f64,
    },
    /// Direction that is not finite.
    #[error("course rejected: a direction of robot {0} is not finite; correct it")]
    Direction(usize),
}

/// Validated course.
#[derive(Clone, Debug, PartialEq)]
pub struct Layout {
    lanes: Vec<Lane>,
}

impl Layout {
    /// Validates lanes.
    ///
    /// # Errors
    /// The first [`CourseError`].
    pub fn new(lanes: Vec<Lane>) -> Result<Self, CourseError> {
        if !(1..=LANES_MAX).contains(&lanes.len()) {
            return Err(CourseError::Robots(lanes.len()));
        }
        for (robot, lane) in (1..).zip(&lanes) {
            check_lane(robot, lane)?;
        }
        if let [a, b] = &lanes[..] {
            check_distance(
                "two starts",
                a.start.position_m,
                b.start.position_m,
                ROBOT_DISTANCE_MIN_M,
            )?;
            check_distance(
                "two objects",
                a.object.position_m,
                b.object.position_m,
                ROBOT_DISTANCE_MIN_M,
            )?;
            check_distance("two goals", a.goal_m, b.goal_m, ROBOT_DISTANCE_MIN_M)?;
            for (a, b) in [(a, b), (b, a)] {
                let (start_m, object_m) = (a.start.position_m, b.object.position_m);
                check_distance(
                    "a start and another's object",
                    start_m,
                    object_m,
                    LANE_DISTANCE_MIN_M,
                )?;
                check_distance(
                    "a goal and another's object",
                    a.goal_m,
                    object_m,
                    LANE_DISTANCE_MIN_M,
                )?;
            }
        }
        Ok(Self { lanes })
    }

    /// Draws a random course.
    ///
    /// # Errors
    /// [`CourseError::Robots`].
    pub fn random(robots: usize, seed: u64) -> Result<Self, CourseError> {
        let mut random = Random::new(seed, stream::COURSE);
        let mut last = Self::new(Vec::new());
        for _ in 0..TRIES {
            last = Self::new((0..robots).map(|_| Lane::random(&mut random)).collect());
            if last.is_ok() || matches!(last, Err(CourseError::Robots(_))) {
                break;
            }
        }
        last
    }

    /// Returns the lanes.
    #[must_use]
    pub fn lanes(&self) -> &[Lane] {
        &self.lanes
    }
}

impl Lane {
    fn random(random: &mut Random) -> Self {
        let mut point_m = |to_wall_m: f64| {
            let most_m = HALF_SIDE_M - to_wall_m;
            [(); 2].map(|()| random.between(-most_m, most_m))
        };
        let places_m = [
            point_m(START_WALL_DISTANCE_MIN_M),
            point_m(WALL_DISTANCE_MIN_M),
            point_m(WALL_DISTANCE_MIN_M),
        ];
        let mut towards = |at_m| PlanarPose {
            position_m: at_m,
            yaw_rad: random.between(-PI, PI),
        };
        Self {
            start: towards(places_m[0]),
            object: towards(places_m[1]),
            goal_m: places_m[2],
        }
    }
}

fn check_lane(robot: usize, lane: &Lane) -> Result<(), CourseError> {
    let places = [
        (
            "the start",
            lane.start.position_m,
            START_WALL_DISTANCE_MIN_M,
        ),
        ("the object", lane.object.position_m, WALL_DISTANCE_MIN_M),
        ("the goal", lane.goal_m, WALL_DISTANCE_MIN_M),
    ];
    for (what, at_m, to_wall_m) in places {
        let limit_m = HALF_SIDE_M - to_wall_m;
        // Also rejects NaN.
        let outside = at_m.into_iter().find(|m| m.is_nan() || m.abs() > limit_m);
        if let Some(value_m) = outside {
            return Err(CourseError::Outside {
                what,
                robot,
                value_m,
                limit_m,
            });
        }
    }
    if !(lane.start.yaw_rad.is_finite() && lane.object.yaw_rad.is_finite()) {
        return Err(CourseError::Direction(robot));
    }
    let object_m = lane.object.position_m;
    check_distance(
        "a start and its object",
        lane.start.position_m,
        object_m,
        LANE_DISTANCE_MIN_M,
    )?;
    check_distance(
        "an object and its goal",
        object_m,
        lane.goal_m,
        LANE_DISTANCE_MIN_M,
    )
}

fn check_distance(
    what: &'static str,
    a_m: [f64; 2],
    b_m: [f64; 2],
    least_m: f64,
) -> Result<(), CourseError> {
    let value_m = libm::hypot(a_m[0] - b_m[0], a_m[1] - b_m[1]);
    if value_m >= least_m {
        return Ok(());
    }
    Err(CourseError::TooClose {
        what,
        value_m,
        least_m,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_seed_gives_a_valid_course() {
        for robots in 1..=LANES_MAX {
            for seed in 0..200 {
                let layout = Layout::random(robots, seed).expect("a course");
                assert_eq!(Layout::random(robots, seed), Ok(layout.clone()));
                assert_ne!(Layout::random(robots, seed + 1), Ok(layout));
            }
        }
    }

    #[test]
    fn invalid_courses_are_rejected() {
        let good = Layout::random(1, 1).expect("a course").lanes()[0];
        let check = |change: fn(&mut Lane), part: &str| {
            let mut lane = good;
            change(&mut lane);
            let error = Layout::new(vec![lane]).expect_err("must be refused");
            assert!(error.to_string().contains(part), "{error}");
        };
        check(|lane| lane.goal_m = [2.9, 0.0], "the goal of robot 1");
        check(|lane| lane.object.position_m[1] = f64::NAN, "the object");
        check(|lane| lane.start.position_m[0] = -2.5, "the start");
        check(
            |lane| lane.start.yaw_rad = f64::INFINITY,
            "direction of robot 1",
        );
        check(|lane| lane.goal_m = lane.object.position_m, "0.00 m apart");
        for robots in [0, 3] {
            assert_eq!(Layout::random(robots, 1), Err(CourseError::Robots(robots)));
        }
        assert!(matches!(
            Layout::new(vec![good, good]),
            Err(CourseError::TooClose { .. })
        ));
    }
}
