//! Who is on a course, drawn by a number: the same for whoever simulates it, judges it, or takes part in it.

use robot_model::Side;

use super::layout::{CourseError, Layout};
use crate::object::Object;
use crate::random::trial_seed;
use crate::scene::{GraspHint, Scene};

/// The hand that works.
pub const SIDE: Side = Side::Right;

/// A course and its robots.
#[derive(Clone, Debug)]
pub struct Cast {
    /// Where everything is.
    pub layout: Layout,
    /// The seed of the floor's bumps.
    pub floor_seed: u64,
    /// The robots, in the order of the lanes.
    pub robots: Vec<Player>,
}

/// A robot of a course.
#[derive(Clone, Debug)]
pub struct Player {
    /// The seed of its noise, and of what it is told wrongly.
    pub seed: u64,
    /// The world of its hands, before its base has moved.
    pub scene: Scene,
    /// What a client knows of its object without seeing it.
    pub known: GraspHint,
}

impl Cast {
    /// Draws a course by its number, for robots with an object each.
    ///
    /// # Errors
    /// [`CourseError`]: too many objects, or none.
    pub fn drawn(number: u64, objects: &[Object]) -> Result<Self, CourseError> {
        let seed = trial_seed("course", number);
        let layout = Layout::drawn(objects.len(), seed)?;
        let lanes = layout.lanes().iter().zip(objects).enumerate();
        let robots = lanes.filter_map(|(index, (lane, object))| {
            let seed = trial_seed(&format!("robot {index}"), seed);
            let mut scene = Scene::grasp(object.clone(), SIDE).varied(seed);
            // A grasp has its object.
            let known = scene.grasp_hint(0)?;
            let placed = scene.objects.first_mut()?;
            placed.position_m = lane.start.sees(lane.object.at_m);
            placed.yaw_rad = lane.object.yaw_rad - lane.start.yaw_rad;
            Some(Player { seed, scene, known })
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
    fn every_robot_has_its_object_and_its_own_noise() {
        let objects: Vec<Object> = ["wood", "sponge"]
            .map(|name| Object::built_in(name).expect("built in"))
            .to_vec();
        let cast = Cast::drawn(1, &objects).expect("a course");
        let names: Vec<&str> = cast
            .robots
            .iter()
            .map(|robot| robot.scene.objects[0].object.name.as_str())
            .collect();
        assert_eq!(names, ["wood", "sponge"]);
        assert_ne!(cast.robots[0].seed, cast.robots[1].seed);
        assert!(matches!(Cast::drawn(1, &[]), Err(CourseError::Robots(0))));
    }
}
