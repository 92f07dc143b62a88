//! Names (in configurations) and numbers (in recordings) of motions, waypoints and transitions.
//!
//! A number is an index into its list, so new entries go last.

use super::step::{Motion, Transition, Waypoint};
use crate::modules::{IDS, Selection};
use shm_schemas::ModuleId;

/// Motions; those to a waypoint contain a placeholder.
pub const MOTIONS: [Motion; 11] = [
    Motion::Stay,
    Motion::Reach(Waypoint::Home),
    Motion::Carry(Waypoint::Home),
    Motion::Convey(Waypoint::Home),
    Motion::Lower,
    Motion::Square,
    Motion::Open,
    Motion::LetGo,
    Motion::Withdraw,
    Motion::Teleop,
    Motion::Brake,
];

/// Waypoints.
pub const WAYPOINTS: [Waypoint; 9] = [
    Waypoint::Tilted,
    Waypoint::BeforeSource,
    Waypoint::Around,
    Waypoint::Source,
    Waypoint::Lifted,
    Waypoint::OverTarget,
    Waypoint::TurnStart,
    Waypoint::Above,
    Waypoint::Home,
];

/// Transitions; `Met` contains a placeholder.
pub const TRANSITIONS: [Transition; 9] = [
    Transition::Arrived,
    Transition::AllTouched,
    Transition::StiffnessKnown,
    Transition::Gripped,
    Transition::Held,
    Transition::Concluded,
    Transition::Met(1),
    Transition::GripRequested,
    Transition::OpeningRequested,
];

impl Motion {
    /// Name without its waypoint.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Stay => "stay",
            Self::Reach(_) => "reach",
            Self::Carry(_) => "carry",
            Self::Convey(_) => "convey",
            Self::Lower => "lower",
            Self::Square => "square",
            Self::Open => "open",
            Self::LetGo => "let-go",
            Self::Withdraw => "withdraw",
            Self::Teleop => "teleop",
            Self::Brake => "brake",
        }
    }

    /// Waypoint of the motion.
    #[must_use]
    pub const fn waypoint(self) -> Option<Waypoint> {
        match self {
            Self::Reach(waypoint) | Self::Carry(waypoint) | Self::Convey(waypoint) => {
                Some(waypoint)
            }
            _ => None,
        }
    }

    /// Returns the motion with another waypoint.
    #[must_use]
    pub const fn with_waypoint(self, waypoint: Waypoint) -> Self {
        match self {
            Self::Reach(_) => Self::Reach(waypoint),
            Self::Carry(_) => Self::Carry(waypoint),
            Self::Convey(_) => Self::Convey(waypoint),
            _ => self,
        }
    }

    /// Returns true if the motion carries an object.
    #[must_use]
    pub const fn needs_grip(self) -> bool {
        matches!(
            self,
            Self::Carry(_) | Self::Convey(_) | Self::Lower | Self::Square
        )
    }
}

impl Waypoint {
    /// Name of the waypoint.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Tilted => "tilted",
            Self::BeforeSource => "before-source",
            Self::Around => "around",
            Self::Source => "source",
            Self::Lifted => "lifted",
            Self::OverTarget => "over-target",
            Self::TurnStart => "turn-start",
            Self::Above => "above",
            Self::Home => "home",
        }
    }
}

impl Transition {
    /// Name without its meeting point.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Arrived => "arrived",
            Self::AllTouched => "all-touched",
            Self::StiffnessKnown => "stiffness-known",
            Self::Gripped => "gripped",
            Self::Held => "held",
            Self::Concluded => "concluded",
            Self::Met(_) => "met",
            Self::GripRequested => "grip-requested",
            Self::OpeningRequested => "opening-requested",
        }
    }

    /// Returns true if the goal, its client or the other hand decides the duration.
    #[must_use]
    pub const fn is_open_ended(self) -> bool {
        matches!(
            self,
            Self::Held | Self::Met(_) | Self::GripRequested | Self::OpeningRequested
        )
    }
}

impl Selection {
    /// Returns the modules in the order of [`IDS`].
    pub fn ids(self) -> impl Iterator<Item = ModuleId> {
        IDS.into_iter().filter(move |id| self.contains(*id))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_unique() {
        fn check<const N: usize>(words: [&str; N]) {
            for (i, word) in words.iter().enumerate() {
                assert!(!words[..i].contains(word), "{word} is used twice");
            }
        }
        check(MOTIONS.map(Motion::name));
        check(WAYPOINTS.map(Waypoint::name));
        check(TRANSITIONS.map(Transition::name));
        for waypoint in WAYPOINTS {
            for motion in MOTIONS {
                let expected = motion.waypoint().map(|_| waypoint);
                assert_eq!(motion.with_waypoint(waypoint).waypoint(), expected);
                assert_eq!(motion.with_waypoint(waypoint).name(), motion.name());
            }
        }
    }
}
