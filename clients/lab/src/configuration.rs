//! The user's configuration of the daemon, for runs in virtual time.
//!
//! `atasd --check-config` reads, merges and checks the file, so that the daemon and this program
//! accept the same configurations.

use std::path::Path;
use std::process::{Command, Stdio};

use anyhow::Context;
use atas_console::{Exit, ExitError};
use atas_core::Settings;
use atas_processes::sibling_program;
use robot_model::{RobotFiles, TWO_HAND_ARM};
use toml::Table;

/// Sections of [`Settings`].
const SECTIONS: [&str; 8] = [
    "intake",
    "perception",
    "grasp",
    "place",
    "screw",
    "teleop",
    "motion",
    "safety",
];
/// Tick rate of virtual time, Hz.
const RATE_HZ: i64 = 1000;

/// Robot and settings of a configuration.
#[derive(Clone, Debug)]
pub(crate) struct Configured {
    /// Name or file.
    pub(crate) robot: String,
    pub(crate) settings: Settings,
}

impl Configured {
    /// Returns name and files of the named robot, else of the configured one.
    pub(crate) fn robot_files(
        &self,
        named: Option<&String>,
    ) -> anyhow::Result<(String, RobotFiles)> {
        let name = named.unwrap_or(&self.robot);
        let files = RobotFiles::find(name)
            .map_err(|error| ExitError::with_code(Exit::Usage, error.to_string()))?;
        Ok((name.clone(), files))
    }
}

/// Returns robot and settings; without a file, the defaults.
pub(crate) fn configured(file: Option<&Path>) -> anyhow::Result<Configured> {
    let Some(file) = file else {
        return Ok(Configured {
            robot: TWO_HAND_ARM.name.to_string(),
            settings: Settings::default(),
        });
    };
    let output = Command::new(sibling_program("atasd")?)
        .args(["--check-config", "--config"])
        .arg(file)
        .stdin(Stdio::null())
        .output()
        .context("could not start atasd")?;
    if !output.status.success() {
        let text = String::from_utf8_lossy(&output.stderr).trim().to_owned();
        return Err(ExitError::with_code(Exit::Input, text));
    }
    let text = String::from_utf8(output.stdout).context("atasd prints UTF-8")?;
    let table: Table = toml::from_str(&text).context("atasd prints TOML")?;
    require_virtual_time(&table, file)?;
    let robot = table.get("robot").and_then(|robot| robot.get("model"));
    let robot = robot.and_then(|model| model.as_str());
    let mut sections = table.clone();
    sections.retain(|name, _| SECTIONS.contains(&name));
    Ok(Configured {
        robot: robot.context("the configuration names a robot")?.to_owned(),
        settings: sections.try_into().context("could not read the settings")?,
    })
}

/// Rejects a configuration of which virtual time has no counterpart.
fn require_virtual_time(table: &Table, file: &Path) -> anyhow::Result<()> {
    let reject = |text: String| {
        let file = file.display();
        Err(ExitError::with_code(
            Exit::Input,
            format!("could not simulate {file}: {text}"),
        ))
    };
    let value = |path: &[&str]| {
        let mut value = table.get(path[0]);
        for key in &path[1..] {
            value = value.and_then(|value| value.get(key));
        }
        value
    };
    let rate = value(&["realtime", "rate_hz"]).and_then(toml::Value::as_integer);
    if rate.is_some_and(|rate| rate != RATE_HZ) {
        return reject(format!("realtime.rate_hz is {rate:?}, needs {RATE_HZ}"));
    }
    for hand in ["left", "right"] {
        let layout = value(&["hands", hand, "layout"]);
        if layout.is_some_and(|layout| layout.as_str() != Some("robot")) {
            return reject(format!(
                "hands.{hand}.layout differs from the robot's; put the layout into a robot file"
            ));
        }
    }
    Ok(())
}
