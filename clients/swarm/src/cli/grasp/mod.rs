//! Grasp tables: `ebts evolve grasp`, `ebts experiment grasp`, `ebts agreement`, and `ebts show` of
//! a grasp table.

mod agreement;
mod evolve;
mod experiment;
mod show;

use super::options::toml_file;
use super::progress::style;
use super::{Format, answer, check_overwrite, continue_unless_set, print, stop_flag};

pub(super) use agreement::{AgreementArgs, agreement};
pub(super) use evolve::{EvolveGraspArgs, evolve};
pub(super) use experiment::{ExperimentGraspArgs, experiment};
pub(super) use show::{is_grasp_file, show};
