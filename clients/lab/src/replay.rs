//! `atas replay`: runs the production controller on recorded inputs.

use std::path::PathBuf;

use atas_console::{Exit, ExitError, Output};
use atas_evaluation::replay::replay as run;
use serde_json::json;

pub(crate) fn replay(files: &[PathBuf], output: &mut Output) -> anyhow::Result<()> {
    let agreement = run(files, |_, _| {})?;
    if output.is_json() {
        output.json(&json!({
            "ticks": agreement.ticks,
            "different": agreement.different,
            "first_tick": agreement.first_difference.as_ref().map(|(tick, _)| tick),
            "first_field": agreement.first_difference.as_ref().map(|(_, field)| field),
            "recorded_version": agreement.recorded_version,
            "version": atas_core::VERSION,
        }))?;
    } else {
        output.line(format_args!(
            "{} ticks replayed, {} commands differ",
            agreement.ticks, agreement.different
        ))?;
    }
    match agreement.first_difference {
        None if agreement.ticks == 0 => Err(no_ticks_error()),
        None => Ok(()),
        Some((tick, field)) => Err(ExitError::with_code(
            Exit::Failed,
            format!(
                "the replay first differs from the recording in tick {tick}: {field}{}",
                other_version(&agreement.recorded_version)
            ),
        )),
    }
}

/// Returns the likely cause of a difference if another controller was recorded.
fn other_version(recorded: &str) -> String {
    if recorded == atas_core::VERSION {
        return String::new();
    }
    let ours = atas_core::VERSION;
    format!("; controller {recorded} was recorded, this is {ours}: replay with that version")
}

fn no_ticks_error() -> anyhow::Error {
    ExitError::with_code(
        Exit::Failed,
        "could not replay: the recording contains no ticks; record a daemon that runs with \
         --record-stream",
    )
}
