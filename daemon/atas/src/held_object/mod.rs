//! Held object: estimates of the object in the hand, from tactile forces and hand motion.
//!
//! Once per tick, before the modules, [`HeldObjectEstimator::update`] computes a [`HeldObject`].
//! Modules and executor read it. Lift verification returns its result by
//! [`HeldObjectEstimator::receive`]. The guide's page "Estimates of a held object" shows the
//! equations.
//!
//! | file | estimate | evidence |
//! |---|---|---|
//! | `contact` | touch, closing distance, carried distance | contact, hand pose |
//! | `verified_grip` | load, load that the grip holds, slide under an overload | force ratio |
//! | `load_response` | load that the grip holds, before the verification | closing without effect |
//! | `drop_detector` | drop | decrease of the vertical load |
//! | `weight` | weight, slip distance, loss | vertical load |
//! | `lever` | lever of the centre of mass, rotation | moment about the closing axis |
//! | `drift` | drift of the tactile zero | force against opening |

mod contact;
mod drift;
mod drop_detector;
mod estimate;
mod estimator;
mod findings;
mod lever;
mod load_response;
mod verified_grip;
mod weight;

pub use drift::Drift;
pub use estimate::{HeldObject, LiftFinding, StepFacts};
pub use estimator::HeldObjectEstimator;
pub use verified_grip::VerifiedGrip;
