//! Error of a rejected file.

use std::path::Path;

use atas_console::{Exit, ExitError};

/// Returns the error of a rejected file with its reason.
pub(crate) fn rejected(file: &Path, why: &dyn std::fmt::Display) -> anyhow::Error {
    let sentence = format!("{} was rejected: {why}", file.display());
    ExitError::with_code(Exit::Input, sentence)
}
