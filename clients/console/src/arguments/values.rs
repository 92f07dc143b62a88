//! Parsers of argument values.

use std::ffi::OsStr;
use std::path::PathBuf;
use std::time::Duration;

use clap::builder::{PossibleValue, StringValueParser, TypedValueParser};

use atas_process::file_name::parse_with_suffix;
use shm_schemas::EventKind;

/// Default robot; a test compares it with the shipped default.
pub(super) const ROBOT: &str = "two-hand-arm";

/// Parser of a name or a file; shells complete the built-in names.
#[derive(Clone, Copy, Debug)]
pub(super) struct NameOrFile(&'static [&'static str]);

/// Built-in robots.
pub(super) const ROBOTS: NameOrFile =
    NameOrFile(&[ROBOT, "arm7-gripper", "three-finger", "test-bench"]);
/// Built-in objects to grasp.
pub(super) const OBJECTS: NameOrFile = NameOrFile(&[
    "wood",
    "slippery-200",
    "slippery-50",
    "paper-box",
    "sponge",
    "bottle",
    "heavy-block",
    "filled-paper-box",
]);

impl TypedValueParser for NameOrFile {
    type Value = String;

    fn parse_ref(
        &self,
        command: &clap::Command,
        argument: Option<&clap::Arg>,
        value: &OsStr,
    ) -> Result<String, clap::Error> {
        StringValueParser::new().parse_ref(command, argument, value)
    }

    fn possible_values(&self) -> Option<Box<dyn Iterator<Item = PossibleValue> + '_>> {
        Some(Box::new(self.0.iter().map(PossibleValue::new)))
    }
}

pub(super) fn finite(text: &str) -> Result<f64, String> {
    match text.trim().parse::<f64>() {
        Ok(value) if value.is_finite() => Ok(value),
        _ => Err("needs a finite number, for example 40 or 0.5".into()),
    }
}

/// Smallest width of an object, mm. Design choice: no fingertip grasps thinner objects, and all
/// widths of graspable objects in metres are smaller numbers.
const WIDTH_MIN_MM: f64 = 1.0;
/// Largest coordinate, m. Design choice: no table-top robot reaches farther, and most places in
/// millimetres are larger numbers.
const COORDINATE_MAX_M: f64 = 10.0;

/// Parses a width, mm; 0 means unknown. A number below 1 mm is probably in metres.
pub(super) fn width_mm(text: &str) -> Result<f64, String> {
    let width_mm = finite(text)?;
    if width_mm > 0.0 && width_mm < WIDTH_MIN_MM {
        let as_mm = width_mm * 1e3;
        return Err(format!(
            "millimetres or metres? The width is in millimetres, at least {WIDTH_MIN_MM}: {width_mm} m is {as_mm:.1}"
        ));
    }
    Ok(width_mm)
}

/// Parses coordinates, m. A number above 10 m is probably in millimetres.
fn coordinates_m(text: &str) -> Result<Option<Vec<f64>>, String> {
    let numbers: Option<Vec<f64>> = text.split(',').map(|word| finite(word).ok()).collect();
    let far = numbers
        .iter()
        .flatten()
        .find(|value| value.abs() > COORDINATE_MAX_M);
    match far {
        Some(value) => Err(format!(
            "millimetres or metres? Coordinates are in metres, at most {COORDINATE_MAX_M}: {value} mm is {}",
            value * 1e-3
        )),
        None => Ok(numbers),
    }
}

/// Parses a sensor's frame rate, Hz.
pub(super) fn rate(text: &str) -> Result<f64, String> {
    let rate_hz = finite(text)?;
    match rate_hz > 0.0 && rate_hz <= 10_000.0 {
        true => Ok(rate_hz),
        false => Err("needs a rate above 0 and at most 10000 Hz".into()),
    }
}

pub(super) fn event_kind(text: &str) -> Result<EventKind, String> {
    let known = EventKind::ALL
        .iter()
        .find(|kind| kind.name() == text.trim());
    known.copied().ok_or_else(|| {
        let names: Vec<&str> = EventKind::ALL.iter().map(|kind| kind.name()).collect();
        format!("needs one of {}", names.join(", "))
    })
}

pub(super) fn picture(text: &str) -> Result<PathBuf, String> {
    parse_with_suffix(text, &["svg", "png", "pdf"])
}

