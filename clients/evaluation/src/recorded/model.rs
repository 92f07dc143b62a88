//! Model: the constants of the evaluation, in a TOML file with names, units and sources.

use std::collections::BTreeMap;
use std::path::Path;

use anyhow::{Context, ensure};
use serde::{Deserialize, Serialize};

/// File format version.
const FORMAT: u32 = 1;
/// Built-in model.
const BUILT_IN: &str = include_str!("../../models/perception.toml");

/// Constants for every kind of recording.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Model {
    /// Version of the file format.
    pub format: u32,
    /// Slip detection.
    pub slip: Slip,
    /// Classification as hard or soft.
    pub hardness: Hardness,
    /// Prediction of the rupture force.
    pub rupture: Rupture,
    /// Contact onsets.
    pub touch: Touch,
}

/// Constants of slip detection.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Slip {
    /// Window whose means are compared, s.
    pub motion_window_s: f64,
    /// Minimum share of the time with motion for slip.
    pub moving_share: f64,
    /// Motion threshold, in multiples of the sensor noise, at `rate_hz`.
    pub motion_at: f64,
    /// Force per count, N.
    pub newtons_per_count: f64,
    /// Sensor rate of `motion_at`, and default frame rate, Hz.
    pub rate_hz: f64,
    /// Labels that mean stable contact.
    pub negative: Vec<String>,
    /// Source.
    pub source: String,
}

impl Slip {
    /// Returns the motion threshold for another sensor rate, Hz. Motion of a stable contact is
    /// independent of the rate; noise of a window mean falls with the root of its frame count; both
    /// add in squares. Constant above `rate_hz`, because a faster sensor need not creep more.
    pub(super) fn motion_threshold(&self, rate_hz: f64) -> f64 {
        let creep = self.motion_at * self.motion_at - 1.0;
        let share = (rate_hz / self.rate_hz).min(1.0);
        (1.0 + creep.max(0.0) * share).sqrt()
    }
}

/// Constants of the classification as hard or soft.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Hardness {
    /// Contact threshold of the force per side, N.
    pub touch_on_n: f64,
    /// Force per side above which the stiffness is estimated, N.
    pub touch_off_n: f64,
    /// Closing per radian of a finger's angle, m.
    pub lever_m: f64,
    /// Time constant of the low-pass on every element, s.
    pub filter_s: f64,
    /// Default frame rate, Hz.
    pub rate_hz: f64,
    /// Hardness threshold over the whole squeeze, N/m.
    pub whole_n_m: f64,
    /// Hardness threshold at the first step after contact, N/m.
    pub first_step_n_m: f64,
    /// Labels that mean hard.
    pub positive: Vec<String>,
    /// Labels that mean soft.
    pub negative: Vec<String>,
    /// Source.
    pub source: String,
}

/// Constants of the rupture prediction.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Rupture {
    /// Force above which stiffness is evaluated, N.
    pub from_n: f64,
    /// Force window of the stiffness estimate, N.
    pub window_n: f64,
    /// Share of the maximum stiffness below which yielding is detected.
    pub share: f64,
    /// Time constant of the low-pass on force and position, s.
    pub filter_s: f64,
    /// Default frame rate, Hz.
    pub rate_hz: f64,
    /// Source.
    pub source: String,
    /// Rupture force over peak force before yielding, per category.
    pub lines: BTreeMap<String, Line>,
}

/// Straight line.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Line {
    /// Value at 0 N.
    pub offset_n: f64,
    /// Slope, N/N.
    pub slope: f64,
}

/// Constants of contact detection on one fingertip.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Touch {
    /// Force per count on the sensor's x, y and z axes, N.
    pub newtons_per_count: [f64; 3],
    /// Normal force at which contact begins, N.
    pub touch_on_n: f64,
    /// Normal force at which contact ends, N.
    pub touch_off_n: f64,
    /// Time constant of the low-pass, s.
    pub filter_s: f64,
    /// Default frame rate, Hz.
    pub rate_hz: f64,
    /// Source.
    pub source: String,
}

impl Model {
    /// Returns the built-in model.
    ///
    /// # Errors
    /// The built-in file is invalid.
    pub fn built_in() -> anyhow::Result<Self> {
        Self::parse(BUILT_IN).context("could not use the built-in model")
    }

    /// Reads a model file.
    ///
    /// # Errors
    /// The file cannot be read, or a value is out of range.
    pub fn open(path: &Path) -> anyhow::Result<Self> {
        let name = path.display();
        let text = atas_text_file::read(path).with_context(|| format!("could not read {name}"))?;
        Self::parse(&text).with_context(|| format!("could not use the model {name}"))
    }

    /// Writes a model file.
    ///
    /// # Errors
    /// The file exists, or cannot be written.
    pub fn save(&self, path: &Path) -> anyhow::Result<()> {
        let text = toml::to_string(self).context("could not write the model")?;
        let name = path.display();
        let mut file = std::fs::File::create_new(path)
            .with_context(|| format!("could not create {name}; a model never overwrites a file"))?;
        std::io::Write::write_all(&mut file, text.as_bytes())
            .with_context(|| format!("could not write {name}"))
    }

    /// Returns the model with this default rate of recordings, Hz.
    #[must_use]
    pub fn with_rate(mut self, rate_hz: f64) -> Self {
        self.slip.motion_at = self.slip.motion_threshold(rate_hz);
        self.slip.rate_hz = rate_hz;
        self.hardness.rate_hz = rate_hz;
        self.rupture.rate_hz = rate_hz;
        self.touch.rate_hz = rate_hz;
        self
    }

    fn parse(text: &str) -> anyhow::Result<Self> {
        let model: Self = toml::from_str(text)?;
        ensure!(
            model.format == FORMAT,
            "format {} is not supported, this version reads format {FORMAT}; fit the model again \
             with --train and --save",
            model.format
        );
        model.check()?;
        Ok(model)
    }

    /// Checks ranges; settings passed on to perception are checked there.
    fn check(&self) -> anyhow::Result<()> {
        let (slip, hardness, rupture, touch) =
            (&self.slip, &self.hardness, &self.rupture, &self.touch);
        let positive = [
            ("slip.motion_at", slip.motion_at),
            ("slip.newtons_per_count", slip.newtons_per_count),
            ("slip.rate_hz", slip.rate_hz),
            ("hardness.lever_m", hardness.lever_m),
            ("hardness.rate_hz", hardness.rate_hz),
            ("rupture.from_n", rupture.from_n),
            ("rupture.window_n", rupture.window_n),
            ("rupture.rate_hz", rupture.rate_hz),
            ("touch.newtons_per_count", touch.newtons_per_count[0]),
            ("touch.newtons_per_count", touch.newtons_per_count[1]),
            ("touch.newtons_per_count", touch.newtons_per_count[2]),
            ("touch.rate_hz", touch.rate_hz),
        ];
        for (name, value) in positive {
            ensure!(
                value.is_finite() && value > 0.0,
                "{name} is {value}, must be a number above 0"
            );
        }
        for (name, share) in [
            ("slip.moving_share", slip.moving_share),
            ("rupture.share", rupture.share),
        ] {
            ensure!(
                (0.0..1.0).contains(&share),
                "{name} is {share}, must be at least 0 and below 1"
            );
        }
        let lines = rupture
            .lines
            .iter()
            .map(|(name, line)| (name, line.offset_n, line.slope));
        for (name, offset_n, slope) in lines {
            ensure!(
                offset_n.is_finite() && slope.is_finite(),
                "rupture.lines.{name} must have two finite numbers"
            );
        }
        Ok(())
    }
}
