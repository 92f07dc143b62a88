//! Arguments of `atas robot`.

use std::path::PathBuf;

use clap::Subcommand;

use super::values::picture;

/// `atas robot`.
#[derive(Debug, Subcommand)]
pub enum RobotAction {
    /// List the built-in robots and the tasks that each supports
    List,
    /// Validate a robot and show its interpretation, workspace and capabilities; lists all errors
    Check {
        /// Built-in robot or robot file
        #[arg(value_name = "NAME|FILE", value_parser = super::values::ROBOTS, hide_possible_values = true)]
        robot: String,
        /// Draw the robot at rest from the front, the side and above
        #[arg(long, value_name = "FILE.svg|png|pdf", value_parser = picture)]
        out: Option<PathBuf>,
    },
}
