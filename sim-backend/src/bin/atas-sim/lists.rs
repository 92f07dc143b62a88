//! Lists on standard output: built-in objects, sensors, faults, errors, completions, manual pages.

use std::path::Path;

use clap::CommandFactory;
use serde::Serialize;
use sim_backend::faults::FaultKind;
use sim_backend::{Errors, Object, SensorModel, SensorModelError};

use crate::args::Cli;
use crate::failure::Failure;
use crate::output::{Format, print, write};

/// Properties of an object, as JSON; an absent value means rigid or uncrushable.
#[derive(Serialize)]
struct ObjectRow {
    name: String,
    mass_kg: f64,
    width_m: f64,
    height_m: f64,
    friction: f64,
    needed_n: f64,
    #[serde(skip_serializing_if = "Option::is_none")]
    stiffness_n_m: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    crush_n: Option<f64>,
}

impl ObjectRow {
    fn from_object(object: Object) -> Self {
        let finite = |value: f64| value.is_finite().then_some(value);
        Self {
            mass_kg: object.mass_kg,
            width_m: object.shape.width_m(),
            height_m: 2.0 * object.shape.half_height_m(),
            friction: object.friction,
            needed_n: object.required_normal_n(),
            stiffness_n_m: finite(object.stiffness_n_m),
            crush_n: finite(object.crush_n),
            name: object.name,
        }
    }

    fn line(&self) -> String {
        let or_none = |value: Option<f64>| value.map_or("-".to_owned(), |value| value.to_string());
        let Self {
            name,
            mass_kg,
            friction,
            needed_n,
            ..
        } = self;
        let (width_mm, height_mm) = (1e3 * self.width_m, 1e3 * self.height_m);
        let (stiffness, crush) = (or_none(self.stiffness_n_m), or_none(self.crush_n));
        format!(
            "{name:16} {mass_kg:7} {width_mm:8.0} {height_mm:9.0} {friction:8} {needed_n:8.2} {stiffness:>9} {crush:>7}"
        )
    }
}

/// Prints one JSON object per line.
fn print_json(rows: &[impl Serialize]) -> Result<(), Failure> {
    // Serialisation cannot fail: only numbers and strings.
    let line = |row| serde_json::to_string(row).unwrap_or_default();
    print(&rows.iter().map(line).collect::<Vec<_>>())
}

pub(crate) fn objects(format: Format) -> Result<(), Failure> {
    let names = Object::names().chain(Object::part_names());
    let rows: Result<Vec<_>, _> = names
        .map(|name| Object::built_in(name).map(ObjectRow::from_object))
        .collect();
    let rows = rows?;
    match format {
        Format::Json => print_json(&rows),
        Format::Human => {
            let header = format!(
                "{:16} {:>7} {:>8} {:>9} {:>8} {:>8} {:>9} {:>7}",
                "name",
                "mass kg",
                "width mm",
                "height mm",
                "friction",
                "needed N",
                "stiff N/m",
                "crush N"
            );
            let lines = rows.iter().map(ObjectRow::line);
            print(&core::iter::once(header).chain(lines).collect::<Vec<_>>())
        }
    }
}

pub(crate) fn faults() -> Result<(), Failure> {
    let mut lines = vec![
        "KIND[=VALUE]@START[+LENGTH][:TARGET], times in seconds, for example drop=0.3@2+0.5:right"
            .to_owned(),
        format!("{:10} {:>7}  {:26}  effect", "kind", "default", "targets"),
    ];
    for fault in FaultKind::all() {
        let takes_value = fault.range != [0.0, 0.0];
        let usually = if takes_value {
            format!("{:?}", fault.value)
        } else {
            String::new()
        };
        lines.push(format!(
            "{:10} {usually:>7}  {:26}  {}",
            fault.name,
            fault.targets(),
            fault.about
        ));
    }
    print(&lines)
}

pub(crate) fn errors() -> Result<(), Failure> {
    let mut lines = vec![
        "all, none, or NAME[=AMOUNT] separated by commas, for example crosstalk=3,yaw or all=0.5"
            .to_owned(),
        format!("{:15} {:>6}  default amount", "name", "unit"),
    ];
    let line = |kind: &sim_backend::ErrorKind| {
        format!("{:15} {:>6}  {}", kind.name, kind.unit(), kind.about)
    };
    lines.extend(Errors::KINDS.iter().map(line));
    lines.push("sensor effects, not included in all:".to_owned());
    lines.extend(Errors::SENSOR_KINDS.iter().map(line));
    lines.push("drive errors, not included in all:".to_owned());
    lines.extend(Errors::DRIVE_KINDS.iter().map(line));
    print(&lines)
}

/// Sensor model with its name, as JSON.
#[derive(Serialize)]
struct SensorRow {
    name: &'static str,
    model: SensorModel,
}

impl SensorRow {
    fn built_in(name: &'static str) -> Result<Self, SensorModelError> {
        let model = SensorModel::built_in(name)?;
        Ok(Self { name, model })
    }

    fn line(&self) -> String {
        let Self { name, model } = self;
        let or_none = |value: Option<String>| value.unwrap_or_else(|| "-".to_owned());
        let percent = |share: f64| format!("{:.1}", 100.0 * share);
        let layout = or_none(model.layout.clone());
        let rate_hz = or_none(model.rate_hz.map(|hz| hz.to_string()));
        let hysteresis = or_none(model.hysteresis.map(|of| percent(of.share)));
        let creep = or_none(model.creep.map(|of| percent(of.per_decade)));
        let noise_mn = 1e3 * model.noise_n[0];
        let about = &model.about;
        format!(
            "{name:16} {layout:14} {rate_hz:>5} {noise_mn:>8.1} {hysteresis:>12} {creep:>14}  {about}"
        )
    }
}

pub(crate) fn sensors(name: Option<&str>, format: Format) -> Result<(), Failure> {
    if let Some(name) = name {
        // An unknown name fails here.
        SensorModel::built_in(name)?;
        return write(
            SensorModel::built_in_text(name)
                .unwrap_or_default()
                .as_bytes(),
        );
    }
    let rows: Result<Vec<_>, _> = SensorModel::names().map(SensorRow::built_in).collect();
    let rows = rows?;
    match format {
        Format::Json => print_json(&rows),
        Format::Human => {
            let header = format!(
                "{:16} {:14} {:>5} {:>8} {:>12} {:>14}  about",
                "name", "layout", "Hz", "noise mN", "hysteresis %", "creep %/decade"
            );
            let lines = rows.iter().map(SensorRow::line);
            print(&core::iter::once(header).chain(lines).collect::<Vec<_>>())
        }
    }
}

pub(crate) fn completions(shell: clap_complete::Shell) -> Result<(), Failure> {
    // Buffered, because clap's generator panics if a pipe is closed or a disk is full.
    let mut script = Vec::new();
    clap_complete::generate(shell, &mut Cli::command(), "atas-sim", &mut script);
    write(&script)
}

/// Writes one manual page for the program and one for each subcommand.
pub(crate) fn manual(folder: &Path) -> Result<(), Failure> {
    std::fs::create_dir_all(folder)
        .and_then(|()| clap_mangen::generate_to(Cli::command(), folder))
        .map_err(|source| Failure::Manual {
            folder: folder.to_owned(),
            source,
        })
}
