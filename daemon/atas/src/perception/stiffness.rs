//! Stiffness estimate (the paper: hardness), from 100 ms of closing after first touch (paper II.b
//! (1)).
//!
//! The total closing is x = x₀ + 2·(δ(F) + F/k) for two fingertips and two faces of the object. The
//! fingertip compression δ(F) = a·F^p is calibrated on a rigid block. Then x − 2·δ(F) is linear in
//! F, with a least-squares slope of 2/k, independent of the force at which the probe begins.
//!
//! A flat face that meets another at an angle first presses with an edge (not in the paper). While
//! a share s is loaded, more force compresses it by dδ/s, as parallel springs. The object also
//! turns until aligned with the faces, which adds closing. Samples from a much smaller contact area
//! are therefore discarded.

use crate::settings::Perception as Settings;
use robot_model::{Compression, PerSide, Skin};

/// Smallest number of samples of a slope, that of a 30 Hz sensor in 100 ms.
const SAMPLES_MIN: f64 = 3.0;
/// Compressed faces, and fingertips.
const FACES: f64 = 2.0;
/// Growth of the loaded share that starts a new contact, and the samples and confidence that its
/// fit needs (design choice). A rigid object never reaches that confidence, because its compliance
/// is near zero. Instead, an upper bound at this many standard errors must be below the previous
/// compliance.
const CONTACT_GROWTH: f64 = 1.5;
const NEW_SAMPLES_MIN: f64 = 6.0;
const NEW_CONFIDENCE: f64 = 0.9;
const BOUND_ERRORS: f64 = 3.0;
/// Smallest resolvable compliance of one face, m/N (1 MN/m).
const COMPLIANCE_FLOOR_M_N: f64 = 1e-6;

/// Returns the fingertip compression: the calibration, or else the skin data of the robot file.
#[must_use]
pub fn compression(settings: &Settings, skin: &Skin) -> Compression {
    if settings.tip_compression_m > 0.0 {
        Compression {
            at_1n_m: settings.tip_compression_m,
            exponent: settings.tip_exponent,
        }
    } else {
        skin.compression
    }
}

/// Least-squares line of closing over force.
#[derive(Clone, Copy, Debug, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct StiffnessEstimate {
    filtered_closing_m: Option<f64>,
    max_force_n: f64,
    /// δ(F) of both fingertips, and the additional compression from partial contact, m.
    compression_m: f64,
    partial_contact_m: f64,
    /// Smallest loaded area of each side in the present contact.
    min_loaded_area: Option<PerSide<f64>>,
    /// Compliance from the previous contact, m/N; infinite if it gave no fit.
    previous_m_n: Option<f64>,
    sums: Sums,
}

#[derive(Clone, Copy, Debug, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
struct Sums {
    n: f64,
    x: f64,
    y: f64,
    xx: f64,
    xy: f64,
    yy: f64,
}

/// Loaded contact area of one side.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LoadedArea {
    /// Effective number of loaded fingertips.
    pub fingertips: f64,
    /// Loaded share of their faces, above 0.
    pub face_share: f64,
}

impl LoadedArea {
    /// One fingertip with its whole face.
    pub const WHOLE: Self = Self {
        fingertips: 1.0,
        face_share: 1.0,
    };
}

/// Result of the stiffness probe.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct StiffnessFit {
    /// k: stiffness of one face of the object, N/m.
    pub object_n_m: f64,
    /// 1/(1 + ε²), 0 to 1, with ε the relative standard error of the compliance.
    pub confidence: f64,
    /// A new contact has replaced the first.
    pub new_contact: bool,
}

