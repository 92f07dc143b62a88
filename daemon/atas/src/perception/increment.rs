//! dF_t: change of the tangential force vector within the last W seconds (paper II.b (1):
//! "tangential force increment dF_t").
//!
//! Computed per frame over a window; single-sample differences are noise on real sensors.

use crate::intake::ValidatedFrame;
use crate::limits::INCREMENT_SAMPLES;
use nalgebra::Vector3;

/// Ring buffer of past tangential forces, thinned out to span the window.
#[derive(Clone, Copy, Debug)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Increment {
    #[cfg_attr(feature = "serde", serde(with = "serde_big_array::BigArray"))]
    samples: [(u64, Vector3<f64>); INCREMENT_SAMPLES],
    newest: usize,
    count: usize,
}

impl Default for Increment {
    fn default() -> Self {
        Self {
            samples: [(0, Vector3::zeros()); INCREMENT_SAMPLES],
            newest: 0,
            count: 0,
        }
    }
}

impl Increment {
    /// Magnitude of the change since the oldest sample of the window, N; 0 without one.
    pub(super) fn update(
        &mut self,
        tangential_n: &Vector3<f64>,
        frame: &ValidatedFrame<'_>,
        window_s: f64,
    ) -> f64 {
        let now_ns = frame.captured_ns();
        let window_ns = (window_s * 1e9) as u64;
        self.discard_before(now_ns.saturating_sub(window_ns));
        let change = self
            .oldest()
            .map_or(0.0, |past| (tangential_n - past).norm());
        let spacing_ns = window_ns / INCREMENT_SAMPLES as u64;
        if self.count == 0 || now_ns >= self.samples[self.newest].0 + spacing_ns {
            self.newest = (self.newest + 1) % INCREMENT_SAMPLES;
            self.samples[self.newest] = (now_ns, *tangential_n);
            self.count = (self.count + 1).min(INCREMENT_SAMPLES);
        }
        change
    }

    fn oldest_index(&self) -> usize {
        (self.newest + INCREMENT_SAMPLES + 1 - self.count) % INCREMENT_SAMPLES
    }

    fn oldest(&self) -> Option<Vector3<f64>> {
        (self.count > 0).then(|| self.samples[self.oldest_index()].1)
    }

    fn discard_before(&mut self, before_ns: u64) {
        while self.count > 1 && self.samples[self.oldest_index()].0 < before_ns {
            self.count -= 1;
        }
    }
}
