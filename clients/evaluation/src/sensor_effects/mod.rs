//! Effects of a drifting, hysteretic or creeping sensor on a held object, with and without joint
//! torques.
//!
//! ```text
//!  object, seed ─▶ grasp without effect: time of the lift ─▶ each case: same world, sensor model with
//!                  one effect ─▶ grasp, then hold for a minute ─▶ outcome by ground truth
//! ```
//!
//! * **In:** objects, seeds. **Out:** an [`EffectReport`]: one row per case.
//! * **Invariants:** the report depends on the plan only. All cases of an object and seed have the
//!   same world, noise and goal.

mod trial;

use std::sync::atomic::{AtomicBool, Ordering};

use serde::Serialize;
use sim_backend::{CreepModel, DriftModel, Errors, HysteresisModel, SensorModel};

use crate::held::{HeldPlan, HeldSummary, HeldWorld, Outcomes};
use crate::markdown::rows_table;
use trial::Ending;

/// Drift per fingertip, N/s, and its duration, s (acceptance criterion).
const DRIFT_N_S: f64 = 0.05;
const DRIFT_S: f64 = 60.0;
/// Hysteresis and creep per decade, relative (acceptance criterion).
const HYSTERESIS: f64 = 0.05;
const CREEP: f64 = 0.05;
/// Full scale of an element's hysteresis, N. Design choice: 8 N on a fifth of 41 elements, as the
/// error `hysteresis` of the simulator.
const FULL_SCALE_N: f64 = 1.0;

/// Result of the evaluation.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct EffectReport {
    /// Always `sensor-effects`.
    pub task: &'static str,
    /// Objects, seeds, engine and discarded trials.
    #[serde(flatten)]
    pub summary: HeldSummary,
    /// One row per effect, with and without joint torques.
    pub rows: Vec<EffectRow>,
}

/// Outcomes of one case.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct EffectRow {
    /// Name of the effect.
    pub effect: &'static str,
    /// True if the servos report joint torques.
    pub torques: bool,
    /// Counts by outcome.
    #[serde(flatten)]
    pub outcomes: Outcomes,
    /// Trials of any outcome with a warning or HOLD before the end.
    pub warned: u64,
}

/// One effect of the sensor.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Effect {
    None,
    /// Rate, N/s, and start.
    Drift(f64, Start),
    Hysteresis,
    Creep,
}

/// Start of a drift.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Start {
    Simulation,
    Grip,
}

const CASES: [(&str, Effect); 7] = [
    ("none", Effect::None),
    (
        "drift +0.05 N/s from the start",
        Effect::Drift(DRIFT_N_S, Start::Simulation),
    ),
    (
        "drift -0.05 N/s from the start",
        Effect::Drift(-DRIFT_N_S, Start::Simulation),
    ),
    (
        "drift +0.05 N/s in the grip",
        Effect::Drift(DRIFT_N_S, Start::Grip),
    ),
    (
        "drift -0.05 N/s in the grip",
        Effect::Drift(-DRIFT_N_S, Start::Grip),
    ),
    ("hysteresis 5 %", Effect::Hysteresis),
    ("creep 5 % per decade", Effect::Creep),
];

impl Effect {
    /// Returns the sensor model with this effect; `lifted_s` is the time of the lift.
    fn model(self, lifted_s: f64) -> SensorModel {
        let mut model = SensorModel::default();
        match self {
            Self::None => {}
            Self::Drift(rate_n_s, start) => {
                model.drift = Some(DriftModel {
                    rate_n_s: [rate_n_s, 0.0, 0.0],
                    limit_n: DRIFT_N_S * DRIFT_S,
                    from_s: match start {
                        Start::Simulation => 0.0,
                        Start::Grip => lifted_s,
                    },
                });
            }
            Self::Hysteresis => {
                model.hysteresis = Some(HysteresisModel {
                    share: HYSTERESIS,
                    full_scale_n: [FULL_SCALE_N; 2],
                });
            }
            Self::Creep => model.creep = Some(CreepModel { per_decade: CREEP }),
        }
        model
    }
}

