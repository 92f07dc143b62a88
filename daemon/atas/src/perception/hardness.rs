//! Hardness: how stiff the object is, from 100 ms of pressing after the first touch (paper II.b (1)).
//!
//! Both fingers close at the approach speed; the least-squares slope of the mean normal force over the total closing is
//! the stiffness of fingertips and object in series. Taking out the fingertips, known from pressing a rigid block with
//! this same pipeline, leaves the object: k_obj = scale / (1/k_est − 1/K_ref).

use crate::settings::Perception as Settings;

/// Fewest samples that make a slope: what a 30 Hz sensor gives within the paper's 100 ms.
const SAMPLES_MIN: f64 = 3.0;
/// Smallest compliance that is told apart from rigid, m/N: 1e-6 reads as 3.6 MN/m, which is rigid.
const COMPLIANCE_FLOOR_M_N: f64 = 1e-6;

/// Running sums of a least-squares line.
#[derive(Clone, Copy, Debug, Default)]
pub struct Hardness {
    n: f64,
    x: f64,
    y: f64,
    xx: f64,
    xy: f64,
    yy: f64,
}

/// What the probe found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HardnessFit {
    /// k_est: slope of mean F_n over total closing, N/m.
    pub slope_n_m: f64,
    /// k_obj: stiffness of the object, N/m.
    pub object_n_m: f64,
    /// How far the figure may be trusted, 0 to 1: the share of the force's variance that the line explains.
    pub confidence: f64,
}

impl Hardness {
    /// Takes in one frame's mean normal force, N, at a total closing since first touch, m.
    pub fn add(&mut self, closing_m: f64, normal_n: f64) {
        self.n += 1.0;
        self.x += closing_m;
        self.y += normal_n;
        self.xx += closing_m * closing_m;
        self.xy += closing_m * normal_n;
        self.yy += normal_n * normal_n;
    }

    /// The fit; `None` when there are too few samples or nothing moved.
    #[must_use]
    pub fn fit(&self, settings: &Settings) -> Option<HardnessFit> {
        let spread_x = self.n * self.xx - self.x * self.x;
        let spread_y = self.n * self.yy - self.y * self.y;
        if self.n < SAMPLES_MIN || spread_x <= 0.0 || spread_y <= 0.0 {
            return None;
        }
        let common = self.n * self.xy - self.x * self.y;
        let slope_n_m = common / spread_x;
        if slope_n_m <= 0.0 {
            return None;
        }
        let compliance = 1.0 / slope_n_m - 1.0 / settings.hardness_reference_n_m;
        let compliance = if compliance > COMPLIANCE_FLOOR_M_N {
            compliance
        } else {
            COMPLIANCE_FLOOR_M_N
        };
        Some(HardnessFit {
            slope_n_m,
            object_n_m: settings.hardness_scale / compliance,
            confidence: common * common / (spread_x * spread_y),
        })
    }
}
