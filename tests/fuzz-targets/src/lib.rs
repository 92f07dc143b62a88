//! Fuzz targets: one pure function per reader of foreign bytes.
//!
//! ```text
//!  seeds ─▶ mutate ─▶ input ─▶ target ─▶ reader of the product     run: ordinary tests, atas-fuzz
//!  libFuzzer (tests/fuzz/) ─▶ input ─▶ the same targets            guided by coverage
//! ```
//!
//! * **In:** bytes. **Out:** nothing; a broken promise of the reader is a panic.
//! * **Invariants:** a target keeps nothing of an input, so an execution can be repeated alone.
//!   Code generates its seeds. A target for checksummed data repairs the checksum for a part of
//!   the inputs, because mutations would not pass it otherwise.
//! * **Failures:** a panic, also of an arithmetic overflow; more memory than
//!   [`Target::memory_max`]; with the command also [`run::SLOW_NS`] of processor time for one
//!   input.
//!
//! A new reader needs a function and an entry in a list `TARGETS`, and a file in
//! `tests/fuzz/fuzz_targets/`.
#![forbid(unsafe_code)]

mod bus;
mod files;
pub mod input;
mod mutate;
mod random;
mod recording;
mod requests;
pub mod run;
mod sensors;
mod servos;
mod target;

pub use mutate::mutated;
pub use random::Random;
pub use target::Target;

/// Returns all targets.
pub fn targets() -> impl Iterator<Item = Target> {
    let bus = bus::TARGETS.into_iter().chain(files::TARGETS);
    let devices = sensors::TARGETS.into_iter().chain(servos::TARGETS);
    let others = recording::TARGETS.into_iter().chain(requests::TARGETS);
    bus.chain(devices).chain(others)
}

/// Returns the target with this name.
#[must_use]
pub fn find(name: &str) -> Option<Target> {
    targets().find(|target| target.name == name)
}

/// Runs the target with this name on one input; for coverage-guided fuzzing.
///
/// # Panics
/// No target has this name, or the reader breaks a promise.
pub fn run_one(name: &str, input: &[u8]) {
    let target = find(name).expect("a listed target");
    (target.run)(input);
}
