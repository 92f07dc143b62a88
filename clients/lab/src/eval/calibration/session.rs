//! Simulated calibration session: loads each fingertip as `atas calibrate guide` asks, records its
//! counts and fits.
//!
//! All data pass through the user's files: `presses.csv` in the format of `atas-sensor --dry-run`,
//! `steps.csv`, `block.csv`, then the calibration and configuration written by
//! `atas calibrate fit`.

use std::fmt::Write as _;
use std::path::Path;

use anyhow::{Context, anyhow};
use atas_console::arguments::{Arguments, Calibrate, Command};
use atas_core::Settings;
use atas_sensors::calibration::{AXES, Block, Calibration, fit_block};
use atas_sensors::continuity::Arrival;
use atas_sensors::reading::{Batch, Condition, Output as _, Quantity, Reading, Shape};
use atas_sensors::table::Table;
use nalgebra::{Rotation3, Vector3};
use sim_backend::Fingertip;
use sim_backend::random::Random;

use super::electronics::Electronics;
use crate::calibrate::fit_files;
use crate::calibrate::guide::{STEPS, loads, row};

/// Frame rate of the fingertip (design choice: a slow sensor), Hz, and duration of each load, s.
const RATE_HZ: u64 = 100;
const LOAD_TIME_S: u64 = 1;
/// Standard deviations of the applied force (relative) and its direction (rad). Design choice:
/// kitchen scales, one degree.
const FORCE_ERROR: f64 = 0.01;
const AIM_ERROR_RAD: f64 = 0.017;
/// Loads on the rigid block, N: up to the force limit of the hand.
const BLOCK_N: [f64; 16] = [
    0.1, 0.2, 0.3, 0.4, 0.6, 0.8, 1.0, 1.3, 1.6, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0, 8.0,
];
/// Standard deviation of the measured closing, m (design choice: one encoder step).
const CLOSING_ERROR_M: f64 = 5e-6;
/// Start time of the recording and frame period, ns.
const BEGIN_NS: u64 = 1_000_000_000;
const FRAME_NS: u64 = 1_000_000_000 / RATE_HZ;

pub(super) struct SessionResult {
    pub(super) calibrations: Vec<Calibration>,
    pub(super) settings: Settings,
}

/// Calibrates the fingertips of a hand in an empty folder. Configurations are applied one after the
/// other, as by repeated `--config`.
pub(super) fn calibrate(
    tips: &mut [Fingertip],
    electronics: &[Electronics],
    random: &mut Random,
    folder: &Path,
) -> anyhow::Result<SessionResult> {
    let mut made = SessionResult {
        calibrations: Vec::new(),
        settings: Settings::default(),
    };
    let block = folder.join("block.csv");
    let presses = press_rigid_block(tips, |deviation| deviation * random.gaussian());
    write(&block, &block_table(&presses)?)?;
    let fingertips = tips.len().to_string();
    for (index, (tip, electronics)) in tips.iter_mut().zip(electronics).enumerate() {
        let path = |name: &str| folder.join(format!("{index}-{name}"));
        let (presses, steps) = record_presses(tip, electronics, random)?;
        write(&path("presses.csv"), &presses)?;
        write(&path("steps.csv"), &steps)?;
        let word = |path: &Path| path.display().to_string();
        let words = [
            ["--presses", &word(&path("presses.csv"))],
            ["--reference", &word(&path("steps.csv"))],
            ["--layout", &tip.layout().to_string()],
            ["--block", &word(&block)],
            ["--block-tips", &fingertips],
            ["--out", &word(&path("tip.toml"))],
            ["--daemon", &word(&path("daemon.toml"))],
        ];
        let Calibrate::Fit(arguments) = action(&[&["fit"], words.as_flattened()].concat())? else {
            return Err(anyhow!("could not fit: unexpected command"));
        };
        fit_files(&arguments)?;
        made.calibrations
            .push(Calibration::open(&path("tip.toml"))?);
        apply_config(&mut made.settings, &path("daemon.toml"))?;
    }
    Ok(made)
}

/// Parses arguments after `atas calibrate`, so that the user's defaults apply.
fn action(words: &[&str]) -> anyhow::Result<Calibrate> {
    match Arguments::from_words(&[&["atas", "calibrate"], words].concat())?.command {
        Command::Calibrate { action } => Ok(action),
        _ => Err(anyhow!("could not calibrate: unexpected command")),
    }
}

