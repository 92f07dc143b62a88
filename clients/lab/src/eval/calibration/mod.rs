//! `atas eval calibration`: compares grasps with a calibration fitted to guided presses and with
//! the exact one.
//!
//! ```text
//!  World ─▶ fingertips ─ Electronics ─▶ session: presses, steps, block ─▶ atas calibrate fit ──┐
//!    └───▶ each trial twice: force ─ Electronics ─ counts ─┬─ exact calibration ─▶ controller  │
//!                                                          └─ fitted one and its settings ◀────┘
//! ```
//!
//! * **Invariants:** the result depends on the arguments only, not on the number of threads. Both
//!   runs of a trial use the same object and fingertips; skins are up to 20 % stiffer or softer
//!   than the controller's model, noise × 1 to 2.

mod electronics;
mod session;

use std::collections::BTreeMap;

use anyhow::Context;
use atas_console::arguments::CalibrationEvaluation;
use atas_console::{Interrupt, Output, number, table};
use atas_core::Settings;
use atas_evaluation::{
    Condition, NamedErrors, Noise, Plan, SensorVariant, Task, VariantTrial, median, seeds, wilson,
};
use atas_sensors::calibration::{AXES, Calibration};
use robot_model::{HandSide, RobotFiles};
use serde::Serialize;
use shm_schemas::HandFrame;
use sim_backend::World;
use sim_backend::random::Random;

use electronics::Electronics;
use session::SessionResult;

/// Random stream of electronics and person (arbitrary, unused by the world).
const STREAM: u64 = 0x6361_6c69;
/// Scale of the sensor noise, and the named error of the skins ([`sim_backend::Errors`]).
const NOISE: [f64; 2] = [1.0, 2.0];
const ERRORS: &str = "tips";

#[derive(Serialize)]
struct Report {
    trials: u64,
    first_seed: u64,
    purpose: &'static str,
    exact: CalibrationResults,
    fitted: CalibrationResults,
    /// Success rate with the exact calibration minus that with the fitted one, percentage points.
    lost_points: f64,
    /// Trials that succeeded with one of the calibrations only.
    only_exact: u64,
    only_fitted: u64,
    fit: Quality,
}

#[derive(Serialize)]
struct CalibrationResults {
    successes: u64,
    success: f64,
    /// Wilson score interval of `success`, 95 %.
    ci95: [f64; 2],
    failures: BTreeMap<String, u64>,
}

#[derive(Serialize)]
struct Quality {
    fingertips: usize,
    /// Relative error of `f_n`, `f_t1`, `f_t2` on held-out presses: median and maximum.
    error_share: [f64; AXES],
    error_share_most: [f64; AXES],
    /// Relative error of the fingertip compression at 1 N: median.
    compression_error: f64,
}

struct Fit {
    error_share: Vec<[f64; AXES]>,
    compression_error: f64,
}

pub(super) fn calibration(
    arguments: &CalibrationEvaluation,
    interrupt: &Interrupt,
    output: &mut Output,
) -> anyhow::Result<()> {
    let plan = plan(arguments)?;
    let side = plan.robot.load()?.acting_side();
    let trials = super::with_progress_bar(plan.jobs(), |done| {
        plan.run_variants(interrupt.flag(), done, |world, seed| {
            make_variants(world, side, seed)
        })
    })?;
    let report = Report::from_trials(&plan, &trials);
    if output.is_json() {
        return output.json(&report);
    }
    print(&report, output)
}

fn plan(arguments: &CalibrationEvaluation) -> anyhow::Result<Plan> {
    let named: NamedErrors = ERRORS.parse()?;
    Ok(Plan {
        robot: RobotFiles::find(&arguments.robot)?,
        skin: None,
        task: Task::Grasp,
        objects: Task::Grasp.objects()?,
        trials: arguments.trials,
        first_seed: arguments.first_seed.unwrap_or(seeds::EVALUATION_START),
        conditions: vec![Condition {
            noise: Noise::Between(NOISE),
            rate_hz: arguments.rate_hz,
            errors: named,
            sensor_model: None,
        }],
        baselines: Vec::new(),
        compare_everywhere: false,
        engine: None,
        threads: arguments.threads,
        settings: Settings::default(),
    })
}

fn make_variants(
    world: &World,
    side: HandSide,
    seed: u64,
) -> anyhow::Result<(Vec<SensorVariant>, Fit)> {
    let mut random = Random::new(seed, STREAM);
    let mut tips: Vec<_> = (0..)
        .map_while(|finger| world.fingertip(side.index(), finger))
        .collect();
    let draw =
        |tip: &mut sim_backend::Fingertip| Electronics::draw(tip.sample().len(), &mut random);
    let electronics: Vec<_> = tips.iter_mut().map(draw).collect();
    let exact: Option<Vec<_>> = electronics.iter().map(Electronics::exact).collect();
    let mut exact = SessionResult {
        calibrations: exact.context("could not invert the simulated electronics")?,
        settings: Settings::default(),
    };
    let folder = tempfile::tempdir().context("could not make a folder for the tables")?;
    let fitted = session::calibrate(&mut tips, &electronics, &mut random, folder.path())?;
    let truth = session::exact_block(&mut tips)?;
    let settings = &mut exact.settings.perception;
    (settings.tip_compression_m, settings.tip_exponent) =
        (truth.tip_compression_m, truth.tip_exponent);
    let fit = Fit {
        error_share: fitted
            .calibrations
            .iter()
            .map(|of| of.quality.error_share)
            .collect(),
        compression_error: (fitted.settings.perception.tip_compression_m / truth.tip_compression_m
            - 1.0)
            .abs(),
    };
    let electronics = std::rc::Rc::new(electronics);
    let corrupted = [exact, fitted].map(|made| SensorVariant {
        settings: made.settings,
        frame_filter: electronics_filter(electronics.clone(), made.calibrations, side),
    });
    Ok((corrupted.into(), fit))
}

