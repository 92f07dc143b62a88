//! Tables as numbers: sensor values, times, temperatures and reference forces.

use anyhow::{Context, bail, ensure};
use atas_evaluation::recorded::Sheet;
use atas_sensors::calibration::{AXES, Point, Press, UnloadedRecording};

const FORCE: [&str; AXES] = ["normal_n", "tangential1_n", "tangential2_n"];
/// Temperature columns, each with the offset to °C.
const TEMPERATURE: [(&str, f64); 2] = [("temperature_c", 0.0), ("temperature_k", -273.15)];
/// Assumed frame rate of a table without times, Hz.
pub(super) const DEFAULT_RATE_HZ: f64 = 100.0;
/// Rows per press in a stream without press numbers (design choice).
const ROWS_PER_PRESS: usize = 100;

pub(super) struct Recording {
    /// Values per frame, three per element.
    pub(super) frames: Vec<Vec<f64>>,
    /// Time per frame, ns; `None` if the table has none.
    pub(super) times_ns: Option<Vec<f64>>,
    /// Temperature per frame, °C; `None` if the table has none.
    pub(super) temperatures_c: Option<Vec<f64>>,
    /// True if the values are magnetic flux.
    pub(super) is_flux: bool,
}

/// Reads the table of `atas-sensor --dry-run`; the sensor's columns are between `status` and
/// `arrival`.
pub(super) fn recording(sheet: &Sheet) -> anyhow::Result<Recording> {
    let path = sheet.path.display();
    let (Some(status), Some(arrival)) = (sheet.column("status"), sheet.column("arrival")) else {
        bail!(
            "could not find sensor values in {path}: needs the table that `atas-sensor SENSOR \
             --dry-run` prints"
        );
    };
    let is_temperature = |column: &usize| {
        let name = &sheet.columns()[*column];
        TEMPERATURE.iter().any(|(known, _)| name == known)
    };
    let columns: Vec<usize> = (status + 1..arrival)
        .filter(|column| !is_temperature(column))
        .collect();
    let first = columns
        .first()
        .map_or("", |&column| sheet.columns()[column].as_str());
    let group = match first.chars().next() {
        Some('p') => 1,
        Some('f')
            if columns
                .iter()
                .any(|&c| sheet.columns()[c].starts_with("tx")) =>
        {
            6
        }
        Some('f' | 'b') => AXES,
        _ => bail!(
            "could not calibrate the values {first:?} of {path}: needs forces, pressures or flux"
        ),
    };
    ensure!(
        !columns.is_empty() && columns.len().is_multiple_of(group),
        "could not calibrate {} values per row of {path}: needs {group} per element",
        columns.len()
    );
    let mut frames = Vec::with_capacity(sheet.len());
    for row in 0..sheet.len() {
        let value = |column: usize| {
            sheet.number(row, column).with_context(|| {
                let name = &sheet.columns()[column];
                format!(
                    "could not calibrate with row {} of {path}: {name} is not a number; remove \
                    the row",
                    row + 1
                )
            })
        };
        let mut frame = Vec::new();
        for element in columns.chunks_exact(group) {
            match element {
                [pressure] => frame.extend([0.0, 0.0, value(*pressure)?]),
                _ => {
                    for &column in &element[..AXES] {
                        frame.push(value(column)?);
                    }
                }
            }
        }
        frames.push(frame);
    }
    Ok(Recording {
        frames,
        times_ns: times_ns(sheet),
        temperatures_c: temperatures_c(sheet),
        is_flux: first.starts_with('b'),
    })
}

fn times_ns(sheet: &Sheet) -> Option<Vec<f64>> {
    let column = sheet.column("captured_ns")?;
    (0..sheet.len())
        .map(|row| sheet.number(row, column))
        .collect()
}

/// Returns `None` if the temperature is missing in any row.
fn temperatures_c(sheet: &Sheet) -> Option<Vec<f64>> {
    let known = |(name, offset): (&str, f64)| Some((sheet.column(name)?, offset));
    let (column, offset) = TEMPERATURE.into_iter().find_map(known)?;
    let value = |row: usize| Some(sheet.number(row, column)? + offset);
    (0..sheet.len()).map(value).collect()
}

impl Recording {
    pub(super) fn quiet(&self, frames: impl Iterator<Item = usize> + Clone) -> UnloadedRecording {
        let time_s = |frame: usize| match &self.times_ns {
            Some(times_ns) => (times_ns[frame] - times_ns[0]) * 1e-9,
            None => frame as f64 / DEFAULT_RATE_HZ,
        };
        let temperatures_c = self.temperatures_c.iter();
        UnloadedRecording {
            frames: frames
                .clone()
                .map(|frame| self.frames[frame].clone())
                .collect(),
            times_s: frames.clone().map(time_s).collect(),
            temperatures_c: temperatures_c
                .flat_map(|all| frames.clone().map(|frame| all[frame]))
                .collect(),
        }
    }
}

