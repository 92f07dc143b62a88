//! Steps of a task: motion, waypoint, modules and transition.

use super::name::Name;
use crate::modules::Selection;
use shm_schemas::ModuleId;

/// Step of a task.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Step {
    /// Name shown to users.
    pub name: Name,
    /// Motion of the hand.
    pub motion: Motion,
    /// Active modules.
    pub modules: Selection,
    /// Condition that ends the step.
    pub transition: Transition,
    /// Maximum duration, s.
    pub timeout_s: f64,
}

impl Step {
    /// Creates a step; arguments in the column order of task tables.
    #[must_use]
    pub const fn new(
        name: &str,
        motion: Motion,
        modules: Selection,
        transition: Transition,
        timeout_s: f64,
    ) -> Self {
        Self {
            name: Name::new(name),
            motion,
            modules,
            transition,
            timeout_s,
        }
    }

    /// Returns true if a behaviour table controls the hand; it may grip on its way.
    #[must_use]
    pub fn uses_table(&self) -> bool {
        self.modules.contains(ModuleId::BEHAVIOUR_TABLE)
    }

    /// Returns true if a task that begins with this step requires an object in hand.
    #[must_use]
    pub fn starts_with_object(&self) -> bool {
        let moves_object = matches!(
            self.motion,
            Motion::Carry(_) | Motion::Convey(_) | Motion::Lower
        );
        moves_object && !self.uses_table()
    }
}

/// Motion of the hand.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Motion {
    /// No motion; modules move the fingers.
    Stay,
    /// Free motion to a waypoint and its opening.
    Reach(Waypoint),
    /// Motion of a gripped object to a waypoint, at lifting speed.
    Carry(Waypoint),
    /// Motion of a gripped object to a waypoint, at conveying speed.
    Convey(Waypoint),
    /// Vertical lowering of a gripped object, down to the lowest permitted target height.
    Lower,
    /// Square trajectory of Module 0, repeated.
    Square,
    /// Opening in place.
    Open,
    /// Fast release of a standing object.
    LetGo,
    /// Free motion back to the start of the previous step.
    Withdraw,
    /// Tracking of the client's targets.
    Teleop,
    /// Braking from teleoperation.
    Brake,
}

/// Condition that ends a step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Transition {
    /// End of the path.
    Arrived,
    /// Contact on every grasp side.
    AllTouched,
    /// Known stiffness.
    StiffnessKnown,
    /// Weakest grasp side above F_1, or strongest above F_2.
    Gripped,
    /// End of the goal's hold time.
    Held,
    /// Conclusion of a module (Module 4).
    Concluded,
    /// Meeting point reached by both hands; points count up along a sequence.
    Met(u8),
    /// Grip request of the client, or contact while closing.
    GripRequested,
    /// Client request for an opening wider than the object.
    OpeningRequested,
}

/// Named pose.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Waypoint {
    /// Rest position, tilted for a side grasp.
    Tilted,
    /// Open pose above the object, or behind it for a side grasp.
    BeforeSource,
    /// Pose at the object, wide open.
    Around,
    /// Pose at the object, slightly wider than it.
    Source,
    /// Pose at lift height.
    Lifted,
    /// Pose over the target at lift height.
    OverTarget,
    /// Present pose, open, at the start of a turn.
    TurnStart,
    /// Pose straight above the present one.
    Above,
    /// Rest pose of the arm.
    Home,
}