/// Runs all cases of all worlds; calls `done` after each world, from any thread; `None` if stopped.
///
/// # Errors
/// The robot, a world or an engine cannot be created, or the plan is empty.
pub fn sensor_effects(
    plan: &HeldPlan,
    stop: &AtomicBool,
    done: impl Fn() + Sync,
) -> anyhow::Result<Option<EffectReport>> {
    let worlds = plan.run(1, stop, done, |_, world| endings(world, stop))?;
    let worlds: Option<Vec<Vec<Ending>>> = worlds.into_iter().flatten().collect();
    Ok(worlds.map(|worlds| EffectReport::new(plan, &worlds)))
}

/// Returns the ending of every case of one world; `None` if stopped.
fn endings(world: &HeldWorld<'_>, stop: &AtomicBool) -> anyhow::Result<Option<Vec<Ending>>> {
    let mut endings = Vec::new();
    for torques in [true, false] {
        let trial = world.trial(&Errors::NONE)?;
        let trial = if torques {
            trial
        } else {
            trial.without_torques()
        };
        let reference = trial::run(&trial, &SensorModel::default())?;
        for (_, effect) in CASES {
            if stop.load(Ordering::Relaxed) {
                return Ok(None);
            }
            endings.push(match effect {
                Effect::None => reference.clone(),
                _ => trial::run(&trial, &effect.model(reference.lifted_s))?,
            });
        }
    }
    Ok(Some(endings))
}

impl EffectReport {
    fn new(plan: &HeldPlan, worlds: &[Vec<Ending>]) -> Self {
        let cases = [true, false]
            .into_iter()
            .flat_map(|torques| CASES.map(|(effect, _)| (effect, torques)));
        let rows = cases.enumerate().map(|(case, (effect, torques))| {
            let endings = || worlds.iter().map(|endings| &endings[case]);
            EffectRow {
                effect,
                torques,
                outcomes: endings().map(|ending| ending.outcome).collect(),
                warned: endings().filter(|ending| ending.warned).count() as u64,
            }
        });
        Self {
            task: "sensor-effects",
            summary: plan.summary(worlds.iter().flatten().map(|end| &end.discarded)),
            rows: rows.collect(),
        }
    }

    /// Returns the rows as a Markdown table.
    #[must_use]
    pub fn markdown(&self) -> String {
        let rows = self.rows.iter().map(EffectRow::cells);
        rows_table(&EffectRow::HEADER, rows) + &self.summary.discards()
    }
}

impl EffectRow {
    /// Headings of [`EffectRow::cells`].
    pub const HEADER: [&str; 9] = [
        "effect",
        "joint torques",
        "trials",
        "held",
        "crushed",
        "dropped",
        "slipped",
        "not lifted",
        "warned",
    ];

    /// Returns the row as text.
    #[must_use]
    pub fn cells(&self) -> [String; 9] {
        let of = &self.outcomes;
        [
            self.effect.to_owned(),
            if self.torques { "yes" } else { "no" }.to_owned(),
            of.trials.to_string(),
            of.held.to_string(),
            of.crushed.to_string(),
            of.dropped.to_string(),
            of.slipped.to_string(),
            of.not_lifted.to_string(),
            self.warned.to_string(),
        ]
    }
}

#[cfg(test)]
mod tests {
    use sim_backend::Object;

    use super::*;
    use crate::seeds;

    #[test]
    fn cases_have_valid_models() {
        for (name, effect) in CASES {
            effect.model(12.0).check().expect(name);
        }
        let grip = Effect::Drift(-0.05, Start::Grip)
            .model(12.0)
            .drift
            .expect("a drift");
        assert_eq!(
            (grip.rate_n_s[0], grip.limit_n, grip.from_s),
            (-0.05, 3.0, 12.0)
        );
    }

    /// One rigid object: without an effect it is held; the rows count every case.
    #[test]
    fn report_counts_every_case() {
        let plan = HeldPlan {
            objects: vec![Object::built_in("wood").expect("built in")],
            seeds: 1,
            first_seed: seeds::EVALUATION_START,
            engine: None,
            threads: 0,
            settings: atas_core::Settings::default(),
        };
        let report = sensor_effects(&plan, &AtomicBool::new(false), || ())
            .expect("it runs")
            .expect("not stopped");
        assert_eq!(report.rows.len(), 2 * CASES.len());
        for row in &report.rows {
            assert_eq!((row.outcomes.trials, row.outcomes.sum()), (1, 1), "{row:?}");
        }
        let first = &report.rows[0];
        assert_eq!((first.effect, first.outcomes.held), ("none", 1));
        assert!(report.markdown().lines().count() == 2 + report.rows.len());
    }
}
