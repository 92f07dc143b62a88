//! Access rights that each command needs on a bus of another user. The gate and its clients both
//! use this table.
//!
//! The matches name every command, and every argument of each command that the gate allows. A new
//! command or argument does not compile before its rights are decided here.

use std::path::Path;

use shm_bus::BusName;

use super::*;

/// Right that the service's group may have.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Right {
    /// Stop the robot.
    Stop,
    /// Read status, events and parameters.
    Observe,
    /// Move the robot and change parameters.
    Command,
}

impl std::fmt::Display for Right {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::Stop => "stop",
            Self::Observe => "observe",
            Self::Command => "command",
        })
    }
}

/// Access that a command needs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Access<'a> {
    /// No bus, or a private bus: the command runs as the calling user.
    Caller,
    /// A right on a bus. The command uses neither files nor the network.
    Right(Right, &'a BusName),
    /// Recordings of a folder: the command runs as the calling user. A server on another machine
    /// supplies its folder.
    Recordings,
    /// The user of the bus, because the command also uses files or ports. The text is the reason.
    Owner(&'a BusName, &'static str),
}

/// Reason to reject plots, recordings and target files.
const FILES: &str = "reads or writes files";
/// Reason to reject servers.
const PORT: &str = "opens a port to every user of this machine";

impl Command {
    /// Returns the access that the command needs.
    #[must_use]
    pub fn access(&self) -> Access<'_> {
        let observe = |bus| Access::Right(Right::Observe, bus);
        let command = |bus| Access::Right(Right::Command, bus);
        match self {
            Self::Demo { .. }
            | Self::Eval { .. }
            | Self::Fault { .. }
            | Self::Soak(_)
            | Self::Assure(_)
            | Self::Plot { .. }
            | Self::Robot { .. }
            | Self::Calibrate { .. }
            | Self::Bench { .. }
            | Self::Replay { .. }
            | Self::Diff { .. }
            | Self::Export(_)
            | Self::Completions { .. }
            | Self::Man { .. }
            | Self::Remote { .. } => Access::Caller,
            Self::Recordings { .. } => Access::Recordings,
            // The doctor checks the limits of the calling user.
            Self::Doctor(_) => Access::Caller,
            Self::Record { action, options } => match action {
                Some(_) => Access::Caller,
                None => Access::Owner(&options.bus.bus, FILES),
            },
            Self::Explain(Explain {
                files,
                goal: _,
                list: _,
                out,
                bus,
            }) => match (*files == [Path::new(Explain::LAST)], out) {
                (true, None) => observe(&bus.bus),
                (true, Some(_)) => Access::Owner(&bus.bus, FILES),
                (false, _) => Access::Caller,
            },
            Self::Dashboard(Dashboard { recording, bus, .. }) if recording.is_empty() => {
                Access::Owner(&bus.bus, PORT)
            }
            Self::Foxglove(Foxglove {
                print_layout: false,
                bus,
                ..
            }) => Access::Owner(&bus.bus, PORT),
            Self::Dashboard(_) | Self::Foxglove(_) => Access::Caller,

            Self::Estop(BusArgument { bus }) => Access::Right(Right::Stop, bus),

            Self::Status(Status { watch: _, bus }) | Self::Latency(Latency { watch: _, bus }) => {
                observe(&bus.bus)
            }
            Self::Top(BusArgument { bus }) => observe(bus),
            Self::Events(Events {
                kinds: _,
                hand: _,
                last_goal: _,
                follow: _,
                count: _,
                bus,
            }) => observe(&bus.bus),
            Self::Topic { action } => observe(match action {
                Topic::List(BusArgument { bus }) => bus,
                Topic::Echo {
                    service: _,
                    count: _,
                    bus,
                }
                | Topic::Hz {
                    service: _,
                    seconds: _,
                    bus,
                } => &bus.bus,
            }),
            Self::Param { action } => match action {
                Param::List(BusArgument { bus }) => observe(bus),
                Param::Get { name: _, bus } => observe(&bus.bus),
                Param::Set {
                    name: _,
                    value: _,
                    bus,
                } => command(&bus.bus),
            },

            Self::Cancel(BusArgument { bus }) | Self::Recover(BusArgument { bus }) => command(bus),
            Self::Zero(Zero { hand: _, bus }) => command(&bus.bus),
            Self::Grasp(Grasp {
                at: _,
                yaw: _,
                width: _,
                lift: _,
                hold: _,
                known: _,
                sending,
            }) => command(sending.bus()),
            Self::PickPlace(PickPlace {
                from: _,
                to: _,
                yaw: _,
                to_yaw: _,
                width: _,
                lift: _,
                known: _,
                sending,
            }) => command(sending.bus()),
            Self::Screw(Screw {
                at: _,
                yaw: _,
                width: _,
                turn: _,
                sending,
            }) => command(sending.bus()),
            Self::Assemble(Assemble {
                cap: _,
                cap_width: _,
                on: _,
                bottle_width: _,
                yaw: _,
                turn: _,
                sending,
            }) => command(sending.bus()),
            Self::Task(UserTask {
                name: _,
                from: _,
                to: _,
                yaw: _,
                to_yaw: _,
                width: _,
                helper_width: _,
                lift: _,
                hold: _,
                turn: _,
                known: _,
                sending,
            }) => command(sending.bus()),
            Self::Release(Release { sending }) => command(sending.bus()),
            Self::Teleop(Teleop {
                file,
                hand: _,
                step: _,
                turn: _,
                yaw: _,
                bus,
            }) => match file {
                Some(_) => Access::Owner(&bus.bus, FILES),
                None => command(&bus.bus),
            },
        }
    }
}

