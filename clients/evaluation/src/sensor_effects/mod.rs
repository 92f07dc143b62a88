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
//! * **Not included:** a controller that compensates these effects; the table shows today's results.

mod trial;

use std::sync::atomic::{AtomicBool, Ordering};

use robot_model::RobotModel;
use serde::Serialize;
use sim_backend::engine::{EngineCommand, EnginePool};
use sim_backend::random::trial_seed;
use sim_backend::{CreepModel, DriftModel, Errors, HysteresisModel, Object, SensorModel};

use crate::held::{self, Discards, HeldTrial, Outcome, discards_text};
use crate::parallel::run_indexed;
use crate::seeds;
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

/// Plan of the evaluation.
#[derive(Clone, Debug)]
pub struct EffectPlan {
    /// Nominal objects.
    pub objects: Vec<Object>,
    /// Trials per object and case.
    pub seeds: u64,
    /// First seed per object.
    pub first_seed: u64,
    /// Physics engine in a process of its own; `None`: the built-in one.
    pub engine: Option<EngineCommand>,
    /// Threads; 0: one per core.
    pub threads: usize,
    /// Controller settings.
    pub settings: atas_core::Settings,
}

/// Result of the evaluation.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct EffectReport {
    /// Always `sensor-effects`.
    pub task: &'static str,
    /// Physics engine, if not the built-in one.
    pub engine: Option<String>,
    /// Names of the objects.
    pub objects: Vec<String>,
    /// Trials per object and case.
    pub seeds: u64,
    /// First seed per object.
    pub first_seed: u64,
    /// `tuning` or `judging`.
    pub purpose: &'static str,
    /// One row per effect, with and without joint torques.
    pub rows: Vec<EffectRow>,
    /// Trials that the engine could not simulate, by reason.
    pub discarded: Discards,
}

/// Outcomes of one case.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct EffectRow {
    /// Name of the effect.
    pub effect: &'static str,
    /// True if the servos report joint torques.
    pub torques: bool,
    /// Trials.
    pub trials: u64,
    /// Objects in the lifted hand after the hold, stable and unharmed.
    pub held: u64,
    /// Crushed objects.
    pub crushed: u64,
    /// Dropped objects.
    pub dropped: u64,
    /// Objects in the lifted hand that slipped or turned beyond the limits of the judge.
    pub slipped: u64,
    /// Objects that were not lifted, or put back.
    pub not_lifted: u64,
    /// Trials that the engine could not simulate: never a success.
    pub discarded: u64,
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

impl EffectPlan {
    /// Returns the number of worlds: one per object and seed.
    #[must_use]
    pub fn worlds(&self) -> u64 {
        self.objects.len() as u64 * self.seeds
    }

    /// Runs all trials; calls `done` after each world, from any thread; `None` if stopped.
    ///
    /// # Errors
    /// The robot or a world cannot be created, or the plan is empty.
    pub fn run(
        &self,
        stop: &AtomicBool,
        done: impl Fn() + Sync,
    ) -> anyhow::Result<Option<EffectReport>> {
        anyhow::ensure!(
            self.worlds() > 0,
            "could not evaluate: the plan has no trial; request at least one object and seed"
        );
        let robot = RobotModel::two_hand_arm()?;
        let engines = held::engines(self.engine.as_ref());
        let worlds = run_indexed(self.worlds(), self.threads, stop, |index| {
            let (object, number) = (index / self.seeds, self.first_seed + index % self.seeds);
            let endings = self.endings(&robot, engines.as_ref(), object as usize, number, stop)?;
            done();
            Ok(endings)
        })?;
        let worlds: Option<Vec<Vec<Ending>>> = worlds.into_iter().flatten().collect();
        Ok(worlds.map(|worlds| self.report(&worlds)))
    }

