//! `atas recordings fetch --remote`: copies a recording of the server into a new file.

use std::fs::{self, File};
use std::path::{Path, PathBuf};

use anyhow::Context;
use atas_console::{Exit, ExitError, Interrupt, Output, print_fetched};
use rustix::fs::{CWD, RenameFlags, renameat_with};

use super::config::Target;
use super::exit;
use super::relay::{self, End, Streams};

/// Fetches a recording. The file gets its name when it is complete.
pub(super) fn fetch(
    target: &Target,
    name: &str,
    out: Option<&Path>,
    interrupt: &Interrupt,
    output: &mut Output,
) -> anyhow::Result<()> {
    let out = out.map_or_else(|| PathBuf::from(name), Path::to_owned);
    let not_created = |why: &dyn std::fmt::Display| {
        let sentence = format!("could not create {}: {why}", out.display());
        ExitError::with_code(Exit::Failed, sentence)
    };
    if out.exists() {
        return Err(not_created(&"it exists"));
    }
    let partial = out.with_extension("mcap.part");
    let file = File::create_new(&partial).map_err(|error| not_created(&error))?;
    let mut words = vec!["recordings".into(), "fetch".into(), name.to_owned()];
    if output.is_json() {
        words.extend(["--format".into(), "json".into()]);
    }
    let end = relay::run(target, words, Streams::file(file), interrupt);
    if !matches!(end, Ok(End::Code(0))) {
        // The error of the transfer is the one to report.
        let _ = fs::remove_file(&partial);
        return exit(&end?, target);
    }
    renameat_with(CWD, &partial, CWD, &out, RenameFlags::NOREPLACE)
        .map_err(|error| not_created(&std::io::Error::from(error)))?;
    let bytes = fs::metadata(&out).context("could not read the file")?.len();
    print_fetched(&out, bytes, output)
}
