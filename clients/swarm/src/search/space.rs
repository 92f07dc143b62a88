//! Search space: keys of a preset with ranges of values, and the candidates drawn from them.

use std::str::FromStr;

use field::Preset;

use crate::error::Result;
use crate::rng::SplitMix64;
use crate::variation::varied;

const CANDIDATES: u64 = 0x6361_6e64;
/// Steps of a numeric range. Design choice: finer than a field resolves.
const STEPS: usize = 200;
/// Draws per candidate before the search fails.
const ATTEMPTS: usize = 100;

/// A key of a preset with its possible values.
#[derive(Clone, Debug, PartialEq)]
pub struct Range {
    key: String,
    values: Values,
}

#[derive(Clone, Debug, PartialEq)]
enum Values {
    Numbers { low: f64, high: f64 },
    Whole { low: i64, high: i64 },
    Listed(Vec<toml::Value>),
}

/// One preset of a search.
#[derive(Clone, Debug, PartialEq)]
pub struct Candidate {
    /// Index; 0 is the initial preset.
    pub index: usize,
    /// Preset, named after its index.
    pub preset: Preset,
    /// Changes as `key=value key=value`.
    pub changes: String,
}

impl FromStr for Range {
    type Err = String;

    /// Parses `key=low..high` or `key=value,value`. Integers stay integers; words need no quotes.
    fn from_str(text: &str) -> std::result::Result<Self, String> {
        let needs = || {
            format!(
                "it is {text:?}, needs a key of a preset and a range or values, as in \
                 goal_radius_px=40.0..60.0 or contact=sliding,blocking"
            )
        };
        let (key, values) = text.split_once('=').ok_or_else(needs)?;
        let values = match values.split_once("..") {
            Some((low, high)) => between(low.trim(), high.trim()),
            None => values
                .split(',')
                .map(value)
                .collect::<Option<_>>()
                .map(Values::Listed),
        };
        match values {
            Some(values) if !key.trim().is_empty() => Ok(Self {
                key: key.trim().to_owned(),
                values,
            }),
            _ => Err(needs()),
        }
    }
}

fn between(low: &str, high: &str) -> Option<Values> {
    if let (Ok(low), Ok(high)) = (low.parse::<i64>(), high.parse::<i64>()) {
        let short = high.checked_sub(low).is_some_and(|way| way < 1_000_000);
        return (low < high && short).then_some(Values::Whole { low, high });
    }
    let (low, high) = (low.parse::<f64>().ok()?, high.parse::<f64>().ok()?);
    (low < high && (high - low).is_finite()).then_some(Values::Numbers { low, high })
}

/// Parses a TOML value; a bare word becomes a string.
fn value(text: &str) -> Option<toml::Value> {
    let text = Some(text.trim()).filter(|text| !text.is_empty())?;
    let plain = format!("value = {text}").parse::<toml::Table>();
    let value = plain.or_else(|_| format!("value = {text:?}").parse::<toml::Table>());
    value.ok().and_then(|mut table| table.remove("value"))
}

impl Range {
    fn draw(&self, rng: &mut SplitMix64) -> toml::Value {
        match &self.values {
            Values::Numbers { low, high } => {
                let part = rng.below(STEPS + 1) as f64 / STEPS as f64;
                // Rounded to the digits that the steps need, so that files stay readable.
                let digit = 10_f64.powf((high - low).log10().floor() - 3.0);
                toml::Value::Float(((low + part * (high - low)) / digit).round() * digit)
            }
            Values::Whole { low, high } => {
                toml::Value::Integer(low + rng.below((high - low) as usize + 1) as i64)
            }
            Values::Listed(values) => values[rng.below(values.len())].clone(),
        }
    }
}

/// Returns the initial preset and `count` − 1 random variations; deterministic for a seed.
///
/// # Errors
/// A key does not exist in presets, or almost no preset in these ranges is valid.
pub fn candidates(
    base: &Preset,
    ranges: &[Range],
    count: usize,
    seed: u64,
) -> Result<Vec<Candidate>> {
    let mut rng = SplitMix64::stream(&[CANDIDATES, seed]);
    let mut candidates = vec![Candidate {
        index: 0,
        preset: base.clone(),
        changes: String::new(),
    }];
    let mut refused = None;
    for _ in 0..count.saturating_mul(ATTEMPTS) {
        if candidates.len() >= count {
            break;
        }
        match draw(base, ranges, candidates.len(), &mut rng) {
            Ok(candidate) => candidates.push(candidate),
            Err(error) => refused = Some(error),
        }
    }
    match refused {
        Some(error) if candidates.len() < count => Err(error),
        _ => Ok(candidates),
    }
}

fn draw(base: &Preset, ranges: &[Range], index: usize, rng: &mut SplitMix64) -> Result<Candidate> {
    let values: Vec<toml::Value> = ranges.iter().map(|range| range.draw(rng)).collect();
    let keys = ranges.iter().map(|range| range.key.as_str());
    let mut preset = varied(base, &keys.zip(&values).collect::<Vec<_>>())?;
    let changes = preset.name.strip_prefix(&*base.name).unwrap_or_default();
    let changes = changes.trim().to_owned();
    preset.name = format!("{}-{index}", base.name).into();
    Ok(Candidate {
        index,
        preset,
        changes,
    })
}

impl Candidate {
    /// Returns the name of its folder and file.
    #[must_use]
    pub fn label(&self) -> String {
        format!("candidate-{:04}", self.index)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ranges(texts: &[&str]) -> Vec<Range> {
        let range = |text: &&str| text.parse().expect(text);
        texts.iter().map(range).collect()
    }

    #[test]
    fn candidates_stay_in_range_and_repeat() {
        let ranges = ranges(&[
            "goal_radius_px=40.0..60.0",
            "ir_angle_steps=6..11",
            "contact=sliding,blocking",
            "friction_per_stall_force=0.9..1.0",
        ]);
        let drawn = candidates(&Preset::R3, &ranges, 50, 7).expect("candidates");
        assert_eq!(
            drawn,
            candidates(&Preset::R3, &ranges, 50, 7).expect("again")
        );
        assert_ne!(
            drawn,
            candidates(&Preset::R3, &ranges, 50, 8).expect("others")
        );
        assert_eq!((drawn.len(), &drawn[0].preset), (50, &Preset::R3));
        for candidate in &drawn[1..] {
            let preset = &candidate.preset;
            assert!((40.0..=60.0).contains(&preset.goal_radius_px), "{preset:?}");
            assert!((6..=11).contains(&preset.ir_angle_steps), "{preset:?}");
            assert!(matches!(preset.push, field::Push::Friction(part) if part >= 0.899));
        }
        let sliding = |candidate: &&Candidate| candidate.preset.contact == field::Contact::Sliding;
        assert!((10..40).contains(&drawn.iter().filter(sliding).count()));
    }

    #[test]
    fn invalid_ranges_and_presets_are_rejected() {
        for text in [
            "goal_radius_px",
            "=1..2",
            "a=2..1",
            "a=1..nan",
            "a=1.0..inf",
            "a=",
        ] {
            assert!(text.parse::<Range>().is_err(), "{text:?}");
        }
        for text in [
            "speed=1.0..2.0",
            "goal_radius_px=900.0..950.0",
            "contact=soft",
        ] {
            let refused = candidates(&Preset::R3, &ranges(&[text]), 3, 1);
            assert!(refused.is_err(), "{text:?}");
        }
    }
}
