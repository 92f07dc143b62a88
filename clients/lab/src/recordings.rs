//! `atas record check` and `repair`, `atas diff` and `atas export`: results of `atas-recording` as
//! text or JSON.

use std::path::Path;
use std::time::Instant;

use atas_client::json;
use atas_console::arguments::{self, ExportKind};
use atas_console::{Exit, ExitError, Interrupt, Output};
use atas_recording::{Choices, Contents, Dataset, DatasetChoices, Difference, Exported, Kind};
use serde_json::{Value, json};
use shm_schemas::Status;

pub(crate) fn check(path: &Path, output: &mut Output) -> anyhow::Result<()> {
    let contents = atas_recording::check(path)?;
    print_contents(&contents, output)?;
    if let Some(damage) = contents.damage {
        return Err(ExitError::with_code(Exit::Failed, damage));
    }
    if contents.lost > 0 {
        let sentence = format!(
            "recording incomplete: {} parts of ticks are missing",
            contents.lost
        );
        return Err(ExitError::with_code(Exit::Failed, sentence));
    }
    Ok(())
}

pub(crate) fn repair(path: &Path, out: Option<&Path>, output: &mut Output) -> anyhow::Result<()> {
    let (out, contents) = atas_recording::repair(path, out)?;
    if !output.is_json() {
        output.line(format_args!("saved to {}:", out.display()))?;
    }
    print_contents(&contents, output)
}

fn print_contents(contents: &Contents, output: &mut Output) -> anyhow::Result<()> {
    if output.is_json() {
        return output.json(&json!({
            "messages": contents.messages,
            "parts": contents.parts,
            "lost": contents.lost,
            "first_part": contents.first,
            "damage": contents.damage,
        }));
    }
    output.line(format_args!(
        "{} messages, {} parts of ticks, {} lost, first part {}",
        contents.messages,
        contents.parts,
        contents.lost,
        contents
            .first
            .map_or("none".to_owned(), |first| first.to_string()),
    ))
}

pub(crate) fn diff(a: &Path, b: &Path, output: &mut Output) -> anyhow::Result<()> {
    let difference = atas_recording::diff(a, b)?;
    print_difference(&difference, output)?;
    match difference.first {
        None => Ok(()),
        Some((tick, field)) => Err(ExitError::with_code(
            Exit::Failed,
            format!("the recordings first differ in tick {tick}: {field}"),
        )),
    }
}

fn print_difference(difference: &Difference, output: &mut Output) -> anyhow::Result<()> {
    let Difference {
        equal_ticks,
        first,
        ends,
    } = difference;
    if output.is_json() {
        let ends: Vec<Value> = ends
            .iter()
            .map(|status| {
                status
                    .as_deref()
                    .map_or(Value::Null, |status| json::status(status, json::CAPACITY))
            })
            .collect();
        return output.json(&json!({
            "equal_ticks": equal_ticks,
            "first_tick": first.as_ref().map(|(tick, _)| tick),
            "first_field": first.as_ref().map(|(_, field)| field),
            "last_status": ends,
        }));
    }
    output.line(format_args!("{equal_ticks} ticks are equal"))?;
    for (name, status) in ["first", "second"].iter().zip(ends) {
        let end = status
            .as_deref()
            .map_or("no status recorded".to_owned(), final_state);
        output.line(format_args!("{name}: {end}"))?;
    }
    Ok(())
}

fn final_state(status: &Status) -> String {
    let reason = if status.reason.is_some() {
        format!(" ({})", status.reason)
    } else {
        String::new()
    };
    match status.goal_id {
        0 => format!("mode {}{reason}, no goal", status.mode),
        _ => format!(
            "mode {}{reason}, goal {} {}",
            status.mode, status.goal_kind, status.goal_state
        ),
    }
}

pub(crate) fn export(
    arguments: &arguments::Export,
    interrupt: &Interrupt,
    output: &mut Output,
) -> anyhow::Result<()> {
    let kind = arguments.kind;
    let out = arguments.file();
    let out = out.map_err(|sentence| ExitError::with_code(Exit::Usage, sentence))?;
    let kind = match kind {
        ExportKind::Mcap => Kind::Mcap,
        ExportKind::Csv => Kind::Csv,
        ExportKind::Parquet => Kind::Parquet,
        ExportKind::Lerobot => return export_dataset(arguments, &out, interrupt, output),
    };
    let choices = Choices {
        kind,
        pictures_hz: arguments.pictures_hz,
        elements: arguments.elements,
    };
    let begin = Instant::now();
    let exported = atas_recording::export(&arguments.files, &out, &choices, interrupt.flag())?;
    let took_s = begin.elapsed().as_secs_f64();
    let file = out.display().to_string();
    let Exported { ticks, seconds } = exported;
    if output.is_json() {
        output
            .json(&json!({ "file": file, "ticks": ticks, "seconds": seconds, "took_s": took_s }))?;
    } else {
        output.line(format_args!(
            "wrote {file}: {ticks} ticks, {seconds:.1} s of the run in {took_s:.2} s"
        ))?;
    }
    interrupt.check("the output file contains the data up to here")
}

fn export_dataset(
    arguments: &arguments::Export,
    out: &Path,
    interrupt: &Interrupt,
    output: &mut Output,
) -> anyhow::Result<()> {
    let choices = DatasetChoices {
        fps: arguments.fps,
        hand: arguments.hand.map(Into::into),
        task: arguments.task.clone(),
        elements: arguments.elements,
    };
    let begin = Instant::now();
    let dataset =
        atas_recording::export_dataset(&arguments.files, out, &choices, interrupt.flag())?;
    let took_s = begin.elapsed().as_secs_f64();
    let file = out.display().to_string();
    let Dataset {
        episodes,
        successes,
        frames,
        skipped,
    } = dataset;
    if output.is_json() {
        output.json(&json!({
            "file": file,
            "episodes": episodes,
            "successes": successes,
            "frames": frames,
            "skipped": skipped,
            "took_s": took_s,
        }))?;
    } else {
        output.line(format_args!(
            "wrote {file}: {episodes} episodes ({successes} succeeded), {frames} frames, {skipped} \
             goals left out, in {took_s:.2} s"
        ))?;
    }
    interrupt.check("the data set contains the data up to here")
}
