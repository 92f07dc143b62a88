//! Simulators of many trials at once, on the widest SIMD instructions available. All give identical
//! bits.

use thiserror::Error;

use crate::constants::Constants;
use crate::lanes::{Lanes, portable, stream};
#[cfg(target_arch = "x86_64")]
use crate::lanes::{avx2, avx512, twice::Twice};
use crate::model::{Model, TeamSize};
use crate::obstacle::Obstacles;
use crate::run::run_trial;
use crate::trial::{Outcome, Trial};

/// Simulator of many trials; exists only if the machine has its instructions.
#[derive(Clone, Copy, Debug)]
pub struct Engine(Kind);

#[derive(Clone, Copy, Debug)]
enum Kind {
    Scalar,
    Portable,
    #[cfg(target_arch = "x86_64")]
    Avx2(avx2::Cpu),
    #[cfg(target_arch = "x86_64")]
    Avx512(avx512::Cpu),
}

/// Unavailable engine: requested name, available names.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[error(
    "engine {0:?} not available: this machine has {1}; choose one of these or leave it out to use \
     the fastest"
)]
pub struct EngineError(pub String, pub String);

impl Engine {
    /// Returns the engines of this machine, slowest first, beginning with the scalar reference.
    #[must_use]
    pub fn all() -> Vec<Self> {
        let kinds = [Kind::Scalar, Kind::Portable].into_iter();
        #[cfg(target_arch = "x86_64")]
        let kinds = kinds
            .chain(avx2::Cpu::detect().map(Kind::Avx2))
            .chain(avx512::Cpu::detect().map(Kind::Avx512));
        kinds.map(Self).collect()
    }

    /// Returns the fastest engine.
    #[must_use]
    pub fn fastest() -> Self {
        Self::all().pop().unwrap_or(Self(Kind::Portable))
    }

    /// Returns an engine by name.
    ///
    /// # Errors
    /// This machine has no such engine.
    pub fn named(name: &str) -> Result<Self, EngineError> {
        let all = Self::all();
        let names = || all.iter().map(|e| e.name()).collect::<Vec<_>>().join(", ");
        all.iter()
            .find(|e| e.name() == name)
            .copied()
            .ok_or_else(|| EngineError(name.to_owned(), names()))
    }

    /// Returns `scalar`, `portable`, `avx2` or `avx512`.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self.0 {
            Kind::Scalar => "scalar",
            Kind::Portable => "portable",
            #[cfg(target_arch = "x86_64")]
            Kind::Avx2(_) => "avx2",
            #[cfg(target_arch = "x86_64")]
            Kind::Avx512(_) => "avx512",
        }
    }

    /// Replaces `outcomes` by one outcome per trial, in order.
    pub fn run(self, model: &Model, team: TeamSize, trials: &[Trial], outcomes: &mut Vec<Outcome>) {
        outcomes.clear();
        outcomes.resize(trials.len(), Outcome::default());
        let c = (&model.constants, &model.obstacles);
        match self.0 {
            Kind::Scalar => {
                for (trial, outcome) in trials.iter().zip(outcomes) {
                    *outcome = run_trial(model, team, trial);
                }
            }
            Kind::Portable => run_portable(c, team, trials, outcomes),
            // SAFETY: `cpu` proves that the processor has AVX2.
            #[cfg(target_arch = "x86_64")]
            Kind::Avx2(cpu) => unsafe { run_avx2(cpu, c, team, trials, outcomes) },
            // SAFETY: `cpu` proves that the processor has AVX-512 F and DQ.
            #[cfg(target_arch = "x86_64")]
            Kind::Avx512(cpu) => unsafe { run_avx512(cpu, c, team, trials, outcomes) },
        }
    }
}

type Field<'a> = (&'a Constants, &'a Obstacles);

/// Selects the kernel. A single agent has its own lane type: its frame is one long chain of
/// dependent steps.
macro_rules! for_team {
    ($run:ident, $alone:ty, $together:ty, $team:expr, $cpu:expr, $c:expr, $trials:expr, $outcomes:expr) => {
        match $c.1.is_empty() {
            true => for_team!($run, $alone, $together, $team, false, $cpu, $c, $trials, $outcomes),
            false => for_team!($run, $alone, $together, $team, true, $cpu, $c, $trials, $outcomes),
        }
    };
    ($run:ident, $alone:ty, $together:ty, $team:expr, $walled:literal, $($argument:expr),*) => {
        match $team.get() {
            1 => $run::<$alone, 1, $walled>($($argument),*),
            2 => $run::<$together, 2, $walled>($($argument),*),
            3 => $run::<$together, 3, $walled>($($argument),*),
            _ => $run::<$together, 4, $walled>($($argument),*),
        }
    };
}

fn run_portable(c: Field<'_>, team: TeamSize, trials: &[Trial], outcomes: &mut [Outcome]) {
    use portable::Floats;
    /// Separate functions: inlined together, some kernels are a third slower (measured).
    #[inline(never)]
    fn run<T: Lanes<Cpu = ()>, const N: usize, const WALLED: bool>(
        (): (),
        c: Field<'_>,
        trials: &[Trial],
        outcomes: &mut [Outcome],
    ) {
        stream::run::<T, N, WALLED>((), c, trials, outcomes);
    }
    for_team!(run, Floats, Floats, team, (), c, trials, outcomes);
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2")]
fn run_avx2(
    cpu: avx2::Cpu,
    c: Field<'_>,
    team: TeamSize,
    trials: &[Trial],
    outcomes: &mut [Outcome],
) {
    use avx2::F32x8;
    /// Separate functions, so that each kernel can use all registers.
    #[inline(never)]
    #[target_feature(enable = "avx2")]
    fn run<T: Lanes<Cpu = avx2::Cpu>, const N: usize, const WALLED: bool>(
        cpu: avx2::Cpu,
        c: Field<'_>,
        trials: &[Trial],
        outcomes: &mut [Outcome],
    ) {
        stream::run::<T, N, WALLED>(cpu, c, trials, outcomes);
    }
    for_team!(run, Twice<F32x8>, F32x8, team, cpu, c, trials, outcomes);
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx512f,avx512dq")]
fn run_avx512(
    cpu: avx512::Cpu,
    c: Field<'_>,
    team: TeamSize,
    trials: &[Trial],
    outcomes: &mut [Outcome],
) {
    use avx512::F32x16;
    #[inline(never)]
    #[target_feature(enable = "avx512f,avx512dq")]
    fn run<T: Lanes<Cpu = avx512::Cpu>, const N: usize, const WALLED: bool>(
        cpu: avx512::Cpu,
        c: Field<'_>,
        trials: &[Trial],
        outcomes: &mut [Outcome],
    ) {
        stream::run::<T, N, WALLED>(cpu, c, trials, outcomes);
    }
    for_team!(run, Twice<F32x16>, F32x16, team, cpu, c, trials, outcomes);
}
