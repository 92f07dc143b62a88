//! `ebts evolve course`, and `ebts show` of a course table.

mod evolve;
mod show;

use super::options::toml_file;
use super::progress::style;
use super::{Format, answer, spare, stop_flag, unless_set};

pub(super) use evolve::{EvolveCourseArgs, evolve};
pub(super) use show::{is_course_file, show};
