//! `ebts evolve course`, and `ebts show` of a course table.

mod evolve;
mod show;

use super::options::toml_file;
use super::progress::style;
use super::{Format, answer, check_overwrite, continue_unless_set, stop_flag};

pub(super) use evolve::{EvolveCourseArgs, evolve};
pub(super) use show::{is_course_file, show};
