//! Many trials at once, on the widest instructions that this machine has. Every engine gives the same bits.

use crate::kernel;
use crate::trial::{Interface, Outcome, Trial};

/// A simulator of many trials. It exists only where its instructions do.
#[derive(Clone, Copy, Debug)]
pub struct Engine(Kind);

#[derive(Clone, Copy, Debug)]
enum Kind {
    /// One trial at a time: the reference.
    Scalar,
    Portable,
    #[cfg(target_arch = "x86_64")]
    Avx2,
    #[cfg(target_arch = "x86_64")]
    Avx512,
}

impl Engine {
    /// Every engine of this machine, slowest first; the first is the scalar reference.
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

    /// The fastest engine of this machine.
    #[must_use]
    pub fn fastest() -> Self {
        Self::all().pop().unwrap_or(Self(Kind::Portable))
    }

    /// Its name.
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

    /// Trials side by side.
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

    /// Simulates every trial to its end; `outcomes` holds one per trial afterwards.
    pub fn run(self, interface: &Interface<'_>, trials: &[Trial], outcomes: &mut Vec<Outcome>) {
        outcomes.resize(trials.len(), Outcome::NONE);
        let width = self.width();
        for (trials, outcomes) in trials.chunks(width).zip(outcomes.chunks_mut(width)) {
            match self.0 {
                Kind::Scalar => kernel::run::<1>(interface, trials, outcomes),
                Kind::Portable => kernel::run::<4>(interface, trials, outcomes),
                // SAFETY: an engine of this kind exists only where AVX2 was detected.
                #[cfg(target_arch = "x86_64")]
                Kind::Avx2 => unsafe { run_avx2(interface, trials, outcomes) },
                // SAFETY: an engine of this kind exists only where AVX-512 was detected.
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
