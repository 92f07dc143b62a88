//! Displayed robot and sensors: those of the daemon, unless the user selects a robot.

use std::time::{Duration, Instant};

use atas_client::{Run, layouts};
use robot_model::RobotFiles;
use shm_bus::{Bus, BusError};
use shm_schemas::capacity::HANDS;
use shm_schemas::{Layout, RunHeader, Status};

/// Time until a missing robot name of the daemon is reported (design choice).
const NAMING_TIMEOUT: Duration = Duration::from_secs(1);

/// Displayed robot, as far as known.
#[derive(Clone, Debug)]
pub(crate) struct DisplayedRobot {
    /// Robot files; `None` if not found.
    pub(crate) robot: Option<RobotFiles>,
    /// Note to the user; empty if the displayed robot is the running one.
    pub(crate) note: String,
    /// Element positions of each hand's fingertips.
    pub(crate) layouts: [Layout; HANDS],
    /// Fingertips with sensors per hand; 0 for a missing hand.
    pub(crate) fingers: [usize; HANDS],
}

/// Displayed robot, kept up to date with the daemon.
pub(crate) struct RobotDisplay<'a> {
    selected: Option<&'a RobotFiles>,
    run: Run,
    shown: Option<DisplayedRobot>,
    key: Key,
    since: Instant,
}

/// Inputs of the displayed robot: process id of the daemon, whether it has named its robot,
/// fingertips with sensors.
type Key = (u32, bool, [usize; HANDS]);

impl<'a> RobotDisplay<'a> {
    /// Starts without a robot. `selected` is the user's robot.
    pub(crate) fn new(selected: Option<&'a RobotFiles>) -> Self {
        Self {
            selected,
            run: Run::default(),
            shown: None,
            key: Key::default(),
            since: Instant::now(),
        }
    }

    /// Updates from the daemon's status; returns true if the displayed robot has changed.
    ///
    /// # Errors
    /// The shared memory of the daemon cannot be read.
    pub(crate) fn update(&mut self, bus: &Bus, status: &Status) -> Result<bool, BusError> {
        self.run.poll(bus, status)?;
        if self.key.0 != status.pid && !self.is_named() {
            (self.key, self.since) = ((status.pid, false, [0; HANDS]), Instant::now());
        }
        let key = (status.pid, self.is_named(), self.run.fingertips(status));
        let is_silent = !self.is_named() && self.since.elapsed() < NAMING_TIMEOUT;
        if status.pid == 0 || is_silent || (key == self.key && self.shown.is_some()) {
            return Ok(false);
        }
        let shown = DisplayedRobot::from_run(self.selected, &self.run, status);
        if !shown.note.is_empty() {
            tracing::warn!("{}", shown.note);
        }
        (self.key, self.shown) = (key, Some(shown));
        Ok(true)
    }

    fn is_named(&self) -> bool {
        self.run.header().is_some()
    }

    /// Returns the displayed robot; `None` before the daemon has named it.
    pub(crate) fn shown(&self) -> Option<&DisplayedRobot> {
        self.shown.as_ref()
    }
}

impl DisplayedRobot {
    /// Determines the displayed robot of a run. `selected` is the user's robot.
    pub(crate) fn from_run(selected: Option<&RobotFiles>, run: &Run, status: &Status) -> Self {
        let (robot, note) = match (selected, run.header()) {
            (Some(selected), header) => (Some(selected.clone()), difference_note(selected, header)),
            (None, Some(header)) => match running_robot(header) {
                Ok(robot) => (Some(robot), String::new()),
                Err(why) => (None, why),
            },
            (None, None) if status.pid == 0 => {
                let why = "no daemon has named its robot yet";
                (None, why.to_owned())
            }
            (None, None) => {
                let why = "the daemon does not name its robot; select it with --robot";
                (None, why.to_owned())
            }
        };
        Self {
            robot,
            note,
            layouts: layouts::of_run(run.header()),
            fingers: if status.pid == 0 {
                [0; HANDS]
            } else {
                run.fingertips(status)
            },
        }
    }

    /// Returns the layout of this hash for the frames of a hand, if known.
    pub(crate) fn layout(&self, hand: usize, hash: u64) -> Option<Layout> {
        let own = &self.layouts[hand];
        if own.hash() == hash {
            Some(*own)
        } else {
            layouts::named(hash)
        }
    }
}

/// Returns the daemon's robot, or the reason why it cannot be drawn.
fn running_robot(header: &RunHeader) -> Result<RobotFiles, String> {
    let name = header.robot.as_str();
    let files = RobotFiles::find(name).and_then(|files| files.load().map(|_| files));
    let files = files.map_err(|error| {
        format!("could not draw robot {name} of the daemon: {error}; give its file with --robot")
    })?;
    if files.hash() != header.robot_hash {
        return Err(format!(
            "could not draw robot {name}: its files differ from those that the daemon has loaded; \
             restart the daemon, or select a robot with --robot"
        ));
    }
    Ok(files)
}

/// Returns a note if the user's robot differs from the running one.
fn difference_note(selected: &RobotFiles, header: Option<&RunHeader>) -> String {
    let other = header.filter(|header| selected.hash() != header.robot_hash);
    other.map_or_else(String::new, |header| {
        format!(
            "the displayed robot is {}, selected by --robot; the daemon runs {}",
            selected.name, header.robot
        )
    })
}

#[cfg(test)]
mod tests {
    use robot_model::{SHIPPED, TWO_HAND_ARM};
    use shm_schemas::Text;
    use shm_schemas::capacity::FINGERS;

    use super::*;

    fn header(name: &str, hash: u64) -> Box<RunHeader> {
        let mut header: Box<RunHeader> = Box::default();
        (header.robot, header.robot_hash) = (Text::new(name), hash);
        header
    }

    #[test]
    fn running_robot_is_found_or_reason_is_given() {
        for robot in SHIPPED {
            let found = running_robot(&header(&robot.name, robot.hash())).expect("built-in");
            assert_eq!(found.name, robot.name);
        }
        let check = |name: &str, hash, part: &str| {
            let why = running_robot(&header(name, hash)).expect_err("must not be drawn");
            assert!(why.contains(name) && why.contains(part), "{why}");
        };
        check("/no/such/arm.toml", 7, "give its file with --robot");
        check(
            "three-finger",
            7,
            "differ from those that the daemon has loaded",
        );
    }

    #[test]
    fn different_selected_robot_has_a_note() {
        let [_, gripper, ..] = SHIPPED;
        let runs = header(&gripper.name, gripper.hash());
        assert_eq!(difference_note(&gripper, Some(&runs)), "");
        assert_eq!(difference_note(&gripper, None), "");
        let note = difference_note(&TWO_HAND_ARM, Some(&runs));
        assert!(
            note.contains("two-hand-arm") && note.contains("arm7-gripper"),
            "{note}"
        );
    }

    #[test]
    fn unnamed_robot_is_not_drawn() {
        let unknown = |pid| {
            let status = Status {
                pid,
                ..Status::default()
            };
            DisplayedRobot::from_run(None, &Run::default(), &status)
        };
        let none = unknown(0);
        assert!(none.robot.is_none() && none.note.contains("no daemon"));
        assert_eq!(none.fingers, [0, 0]);
        let silent = unknown(7);
        assert!(silent.robot.is_none() && silent.note.contains("--robot"));
        assert_eq!(
            silent.fingers, [FINGERS; HANDS],
            "all fingertips are included"
        );
    }
}
