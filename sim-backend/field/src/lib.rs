//! The field of methodology 2: circular mobile robots push an object of light towards a goal of light (paper III.b).
//!
//! **In**: a [`Preset`] (every number of the field, as data), checked into a [`Model`]; a [`Trial`] (who starts where, the
//! goal, one response table per agent). **Out**: an [`Outcome`] (distances at the two instants the fitness needs, the rows
//! of the tables that were read) and what it is worth ([`FitnessRule`]), or, frame by frame, a [`TrialRun`].
//!
//! Two simulators of the same model live here and give the same bits:
//!
//! * [`World`]: scalar, one trial, one call to [`World::sense`] and one to [`World::advance`] per frame. It is the
//!   reference, and it is what a bus, an animation or an analysis steps from outside.
//! * [`Engine`]: many trials at once, one per SIMD lane; AVX-512, AVX2 or portable, chosen at run time.
//!
//! Invariants:
//!
//! * The bits of an outcome do not depend on the engine, on the number of trials in a call or on their order
//!   (test `tests/identical_bits.rs`). This rests on: only IEEE `+ − × ÷ √`, comparison and selection; no fused
//!   multiply-add; `max` and `min` as `a > b ? a : b`; headings from a literal table; every skipped computation skipped only
//!   where it provably changes nothing.
//! * A [`Model`] holds only finite numbers inside their ranges: what is not, is refused by [`Model::new`].
//!
//! * Noise is a part of a trial, drawn from a stream that the trial names, whatever the agents do.
//!
//! Deliberately absent: time, unseeded randomness, files, threads and learning. Lengths are in pixels (px), times in frames,
//! headings in steps of 1/64 turn, counter-clockwise from +x; the paper's field is the square `[−400, 400]²` (III.b.3).

mod arithmetic;
mod chance;
mod check;
mod constants;
mod engine;
mod fingerprint;
mod fitness;
mod heading;
mod lanes;
mod model;
mod obstacle;
mod preset;
mod responses;
mod room;
mod run;
mod sight;
mod training;
mod trial;
mod weights;
mod world;
mod written;

pub use chance::Noise;
pub use check::{Finding, PresetError};
pub use engine::{Engine, EngineError};
pub use fitness::{FitnessRule, GOAL_POINTS, accompanied, accuracy, delivered, efficiency, solved};
pub use heading::{HEADINGS, cos_sin};
pub use model::{Model, TeamSize, TeamSizeError};
pub use obstacle::{DrawnPosts, MAX_OBSTACLES, Post, Wall};
pub use preset::{Contact, Corner, Goals, Photo, Preset, Push, Start, Starts};
pub use responses::{ROWS, Responses, SENSORS, Wheels};
pub use run::{TrialRun, run_trial};
pub use training::{Places, Training};
pub use trial::{
    EVALUATION_FRAMES, EXECUTION_FRAMES, Layout, MAX_AGENTS, Outcome, Point, Pose, Snapshot,
    TRIAL_FRAMES, Trial,
};
pub use weights::Weights;
pub use world::World;