pub(super) fn mcap(text: &str) -> Result<PathBuf, String> {
    parse_with_suffix(text, &["mcap"])
}

pub(super) fn html(text: &str) -> Result<PathBuf, String> {
    parse_with_suffix(text, &["html"])
}

pub(super) fn toml(text: &str) -> Result<PathBuf, String> {
    parse_with_suffix(text, &["toml"])
}

pub(super) fn csv(text: &str) -> Result<PathBuf, String> {
    parse_with_suffix(text, &["csv"])
}

pub(super) fn position_m(text: &str) -> Result<[f64; 3], String> {
    coordinates_m(text)?
        .and_then(|numbers| numbers.try_into().ok())
        .ok_or_else(|| {
            "needs three finite numbers in metres, X,Y,Z, for example 0.32,-0.15,0.035".into()
        })
}

pub(super) fn duration(text: &str) -> Result<Duration, String> {
    finite(text)
        .ok()
        .and_then(|seconds| Duration::try_from_secs_f64(seconds).ok())
        .filter(|duration| !duration.is_zero())
        .ok_or_else(|| "needs a number of seconds above zero, for example 30".into())
}

pub(super) fn note(text: &str) -> Result<(String, String), String> {
    text.split_once('=')
        .filter(|(key, _)| !key.is_empty())
        .map(|(key, value)| (key.to_owned(), value.to_owned()))
        .ok_or_else(|| "needs KEY=VALUE, for example seed=7".into())
}

pub(super) fn bytes(text: &str) -> Result<u64, String> {
    let text = text.trim();
    let (digits, shift) = match text.char_indices().last() {
        Some((at, 'k' | 'K')) => (&text[..at], 10),
        Some((at, 'M')) => (&text[..at], 20),
        Some((at, 'G')) => (&text[..at], 30),
        _ => (text, 0),
    };
    let number = digits.parse::<u64>().ok().filter(|number| *number > 0);
    number
        .and_then(|number| number.checked_mul(1 << shift))
        .ok_or_else(|| {
            "needs a whole number of bytes, optionally with K, M or G, for example 500M".into()
        })
}

pub(super) fn frequency_hz(text: &str) -> Result<f64, String> {
    finite(text)
        .ok()
        .filter(|hertz| *hertz > 0.0)
        .ok_or_else(|| "needs a number of hertz above zero, for example 30".into())
}

/// Target position of a hand in the base frame, m: x forward, y left, z up. Without z, the task's
/// scene sets the height.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Place {
    /// x and y.
    pub xy_m: [f64; 2],
    /// Height of the fingertips.
    pub z_m: Option<f64>,
}

impl Place {
    /// Returns the full position, with `z_m` as the default height.
    #[must_use]
    pub fn or_height(self, z_m: f64) -> [f64; 3] {
        let [x_m, y_m] = self.xy_m;
        [x_m, y_m, self.z_m.unwrap_or(z_m)]
    }
}

pub(super) fn place(text: &str) -> Result<Place, String> {
    match coordinates_m(text)?.as_deref() {
        Some([x, y]) => Ok(Place {
            xy_m: [*x, *y],
            z_m: None,
        }),
        Some([x, y, z]) => Ok(Place {
            xy_m: [*x, *y],
            z_m: Some(*z),
        }),
        _ => Err(
            "needs two or three finite numbers in metres, X,Y or X,Y,Z, for example 0.32,-0.15"
                .into(),
        ),
    }
}

/// Longest task name, bytes: capacity of [`shm_schemas::GoalRequest::task`].
const TASK_NAME_BYTES: usize = 32;

pub(super) fn task_name(text: &str) -> Result<String, String> {
    match text.trim() {
        "" => Err("needs a name from the daemon's configuration".into()),
        name if name.len() > TASK_NAME_BYTES => Err(format!(
            "is {} bytes long, needs at most {TASK_NAME_BYTES}",
            name.len()
        )),
        name => Ok(name.to_owned()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn completed_names_are_the_built_in_names() {
        let robots: Vec<String> = robot_model::shipped_names().collect();
        assert_eq!(ROBOTS.0, robots);
        let objects: Vec<&str> = sim_backend::Object::names().collect();
        assert_eq!(OBJECTS.0, objects);
    }
}
