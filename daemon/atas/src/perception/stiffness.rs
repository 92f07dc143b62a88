//! StiffnessEstimate: how stiff the object is, from 100 ms of pressing after the first touch (paper II.b (1)).
//!
//! While both fingers close, the total closing is x = x₀ + 2·(δ(F) + F/k): two fingertips, whose compression
//! δ(F) = a·F^p is known from pressing a rigid block, and two faces of the object. Taking the fingertips out leaves a
//! straight line of x − 2·δ(F) over F, whose least-squares slope is 2/k. Unlike the slope of F over x it does not depend
//! on the force at which the probe began.
//!
//! A flat face that meets another at an angle presses with an edge first (what follows is ours). While only a share s of it
//! presses, more force compresses it by dδ/s, as parallel springs; and the object turns until it lies against the faces,
//! which closes the fingers as if it gave way. So what was learnt while much less of the faces pressed is forgotten.

use crate::settings::Perception as Settings;
use robot_model::{Compression, Skin, VIRTUAL_FINGERS};

/// Fewest samples that make a slope: what a 30 Hz sensor gives within the paper's 100 ms.
const SAMPLES_MIN: f64 = 3.0;
/// Faces, and fingertips, that the total closing compresses.
const FACES: f64 = 2.0;
/// Growth of the share that presses by which a contact is another one, and what an answer of the new one needs instead of the
/// old one's: the fewest samples, and confidence (ours). Of a rigid object, whose compliance is nearly nothing, that is never
/// certain; but that it is certainly less than the old one's is, this many standard errors above what was found (ours).
const CONTACT_GROWTH: f64 = 1.5;
const NEW_SAMPLES_MIN: f64 = 6.0;
const NEW_CONFIDENCE: f64 = 0.9;
const CERTAIN_ERRORS: f64 = 3.0;
/// Smallest compliance of one face that is told apart from rigid, m/N (1 MN/m).
const COMPLIANCE_FLOOR_M_N: f64 = 1e-6;

/// How the fingertips give way: as they were calibrated, else as the robot file says of their skin.
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

/// Running sums of a least-squares line of closing over force.
#[derive(Clone, Copy, Debug, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct StiffnessEstimate {
    filtered_closing_m: Option<f64>,
    hardest_n: f64,
    /// δ(F) of both fingertips, m, and by how much more they gave way because parts of them pressed.
    tips_m: f64,
    beyond_m: f64,
    /// Least of each side that has pressed in the present contact: fingertips times the share of their faces.
    least_bearing: Option<[f64; VIRTUAL_FINGERS]>,
    /// Compliance that the contact before this one showed, m/N, if there was one: infinite if it showed none.
    before_m_n: Option<f64>,
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

/// What of one side bears its force.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bearing {
    /// How many fingertips do, counted by how evenly.
    pub tips: f64,
    /// Share of their faces that presses, above 0.
    pub face_share: f64,
}

impl Bearing {
    /// One fingertip, with its whole face.
    pub const WHOLE: Self = Self {
        tips: 1.0,
        face_share: 1.0,
    };
}

/// What the probe found.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct StiffnessFit {
    /// k: stiffness of one face of the object, N/m.
    pub object_n_m: f64,
    /// How far the figure may be trusted, 0 to 1: 1/(1 + ε²) with ε the relative standard error of the compliance.
    pub confidence: f64,
    /// See [`StiffnessEstimate::has_settled`].
    pub settled: bool,
}

impl StiffnessEstimate {
    /// Takes in one frame: the total closing since first touch, m, the mean normal force, N, and the sensor time since
    /// the frame before, s, of fingertips that each give way like `tips`, of which on each side so much bears the force. Only a
    /// force beyond every force before is new; it gives a refined fit, if there is one.
    pub fn add(
        &mut self,
        closing_m: f64,
        normal_n: f64,
        step_s: f64,
        tips: &Compression,
        bearing: [Bearing; VIRTUAL_FINGERS],
        settings: &Settings,
    ) -> Option<StiffnessFit> {
        let closing_m = self.delayed(closing_m, step_s, settings.filter_s);
        if normal_n <= settings.touch_off_n || normal_n <= self.hardest_n {
            return None;
        }
        self.hardest_n = normal_n;
        let of_side = |it: &Bearing| tips.at_1n_m * libm::pow(normal_n / it.tips, tips.exponent);
        let tips_m = bearing.iter().map(of_side).sum::<f64>();
        let beyond = bearing.iter().map(|it| 1.0 / it.face_share - 1.0);
        self.beyond_m += (tips_m - self.tips_m) * beyond.sum::<f64>() / FACES;
        self.tips_m = tips_m;
        self.meet(bearing.map(|it| it.tips * it.face_share));
        self.sums.add(normal_n, closing_m - tips_m - self.beyond_m);
        let line = self.sums.line()?;
        let Some(before_m_n) = self.before_m_n else {
            return Some(line.fit());
        };
        self.of_new_contact(&line, before_m_n)
    }

    /// Whether the contact became another one: the object may have turned against the fingertips.
    #[must_use]
    pub fn has_settled(&self) -> bool {
        self.before_m_n.is_some()
    }

    /// What is certain of a contact that took the place of one with this compliance, m/N.
    fn of_new_contact(&self, line: &Line, before_m_n: f64) -> Option<StiffnessFit> {
        if self.sums.n < NEW_SAMPLES_MIN {
            return None;
        }
        let fit = line.fit();
        let at_most = Line {
            slope_m_n: line.slope_m_n + CERTAIN_ERRORS * line.error_m_n,
            ..*line
        };
        if fit.confidence >= NEW_CONFIDENCE {
            Some(fit)
        } else {
            (at_most.slope_m_n < before_m_n).then(|| at_most.fit())
        }
    }

    /// Forgets what was learnt while much less of a side pressed: of its faces, or of its fingertips.
    fn meet(&mut self, bearing: [f64; VIRTUAL_FINGERS]) {
        let least = self.least_bearing.unwrap_or(bearing);
        let grows = |(now, least): (&f64, &f64)| *now > CONTACT_GROWTH * least;
        if bearing.iter().zip(&least).any(grows) {
            let line = self.sums.line();
            self.before_m_n = Some(line.map_or(f64::INFINITY, |line| line.slope_m_n));
            self.sums = Sums::default();
            self.least_bearing = Some(bearing);
        } else {
            let less = |side: usize| {
                if bearing[side] < least[side] {
                    bearing[side]
                } else {
                    least[side]
                }
            };
            self.least_bearing = Some(core::array::from_fn(less));
        }
    }

    /// The forces come through a low-pass; the closing must be as late as they are.
    fn delayed(&mut self, closing_m: f64, step_s: f64, filter_s: f64) -> f64 {
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

    /// The line of closing over force; `None` when there are too few samples or the force did not change.
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

/// The line that fits best: its slope, and the standard error of that, m/N.
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
            settled: false,
        }
    }
}
