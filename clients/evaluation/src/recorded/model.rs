//! The constants in force: a small file with names, units and where each comes from.

use std::collections::BTreeMap;
use std::path::Path;

use anyhow::{Context, ensure};
use serde::{Deserialize, Serialize};

/// What this version writes and reads.
const FORMAT: u32 = 1;
/// The constants that come with the program.
const SHIPPED: &str = include_str!("../../models/perception.toml");

/// Constants for every kind of recording.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Model {
    /// Version of the file.
    pub format: u32,
    /// Slip against stable touch.
    pub slip: Slip,
    /// Hard against soft.
    pub hardness: Hardness,
    /// The force at which something gives way.
    pub rupture: Rupture,
    /// Touches.
    pub touch: Touch,
}

/// Slip against stable touch.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Slip {
    /// Window whose means are compared, s.
    pub motion_window_s: f64,
    /// Share of the time for which the pattern must move.
    pub moving_share: f64,
    /// Motion that counts, in multiples of the sensor's own noise, at `rate_hz`.
    pub motion_at: f64,
    /// Newtons that a count stands for.
    pub newtons_per_count: f64,
    /// Frames per second for which `motion_at` is meant, and of a recording that does not say, Hz.
    pub rate_hz: f64,
    /// Labels that mean a stable touch.
    pub negative: Vec<String>,
    /// Where the constants come from.
    pub source: String,
}

impl Slip {
    /// Motion that counts for a sensor of another rate, Hz: what a stable touch moves is the same, while the noise of a window's mean
    /// falls with the root of its frames. Both add up by their squares. A faster sensor is another one, and need not creep more.
    pub(super) fn motion_at(&self, rate_hz: f64) -> f64 {
        let creep = self.motion_at * self.motion_at - 1.0;
        let share = (rate_hz / self.rate_hz).min(1.0);
        (1.0 + creep.max(0.0) * share).sqrt()
    }
}

/// Hard against soft.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Hardness {
    /// Force on one face that counts as a touch, N.
    pub touch_on_n: f64,
    /// Force on one face from which the stiffness is read, N.
    pub touch_off_n: f64,
    /// Closing per radian of a finger's angle, m.
    pub lever_m: f64,
    /// Low-pass on every element, s.
    pub filter_s: f64,
    /// Frames per second of a recording that does not say, Hz.
    pub rate_hz: f64,
    /// Stiffness above which an object is hard, from the whole squeeze, N/m.
    pub whole_n_m: f64,
    /// The same from the first step after touch, N/m.
    pub first_step_n_m: f64,
    /// Labels that mean hard.
    pub positive: Vec<String>,
    /// Labels that mean soft.
    pub negative: Vec<String>,
    /// Where the constants come from.
    pub source: String,
}

/// The force at which something gives way.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Rupture {
    /// Force at which watching begins, N.
    pub from_n: f64,
    /// Window of force over which the stiffness is read, N.
    pub window_n: f64,
    /// Share of the stiffest below which it yields.
    pub share: f64,
    /// Low-pass on force and position, s.
    pub filter_s: f64,
    /// Frames per second of a recording that does not say, Hz.
    pub rate_hz: f64,
    /// Where the constants come from.
    pub source: String,
    /// From the greatest force before yielding to that at which it ruptured, by sort of thing.
    pub lines: BTreeMap<String, Line>,
}

/// A straight line.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Line {
    /// At 0 N.
    pub offset_n: f64,
    /// N per N.
    pub slope: f64,
}

/// Touches of one fingertip.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Touch {
    /// Newtons per count along the device's x, y and z.
    pub newtons_per_count: [f64; 3],
    /// Normal force that counts as a touch, N.
    pub touch_on_n: f64,
    /// Normal force below which a touch has ended, N.
    pub touch_off_n: f64,
    /// Low-pass, s.
    pub filter_s: f64,
    /// Frames per second of a recording that does not say, Hz.
    pub rate_hz: f64,
    /// Where the constants come from.
    pub source: String,
}

impl Model {
    /// The constants that come with the program.
    ///
    /// # Errors
    /// Never for a program whose tests pass.
    pub fn shipped() -> anyhow::Result<Self> {
        Self::parse(SHIPPED).context("the model that comes with the program")
    }

    /// Reads a file that [`Model::save`] wrote.
    ///
    /// # Errors
    /// It cannot be read, or says something that no sensor can be.
    pub fn open(path: &Path) -> anyhow::Result<Self> {
        let name = path.display();
        let text =
            std::fs::read_to_string(path).with_context(|| format!("could not read {name}"))?;
        Self::parse(&text).with_context(|| format!("could not use the model {name}"))
    }

    /// Writes a file.
    ///
    /// # Errors
    /// It exists, or cannot be written.
    pub fn save(&self, path: &Path) -> anyhow::Result<()> {
        let text = toml::to_string(self).context("could not write the model")?;
        let name = path.display();
        let mut file = std::fs::File::create_new(path)
            .with_context(|| format!("could not write {name}; a model never overwrites a file"))?;
        std::io::Write::write_all(&mut file, text.as_bytes())
            .with_context(|| format!("could not write {name}"))
    }

    /// The same for recordings of this rate where they do not say theirs, Hz.
    #[must_use]
    pub fn at_rate(mut self, rate_hz: f64) -> Self {
        self.slip.motion_at = self.slip.motion_at(rate_hz);
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
            "its format is {}, needs {FORMAT}; fit it again with --train and --save",
            model.format
        );
        model.check()?;
        Ok(model)
    }

    /// Every number within what a sensor can be; what perception itself is told is checked there.
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
                "{name} is {value}, needs a number above 0"
            );
        }
        for (name, share) in [
            ("slip.moving_share", slip.moving_share),
            ("rupture.share", rupture.share),
        ] {
            ensure!(
                (0.0..1.0).contains(&share),
                "{name} is {share}, needs a number from 0 to below 1"
            );
        }
        let lines = rupture
            .lines
            .iter()
            .map(|(name, line)| (name, line.offset_n, line.slope));
        for (name, offset_n, slope) in lines {
            ensure!(
                offset_n.is_finite() && slope.is_finite(),
                "rupture.lines.{name} needs two numbers"
            );
        }
        Ok(())
    }
}
