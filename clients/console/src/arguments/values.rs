//! How values are read from text.

use std::path::PathBuf;
use std::time::Duration;

use atas_process::file_name::ending_in;
use shm_schemas::EventKind;

/// The robot where nothing is said; a test holds it to the one that ships as the default.
pub(super) const ROBOT: &str = "two-hand-arm";

pub(super) fn finite(text: &str) -> Result<f64, String> {
    match text.trim().parse::<f64>() {
        Ok(value) if value.is_finite() => Ok(value),
        _ => Err("needs a finite number, for example 40 or 0.5".into()),
    }
}

/// Frames per second that a sensor may have.
pub(super) fn rate(text: &str) -> Result<f64, String> {
    let rate_hz = finite(text)?;
    match rate_hz > 0.0 && rate_hz <= 10_000.0 {
        true => Ok(rate_hz),
        false => Err("needs a rate above 0 and up to 10000 Hz".into()),
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
    ending_in(text, &["svg", "png", "pdf"])
}

pub(super) fn mcap(text: &str) -> Result<PathBuf, String> {
    ending_in(text, &["mcap"])
}

pub(super) fn html(text: &str) -> Result<PathBuf, String> {
    ending_in(text, &["html"])
}

pub(super) fn toml(text: &str) -> Result<PathBuf, String> {
    ending_in(text, &["toml"])
}

pub(super) fn csv(text: &str) -> Result<PathBuf, String> {
    ending_in(text, &["csv"])
}

pub(super) fn position_m(text: &str) -> Result<[f64; 3], String> {
    let numbers: Result<Vec<f64>, String> = text.split(',').map(finite).collect();
    numbers
        .ok()
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
        .ok_or_else(|| "needs a whole number of bytes, or of K, M or G, for example 500M".into())
}

pub(super) fn frequency_hz(text: &str) -> Result<f64, String> {
    finite(text)
        .ok()
        .filter(|hertz| *hertz > 0.0)
        .ok_or_else(|| "needs a number of hertz above zero, for example 30".into())
}

/// A place that a hand goes to: metres from the robot's base, x forward, y left, z up. Without z it is where the task's
/// scene has it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Place {
    /// x and y.
    pub xy_m: [f64; 2],
    /// Height of the fingertips.
    pub z_m: Option<f64>,
}

impl Place {
    /// The place in full.
    #[must_use]
    pub fn or_height(self, z_m: f64) -> [f64; 3] {
        let [x_m, y_m] = self.xy_m;
        [x_m, y_m, self.z_m.unwrap_or(z_m)]
    }
}

pub(super) fn place(text: &str) -> Result<Place, String> {
    let numbers: Option<Vec<f64>> = text.split(',').map(|word| finite(word).ok()).collect();
    match numbers.as_deref() {
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

/// Bytes of a task's name at most, the capacity of [`shm_schemas::GoalRequest::task`].
const TASK_NAME_BYTES: usize = 32;

pub(super) fn task_name(text: &str) -> Result<String, String> {
    match text.trim() {
        "" => Err("needs a name, as in the daemon's configuration".into()),
        name if name.len() > TASK_NAME_BYTES => Err(format!(
            "is {} bytes long, needs at most {TASK_NAME_BYTES}",
            name.len()
        )),
        name => Ok(name.to_owned()),
    }
}
