//! Decision about a command line: its right, and the arguments to run.
//!
//! The definition of the command line decides, not the spelling of the words.

use std::path::PathBuf;

use atas_console::arguments::{Access, Arguments, Command, Recordings, Right, command};
use clap::parser::ValueSource;
use clap::{ArgMatches, FromArgMatches};
use shm_bus::BusName;

/// Permitted command.
#[derive(Debug, PartialEq, Eq)]
pub(crate) struct Decision {
    /// Right that the client needs.
    pub(crate) right: Right,
    /// Arguments after `atas`.
    pub(crate) arguments: Vec<String>,
}

/// Decides about the words after `atas`. The error is the reason of a rejection.
pub(crate) fn decide(
    mut words: Vec<String>,
    bus: &BusName,
    recordings: Option<PathBuf>,
) -> Result<Decision, String> {
    if words.iter().any(|word| word.contains('\0')) {
        return Err("a word of the command line contains a zero byte".into());
    }
    let line = std::iter::once("atas").chain(words.iter().map(String::as_str));
    let matches = command().try_get_matches_from(line);
    let matches = matches.map_err(|_| "the command line is invalid".to_owned())?;
    let arguments = Arguments::from_arg_matches(&matches);
    let arguments = arguments.map_err(|_| "the command line is invalid".to_owned())?;
    let selection = &arguments.remote;
    if selection.remote.is_some() || selection.remote_config.is_some() {
        return Err("the server does not connect to other machines".into());
    }
    if let Some(why) = local_reason(&arguments) {
        return Err(why);
    }
    let right = match arguments.command.access() {
        Access::Right(right, selected) => {
            if is_bus_selected(&matches) && selected != bus {
                return Err(format!("the server serves bus {bus}, not {selected}"));
            }
            right
        }
        Access::Recordings => {
            words.extend(recordings_words(&arguments.command, recordings)?);
            Right::Observe
        }
        Access::Caller | Access::Owner(..) => return Err("the command is not permitted".into()),
    };
    Ok(Decision {
        right,
        arguments: words,
    })
}

/// Returns the reason why a command does not run on another machine.
pub(crate) fn local_reason(arguments: &Arguments) -> Option<String> {
    let why = match (&arguments.command, arguments.command.access()) {
        (Command::Top(_) | Command::Teleop(_), _) => {
            "needs a terminal of the robot's machine; use ssh"
        }
        (_, Access::Right(..) | Access::Recordings) => return None,
        (_, Access::Caller) => "runs on this machine only; omit --remote",
        (_, Access::Owner(_, why)) => {
            return Some(format!(
                "this command does not run with --remote: it {why}; run it on the robot's machine"
            ));
        }
    };
    Some(format!("this command does not run with --remote: it {why}"))
}

/// Returns true if the command line contains `--bus`.
fn is_bus_selected(matches: &ArgMatches) -> bool {
    let known = matches.try_contains_id("bus").unwrap_or(false);
    let own = known && matches.value_source("bus") == Some(ValueSource::CommandLine);
    own || matches
        .subcommand()
        .is_some_and(|(_, below)| is_bus_selected(below))
}

/// Returns the words that select the server's folder.
fn recordings_words(
    command: &Command,
    folder: Option<PathBuf>,
) -> Result<impl Iterator<Item = String>, String> {
    let Command::Recordings { action } = command else {
        return Err("the command is not permitted".into());
    };
    let is_fetch = match action {
        Recordings::List { folder: None } => false,
        Recordings::Fetch {
            name: _,
            out: None,
            folder: None,
            stdout: false,
        } => true,
        _ => return Err("the folder of the recordings is in the server's configuration".into()),
    };
    let folder = folder
        .ok_or("the server's configuration has no folder of recordings; set `recordings` in it")?;
    let folder = folder
        .into_os_string()
        .into_string()
        .map_err(|_| "the folder of the recordings is not UTF-8".to_owned())?;
    let stdout = is_fetch.then(|| "--stdout".to_owned());
    Ok(["--folder".to_owned(), folder].into_iter().chain(stdout))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn decided(line: &str) -> Result<Decision, String> {
        let words = line.split_whitespace().map(str::to_owned).collect();
        let bus = "arm".parse().expect("a name");
        decide(words, &bus, Some("/tapes".into()))
    }

    #[test]
    fn commands_need_the_right_of_the_gate() {
        let check = |line: &str, right| {
            let decision = decided(line).expect("permitted");
            assert_eq!(
                (decision.right, decision.arguments.join(" ")),
                (right, line.to_owned())
            );
        };
        check("estop", Right::Stop);
        check("status --format json", Right::Observe);
        check("status --bus arm", Right::Observe);
        check("explain last", Right::Observe);
        check("grasp --at 0.3,0,0.1 --width 50 --attached", Right::Command);
        check("cancel", Right::Command);
    }

    #[test]
    fn recordings_come_from_the_folder_of_the_server() {
        let arguments = |line: &str| decided(line).expect("permitted").arguments.join(" ");
        assert_eq!(
            arguments("recordings list"),
            "recordings list --folder /tapes"
        );
        assert_eq!(
            arguments("recordings fetch a.mcap"),
            "recordings fetch a.mcap --folder /tapes --stdout"
        );
        let without = decide(
            vec!["recordings".into(), "list".into()],
            &BusName::default(),
            None,
        );
        assert!(without.is_err_and(|why| why.contains("has no folder")));
    }

    #[test]
    fn unsuitable_command_lines_are_refused_with_reason() {
        let check = |line: &str, part: &str| {
            let why = decided(line).expect_err("refused");
            assert!(why.contains(part), "{line}: {why}");
        };
        check("", "invalid");
        check("fly", "invalid");
        check("--help", "invalid");
        check("status --bus other", "serves bus arm, not other");
        check(
            "status --remote other",
            "does not connect to other machines",
        );
        check(
            "status --remote-config x",
            "does not connect to other machines",
        );
        check("top", "terminal");
        check("teleop", "terminal");
        check("record", "reads or writes files");
        check("explain last --out why.svg", "reads or writes files");
        check("dashboard", "opens a port");
        check("demo grasp", "runs on this machine only");
        check("doctor", "runs on this machine only");
        check("explain /etc/shadow", "runs on this machine only");
        check("remote serve --config x", "runs on this machine only");
        check(
            "recordings list --folder /etc",
            "in the server's configuration",
        );
        check("recordings fetch ../a.mcap", "invalid");
        check(
            "recordings fetch a.mcap --out b.mcap",
            "in the server's configuration",
        );
    }
}