impl SendOptions {
    fn bus(&self) -> &BusName {
        let Self {
            hand: _,
            attached: _,
            timeout: _,
            bus: BusArgument { bus },
        } = self;
        bus
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::Parser;

    #[test]
    fn commands_need_expected_access() {
        let check = |line: &str, needs: &str| {
            let words = format!("atas {line}");
            let parsed = Arguments::try_parse_from(words.split_whitespace());
            let command = parsed
                .unwrap_or_else(|error| panic!("{line}: {error}"))
                .command;
            let found = match command.access() {
                Access::Caller => "caller".to_owned(),
                Access::Recordings => "recordings".to_owned(),
                Access::Right(right, bus) => format!("{right} on {bus}"),
                Access::Owner(bus, why) => format!("owner of {bus}: {why}"),
            };
            assert_eq!(found, needs, "{line}");
        };
        check("estop --bus b", "stop on b");
        check("stop --bus b", "stop on b");
        for line in [
            "status",
            "status --watch --format json",
            "top",
            "topic list",
            "topic echo status --count 2",
            "topic hz view",
            "events --follow",
            "latency --watch",
            "param list",
            "param get grasp.dr_n",
            "explain last",
        ] {
            check(&format!("{line} --bus b"), "observe on b");
        }
        for line in [
            "grasp --at 0.3,0,0.1 --width 50",
            "pick-place",
            "screw",
            "assemble",
            "task polish",
            "release",
            "teleop",
            "cancel",
            "recover",
            "zero",
            "param set grasp.dr_n 0.1",
        ] {
            check(&format!("{line} --bus b"), "command on b");
        }
        for line in ["record", "teleop targets.csv", "explain last --out why.svg"] {
            check(
                &format!("{line} --bus b"),
                "owner of b: reads or writes files",
            );
        }
        for line in ["dashboard", "foxglove"] {
            check(
                &format!("{line} --bus b"),
                "owner of b: opens a port to every user of this machine",
            );
        }
        for line in [
            "demo grasp",
            "eval screw",
            "plot run.mcap --out run.svg",
            "robot list",
            "assure --check",
            "replay run.mcap",
            "diff one.mcap other.mcap",
            "export run.mcap --to csv",
            "record check run.mcap",
            "explain run.mcap",
            "explain last run.mcap",
            "dashboard --recording run.mcap",
            "foxglove --print-layout",
            "doctor",
            "completions bash",
            "man pages",
            "remote serve --config remote.toml",
            "remote keys --out keys",
            "remote check",
        ] {
            check(line, "caller");
        }
        check("recordings list", "recordings");
        check("recordings fetch run.mcap", "recordings");
    }
}
