//! Friction utilisation S: how much of the available friction the contact uses, from the distribution of forces over
//! the patch.
//!
//! At the rim of a patch elements slip before the contact as a whole does (incipient slip). Their ratio of tangential
//! to normal force reads the friction coefficient; S compares the whole contact's ratio with it. Unlike `dF_t > dr`
//! this sees an object that is about to slip while every force still stands still (source: ours, prototype).

use super::patch::Patch;
use crate::limits::{FRICTION_CLIP, FRICTION_FLOOR, FRICTION_RELAX_S, TANGENTIAL_FLOOR_N};
use crate::settings::Perception as Settings;

/// Momentary utilisation above which the remembered friction relaxes to F_t/F_n (prototype: 0.955).
const GROSS_UTILISATION: f64 = 0.955;
/// How long it must last, s (prototype: 10 ms).
const GROSS_AFTER_S: f64 = 0.01;
/// Utilisation is clipped here: beyond gross slip it means nothing more.
const UTILISATION_CLIP: f64 = 1.2;
/// Smallest present friction reading that is divided by (prototype: 0.03).
const READING_FLOOR: f64 = 0.03;

/// What the friction estimate says.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Slipping {
    pub(super) utilisation: f64,
    pub(super) utilisation_now: f64,
    pub(super) friction: f64,
    pub(super) gross_s: f64,
    pub(super) error: f64,
}

/// Memory of one contact, from first touch to letting go.
#[derive(Clone, Debug, Default)]
pub(super) struct Friction {
    /// m_raw: low-passed ratio of the most loaded elements.
    reading: f64,
    /// μ̂: largest reading since the first touch.
    remembered: f64,
    /// S_inst: low-passed utilisation against the present reading.
    utilisation_now: f64,
    gross_s: f64,
}

impl Friction {
    pub(super) fn update(&mut self, patch: &Patch, step_s: f64, settings: &Settings) -> Slipping {
        let tangential_n = patch.tangential_n.norm();
        let ratio = tangential_n / patch.normal_n.max(NORMAL_MIN_N);
        let Some(loaded) = most_loaded(patch).filter(|_| tangential_n > TANGENTIAL_FLOOR_N) else {
            self.gross_s = 0.0;
            return Slipping {
                friction: self.remembered,
                ..Slipping::default()
            };
        };
        let share = step_s / (settings.friction_filter_s + step_s);
        self.reading += (loaded.ratio.min(FRICTION_CLIP) - self.reading) * share;
        self.remembered = if self.reading > self.remembered {
            self.reading
        } else {
            self.remembered
        };
        self.utilisation_now +=
            (ratio / self.reading.max(READING_FLOOR) - self.utilisation_now) * share;
        self.watch_gross(ratio, step_s);
        Slipping {
            utilisation: (ratio / self.remembered.max(FRICTION_FLOOR)).min(UTILISATION_CLIP),
            utilisation_now: self.utilisation_now,
            friction: self.remembered,
            gross_s: self.gross_s,
            error: loaded.error,
        }
    }

    /// While everything slides, F_t/F_n itself is the friction: the memory must not insist on more.
    fn watch_gross(&mut self, ratio: f64, step_s: f64) {
        self.gross_s = if self.utilisation_now > GROSS_UTILISATION {
            self.gross_s + step_s
        } else {
            0.0
        };
        if self.gross_s > GROSS_AFTER_S {
            let share = step_s / (FRICTION_RELAX_S + step_s);
            self.remembered += (ratio - self.remembered) * share;
        }
    }
}

/// Smallest normal force that F_t is divided by, N.
const NORMAL_MIN_N: f64 = 0.01;

/// The elements that use most friction.
struct Loaded {
    /// Mean ratio of tangential to normal force, weighted by normal force.
    ratio: f64,
    /// What the sensor's noise adds to the ratio of one of them, standard deviation.
    error: f64,
}

/// The third of the pressed elements (at least two) that use most friction.
fn most_loaded(patch: &Patch) -> Option<Loaded> {
    let mut ratios = patch.ratios;
    let pressed = &mut ratios[..patch.pressed];
    if pressed.len() < 2 {
        return None;
    }
    let top = (pressed.len() / 3).max(2);
    // All ratios are finite: intake refused everything else, and the normal force that divides is above its floor.
    pressed.select_nth_unstable_by(top - 1, |a, b| b.0.total_cmp(&a.0));
    let (weighted, weight) = pressed[..top]
        .iter()
        .fold((0.0, 0.0), |(q, w), &(ratio, n)| (q + ratio * n, w + n));
    Some(Loaded {
        ratio: weighted / weight,
        error: patch.noise_n * top as f64 / weight,
    })
}
