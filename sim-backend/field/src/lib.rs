//! Two-dimensional field of methodology 2: circular mobile robots push a luminous object to a
//! luminous goal (paper III.b).
//!
//! * **Inputs**: a [`Preset`], validated into a [`Model`]; a [`Trial`] (start poses, goal, one
//!   response table per agent).
//! * **Outputs**: an [`Outcome`] (distances at two instants, table rows read) and its score
//!   ([`FitnessRule`]); or a [`TrialRun`], frame by frame.
//!
//! Two simulators of the model give identical bits:
//!
//! * [`World`]: scalar reference for one trial, stepped from outside with [`World::sense`] and
//!   [`World::advance`].
//! * [`Engine`]: many trials, one per SIMD lane; AVX-512, AVX2 or portable, selected at run time.
//!
//! Invariants:
//!
//! * The bits of an outcome depend neither on the engine nor on the number or order of trials (test
//!   `tests/identical_bits.rs`). Only IEEE `+ − × ÷ √`, comparison and selection; no fused
//!   multiply-add; `max` and `min` are `a > b ? a : b`; headings come from a literal table. A
//!   computation is skipped only if it provably changes nothing.
//! * [`Model::new`] rejects numbers that are not finite or out of range.
//! * Noise comes from a stream of the trial, independent of the agents' actions.
//!
//! Excluded: time, unseeded randomness, files, threads, learning. Units: pixels (px), frames,
//! headings in 1/64 turn, counter-clockwise from +x. The paper's field is `[−400, 400]²` (III.b.3).
//!
//! ```
//! use field::{Model, Preset, TeamSize};
//!
//! let model = Model::new(Preset::R3)?;
//! assert_eq!(model.training_goals().len(), 8);
//! assert!(TeamSize::new(5).is_err(), "at most four agents");
//! # Ok::<(), field::PresetError>(())
//! ```

mod arithmetic;
mod check;
mod constants;
mod engine;
mod fingerprint;
mod fitness;
mod heading;
mod lanes;
mod model;
mod noise;
mod obstacle;
mod placement;
mod preset;
mod preset_file;
mod responses;
mod run;
mod sensing;
mod training;
mod trial;
mod weights;
mod world;

pub use check::{Finding, PresetError};
pub use engine::{Engine, EngineError};
pub use fitness::{FitnessRule, GOAL_POINTS, accompanied, accuracy, delivered, efficiency, solved};
pub use heading::{HEADINGS, cos_sin};
pub use model::{Model, TeamSize, TeamSizeError};
pub use noise::Noise;
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
