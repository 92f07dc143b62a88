//! Tests of the program: output, rejections, and safety of finished runs.

mod experiments;
mod interruption;
mod program;
mod search;
mod tables;
mod transfer;
mod worlds;

use std::collections::BTreeSet;
use std::path::Path;
use std::process::{Command, Output, Stdio};
use std::time::Duration;

use serde_json::Value;
use tempfile::TempDir;

fn folder() -> TempDir {
    tempfile::tempdir().expect("a temporary folder")
}

fn ebts(folder: &Path, arguments: &str) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_ebts"));
    command
        .current_dir(folder)
        .args(arguments.split_whitespace());
    command
}

fn output(folder: &Path, arguments: &str) -> Output {
    ebts(folder, arguments).output().expect("ebts starts")
}

/// Runs a command that must succeed; returns its standard output.
fn run(folder: &Path, arguments: &str) -> String {
    let output = output(folder, arguments);
    assert!(
        output.status.success(),
        "{arguments}: {}",
        String::from_utf8_lossy(&output.stderr)
    );
    String::from_utf8(output.stdout).expect("text")
}

fn json(folder: &Path, arguments: &str) -> Value {
    serde_json::from_str(&run(folder, arguments)).expect("JSON")
}

/// Runs a command that must fail with this exit code; returns its standard error.
fn refused(folder: &Path, arguments: &str, code: i32) -> String {
    let output = output(folder, arguments);
    let message = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(code), "{arguments}: {message}");
    message
}

fn results(folder: &Path, name: &str) -> Vec<(String, String)> {
    let files = [
        "runs.csv",
        "curves.csv",
        "findings.json",
        "best-1.toml",
        "best-4.toml",
        "fig14.svg",
    ];
    let read =
        |file: &str| std::fs::read_to_string(folder.join(name).join(file)).expect("a result file");
    files.map(|file| (file.to_owned(), read(file))).to_vec()
}

fn keys(value: &Value) -> BTreeSet<&str> {
    value
        .as_object()
        .expect("an object")
        .keys()
        .map(String::as_str)
        .collect()
}

const SMALL: &str = "experiment fig14 --preset N --seeds 3 --generations 40";
