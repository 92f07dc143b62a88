//! Closed-loop tests: the production controller with the simulated world, in process.
//!
//! The evaluation (`atas eval`) measures success over object families; these tests cover branches
//! that it rarely takes.

mod any_robot;
mod arm_clearance;
mod assembly;
mod goal_data;
mod hold;
mod interrupted;
mod model_errors;
mod placing;
mod regrasp;
mod restart;
mod rig;
mod screwing;
mod skin;
