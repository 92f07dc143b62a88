//! Closed-loop tests: the production controller with the simulated world, in process.
//!
//! The evaluation (`atas eval`) measures success over object families; these tests cover branches
//! that it rarely takes.

mod any_robot;
mod apart;
mod assembly;
mod hold;
mod interrupted;
mod placing;
mod regrasp;
mod restart;
mod rig;
mod screwing;
mod skin;
mod told;
mod unlike;
