//! Random scenario of a course, reproducible from its number in every process.

use robot_model::HandSide;

use super::layout::{CourseError, Layout};
use crate::object::Object;
use crate::random::trial_seed;
use crate::scene::{GraspHint, Scene};

/// Working hand.
pub const SIDE: HandSide = HandSide::Right;

/// Course with its robots.
#[derive(Clone, Debug)]
pub struct Scenario {
    /// Layout of the course.
    pub layout: Layout,
    /// Seed of the floor's bumps.
    pub floor_seed: u64,
    /// Robots, in lane order.
    pub robots: Vec<RobotSetup>,
}

/// Set-up of one robot.
#[derive(Clone, Debug)]
pub struct RobotSetup {
    /// Seed of its noise and command errors.
    pub seed: u64,
    /// World of its hands at the start.
    pub scene: Scene,
    /// Client's prior knowledge of the object.
    pub hint: GraspHint,
}

impl Scenario {
    /// Draws a course by its number, with one robot per object.
    ///
    /// # Errors
    /// [`CourseError`]: unsupported number of objects.
    pub fn random(number: u64, objects: &[Object]) -> Result<Self, CourseError> {
        let seed = trial_seed("course", number);
        let layout = Layout::random(objects.len(), seed)?;
        let lanes = layout.lanes().iter().zip(objects).enumerate();
        let robots = lanes.filter_map(|(index, (lane, object))| {
            let seed = trial_seed(&format!("robot {index}"), seed);
            let mut scene = Scene::grasp(object.clone(), SIDE).varied(seed);
            // A grasp scene always contains its object.
            let known = scene.grasp_hint(0)?;
            let placed = scene.objects.first_mut()?;
            placed.position_m = lane.start.relative_m(lane.object.position_m);
            placed.yaw_rad = lane.object.yaw_rad - lane.start.yaw_rad;
            Some(RobotSetup {
                seed,
                scene,
                hint: known,
            })
        });
        Ok(Self {
            robots: robots.collect(),
            layout,
            floor_seed: seed,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn robots_have_separate_objects_and_seeds() {
        let objects: Vec<Object> = ["wood", "sponge"]
            .map(|name| Object::built_in(name).expect("built in"))
            .to_vec();
        let cast = Scenario::random(1, &objects).expect("a course");
        let names: Vec<&str> = cast
            .robots
            .iter()
            .map(|robot| robot.scene.objects[0].object.name.as_str())
            .collect();
        assert_eq!(names, ["wood", "sponge"]);
        assert_ne!(cast.robots[0].seed, cast.robots[1].seed);
        assert!(matches!(
            Scenario::random(1, &[]),
            Err(CourseError::Robots(0))
        ));
    }
}
