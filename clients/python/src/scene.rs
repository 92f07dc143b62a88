//! Scenes of the simulator by name, with their goals, and settings of the controller.

use atas_client::goal::{HOLD_S, LIFT_M};
use atas_core::Settings;
use atas_evaluation::goals::{assemble_goal, grasp_goal, pick_place_goal, screw_goal};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use robot_model::{HandSide, RobotModel};
use shm_schemas::GoalRequest;
use sim_backend::{Object, Scene};

use crate::errors::atas_error;

type GoalOf = Box<dyn Fn(&Scene) -> Option<GoalRequest>>;

/// Returns a scene by name in front of a hand, and the function that derives its goal.
pub(crate) fn scene_of(
    name: &str,
    object: Option<&str>,
    robot: &RobotModel,
    side: HandSide,
) -> PyResult<(Scene, GoalOf)> {
    let found = |name: &str| {
        Object::from_name_or_file(name).map_err(|why| PyValueError::new_err(why.to_string()))
    };
    let thing = || found(object.unwrap_or(Scene::OBJECT));
    let cap = || found(object.unwrap_or(Scene::CAP));
    let bottle = || found(Scene::BOTTLE);
    let (scene, goal): (Scene, GoalOf) = match name {
        "grasp" => (Scene::grasp(thing()?, side), goal_of_grasp(side)),
        "pick-place" => (Scene::pick_place(thing()?, side), goal_of_pick_place(side)),
        "screw" => (Scene::screw(cap()?, bottle()?, side), goal_of_screw(side)),
        "assembly" if robot.sides().count() < 2 => {
            return Err(PyValueError::new_err(
                "scene rejected: \"assembly\" needs two hands, the robot has one; choose another \
                 scene or robot",
            ));
        }
        "assembly" => (
            Scene::assembly(cap()?, bottle()?, side),
            goal_of_assembly(side),
        ),
        _ => {
            return Err(PyValueError::new_err(format!(
                "unknown scene {name:?}; needs \"grasp\", \"pick-place\", \"screw\" or \"assembly\""
            )));
        }
    };
    Ok((scene.moved_to_hand(robot.hand(side)), goal))
}

fn goal_of_grasp(side: HandSide) -> GoalOf {
    Box::new(move |scene| {
        let goal = grasp_goal(&scene.grasp_hint(0)?, side, LIFT_M, HOLD_S);
        Some(with_goal_id(goal))
    })
}

fn goal_of_pick_place(side: HandSide) -> GoalOf {
    Box::new(move |scene| {
        let place = scene.place?;
        let goal = pick_place_goal(&scene.grasp_hint(0)?, side, &place, LIFT_M);
        Some(with_goal_id(goal))
    })
}

fn goal_of_screw(side: HandSide) -> GoalOf {
    Box::new(move |scene| Some(with_goal_id(screw_goal(&scene.grasp_hint(0)?, side))))
}

fn goal_of_assembly(side: HandSide) -> GoalOf {
    Box::new(move |scene| {
        let (cap, bottle) = (scene.grasp_hint(0)?, scene.grasp_hint(1)?);
        let goal = assemble_goal(&cap, &scene.place?, bottle.width_m, side);
        Some(with_goal_id(goal))
    })
}

/// Sets the goal id: a simulation has one goal at a time.
fn with_goal_id(goal: GoalRequest) -> GoalRequest {
    GoalRequest { goal_id: 1, ..goal }
}

/// Returns the default settings with these changes.
pub(crate) fn parse_settings(settings: Option<&Bound<'_, PyDict>>) -> PyResult<Settings> {
    let mut changed = Settings::default();
    for (name, value) in settings.into_iter().flat_map(|it| it.iter()) {
        let (name, value): (String, f64) = (name.extract()?, value.extract()?);
        changed.set(&name, value).map_err(|why| {
            PyValueError::new_err(format!("could not set {name:?} to {value}: {why}"))
        })?;
    }
    changed
        .check()
        .map_err(|why| atas_error(anyhow::anyhow!("settings rejected: {why}")))?;
    Ok(changed)
}

/// Names of the built-in objects that can be grasped.
#[pyfunction]
pub(crate) fn objects() -> Vec<&'static str> {
    Object::names().collect()
}
