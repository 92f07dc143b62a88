//! The four tasks of the paper, with scene and goal of each.

use anyhow::Context;
use atas_client::goal::{HOLD_S, LIFT_M};
use robot_model::{HandSide, RobotModel};
use shm_schemas::GoalRequest;
use sim_backend::{GraspHint, Object, ObjectError, Scene};

use crate::goals::{assemble_goal, grasp_goal, pick_place_goal, screw_goal};
use crate::judge::Load;

/// Acting hand of the two-hand arm.
pub const SIDE: HandSide = HandSide::Right;
/// Task of the paper.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Task {
    /// Grasp, lift and hold.
    Grasp,
    /// Pick up and set down on a plate with a height error of up to 10 mm.
    PickPlace,
    /// Close a cap on a clamped bottle.
    Screw,
    /// Put a cap on a free bottle and close it, with both hands.
    Assembly,
}

impl Task {
    /// All tasks.
    pub const ALL: [Self; 4] = [Self::Grasp, Self::PickPlace, Self::Screw, Self::Assembly];

    /// Returns the name, as users type it.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Grasp => "grasp",
            Self::PickPlace => "pick-place",
            Self::Screw => "screw",
            Self::Assembly => "assembly",
        }
    }

    /// Returns the built-in objects of the task: all for the grasp, the feasible ones for pick and
    /// place, a cap otherwise.
    ///
    /// # Errors
    /// A built-in object's file is invalid.
    pub fn objects(self) -> Result<Vec<Object>, ObjectError> {
        let grasp = atas_core::settings::Grasp::default();
        let can_be_held = |object: &Object| Load::from_object(object, &grasp, 1).is_feasible();
        match self {
            Self::Grasp => Object::names().map(Object::built_in).collect(),
            Self::PickPlace => {
                let mut objects: Vec<Object> = Task::Grasp.objects()?;
                objects.retain(can_be_held);
                Ok(objects)
            }
            Self::Screw | Self::Assembly => Ok(vec![Object::built_in("cap")?]),
        }
    }

    /// Time limit of a trial, s. Design choice: several times the usual duration.
    #[must_use]
    pub fn limit_s(self) -> f64 {
        match self {
            Self::Grasp | Self::PickPlace => 120.0,
            Self::Screw => 240.0,
            Self::Assembly => 400.0,
        }
    }

    /// Returns true if the robot's default acting hand can do the task.
    #[must_use]
    pub fn is_supported_by(self, robot: &RobotModel) -> bool {
        let able = robot.hand(robot.acting_side()).capabilities();
        match self {
            Self::Grasp => able.lift,
            Self::PickPlace => able.lift && able.carry,
            Self::Screw => able.cap_turning,
            Self::Assembly => {
                let other = HandSide::BOTH[1 - robot.acting_side().index()];
                able.cap_turning && robot.hand(other).capabilities().side_grasp
            }
        }
    }

    /// Rejects a robot that cannot do the task.
    ///
    /// # Errors
    /// The acting hand lacks a capability.
    pub fn check(self, robot: &RobotModel) -> anyhow::Result<()> {
        anyhow::ensure!(
            self.is_supported_by(robot),
            "could not run {}: the robot's hand cannot do this task; choose another robot (`atas \
             robot list` shows the tasks of each)",
            self.name()
        );
        Ok(())
    }

    /// Returns the usual scene of the task around an object, within the hand's workspace.
    ///
    /// # Errors
    /// A built-in object's file is invalid.
    pub fn scene(self, robot: &RobotModel, object: Object) -> Result<Scene, ObjectError> {
        let (side, bottle) = (robot.acting_side(), || Object::built_in("open-bottle"));
        let scene = match self {
            Self::Grasp => Scene::grasp(object, side),
            Self::PickPlace => Scene::pick_place(object, side),
            Self::Screw => Scene::screw(object, bottle()?, side),
            Self::Assembly => Scene::assembly(object, bottle()?, side),
        };
        Ok(scene.moved_to_hand(robot.hand(side)))
    }

    /// Returns the goal that a client with nominal knowledge of the scene requests.
    ///
    /// # Errors
    /// The scene lacks an object or place of the task.
    pub fn goal(self, scene: &Scene, side: HandSide) -> anyhow::Result<GoalRequest> {
        let hint = |index: usize| {
            scene
                .grasp_hint(index)
                .context("a task's scene has its objects")
        };
        let place =
            || -> anyhow::Result<GraspHint> { scene.place.context("the scene has no destination") };
        let (object, lift_m) = (hint(0)?, LIFT_M);
        Ok(match self {
            Self::Grasp => grasp_goal(&object, side, lift_m, HOLD_S),
            Self::PickPlace => pick_place_goal(&object, side, &place()?, lift_m),
            Self::Screw => screw_goal(&object, side),
            Self::Assembly => assemble_goal(&object, &place()?, hint(1)?.width_m, side),
        })
    }
}