    /// Returns the ending of every case of one world; `None` if stopped.
    fn endings(
        &self,
        robot: &RobotModel,
        engines: Option<&EnginePool>,
        object: usize,
        number: u64,
        stop: &AtomicBool,
    ) -> anyhow::Result<Option<Vec<Ending>>> {
        let nominal = &self.objects[object];
        let seed = trial_seed(&nominal.name, number);
        let mut endings = Vec::new();
        for torques in [true, false] {
            let trial = HeldTrial::new(
                robot,
                engines,
                nominal.clone(),
                seed,
                self.settings,
                &Errors::NONE,
            )?;
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

    fn report(&self, worlds: &[Vec<Ending>]) -> EffectReport {
        let cases = [true, false]
            .into_iter()
            .flat_map(|t| CASES.map(|(name, _)| (name, t)));
        let rows = cases.enumerate().map(|(case, (effect, torques))| {
            let endings = worlds.iter().map(|endings| &endings[case]);
            EffectRow::count(effect, torques, endings)
        });
        EffectReport {
            task: "sensor-effects",
            engine: self.engine.as_ref().map(ToString::to_string),
            objects: self
                .objects
                .iter()
                .map(|object| object.name.clone())
                .collect(),
            seeds: self.seeds,
            first_seed: self.first_seed,
            purpose: seeds::purpose(self.first_seed, self.seeds),
            rows: rows.collect(),
            discarded: held::count_discards(worlds.iter().flatten().map(|end| &end.discarded)),
        }
    }
}

impl EffectRow {
    fn count<'a>(
        effect: &'static str,
        torques: bool,
        endings: impl Iterator<Item = &'a Ending>,
    ) -> Self {
        let mut row = Self {
            effect,
            torques,
            trials: 0,
            held: 0,
            crushed: 0,
            dropped: 0,
            slipped: 0,
            not_lifted: 0,
            discarded: 0,
            warned: 0,
        };
        for ending in endings {
            row.trials += 1;
            row.warned += u64::from(ending.warned);
            *match ending.outcome {
                Outcome::Held => &mut row.held,
                Outcome::Crushed => &mut row.crushed,
                Outcome::Dropped => &mut row.dropped,
                Outcome::Slipped => &mut row.slipped,
                Outcome::NotLifted => &mut row.not_lifted,
                Outcome::Discarded => &mut row.discarded,
            } += 1;
        }
        row
    }
}

impl EffectReport {
    /// Returns the rows as a Markdown table.
    #[must_use]
    pub fn markdown(&self) -> String {
        let mut text = "| effect | joint torques | trials | held | crushed | dropped | slipped | not lifted | \
                        warned |\n|---|---|---|---|---|---|---|---|---|\n"
            .to_owned();
        for row in &self.rows {
            let torques = if row.torques { "yes" } else { "no" };
            let counts = [
                row.trials,
                row.held,
                row.crushed,
                row.dropped,
                row.slipped,
                row.not_lifted,
                row.warned,
            ];
            let counts = counts.map(|count| count.to_string()).join(" | ");
            text += &format!("| {} | {torques} | {counts} |\n", row.effect);
        }
        text + &discards_text(&self.discarded)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

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
        let plan = EffectPlan {
            objects: vec![Object::built_in("wood").expect("built in")],
            seeds: 1,
            first_seed: seeds::EVALUATION_START,
            engine: None,
            threads: 0,
            settings: atas_core::Settings::default(),
        };
        let report = plan
            .run(&AtomicBool::new(false), || ())
            .expect("it runs")
            .expect("not stopped");
        assert_eq!(report.rows.len(), 2 * CASES.len());
        for row in &report.rows {
            let held_or_not = row.held + row.slipped + row.not_lifted + row.discarded;
            let sum = held_or_not + row.crushed + row.dropped;
            assert_eq!((row.trials, sum), (1, 1), "{row:?}");
        }
        assert_eq!((report.rows[0].effect, report.rows[0].held), ("none", 1));
        assert!(report.markdown().lines().count() == 2 + report.rows.len());
    }
}
