//! The production controller before the simulated world, in process: what only both together can show.
//!
//! Success over the families of objects is the evaluation's affair (`atas eval`); here are the branches that it rarely takes.

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