/// Returns a filter that converts each frame of a hand to counts, and back to newtons with the
/// calibrations.
fn electronics_filter(
    electronics: std::rc::Rc<Vec<Electronics>>,
    calibrations: Vec<Calibration>,
    side: HandSide,
) -> Box<dyn FnMut(&mut HandFrame)> {
    Box::new(move |frame| {
        if frame.hand.index() != Some(side.index()) {
            return;
        }
        let fingers = frame
            .force_n
            .iter_mut()
            .zip(electronics.iter())
            .zip(&calibrations);
        for ((force_n, electronics), calibration) in fingers {
            let count = calibration.elements_out();
            let counts = electronics.counts(&force_n[..count]);
            for (element, force_n) in force_n[..count].iter_mut().enumerate() {
                *force_n = calibration.force_n(element, &counts).map(|n| n as f32);
            }
        }
        frame.seal();
    })
}

impl Report {
    fn from_trials(plan: &Plan, trials: &[VariantTrial<Fit>]) -> Self {
        let failure = |which: usize| {
            trials
                .iter()
                .map(move |(records, _)| records[which].failure())
        };
        let pairs = || failure(0).zip(failure(1));
        let only =
            |is: fn(&(Option<&str>, Option<&str>)) -> bool| pairs().filter(is).count() as u64;
        let (exact, fitted) = (
            CalibrationResults::from_failures(failure(0)),
            CalibrationResults::from_failures(failure(1)),
        );
        Self {
            trials: plan.trials,
            first_seed: plan.first_seed,
            purpose: seeds::purpose(plan.first_seed, plan.seeds()),
            lost_points: 100.0 * (exact.success - fitted.success),
            exact,
            fitted,
            only_exact: only(|(exact, fitted)| exact.is_none() && fitted.is_some()),
            only_fitted: only(|(exact, fitted)| exact.is_some() && fitted.is_none()),
            fit: Quality::from_fits(trials.iter().map(|(_, fit)| fit)),
        }
    }
}

impl CalibrationResults {
    fn from_failures<'a>(failures: impl Iterator<Item = Option<&'a str>>) -> Self {
        let (mut trials, mut counted) = (0, BTreeMap::new());
        for failure in failures {
            trials += 1;
            failure
                .into_iter()
                .for_each(|key| *counted.entry(key.to_owned()).or_default() += 1);
        }
        let successes = trials - counted.values().sum::<u64>();
        Self {
            successes,
            success: successes as f64 / trials.max(1) as f64,
            ci95: wilson(successes, trials),
            failures: counted,
        }
    }
}

impl Quality {
    fn from_fits<'a>(fits: impl Iterator<Item = &'a Fit> + Clone) -> Self {
        let tips: Vec<[f64; AXES]> = fits
            .clone()
            .flat_map(|fit| fit.error_share.clone())
            .collect();
        let along = |axis: usize| tips.iter().map(move |share| share[axis]);
        let middle = |values: Vec<f64>| median(values).unwrap_or(f64::NAN);
        Self {
            fingertips: tips.len(),
            error_share: core::array::from_fn(|axis| middle(along(axis).collect())),
            error_share_most: core::array::from_fn(|axis| along(axis).fold(0.0, f64::max)),
            compression_error: middle(fits.map(|fit| fit.compression_error).collect()),
        }
    }
}

fn print(report: &Report, output: &mut Output) -> anyhow::Result<()> {
    let mut rows = table(&["calibration", "success", "95 % interval", "failures"]);
    for (name, under) in [("exact", &report.exact), ("fitted", &report.fitted)] {
        let [low, high] = under.ci95.map(|share| number(100.0 * share, 1));
        let otherwise = under
            .failures
            .iter()
            .map(|(key, count)| format!("{count} {key}"));
        rows.add_row([
            name.to_owned(),
            super::table::percent(under.success),
            format!("{low} to {high} %"),
            otherwise.collect::<Vec<_>>().join(", "),
        ]);
    }
    output.table(rows)?;
    let fit = &report.fit;
    let [n, a, b] = fit.error_share.map(|share| number(100.0 * share, 1));
    output.line(format_args!(
        "{} fingertips fitted, medians: relative error {n}, {a} and {b} % along f_n, f_t1, f_t2, \
         compression error {} %",
        fit.fingertips,
        number(100.0 * fit.compression_error, 1)
    ))?;
    output.line(format_args!(
        "{} grasps: {} succeeded with the exact calibration only, {} with the fitted one only; \
         seeds from {} for each object, purpose: {}",
        report.trials, report.only_exact, report.only_fitted, report.first_seed, report.purpose
    ))
}
