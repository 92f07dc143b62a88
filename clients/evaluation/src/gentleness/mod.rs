//! Gentleness: forces and deformations of reference objects from egg-like to brick-like, for the
//! ATAS modules and three baselines, also with sensor noise and wrong expected widths.
//!
//! ```text
//!  reference object, seed, gripper ─▶ grasp, lift, hold ─▶ peak force, deformation, slip, time
//!                  noise × 1 to 4, wrong widths ─▶ success and over-grip
//! ```
//!
//! * **In:** objects, seeds, an engine. **Out:** a [`GentlenessReport`].
//! * **Invariants:** with the built-in engine, the report depends on the plan only. All grippers of
//!   an object and seed get the same world and noise. The baselines are tuned on the same objects
//!   with other seeds.
//! * **Not included:** damage other than by the largest force of a fingertip.

mod grips;
mod objects;
mod report;
mod trial;

use std::sync::atomic::AtomicBool;

use sim_backend::Errors;

use crate::held::{Grip, HeldPlan};
use trial::Ending;

pub use objects::{reference_objects, reference_or_other};
pub use report::{GentlenessReport, GentlenessRow, RobustnessRow};

/// Larger noise of the robustness rows, as factor on the sensor model (acceptance criterion).
const NOISES: [f64; 3] = [2.0, 3.0, 4.0];
/// Largest error of the expected width, m: that of `--errors expected-width`.
const WIDTH_ERROR_M: f64 = 0.004;

/// Plan of the evaluation.
#[derive(Clone, Debug)]
pub struct GentlenessPlan {
    /// Worlds, each with every gripper.
    pub held: HeldPlan,
    /// True: all candidates of the baselines, without robustness.
    pub tunes: bool,
}

/// Gripper and condition of some trials.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Series {
    grip: Grip,
    condition: Condition,
}

/// Deviation from exact widths and noise × 1.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Condition {
    Nominal,
    /// Factor on the noise.
    Noise(f64),
    /// The expected width is wrong.
    Width,
}

impl Condition {
    fn name(self) -> String {
        match self {
            Self::Nominal => "noise × 1, exact width".to_owned(),
            Self::Noise(noise) => format!("noise × {noise}"),
            Self::Width => {
                format!("expected width wrong by up to {} mm", WIDTH_ERROR_M * 1e3)
            }
        }
    }

    fn noise(self) -> f64 {
        match self {
            Self::Noise(noise) => noise,
            Self::Nominal | Self::Width => 1.0,
        }
    }

    fn errors(self) -> Errors {
        Errors {
            expected_width_m: if self == Self::Width {
                WIDTH_ERROR_M
            } else {
                0.0
            },
            ..Errors::NONE
        }
    }
}

impl GentlenessPlan {
    /// Returns the number of trials.
    #[must_use]
    pub fn trials(&self) -> u64 {
        self.held.worlds() * self.series().len() as u64
    }

    /// Runs all trials; calls `done` after each, from any thread; `None` if stopped.
    ///
    /// # Errors
    /// The robot, a world or an engine cannot be created, or the plan is empty.
    pub fn run(
        &self,
        stop: &AtomicBool,
        done: impl Fn() + Sync,
    ) -> anyhow::Result<Option<GentlenessReport>> {
        let series = self.series();
        let endings = self.held.run(series.len(), stop, done, |index, world| {
            let Series { grip, condition } = series[index];
            trial::run(&world.trial(&condition.errors())?, grip, condition.noise())
        })?;
        Ok(endings.map(|endings| GentlenessReport::new(self, &self.by_series(endings))))
    }

    /// Returns all grippers with exact widths and noise × 1, the ATAS modules at larger noise, then
    /// all grippers with wrong widths.
    fn series(&self) -> Vec<Series> {
        let under = |condition| move |grip| Series { grip, condition };
        if self.tunes {
            let candidates = grips::candidates().into_iter();
            return candidates.map(under(Condition::Nominal)).collect();
        }
        let grips = grips::grips();
        let noisy = NOISES.map(|noise| under(Condition::Noise(noise))(grips[0]));
        let nominal = grips.iter().copied().map(under(Condition::Nominal));
        let width = grips.iter().copied().map(under(Condition::Width));
        nominal.chain(noisy).chain(width).collect()
    }

    /// Groups the endings by series; within one, the trials of an object are consecutive.
    fn by_series(&self, endings: Vec<Ending>) -> Vec<(Series, Vec<Ending>)> {
        let mut endings = endings.into_iter();
        let worlds = self.held.worlds() as usize;
        let series = self.series().into_iter();
        series
            .map(|series| (series, endings.by_ref().take(worlds).collect()))
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::seeds;

    #[test]
    fn report_counts_grippers_and_conditions() {
        let plan = |threads| GentlenessPlan {
            held: HeldPlan {
                objects: vec![reference_or_other("egg").expect("known")],
                seeds: 1,
                first_seed: seeds::EVALUATION_START,
                engine: None,
                threads,
                settings: atas_core::Settings::default(),
            },
            tunes: false,
        };
        let run = |threads| {
            let report = plan(threads).run(&AtomicBool::new(false), || ());
            report.expect("it runs").expect("not stopped")
        };
        let report = run(0);
        let names: Vec<&str> = report.rows.iter().map(|row| row.gripper).collect();
        assert_eq!(names, ["ours", "fixed_force", "slip_reactive", "position"]);
        for row in &report.rows {
            assert_eq!((row.outcomes.trials, row.outcomes.sum()), (1, 1), "{row:?}");
        }
        let ours = &report.rows[0];
        assert_eq!(
            (ours.object.as_str(), ours.outcomes.held),
            ("egg", 1),
            "{ours:?}"
        );
        assert!(
            ours.peak.is_some_and(|peak| (1.0..4.0).contains(&peak)),
            "{ours:?}"
        );
        assert_eq!(report.robustness.len(), 4 + NOISES.len() + 4);
        assert_eq!(report, run(1), "independent of the number of threads");
    }
}
