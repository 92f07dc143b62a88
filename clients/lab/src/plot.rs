//! `atas plot`: draws goals of recorded runs, or one offline run, into a file.

use std::path::{Path, PathBuf};

use atas_console::arguments::{Plot, PlotOffline, PlotRecorded};
use atas_console::{Exit, ExitError, Output};
use atas_evaluation::Task;
use atas_evaluation::figures::{self, GoalSelection, GoalTrace};
use serde_json::json;
use sim_backend::{Object, ObjectError};

use crate::picture;

pub(crate) fn plot(
    offline: Option<&Plot>,
    recorded: Option<&PlotRecorded>,
    output: &mut Output,
) -> anyhow::Result<()> {
    let (svg, out) = match (offline, recorded) {
        (Some(plot), _) => run_offline(plot)?,
        (None, Some(recorded)) => (draw_recorded(recorded)?, &recorded.out),
        (None, None) => {
            let sentence = "nothing to draw: needs a recording, or a task to run offline; see \
                `atas plot --help`";
            return Err(ExitError::with_code(Exit::Usage, sentence));
        }
    };
    picture::write(out, &svg)?;
    if output.is_json() {
        return output.json(&json!({ "file": out.display().to_string() }));
    }
    output.line(format_args!("wrote {}", out.display()))
}

fn run_offline(plot: &Plot) -> anyhow::Result<(String, &PathBuf)> {
    let (task, arguments): (Task, &PlotOffline) = match plot {
        Plot::Grasp(arguments) => (Task::Grasp, arguments),
        Plot::PickPlace(arguments) => (Task::PickPlace, arguments),
        Plot::Screw(arguments) => (Task::Screw, arguments),
        Plot::Assembly(arguments) => (Task::Assembly, arguments),
    };
    let usage = |error: ObjectError| ExitError::with_code(Exit::Usage, error.to_string());
    let object = match &arguments.object {
        Some(name) => Object::from_name_or_file(name).map_err(usage)?,
        None => figures::default_object(task).map_err(usage)?,
    };
    let svg = figures::draw(task, &object, arguments.seed)?;
    Ok((svg, &arguments.out))
}

fn draw_recorded(arguments: &PlotRecorded) -> anyhow::Result<String> {
    let runs = atas_recording::runs(&arguments.files)?.into_iter();
    let choice = GoalSelection::parse(arguments.goal.as_deref());
    let courses =
        runs.map(|files| GoalTrace::from_recording(&run_name(&files[0]), &files, &choice));
    let courses = courses.collect::<anyhow::Result<Vec<GoalTrace>>>()?;
    figures::overlay(&courses, arguments.from.as_deref())
}

/// Returns the name of a run: its first file without folder and suffix.
pub(crate) fn run_name(file: &Path) -> String {
    let stem = file.file_stem().unwrap_or_default();
    stem.to_string_lossy().into_owned()
}
