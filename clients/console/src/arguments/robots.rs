//! What `atas robot` may be told.

use std::path::PathBuf;

use clap::Subcommand;

use super::values::picture;

/// `atas robot`.
#[derive(Debug, Subcommand)]
pub enum RobotAction {
    /// The robots that ship, and the tasks that each can do
    List,
    /// What is understood of a robot, what is wrong with it, all at once, what it reaches and what it can do
    Check {
        /// One that ships, or a robot file
        #[arg(value_name = "NAME|FILE")]
        robot: String,
        /// Draw it where it rests, from the front, from the side and from above
        #[arg(long, value_name = "FILE.svg|png|pdf", value_parser = picture)]
        out: Option<PathBuf>,
    },
}
