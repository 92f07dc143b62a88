//! What a task consists of: steps, and the three things that a step says besides its modules: how the hand moves, where
//! to, and when the step is done.

use super::name::Name;
use crate::modules::Selection;
use shm_schemas::ModuleId;

/// One step of a task.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Step {
    /// Name, as users see it.
    pub name: Name,
    /// How the hand moves.
    pub motion: Motion,
    /// Which modules work.
    pub modules: Selection,
    /// When the step is done.
    pub transition: Transition,
    /// When it has taken too long, s.
    pub timeout_s: f64,
}

impl Step {
    /// A step; the arguments in the order of the columns of a task's table.
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

    /// Whether a behaviour table governs fingers and hand: it may grip on its way.
    #[must_use]
    pub fn is_read_off(&self) -> bool {
        self.modules.contains(ModuleId::BEHAVIOUR_TABLE)
    }

    /// Whether a task that begins with this step goes on with what the hand already holds.
    #[must_use]
    pub fn takes_over(&self) -> bool {
        let moves_object = matches!(
            self.motion,
            Motion::Carry(_) | Motion::Convey(_) | Motion::Lower
        );
        moves_object && !self.is_read_off()
    }
}

/// How the hand moves in a step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Motion {
    /// Not at all; the fingers follow the modules.
    Stay,
    /// Freely to a waypoint, fingers opening as the waypoint says.
    Reach(Waypoint),
    /// Gripping to a waypoint, at the lifting speed; the fingers follow the modules.
    Carry(Waypoint),
    /// Gripping to a waypoint, at the conveying speed; the fingers follow the modules.
    Convey(Waypoint),
    /// Gripping straight down, as far as the target may lie below its expected height.
    Lower,
    /// On the square trajectory of Module 0, over and over.
    Square,
    /// Stays and opens.
    Open,
    /// Stays and opens at once, just off what stands.
    LetGo,
    /// Freely back to where the step before began.
    Withdraw,
    /// After the targets of the goal's client.
    Follow,
    /// Brakes from following, and stays.
    Brake,
}

/// When a step is done.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Transition {
    /// The path has ended.
    Arrived,
    /// Every finger has touched.
    AllTouched,
    /// The stiffness is known.
    StiffnessKnown,
    /// The weakest finger presses more than F_1, or the strongest more than F_2.
    Gripped,
    /// The goal's holding time has passed.
    Held,
    /// A module says so: Module 4.
    Concluded,
    /// Both hands have come to this meeting point; points count up along a track.
    Met(u8),
    /// The client that leads the hand wants something held, or has closed the fingers on it.
    GripWanted,
    /// The client that leads the hand wants it wider than what it holds.
    OpeningWanted,
}

/// A named pose.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Waypoint {
    /// Where the arm rests, tilted and open for a grasp from the side.
    Tilted,
    /// Before the object, open: straight above it, or behind it for a grasp from the side.
    BeforeSource,
    /// At the object, opened wide.
    Around,
    /// At the object, open a little wider than it.
    Source,
    /// Where the object is lifted to.
    Lifted,
    /// Over the target, as high as the object is lifted.
    OverTarget,
    /// Where the hand is, open, where a turn begins.
    TurnStart,
    /// Straight above where the hand is.
    Above,
    /// Where the arm rests.
    Home,
}
