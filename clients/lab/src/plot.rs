//! `atas plot`: a figure of one offline run, into a file.

use std::path::Path;

use anyhow::Context;
use atas_console::arguments::Plot;
use atas_console::{Ended, Exit, Output};
use atas_evaluation::{Task, figures};
use serde_json::json;
use sim_backend::{Object, ObjectError};

/// `atas plot`.
pub(crate) fn plot(plot: &Plot, output: &mut Output) -> anyhow::Result<()> {
    let (task, arguments) = match plot {
        Plot::Grasp(arguments) => (Task::Grasp, arguments),
        Plot::PickPlace(arguments) => (Task::PickPlace, arguments),
        Plot::Screw(arguments) => (Task::Screw, arguments),
        Plot::Assembly(arguments) => (Task::Assembly, arguments),
    };
    let usage = |error: ObjectError| Ended::with(Exit::Usage, error.to_string());
    let object = match &arguments.object {
        Some(name) => Object::named_or_file(name).map_err(usage)?,
        None => figures::usual(task).map_err(usage)?,
    };
    let svg = figures::draw(task, &object, arguments.seed)?;
    write(&arguments.out, &svg)?;
    if output.is_json() {
        return output.json(&json!({ "file": arguments.out.display().to_string() }));
    }
    output.line(format!("wrote {}", arguments.out.display()))
}

fn write(path: &Path, svg: &str) -> anyhow::Result<()> {
    std::fs::write(path, svg).with_context(|| {
        let path = path.display();
        format!("could not write {path}; name a file in a folder that exists and may be written")
    })
}
