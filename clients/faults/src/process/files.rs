//! Faults of the configuration file.

use std::process::Command;
use std::time::Instant;

use anyhow::Context;
use atas_core::settings::PARAMETERS;
use atas_processes::sibling_program;
use rustix::process::Signal;
use shm_schemas::{ControlOp, ControlOutcome, ControlReply, ControlRequest, Text};
use toml::{Table, Value};

use super::pace::TIMEOUT;
use super::start::own_file;
use super::{Drill, Effect, Pace, Rig};

/// Parameter that a reload changes; any robot permits it during a goal.
const CHANGED: (&str, &str) = ("grasp", "dr_n");
/// Ticks between two polls.
const BETWEEN_TICKS: u64 = 20;

/// Each parameter in turn has a value above its range: the configuration is refused.
pub(super) const INVALID_CONFIGURATION: Drill = Drill::new(Pace::LockStep, invalid_configuration);

/// SIGHUP during a goal, with a changed configuration, then with an invalid one.
pub(super) const RELOAD: Drill =
    Drill::new(Pace::LockStep, reload).with_setup(|setup| setup.has_own_file = true);

fn invalid_configuration(rig: &mut Rig<'_>) -> anyhow::Result<Effect> {
    rig.promise();
    let program = sibling_program("atasd")?;
    for parameter in PARAMETERS {
        let value = 2.0 * parameter.upper.abs() + 1.0;
        let output = Command::new(&program)
            .args(["--check-config", "--config", "/dev/null", "--set"])
            .arg(format!("{}={value}", parameter.name))
            .output()?;
        let text = String::from_utf8_lossy(&output.stderr);
        let is_named = text.contains(parameter.name) && text.contains("needs");
        if output.status.code() != Some(7) || !is_named {
            return Ok(Effect::Failed(format!(
                "{}={value} is not refused by name and range ({}): {text}",
                parameter.name, output.status
            )));
        }
        rig.advance(BETWEEN_TICKS)?;
    }
    Ok(Effect::Done)
}

fn reload(rig: &mut Rig<'_>) -> anyhow::Result<Effect> {
    rig.promise();
    let file = own_file(&rig.logs.folder);
    let text = std::fs::read_to_string(&file)?;
    let mut table: Table = toml::from_str(&text).context("the configuration is TOML")?;
    let (section, key) = CHANGED;
    let name = format!("{section}.{key}");
    let value = read(rig, &name)?.value;
    let changed = value * 1.01;
    set(&mut table, section, key, changed)?;
    std::fs::write(&file, table.to_string())?;
    rig.daemon.signal(Signal::HUP)?;
    let begin = Instant::now();
    while read(rig, &name)?.value != changed {
        rig.advance(BETWEEN_TICKS)?;
        if begin.elapsed() > TIMEOUT {
            return Ok(Effect::Failed(format!("SIGHUP does not change {name}")));
        }
    }
    set(&mut table, section, key, -1.0)?;
    std::fs::write(&file, table.to_string())?;
    rig.daemon.signal(Signal::HUP)?;
    let begin = Instant::now();
    // The log names the refused value; until then the daemon has not read the file.
    while !rig.daemon.log().contains(&format!("{name} is -1")) {
        rig.advance(BETWEEN_TICKS)?;
        if begin.elapsed() > TIMEOUT {
            let text = format!("the daemon does not refuse {name} = -1");
            return Ok(Effect::Failed(text));
        }
    }
    let kept = read(rig, &name)?.value;
    std::fs::write(&file, text)?;
    Ok(Effect::require(kept == changed, || {
        format!("{name} is {kept} after a refused configuration; expected {changed}")
    }))
}

fn set(table: &mut Table, section: &str, key: &str, value: f64) -> anyhow::Result<()> {
    let section = table
        .entry(section)
        .or_insert_with(|| Value::Table(Table::new()));
    let section = section.as_table_mut().context("a section is a table")?;
    section.insert(key.to_owned(), Value::Float(value));
    Ok(())
}

fn read(rig: &mut Rig<'_>, name: &str) -> anyhow::Result<ControlReply> {
    let request = ControlRequest {
        op: ControlOp::PARAM_GET,
        name: Text::new(name),
        ..ControlRequest::default()
    };
    let reply = rig.call(&request)?;
    anyhow::ensure!(reply.outcome == ControlOutcome::DONE, "{}", reply.text);
    Ok(reply)
}