/// Loads a fingertip as guided and records it; returns the tables of presses and steps.
fn record_presses(
    tip: &mut Fingertip,
    electronics: &Electronics,
    random: &mut Random,
) -> anyhow::Result<(String, String)> {
    let Calibrate::Guide(guide) = action(&["guide", "--out", "steps.csv"])? else {
        return Err(anyhow!("could not guide: unexpected command"));
    };
    let shape = Shape {
        quantity: Quantity::Force,
        unit: "counts",
        fingers: 1,
        taxels: tip.sample().len(),
    };
    let mut presses = Vec::new();
    let mut table = Table::new(&mut presses, shape, None).context("could not begin the presses")?;
    let mut steps = format!("{STEPS}\n");
    let mut frame = 0;
    for load_n in loads(&guide) {
        tip.load(actual_load_n(load_n, random));
        let mut batch = Batch::new(shape);
        let from_ns = BEGIN_NS + frame * FRAME_NS;
        for _ in 0..LOAD_TIME_S * RATE_HZ {
            batch.push(reading(frame), &electronics.counts(&tip.sample()));
            frame += 1;
        }
        table
            .readings(&batch)
            .context("could not write the presses")?;
        writeln!(
            steps,
            "{}",
            row(from_ns, BEGIN_NS + (frame - 1) * FRAME_NS, load_n)
        )?;
        // Placing the next load takes one second.
        frame += RATE_HZ;
    }
    drop(table);
    Ok((String::from_utf8(presses)?, steps))
}

fn reading(frame: u64) -> Reading {
    Reading {
        byte_offset: frame,
        count: None,
        status: 0,
        temperature_c: None,
        condition: Condition::Normal,
        arrival: if frame == 0 {
            Arrival::First
        } else {
            Arrival::Newer { gap: 0 }
        },
        advance: 1,
        captured_ns: BEGIN_NS + frame * FRAME_NS,
    }
}

/// Returns the actual load of a person who aims at `load_n`, N, with errors of force and direction.
fn actual_load_n(load_n: [f64; AXES], random: &mut Random) -> [f64; AXES] {
    let mut draw = |deviation: f64| deviation * random.gaussian();
    let aim = Rotation3::new(Vector3::from_fn(|_, _| draw(AIM_ERROR_RAD)));
    (aim * Vector3::from(load_n) * (1.0 + draw(FORCE_ERROR))).into()
}

/// Returns the exact compression law, fitted over all fingertips.
pub(super) fn exact_block(tips: &mut [Fingertip]) -> anyhow::Result<Block> {
    let presses = press_rigid_block(tips, |_| 0.0);
    fit_block(&presses, 0.0, tips.len() as u32).context("could not press a rigid block")
}

/// Presses a rigid block between the fingertips; returns closing, m, and force, N. `err` draws an
/// error of a given standard deviation.
fn press_rigid_block(tips: &mut [Fingertip], mut err: impl FnMut(f64) -> f64) -> Vec<(f64, f64)> {
    let press = |force_n: f64| {
        let closing_m: f64 = tips
            .iter_mut()
            .map(|tip| tip.load([force_n, 0.0, 0.0]))
            .sum();
        (
            closing_m + err(CLOSING_ERROR_M),
            force_n * (1.0 + err(FORCE_ERROR)),
        )
    };
    BLOCK_N.map(press).to_vec()
}

fn block_table(presses: &[(f64, f64)]) -> anyhow::Result<String> {
    let mut table = "closing_m,normal_n\n".to_owned();
    for (closing_m, normal_n) in presses {
        writeln!(table, "{closing_m},{normal_n}")?;
    }
    Ok(table)
}

/// Applies a configuration file to settings, as the daemon does.
fn apply_config(settings: &mut Settings, path: &Path) -> anyhow::Result<()> {
    let reported: toml::Table = std::fs::read_to_string(path)?.parse()?;
    let perception = reported.get("perception").and_then(toml::Value::as_table);
    // Set the lower threshold to 0 first and last (keys are sorted): every order of the two
    // thresholds is then valid.
    settings.perception.touch_off_n = 0.0;
    let numbers: Vec<_> = perception.into_iter().flatten().collect();
    for (key, value) in numbers.into_iter().rev() {
        let value = value
            .as_float()
            .with_context(|| format!("{key} is not a number"))?;
        settings
            .set(&format!("perception.{key}"), value)
            .map_err(|error| anyhow!("could not set {key}: {error}"))?;
    }
    Ok(())
}

fn write(path: &Path, text: &str) -> anyhow::Result<()> {
    std::fs::write(path, text).with_context(|| format!("could not write {}", path.display()))
}
