//! Motion: persistence of changes in the readings, a sign of slip on real sensors.
//!
//! On real fingertips, dF_t > dr gives false alarms: skin creeps and objects settle, so stable
//! contacts also change now and then. Slip changes readings *most of the time*. The means of two
//! adjacent windows are compared by element, relative to the noise. The share of recent comparisons
//! above a threshold is the persistence. Offsets, units and element meaning have no effect. It
//! works for single elements and for skins without force calibration, where friction cannot be
//! estimated.
//!
//! Delay: one window plus most of the counted comparisons (`motion_window_s`, `motion_at`).

use crate::intake::ValidatedFrame;
use crate::settings::Perception as Settings;
use shm_schemas::capacity::ELEMENTS;

/// Values of one fingertip.
const VALUES: usize = ELEMENTS * 3;
/// Stored half windows: two windows.
const HALVES: usize = 4;
/// Comparisons in the share (design choice: 1.2 s for a window of 0.15 s).
const COMPARISONS: u32 = 16;
/// Averaging time of the noise, s (design choice: long against a window, short against sensor
/// warm-up).
const NOISE_S: f64 = 1.0;

/// Result of the window comparison.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct MotionPercept {
    /// Change between windows in multiples of that from noise; 0 before two windows and without
    /// noise.
    pub level: f64,
    /// Share of the last 16 comparisons above `motion_at`.
    pub share: f64,
    /// Comparisons since the start.
    pub comparisons: u32,
}

#[derive(Clone, Copy, Debug)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Motion {
    /// Sums over half windows, N; `sums[newest]` is being filled.
    #[cfg_attr(feature = "serde", serde(with = "crate::serde_arrays::nested"))]
    sums: [[f32; VALUES]; HALVES],
    frames: [u32; HALVES],
    newest: usize,
    covered_s: f64,
    /// Readings of the previous frame, N.
    #[cfg_attr(feature = "serde", serde(with = "serde_big_array::BigArray"))]
    previous: [f32; VALUES],
    /// Sum of the variances of all values, N², from frame differences.
    noise_n2: f64,
    noise_s: f64,
    has_begun: bool,
    recent: u16,
    percept: MotionPercept,
}

impl Default for Motion {
    fn default() -> Self {
        Self {
            sums: [[0.0; VALUES]; HALVES],
            frames: [0; HALVES],
            newest: 0,
            covered_s: 0.0,
            previous: [0.0; VALUES],
            noise_n2: 0.0,
            noise_s: 0.0,
            has_begun: false,
            recent: 0,
            percept: MotionPercept::default(),
        }
    }
}

impl Motion {
    /// Adds one unfiltered frame: a low-pass would reduce the measured noise.
    pub(super) fn update(
        &mut self,
        finger: usize,
        count: usize,
        frame: &ValidatedFrame<'_>,
        settings: &Settings,
    ) -> MotionPercept {
        let mut now = self.previous;
        let (readings, mask) = frame.readings_n(finger);
        for (element, reading) in readings.iter().enumerate().take(count) {
            // Missing elements keep their previous reading.
            if mask >> element & 1 == 1 {
                now[3 * element..3 * element + 3].copy_from_slice(reading);
            }
        }
        let step_s = frame.step_s();
        self.update_noise(&now[..3 * count], step_s);
        let sum = &mut self.sums[self.newest];
        for (sum, value) in sum.iter_mut().zip(&now[..3 * count]) {
            *sum += value;
        }
        self.frames[self.newest] += 1;
        self.covered_s += step_s;
        self.previous = now;
        // A frame belongs to the window that contains most of its time.
        if self.covered_s + 0.5 * step_s >= 0.5 * settings.motion_window_s {
            self.end_half_window(3 * count, settings.motion_at);
        }
        self.percept
    }

    /// Updates the noise: half the mean square difference is the variance of white noise.
    fn update_noise(&mut self, now: &[f32], step_s: f64) {
        if !self.has_begun {
            self.has_begun = true;
            return;
        }
        let sum: f32 = now
            .iter()
            .zip(&self.previous)
            .map(|(now, before)| (now - before) * (now - before))
            .sum();
        self.noise_s += step_s;
        let share = step_s / self.noise_s.clamp(1e-9, NOISE_S);
        self.noise_n2 += (0.5 * f64::from(sum) - self.noise_n2) * share.min(1.0);
    }

    /// Ends a half window and compares the two newest with the two oldest.
    fn end_half_window(&mut self, values: usize, motion_at: f64) {
        let half = |age: usize| (self.newest + HALVES - age) % HALVES;
        let [a, b, c, d] = [half(0), half(1), half(2), half(3)];
        if self.frames[d] > 0 {
            let (late, early) = (
                self.frames[a] + self.frames[b],
                self.frames[c] + self.frames[d],
            );
            let (late, early) = (1.0 / late as f32, 1.0 / early as f32);
            let moved_n2: f32 = (0..values)
                .map(|value| {
                    let sums = &self.sums;
                    let change = (sums[a][value] + sums[b][value]) * late
                        - (sums[c][value] + sums[d][value]) * early;
                    change * change
                })
                .sum();
            let expected_n2 = self.noise_n2 * f64::from(late + early);
            self.compare(f64::from(moved_n2), expected_n2, motion_at);
        }
        self.newest = (self.newest + 1) % HALVES;
        self.sums[self.newest] = [0.0; VALUES];
        self.frames[self.newest] = 0;
        self.covered_s = 0.0;
    }

    fn compare(&mut self, moved_n2: f64, expected_n2: f64, motion_at: f64) {
        let percept = &mut self.percept;
        percept.level = if expected_n2 > 0.0 {
            libm::sqrt(moved_n2 / expected_n2)
        } else {
            0.0
        };
        percept.comparisons = percept.comparisons.saturating_add(1);
        self.recent = self.recent << 1 | u16::from(percept.level > motion_at);
        let of = percept.comparisons.min(COMPARISONS);
        percept.share = f64::from(self.recent.count_ones()) / f64::from(of);
    }
}
