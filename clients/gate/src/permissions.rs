//! Permissions of group members by the configuration.

use std::path::{Path, PathBuf};

use atas_console::arguments::Right;
use atas_process::configuration::{GroupRight, SYSTEM_FILE, SYSTEM_FOLDER, system_files};
use serde::Deserialize;
use toml::{Table, Value};

/// Reads these files, or the system's files if there are none; later ones win. The daemon reports
/// errors of other keys.
pub(crate) fn read_permission(files: &[PathBuf]) -> Result<GroupRight, String> {
    let system;
    let files = if files.is_empty() {
        system = system_files().map_err(|error| format!("{SYSTEM_FOLDER}: {error}"))?;
        &system
    } else {
        files
    };
    let mut granted = GroupRight::default();
    for file in files {
        let read = read(file).map_err(|why| format!("{}: {why}", file.display()))?;
        granted = read.unwrap_or(granted);
    }
    Ok(granted)
}

/// Checks whether a permission is granted. The error names the reason and the remedy for an
/// administrator.
pub(crate) fn check(needed: Right, granted: &Result<GroupRight, String>) -> Result<(), String> {
    match (granted, needed) {
        // A stopped robot is safer than one that waits for a corrected file.
        (Err(_), Right::Stop)
        | (Ok(GroupRight::Observe), Right::Stop | Right::Observe)
        | (Ok(GroupRight::Command), _) => Ok(()),
        (Err(why), _) => Err(format!(
            "could not read access.group because {why}; an administrator must correct this; until then only a stop passes the gate"
        )),
        (Ok(granted @ (GroupRight::None | GroupRight::Observe)), _) => Err(format!(
            "command rejected by the gate: access.group is \"{granted}\", needs \"{}\"; an administrator sets it in \
             {SYSTEM_FILE} or in {SYSTEM_FOLDER}, and it takes effect at once",
            if needed == Right::Command {
                GroupRight::Command
            } else {
                GroupRight::Observe
            }
        )),
    }
}

/// Returns the permission of one file, if it has one.
fn read(file: &Path) -> Result<Option<GroupRight>, String> {
    let text = atas_text_file::read(file)
        .map_err(|error| format!("could not read it because of: {error}"))?;
    let table: Table = text.parse().map_err(|error: toml::de::Error| {
        format!("is not TOML: {}", error.message().replace('\n', ", "))
    })?;
    let Some(access) = table.get("access") else {
        return Ok(None);
    };
    let access = access.as_table().ok_or("access is not a section")?;
    let word = |value: &Value| {
        GroupRight::deserialize(value.clone()).map_err(|_| {
            format!("access.group is {value}, needs \"none\", \"observe\" or \"command\"")
        })
    };
    access.get("group").map(word).transpose()
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;

    #[test]
    fn missing_permission_names_its_key() {
        let check = |needed: Right, granted: Result<GroupRight, &str>, refused: Option<&str>| {
            let granted = granted.map_err(str::to_owned);
            match (check(needed, &granted), refused) {
                (Ok(()), None) => {}
                (Err(why), Some(part)) => assert!(why.contains(part), "{why}"),
                (found, _) => panic!("{needed} with {granted:?}: {found:?}"),
            }
        };
        let needs_command = Some("access.group is \"observe\", needs \"command\"");
        check(
            Right::Stop,
            Ok(GroupRight::None),
            Some("is \"none\", needs \"observe\""),
        );
        check(
            Right::Observe,
            Ok(GroupRight::None),
            Some("is \"none\", needs \"observe\""),
        );
        check(
            Right::Command,
            Ok(GroupRight::None),
            Some("is \"none\", needs \"command\""),
        );
        check(Right::Stop, Ok(GroupRight::Observe), None);
        check(Right::Observe, Ok(GroupRight::Observe), None);
        check(Right::Command, Ok(GroupRight::Observe), needs_command);
        check(Right::Stop, Ok(GroupRight::Command), None);
        check(Right::Observe, Ok(GroupRight::Command), None);
        check(Right::Command, Ok(GroupRight::Command), None);
        check(Right::Stop, Err("x.toml: is not TOML"), None);
        check(
            Right::Observe,
            Err("x.toml: is not TOML"),
            Some("x.toml: is not TOML"),
        );
        check(
            Right::Command,
            Err("x.toml: is not TOML"),
            Some("only a stop"),
        );
    }

    #[test]
    fn gate_and_daemon_read_equal_files() {
        let folder = tempfile::tempdir().expect("a folder");
        let check = |texts: &[&str], expected: Result<GroupRight, &str>| {
            let mut files = Vec::new();
            for (index, text) in texts.iter().enumerate() {
                files.push(folder.path().join(format!("{index}.toml")));
                fs::write(&files[index], text).expect("written");
            }
            match (read_permission(&files), expected) {
                (Ok(found), Ok(expected)) => assert_eq!(found, expected, "{texts:?}"),
                (Err(why), Err(part)) => assert!(why.contains(part), "{why}"),
                (found, _) => panic!("{texts:?}: {found:?}"),
            }
            // The gate accepts the same files as the daemon.
            let source = atasd::config::Source {
                files,
                flags: vec![],
            };
            let daemon = source.load().map(|config| config.access.group);
            match (daemon, expected) {
                (Ok(word), Ok(granted)) => assert_eq!(word, granted),
                (Err(_), Err(_)) => {}
                (daemon, _) => panic!("{texts:?}: the daemon {daemon:?}"),
            }
        };
        check(&[""], Ok(GroupRight::Observe));
        check(&["[access]"], Ok(GroupRight::Observe));
        check(&["[access]\ngroup = \"none\""], Ok(GroupRight::None));
        check(&["access.group = \"command\""], Ok(GroupRight::Command));
        check(
            &["access.group = \"command\"", "[grasp]\ndr_n = 0.1"],
            Ok(GroupRight::Command),
        );
        check(
            &["access.group = \"command\"", "access.group = \"observe\""],
            Ok(GroupRight::Observe),
        );
        check(
            &["access.group = \"all\""],
            Err("0.toml: access.group is \"all\", needs"),
        );
        check(&["access.group = true"], Err("access.group is true, needs"));
        check(&["access = 1"], Err("not a section"));
        check(&["access.group = "], Err("is not TOML"));
        let absent = [folder.path().join("absent.toml")];
        assert!(read_permission(&absent).is_err_and(|why| why.contains("absent.toml")));
    }
}
