//! Friction utilisation S: how much of the available friction the contact uses, from the distribution of forces over
//! the patch.
//!
//! At the rim of a patch elements slip before the contact as a whole does (incipient slip). Their ratio of tangential
//! to normal force reads the friction coefficient; S compares the whole contact's ratio with it. Unlike `dF_t > dr`
//! this sees an object that is about to slip while every force still stands still (source: ours, prototype). Both are
//! summed along the way that the patch is sheared, torsion included: what noise and crosstalk mix in is then as often
//! less as more. What was seen to slide by other evidence corrects the estimate for as long as the contact lasts.
//!
//! Only a face that is round both ways shows incipient slip whatever it touches. A flat one presses evenly, or with an edge where it
//! is not quite parallel; a cylinder presses along a line; a single element has no pattern at all. Of these nothing is known of
//! friction until other evidence has told at which ratio the object slid (read from the pattern all the same, flat pads refused 11
//! to 20 % of what they can hold, and cylinders 17 to 25 %).

use super::patch::Patch;
use crate::filter::low_pass;
use crate::limits::{
    FRICTION_CLIP, FRICTION_FLOOR, FRICTION_RELAX_S, NORMAL_MIN_N, TANGENTIAL_FLOOR_N,
};
use crate::settings::Perception as Settings;
use shm_schemas::capacity::ELEMENTS;

/// Momentary utilisation above which the remembered friction relaxes to F_t/F_n (prototype: 0.955).
const GROSS_UTILISATION: f64 = 0.955;
/// How long it must last, s (prototype: 10 ms).
const GROSS_AFTER_S: f64 = 0.01;
/// Utilisation is clipped here: beyond gross slip it means nothing more.
const UTILISATION_CLIP: f64 = 1.2;
/// Smallest present friction reading that is divided by (prototype: 0.03).
const READING_FLOOR: f64 = 0.03;
/// Time constant with which the largest ratio of late is forgotten, s (ours: a slide is noticed within it).
const LATELY_S: f64 = 0.3;
/// Momentary utilisation below which a bout of gross slip has ended (ours: well below what begins one).
const GROSS_OVER: f64 = 0.9;
/// Share of the largest F_t/F_n of a bout below which what slid sticks (ours: once a patch is sheared alike all over it bears what kinetic
/// friction does, and that scatters by less).
const SLIDING_SHARE: f64 = 0.96;
/// Time constant over which that ratio is felt, s (ours: a few frames of noise).
const FELT_S: f64 = 0.03;

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
#[derive(Clone, Copy, Debug, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Friction {
    /// μ̂: largest reading since the first touch.
    remembered: f64,
    /// S_inst: low-passed utilisation against the present reading.
    utilisation_now: f64,
    gross_s: f64,
    /// F_t/F_n, low-passed, and the largest of it since the patch was first sheared alike all over in this bout; 0 between bouts.
    felt: f64,
    slid_from: f64,
    /// Largest F_t/F_n of late.
    lately: f64,
    /// F_t/F_n at which the object was seen to slide, if it was: there is no more friction than that.
    slid_at: Option<f64>,
}

impl Friction {
    /// `steady` makes the patch as it was over the friction filter: the elements that use most friction are chosen from it, so that
    /// noise does not choose them. It is not asked for before the patch is sheared. `slides` tells of an object that was seen to slide by other evidence.
    pub(super) fn update(
        &mut self,
        patch: &Patch,
        is_round: bool,
        steady: impl FnOnce() -> Patch,
        slides: bool,
        step_s: f64,
        settings: &Settings,
    ) -> Slipping {
        let (tangential_n, normal_n) = patch
            .elements
            .iter()
            .fold((0.0, NORMAL_MIN_N), |(t, n), e| {
                (t + e.along_n, n + e.normal_n)
            });
        let ratio = tangential_n / normal_n;
        let is_sheared = tangential_n > TANGENTIAL_FLOOR_N;
        if !is_round {
            self.gross_s = 0.0;
            self.remember_slide(ratio, slides, step_s, settings);
            return self.known_from_slides(ratio);
        }
        let Some(loaded) = is_sheared.then(steady).as_ref().and_then(most_loaded) else {
            self.gross_s = 0.0;
            return Slipping {
                friction: self.remembered,
                ..Slipping::default()
            };
        };
        let share = step_s / (settings.friction_filter_s + step_s);
        // m_raw: the ratio of the most loaded elements, low-passed because they are.
        let reading = loaded.ratio.min(FRICTION_CLIP);
        self.remembered = if reading > self.remembered {
            reading
        } else {
            self.remembered
        };
        self.utilisation_now += (ratio / reading.max(READING_FLOOR) - self.utilisation_now) * share;
        self.watch_gross(ratio, step_s);
        self.remember_slide(ratio, slides, step_s, settings);
        Slipping {
            utilisation: (ratio / self.remembered.max(FRICTION_FLOOR)).min(UTILISATION_CLIP),
            utilisation_now: self.utilisation_now,
            friction: self.remembered,
            gross_s: self.gross_s,
            error: loaded.error,
        }
    }

    /// What can be said without the pattern of forces.
    fn known_from_slides(&self, ratio: f64) -> Slipping {
        let Some(slid_at) = self.slid_at else {
            return Slipping::default();
        };
        let utilisation = (ratio / slid_at.max(FRICTION_FLOOR)).min(UTILISATION_CLIP);
        Slipping {
            utilisation,
            utilisation_now: utilisation,
            friction: slid_at,
            ..Slipping::default()
        }
    }

    /// Evidence that needs no friction estimate corrects the estimate for as long as the contact lasts.
    fn remember_slide(&mut self, ratio: f64, slides: bool, step_s: f64, settings: &Settings) {
        let filter_s = if ratio > self.lately {
            settings.friction_filter_s
        } else {
            LATELY_S
        };
        self.lately = low_pass(self.lately, ratio, step_s, filter_s);
        if slides {
            self.slid_at = Some(self.slid_at.unwrap_or(f64::INFINITY).min(self.lately));
        }
        if let Some(slid_at) = self.slid_at.filter(|slid_at| *slid_at < self.remembered) {
            self.remembered = slid_at;
        }
    }

    /// While everything slides, F_t/F_n itself is the friction: the memory must not insist on more. A patch that was sheared alike all
    /// over stays so when it sticks again, until it is loaded anew: only while it bears as much for its pressing as when it slid, does it
    /// slide.
    fn watch_gross(&mut self, ratio: f64, step_s: f64) {
        self.felt = low_pass(self.felt, ratio, step_s, FELT_S);
        let alike = self.utilisation_now > GROSS_UTILISATION;
        if self.utilisation_now < GROSS_OVER {
            self.slid_from = 0.0;
        } else if alike && self.felt > self.slid_from {
            self.slid_from = self.felt;
        }
        self.gross_s = if alike && self.felt > SLIDING_SHARE * self.slid_from {
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

/// The elements that use most friction.
struct Loaded {
    /// Mean ratio of tangential to normal force, weighted by normal force.
    ratio: f64,
    /// What the sensor's noise adds to the ratio of one of them, standard deviation.
    error: f64,
}

/// The third of the pressed elements (at least two) that use most friction.
fn most_loaded(patch: &Patch) -> Option<Loaded> {
    let mut ratios = [(0.0, 0.0); ELEMENTS];
    for (ratio, element) in ratios.iter_mut().zip(&patch.elements) {
        *ratio = (element.along_n / element.normal_n, element.normal_n);
    }
    let pressed = &mut ratios[..patch.elements.len()];
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
        error: patch.noise_n * libm::sqrt(top as f64) / weight,
    })
}