impl StiffnessEstimate {
    /// Adds one frame and returns a refined fit. Only a force above all previous ones adds a
    /// sample.
    ///
    /// Inputs: total closing since first touch, m; mean normal force, N; sensor time since the
    /// previous frame, s; compression of a fingertip; loaded area of each side.
    pub fn add(
        &mut self,
        closing_m: f64,
        normal_n: f64,
        step_s: f64,
        tips: &Compression,
        bearing: PerSide<LoadedArea>,
        settings: &Settings,
    ) -> Option<StiffnessFit> {
        let closing_m = self.delay_closing(closing_m, step_s, settings.filter_s);
        if normal_n <= settings.touch_off_n || normal_n <= self.max_force_n {
            return None;
        }
        self.max_force_n = normal_n;
        let of_side = |it: &LoadedArea| tips.depth_m(normal_n / it.fingertips);
        let tips_m = bearing.iter().map(of_side).sum::<f64>();
        let beyond = bearing.iter().map(|it| 1.0 / it.face_share - 1.0);
        self.partial_contact_m += (tips_m - self.compression_m) * beyond.sum::<f64>() / FACES;
        self.compression_m = tips_m;
        self.detect_new_contact(bearing.map(|it| it.fingertips * it.face_share));
        self.sums
            .add(normal_n, closing_m - tips_m - self.partial_contact_m);
        let line = self.sums.line()?;
        let Some(before_m_n) = self.previous_m_n else {
            return Some(line.fit());
        };
        self.fit_new_contact(&line, before_m_n)
    }

    /// Returns whether a new contact has replaced the first: the object may have turned.
    #[must_use]
    pub fn has_new_contact(&self) -> bool {
        self.previous_m_n.is_some()
    }

    /// Fits a new contact, given the previous compliance, m/N.
    fn fit_new_contact(&self, line: &Line, previous_m_n: f64) -> Option<StiffnessFit> {
        if self.sums.n < NEW_SAMPLES_MIN {
            return None;
        }
        let fit = line.fit();
        let at_most = Line {
            slope_m_n: line.slope_m_n + BOUND_ERRORS * line.error_m_n,
            ..*line
        };
        if fit.confidence >= NEW_CONFIDENCE {
            Some(fit)
        } else {
            (at_most.slope_m_n < previous_m_n).then(|| at_most.fit())
        }
    }

    /// Discards samples from a much smaller loaded area.
    fn detect_new_contact(&mut self, bearing: PerSide<f64>) {
        let least = self.min_loaded_area.unwrap_or(bearing);
        let grows = |(now, least): (&f64, &f64)| *now > CONTACT_GROWTH * least;
        if bearing.iter().zip(&least).any(grows) {
            let line = self.sums.line();
            self.previous_m_n = Some(line.map_or(f64::INFINITY, |line| line.slope_m_n));
            self.sums = Sums::default();
            self.min_loaded_area = Some(bearing);
        } else {
            let smaller = |now, least| if now < least { now } else { least };
            self.min_loaded_area = Some(bearing.zip_map(least, smaller));
        }
    }

    /// Delays the closing by the low-pass of the forces.
    fn delay_closing(&mut self, closing_m: f64, step_s: f64, filter_s: f64) -> f64 {
        let before_m = self.filtered_closing_m.unwrap_or(closing_m);
        let share = if filter_s > 0.0 {
            step_s / (filter_s + step_s)
        } else {
            1.0
        };
        let after_m = before_m + (closing_m - before_m) * share;
        self.filtered_closing_m = Some(after_m);
        after_m
    }
}

impl Sums {
    fn add(&mut self, x: f64, y: f64) {
        self.n += 1.0;
        self.x += x;
        self.y += y;
        self.xx += x * x;
        self.xy += x * y;
        self.yy += y * y;
    }

    fn line(&self) -> Option<Line> {
        let spread_x = self.n * self.xx - self.x * self.x;
        if self.n < SAMPLES_MIN || spread_x <= 0.0 {
            return None;
        }
        let slope = (self.n * self.xy - self.x * self.y) / spread_x;
        let spread_y = self.n * self.yy - self.y * self.y;
        let residual = spread_y - slope * slope * spread_x;
        let variance = if residual > 0.0 {
            residual / spread_x / (self.n - 2.0)
        } else {
            0.0
        };
        Some(Line {
            slope_m_n: slope,
            error_m_n: libm::sqrt(variance),
        })
    }
}

/// Fitted line: slope and its standard error, m/N.
#[derive(Clone, Copy)]
struct Line {
    slope_m_n: f64,
    error_m_n: f64,
}

impl Line {
    fn fit(&self) -> StiffnessFit {
        let floor = FACES * COMPLIANCE_FLOOR_M_N;
        let slope = if self.slope_m_n > floor {
            self.slope_m_n
        } else {
            floor
        };
        let error = self.error_m_n / slope;
        StiffnessFit {
            object_n_m: FACES / slope,
            confidence: 1.0 / (1.0 + error * error),
            new_contact: false,
        }
    }
}
