//! Simulators of many trials at once, on the widest SIMD instructions available. All give identical
//! bits.

use crate::kernel;
use crate::trial::{Interface, Outcome, Trial};

/// Simulator of many trials; exists only if the machine has its instructions.
#[derive(Clone, Copy, Debug)]
pub struct Engine(Kind);

#[derive(Clone, Copy, Debug)]
enum Kind {
    /// One trial at a time.
    Scalar,
    Portable,
    #[cfg(target_arch = "x86_64")]
    Avx2,
    #[cfg(target_arch = "x86_64")]
    Avx512,
}

impl Engine {
    /// Returns the engines of this machine, slowest first, beginning with the scalar reference.
    #[must_use]
    pub fn all() -> Vec<Self> {
        let kinds = [Kind::Scalar, Kind::Portable].into_iter();
        #[cfg(target_arch = "x86_64")]
        let kinds = {
            let has_avx2 = is_x86_feature_detected!("avx2");
            let has_avx512 =
                is_x86_feature_detected!("avx512f") && is_x86_feature_detected!("avx512dq");
            kinds
                .chain(has_avx2.then_some(Kind::Avx2))
                .chain(has_avx512.then_some(Kind::Avx512))
        };
        kinds.map(Self).collect()
    }

    /// Returns the fastest engine.
    #[must_use]
    pub fn fastest() -> Self {
        Self::all().pop().unwrap_or(Self(Kind::Portable))
    }

    /// Returns the name.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self.0 {
            Kind::Scalar => "scalar",
            Kind::Portable => "portable",
            #[cfg(target_arch = "x86_64")]
            Kind::Avx2 => "avx2",
            #[cfg(target_arch = "x86_64")]
            Kind::Avx512 => "avx512",
        }
    }

    /// Returns the number of parallel trials.
    #[must_use]
    pub fn width(self) -> usize {
        match self.0 {
            Kind::Scalar => 1,
            Kind::Portable => 4,
            #[cfg(target_arch = "x86_64")]
            Kind::Avx2 => 8,
            #[cfg(target_arch = "x86_64")]
            Kind::Avx512 => 16,
        }
    }

    /// Replaces `outcomes` by one outcome per trial, in order.
    pub fn run(self, interface: &Interface<'_>, trials: &[Trial], outcomes: &mut Vec<Outcome>) {
        outcomes.resize(trials.len(), Outcome::NONE);
        let width = self.width();
        for (trials, outcomes) in trials.chunks(width).zip(outcomes.chunks_mut(width)) {
            match self.0 {
                Kind::Scalar => kernel::run::<1>(interface, trials, outcomes),
                Kind::Portable => kernel::run::<4>(interface, trials, outcomes),
                // SAFETY: this kind exists only if AVX2 was detected.
                #[cfg(target_arch = "x86_64")]
                Kind::Avx2 => unsafe { run_avx2(interface, trials, outcomes) },
                // SAFETY: this kind exists only if AVX-512 was detected.
                #[cfg(target_arch = "x86_64")]
                Kind::Avx512 => unsafe { run_avx512(interface, trials, outcomes) },
            }
        }
    }
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2")]
fn run_avx2(interface: &Interface<'_>, trials: &[Trial], outcomes: &mut [Outcome]) {
    kernel::run::<8>(interface, trials, outcomes);
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx512f,avx512dq")]
fn run_avx512(interface: &Interface<'_>, trials: &[Trial], outcomes: &mut [Outcome]) {
    kernel::run::<16>(interface, trials, outcomes);
}
