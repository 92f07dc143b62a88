//! `ebts sweep`: one experiment for every combination of some values of a preset.

use std::path::PathBuf;
use std::str::FromStr;

use clap::Args;
use indicatif::ProgressBar;
use serde::Serialize;

use ebts::error::{Error, Result};
use ebts::experiment::Shard;
use ebts::files::plain_name;
use ebts::results::Summary;
use ebts::variation::varied;
use ebts::workers::pool;
use field::Preset;

use super::experiment::{RunsArgs, Stopwatch, conclude, run};
use super::report;
use super::{Format, answer, stop_flag};

const EXAMPLES: &str = "Examples:
  ebts sweep --preset LB2 --vary goal_radius_px=40,50 --seeds 15 --out sweep
  ebts sweep --vary friction_per_stall_force=0.9,0.95 --vary starts.distance_px=300,325

Results of few seeds mislead: confirm the best combination on further seeds,
for example with --seeds 320 --first-seed 100001.";

const COMBINATIONS_MAX: usize = 1000;

#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct SweepArgs {
    /// A key of the preset and its values; repeat for all combinations.
    #[arg(long, required = true, value_name = "KEY=V,...")]
    vary: Vec<Vary>,
    #[command(flatten)]
    runs: RunsArgs,
    /// Folder of the sweep, with one experiment per combination; an existing one is continued.
    #[arg(long, default_value = "sweep")]
    out: PathBuf,
}

/// Key and values: `key=value,value`, as in `starts.distance_px=300,325`.
#[derive(Clone, Debug)]
pub(super) struct Vary {
    pub(super) key: String,
    pub(super) values: Vec<toml::Value>,
}

impl FromStr for Vary {
    type Err = String;

    fn from_str(text: &str) -> std::result::Result<Self, String> {
        let needs = || {
            format!(
                "it is {text:?}, needs a key of a preset and values, as in goal_radius_px=40,50"
            )
        };
        let (key, values) = text.split_once('=').ok_or_else(needs)?;
        let value = |text: &str| {
            let text = text.trim();
            let plain = format!("value = {text}").parse::<toml::Table>();
            // Bare words are strings.
            let value = plain.or_else(|_| format!("value = {text:?}").parse::<toml::Table>());
            value.ok().and_then(|mut table| table.remove("value"))
        };
        let values = values.split(',').map(value).collect::<Option<Vec<_>>>();
        match values {
            Some(values) if !key.trim().is_empty() => Ok(Self {
                key: key.trim().to_owned(),
                values,
            }),
            _ => Err(needs()),
        }
    }
}

#[derive(Serialize)]
struct Combination {
    folder: PathBuf,
    #[serde(flatten)]
    summary: Summary,
}

pub(super) fn sweep(args: SweepArgs, format: Format) -> Result<()> {
    let base = args.runs.evolution.preset()?;
    let presets = combinations(&base, &args.vary)?;
    let plans = presets
        .into_iter()
        .map(|preset| args.runs.plan(preset))
        .collect::<Result<Vec<_>>>()?;
    let engine = &args.runs.engine;
    let (workers, threads) = (engine.workers(stop_flag()?)?, engine.threads());
    let (mut shown, mut found) = (Vec::new(), Vec::new());
    for plan in &plans {
        let watch = Stopwatch::start();
        let folder = args.out.join(plain_name(&plan.preset.name));
        let (records, _) = run(
            plan,
            Shard::WHOLE,
            &folder,
            (&workers, threads),
            &ProgressBar::new(0),
        )?;
        let (summary, findings) =
            pool(threads)?.install(|| conclude(&folder, plan, &records, &watch))?;
        found.push(Combination {
            folder,
            summary: summary.clone(),
        });
        shown.push((summary, findings));
    }
    answer(format, &found, || report::side_by_side(&shown))
}

/// Returns every combination, named by its values. All are validated before any run.
fn combinations(base: &Preset, vary: &[Vary]) -> Result<Vec<Preset>> {
    let count = vary.iter().map(|vary| vary.values.len()).product::<usize>();
    if !(1..=COMBINATIONS_MAX).contains(&count) {
        return Err(Error::refused(
            "sweep",
            format_args!("--vary makes {count} combinations"),
            format_args!("1 to {COMBINATIONS_MAX}"),
            "vary fewer keys or values",
        ));
    }
    let nth = |mut index: usize| {
        let mut chosen = Vec::new();
        for Vary { key, values } in vary {
            chosen.push((key.as_str(), &values[index % values.len()]));
            index /= values.len();
        }
        varied(base, &chosen)
    };
    (0..count).map(nth).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_combination_appears_once() {
        let vary: Vec<Vary> = [
            "goal_radius_px=40,50",
            "starts.distance_px=300,310.5,320",
            "contact=sliding",
        ]
        .map(|text| text.parse().expect(text))
        .to_vec();
        let presets = combinations(&Preset::R3, &vary).expect("valid presets");
        assert_eq!(presets.len(), 6);
        assert_eq!(presets[3].goal_radius_px, 50.0);
        assert_eq!(presets[3].starts.distance_px, 310.5);
        assert_eq!(
            presets[3].name,
            "R3 goal_radius_px=50 starts.distance_px=310.5 contact=sliding"
        );
    }

    #[test]
    fn push_law_and_fitted_factors_exclude_each_other() {
        let one = |base: &Preset, text: &str| {
            combinations(base, &[text.parse::<Vary>().expect(text)]).map(|presets| presets[0].push)
        };
        let law = field::Push::Friction(0.9);
        assert_eq!(
            one(&Preset::R3, "friction_per_stall_force=0.9").ok(),
            Some(law)
        );
        assert!(
            one(&Preset::LB3, "solo_push=0.1").is_err(),
            "the other number is missing"
        );
    }

    #[test]
    fn invalid_variations_are_rejected() {
        for text in ["goal_radius_px", "=1", ""] {
            assert!(text.parse::<Vary>().is_err(), "{text:?}");
        }
        for text in [
            "speed=1",
            "goal_radius_px=fast",
            "goal_radius_px=nan",
            "starts.x=1",
        ] {
            let vary: Vary = text.parse().expect(text);
            assert!(combinations(&Preset::R3, &[vary]).is_err(), "{text:?}");
        }
    }
}