/// Returns presses with reference forces, and the frames without contact.
pub(super) fn presses(
    sheet: &Sheet,
    recording: &Recording,
    reference: Option<&Sheet>,
) -> anyhow::Result<(Vec<Press>, UnloadedRecording)> {
    let known: Vec<Option<(usize, [f64; AXES])>> = match reference {
        None => from_recording(sheet)?,
        Some(steps) if steps.column("from_ns").is_some() => from_steps(sheet, recording, steps)?,
        Some(stream) => from_stream(sheet, recording, stream)?,
    };
    let (mut presses, mut silence) = (Vec::<Press>::new(), Vec::new());
    let mut last = None;
    for (number, (frame, known)) in recording.frames.iter().zip(known).enumerate() {
        let Some((press, force_n)) = known else {
            continue;
        };
        if force_n == [0.0; AXES] {
            silence.push(number);
            continue;
        }
        if last != Some(press) {
            presses.push(Press::default());
            last = Some(press);
        }
        if let Some(press) = presses.last_mut() {
            let values = frame.clone();
            press.points.push(Point { values, force_n });
        }
    }
    Ok((presses, recording.quiet(silence.into_iter())))
}

fn columns(sheet: &Sheet) -> anyhow::Result<[usize; AXES]> {
    let path = sheet.path.display();
    let of = |name: &str| {
        sheet.column(name).with_context(|| {
            format!("could not find the reference force in {path}: it has no column {name}")
        })
    };
    Ok([of(FORCE[0])?, of(FORCE[1])?, of(FORCE[2])?])
}

fn force(sheet: &Sheet, row: usize, columns: [usize; AXES]) -> Option<[f64; AXES]> {
    let mut force_n = [0.0; AXES];
    for (force_n, column) in force_n.iter_mut().zip(columns) {
        *force_n = sheet.number(row, column)?;
    }
    Some(force_n)
}

/// Press number and force of a row, N; `None` if the row belongs to no press.
type Reference = Option<(usize, [f64; AXES])>;

/// Reads forces from the recording itself; presses are numbered by its column `press`, else every
/// [`ROWS_PER_PRESS`] rows.
fn from_recording(sheet: &Sheet) -> anyhow::Result<Vec<Reference>> {
    let columns = columns(sheet)?;
    let press = sheet.column("press");
    let number = |row: usize| match press {
        Some(column) => sheet.number(row, column).map(|number| number as usize),
        None => Some(row / ROWS_PER_PRESS),
    };
    let of = |row: usize| Some((number(row)?, force(sheet, row, columns)?));
    Ok((0..sheet.len()).map(of).collect())
}

/// Takes forces from a table of guided steps; each step is a press.
fn from_steps(
    sheet: &Sheet,
    recording: &Recording,
    steps: &Sheet,
) -> anyhow::Result<Vec<Reference>> {
    let (from, to) = (steps.column("from_ns"), steps.column("to_ns"));
    let columns = columns(steps)?;
    let step = |row: usize| {
        let range = (steps.number(row, from?)?, steps.number(row, to?)?);
        Some((range, force(steps, row, columns)?))
    };
    let steps: Vec<_> = (0..steps.len()).filter_map(step).collect();
    let times = needed_times(sheet, recording)?;
    let of = |time_ns: &f64| {
        let step = steps
            .iter()
            .position(|((from, to), _)| (*from..=*to).contains(time_ns))?;
        Some((step, steps[step].1))
    };
    Ok(times.iter().map(of).collect())
}

/// Takes forces from another sensor's recording by linear interpolation in time.
fn from_stream(
    sheet: &Sheet,
    recording: &Recording,
    stream: &Sheet,
) -> anyhow::Result<Vec<Reference>> {
    let columns = columns(stream)?;
    let path = stream.path.display();
    let when = stream.column("captured_ns").with_context(|| {
        format!("could not find captured_ns in {path}: needs the times of the reference force")
    })?;
    let mut known: Vec<(f64, [f64; AXES])> = (0..stream.len())
        .filter_map(|row| Some((stream.number(row, when)?, force(stream, row, columns)?)))
        .collect();
    known.sort_by(|a, b| a.0.total_cmp(&b.0));
    let times = needed_times(sheet, recording)?;
    let of = |(row, time_ns): (usize, &f64)| {
        let after = known.partition_point(|(at_ns, _)| at_ns < time_ns);
        let (early, late) = (known.get(after.checked_sub(1)?)?, known.get(after)?);
        let share = (time_ns - early.0) / (late.0 - early.0);
        let between = |axis: usize| early.1[axis] + (late.1[axis] - early.1[axis]) * share;
        let force_n = [between(0), between(1), between(2)];
        force_n
            .iter()
            .all(|n| n.is_finite())
            .then_some((row / ROWS_PER_PRESS, force_n))
    };
    Ok(times.iter().enumerate().map(of).collect())
}

fn needed_times<'a>(sheet: &Sheet, recording: &'a Recording) -> anyhow::Result<&'a [f64]> {
    recording.times_ns.as_deref().with_context(|| {
        let path = sheet.path.display();
        format!(
            "could not find captured_ns in every row of {path}: needs it to assign forces to \
            frames"
        )
    })
}
