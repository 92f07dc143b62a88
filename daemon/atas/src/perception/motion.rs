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

use super::lanes::{LANES, LANES_MASK};
use crate::intake::ValidatedFrame;
use crate::settings::Perception as Settings;
use shm_schemas::capacity::ELEMENTS;
use wide::f32x4;

/// The twelve values of four consecutive elements.
type Group = [f32x4; 3];
/// Values of one fingertip; 0 beyond the last element.
type Values = [Group; ELEMENTS / LANES];
/// Stored half windows: two windows.
const HALVES: usize = 4;
/// Comparisons in the share (design choice: 1.2 s for a window of 0.15 s).
const COMPARISONS: u32 = 16;
/// Averaging time of the noise, s (design choice: long against a window, short against sensor
/// warm-up).
const NOISE_S: f64 = 1.0;

/// Values without a reading.
const NONE: Values = [[f32x4::ZERO; 3]; ELEMENTS / LANES];

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
    sums: [Values; HALVES],
    frames: [u32; HALVES],
    newest: usize,
    covered_s: f64,
    /// Readings of the previous frame, N.
    #[cfg_attr(feature = "serde", serde(with = "serde_big_array::BigArray"))]
    previous: Values,
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
            sums: [NONE; HALVES],
            frames: [0; HALVES],
            newest: 0,
            covered_s: 0.0,
            previous: NONE,
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
        let (groups, step_s) = (count.div_ceil(LANES), frame.step_s());
        let change_n2 = self.add(groups, frame.readings_n(finger));
        self.update_noise(change_n2, step_s);
        self.frames[self.newest] += 1;
        self.covered_s += step_s;
        // A frame belongs to the window that contains most of its time.
        if self.covered_s + 0.5 * step_s >= 0.5 * settings.motion_window_s {
            self.end_half_window(groups, settings.motion_at);
        }
        self.percept
    }

    /// Adds the values of a frame to the newest half window; missing elements keep their previous
    /// reading. Returns the sum of the squared changes since the previous frame, N².
    fn add(&mut self, groups: usize, (readings, mask): (&[[f32; 3]; ELEMENTS], u64)) -> f32 {
        let (readings, _) = readings.as_chunks::<LANES>();
        let sums = &mut self.sums[self.newest][..groups];
        let previous = &mut self.previous[..groups];
        let mut squares = f32x4::ZERO;
        for (index, (sums, previous)) in sums.iter_mut().zip(previous).enumerate() {
            let now = values(&readings[index], mask >> (LANES * index), previous);
            for axis in 0..3 {
                let change = now[axis] - previous[axis];
                squares += change * change;
                sums[axis] += now[axis];
            }
            *previous = now;
        }
        sum(squares)
    }

    /// Updates the noise: half the mean square difference is the variance of white noise.
    fn update_noise(&mut self, change_n2: f32, step_s: f64) {
        if !self.has_begun {
            self.has_begun = true;
            return;
        }
        self.noise_s += step_s;
        let share = step_s / self.noise_s.clamp(1e-9, NOISE_S);
        self.noise_n2 += (0.5 * f64::from(change_n2) - self.noise_n2) * share.min(1.0);
    }

    /// Ends a half window and compares the two newest with the two oldest.
    fn end_half_window(&mut self, groups: usize, motion_at: f64) {
        let half = |age: usize| (self.newest + HALVES - age) % HALVES;
        let [a, b, c, d] = [half(0), half(1), half(2), half(3)];
        if self.frames[d] > 0 {
            let (late, early) = (
                self.frames[a] + self.frames[b],
                self.frames[c] + self.frames[d],
            );
            let (late, early) = (1.0 / late as f32, 1.0 / early as f32);
            let [a, b, c, d] = [a, b, c, d].map(|half| &self.sums[half]);
            let mut squares = f32x4::ZERO;
            for (group, axis) in (0..groups).flat_map(|group| (0..3).map(move |axis| (group, axis)))
            {
                let late_n = (a[group][axis] + b[group][axis]) * f32x4::splat(late);
                let early_n = (c[group][axis] + d[group][axis]) * f32x4::splat(early);
                squares += (late_n - early_n) * (late_n - early_n);
            }
            let moved_n2 = sum(squares);
            let expected_n2 = self.noise_n2 * f64::from(late + early);
            self.compare(f64::from(moved_n2), expected_n2, motion_at);
        }
        self.newest = (self.newest + 1) % HALVES;
        self.sums[self.newest] = NONE;
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

/// Returns the values of four elements; those whose bit in `mask` is 0 keep their previous ones.
#[inline(always)]
fn values(readings: &[[f32; 3]; LANES], mask: u64, previous: &Group) -> Group {
    let mut values = *readings;
    if mask & LANES_MASK != LANES_MASK {
        let previous = previous.map(f32x4::to_array);
        for (element, values) in values.iter_mut().enumerate() {
            if mask >> element & 1 == 0 {
                let first = 3 * element;
                *values = core::array::from_fn(|axis| {
                    previous[(first + axis) / LANES][(first + axis) % LANES]
                });
            }
        }
    }
    let [[a, b, c], [d, e, f], [g, h, i], [j, k, l]] = values;
    [
        f32x4::new([a, b, c, d]),
        f32x4::new([e, f, g, h]),
        f32x4::new([i, j, k, l]),
    ]
}

/// Sums the lanes in one fixed order: the same bits on every machine.
fn sum(lanes: f32x4) -> f32 {
    let [a, b, c, d] = lanes.to_array();
    (a + c) + (b + d)
}
