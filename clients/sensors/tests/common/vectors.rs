//! Tables of test vectors, and drivers to decode them.

use std::collections::BTreeSet;
use std::path::PathBuf;

use atas_sensors::cli;
use atas_sensors::reading::Condition;
use atas_sensors::wire::{Driver, Event, Interface, Request, SensorType};
use toml::Value;

/// Row of a table.
pub(crate) struct Case {
    pub(crate) about: String,
    pub(crate) options: Vec<String>,
    pub(crate) bytes: Vec<u8>,
    pub(crate) expect: Vec<String>,
}

fn folder() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("tests/vectors")
}

/// Returns the sensors that have a table.
pub(crate) fn names() -> BTreeSet<String> {
    std::fs::read_dir(folder())
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .map(|path| path.file_stem().unwrap().to_str().unwrap().to_owned())
        .collect()
}

/// Returns the table of a sensor.
pub(crate) fn cases_of(sensor: &str) -> Vec<Case> {
    let path = folder().join(sensor).with_extension("toml");
    let text = std::fs::read_to_string(&path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
    let table: toml::Table = text.parse().unwrap();
    table["case"].as_array().unwrap().iter().map(case).collect()
}

fn case(row: &Value) -> Case {
    let words = |key: &str| -> Vec<String> {
        let list = row.get(key).and_then(Value::as_array);
        let text = |word: &Value| word.as_str().unwrap().to_owned();
        list.map(|list| list.iter().map(text).collect())
            .unwrap_or_default()
    };
    let bytes = match (row.get("hex"), row.get("text")) {
        (Some(hex), None) => hex
            .as_str()
            .unwrap()
            .split_whitespace()
            .map(|byte| u8::from_str_radix(byte, 16).unwrap())
            .collect(),
        (None, Some(text)) => text.as_str().unwrap().as_bytes().to_vec(),
        _ => panic!("needs hex or text"),
    };
    Case {
        about: row["about"].as_str().unwrap().to_owned(),
        options: words("options"),
        bytes,
        expect: words("expect"),
    }
}

/// Returns true if a sensor sends a byte stream without packet boundaries.
pub(crate) fn is_stream(sensor: &SensorType) -> bool {
    matches!(sensor.interface, Interface::Serial { .. })
}

/// Returns a sensor's driver with these options.
pub(crate) fn driver(sensor: &SensorType, options: &[String]) -> Box<dyn Driver> {
    let line = ["atas-sensor", sensor.name, "--device", "-", "--dry-run"]
        .map(str::to_owned)
        .into_iter()
        .chain(options.iter().cloned());
    let matches = cli::command().try_get_matches_from(line).unwrap();
    let request = Request {
        rate_hz: sensor.rate_hz.parse().unwrap(),
        zero: false,
    };
    (sensor.driver)(matches.subcommand().unwrap().1, &request).unwrap()
}

/// Returns all events of a driver for these chunks and their end, in the notation of the tables.
pub(crate) fn receive<'a>(
    driver: &mut dyn Driver,
    chunks: impl IntoIterator<Item = &'a [u8]>,
) -> Vec<String> {
    let mut events = Vec::new();
    let mut note = |event: Event<'_>| events.push(describe(&event));
    for chunk in chunks {
        driver.receive(chunk, &mut note);
    }
    driver.finish(&mut note);
    events
}

fn describe(event: &Event<'_>) -> String {
    match event {
        Event::Acknowledged(status) => format!("acknowledged {status}"),
        Event::OtherKind(kind) => format!("foreign {kind}"),
        Event::Frame(frame) => {
            let count = frame
                .count
                .map_or("-".to_owned(), |count| count.to_string());
            let condition = match frame.condition {
                Condition::Normal => "normal",
                Condition::Degraded => "degraded",
                Condition::Failed => "failed",
            };
            let values: Vec<String> = frame.values.iter().map(f64::to_string).collect();
            format!(
                "frame {count} {} {condition}: {}",
                frame.status,
                values.join(" ")
            )
        }
    }
}
