//! Grasp, lift and long hold of one object, tick by tick: the common part of the evaluations of
//! sensor effects, disturbances and gentleness.
//!
//! ```text
//!  HeldPlan: objects, seeds ─▶ HeldWorld ─▶ HeldTrial: scene and goal
//!                       ─▶ HeldRun: grip, lift, watch ─▶ Outcome ─▶ Outcomes, HeldSummary
//!                            ▲ loads, bumps; commands and truth
//! ```
//!
//! * **In:** an object, a seed, a [`Grip`], settings and an engine. **Out:** ground truth per tick,
//!   and an [`Outcome`].
//! * **Invariants:** equal arguments give equal bits with the built-in engine. All grips of an
//!   object and seed get the same world and noise.

mod plan;
mod position;
mod run;

use anyhow::Context;
use atas_client::goal::LIFT_M;
use atas_core::Settings;
use atas_tasks::goals::grasp_goal;
use robot_model::RobotModel;
use shm_schemas::{GoalRequest, ObjectTruth};
use sim_backend::engine::{EngineError, EnginePool};
use sim_backend::{Errors, GraspHint, Object, Scene, World, WorldFault};

use crate::Task;
use crate::judge::{Load, SLIP_MAX_M, TURN_MAX_RAD};
use crate::policy::GripPolicy;

pub(crate) use plan::HeldWorld;
pub use plan::{HeldPlan, HeldSummary, Outcomes};
use position::PositionGripper;
pub(crate) use run::HeldRun;

/// Hold of the goal, s: longer than any trial.
const HOLD_S: f64 = 300.0;
/// Share of the lift above which an object counts as lifted.
pub(crate) const LIFTED_SHARE: f64 = 0.5;

/// Gripper of a trial.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Grip {
    /// Grip policy of the tactile controller.
    Policy(GripPolicy),
    /// Position-controlled gripper: closes to the expected width minus this margin, m, without
    /// tactile sensing.
    Position(f64),
}

/// World and goal of a trial.
pub(crate) struct HeldTrial<'a> {
    robot: &'a RobotModel,
    engines: Option<&'a EnginePool>,
    scene: Scene,
    hint: GraspHint,
    goal: GoalRequest,
    seed: u64,
    settings: Settings,
    has_torques: bool,
}

/// True outcome of a hold.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Outcome {
    Held,
    Crushed,
    Dropped,
    Slipped,
    NotLifted,
    /// The engine could not simulate the trial.
    Discarded,
}

impl Grip {
    /// Returns the name in reports.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Policy(policy) => policy.name(),
            Self::Position(_) => "position",
        }
    }

    /// Returns the controller settings for this gripper.
    fn settings(self, ours: &Settings) -> Settings {
        match self {
            Self::Policy(policy) => policy.settings(ours),
            Self::Position(_) => PositionGripper::settings(ours),
        }
    }

    /// Returns forces or margin as text; empty for the ATAS modules.
    pub(crate) fn setting(self) -> String {
        match self {
            Self::Policy(policy) => policy.setting(),
            Self::Position(margin_m) => format!("{:.1} mm", margin_m * 1e3),
        }
    }
}

impl<'a> HeldTrial<'a> {
    /// Prepares the grasp of a member of the object's family, with these errors.
    ///
    /// # Errors
    /// The robot cannot grasp.
    pub(crate) fn new(
        robot: &'a RobotModel,
        engines: Option<&'a EnginePool>,
        object: Object,
        seed: u64,
        settings: Settings,
        errors: &Errors,
    ) -> anyhow::Result<Self> {
        let scene = Task::Grasp.scene(robot, object)?.varied(seed);
        let scene = scene.with_errors(errors, seed);
        let hint = scene
            .grasp_hint(0)
            .context("a grasp's scene has an object")?;
        Ok(Self {
            robot,
            engines,
            goal: grasp_goal(&hint, robot.acting_side(), LIFT_M, HOLD_S),
            hint,
            scene,
            seed,
            settings,
            has_torques: true,
        })
    }

    /// Lets the servos report zero torque.
    pub(crate) fn without_torques(self) -> Self {
        Self {
            has_torques: false,
            ..self
        }
    }

    /// Changes the sensors of the scene.
    pub(crate) fn with_scene(&self, change: impl FnOnce(&mut Scene)) -> Self {
        let mut scene = self.scene.clone();
        change(&mut scene);
        Self { scene, ..*self }
    }

    /// Returns the true object.
    pub(crate) fn object(&self) -> &Object {
        &self.scene.objects[0].object
    }

    /// Returns the forces that decide whether the object can be held.
    pub(crate) fn load(&self) -> Load {
        let hand = self.robot.hand(self.robot.acting_side());
        Load::from_object(self.object(), &self.settings.grasp, hand.opposed_tips())
    }

    /// Returns the direction of the hand's closing axis, rad from +x towards +y.
    pub(crate) fn closing_yaw_rad(&self) -> f64 {
        self.hint.yaw_rad
    }

    /// Starts the trial: world at rest, controller ready, grasp requested.
    ///
    /// # Errors
    /// The world cannot be created.
    pub(crate) fn start(&self, grip: Grip) -> anyhow::Result<HeldRun<'_>> {
        HeldRun::new(self, grip)
    }

    fn world(&self) -> anyhow::Result<World> {
        let (robot, scene) = (self.robot, &self.scene);
        Ok(match self.engines {
            None => World::new(robot, scene, self.seed)?,
            Some(engines) => World::with_engine(robot, scene, self.seed, engines.borrow()?)?,
        })
    }
}

impl Outcome {
    /// Evaluates the object at the end of a hold.
    pub(crate) fn of(object: &ObjectTruth) -> Self {
        let is_steady =
            object.slip_in_hand_m <= SLIP_MAX_M && object.turn_in_hand_rad <= TURN_MAX_RAD;
        if object.crushed != 0 {
            Self::Crushed
        } else if object.dropped != 0 {
            Self::Dropped
        } else if object.lifted_m < LIFTED_SHARE * LIFT_M {
            Self::NotLifted
        } else if is_steady {
            Self::Held
        } else {
            Self::Slipped
        }
    }
}

/// Returns the reason if the engine did not simulate a tick; `None` without a fault. Also an engine
/// that ended or hung costs one trial only: the next one gets another process.
///
/// # Errors
/// Any other fault.
pub(crate) fn discarded(world: &World) -> anyhow::Result<Option<String>> {
    match world.fault() {
        None => Ok(None),
        Some(WorldFault::Engine(EngineError::Tick(reason))) => Ok(Some(reason)),
        Some(WorldFault::Engine(error)) => Ok(Some(error.to_string())),
        Some(fault) => Err(fault.into()),
    }
}
