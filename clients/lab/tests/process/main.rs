//! Laboratory commands as processes: exit codes, messages, and clean-up.

mod calibrate;
mod eval;

use std::process::{Command, Output, Stdio};

fn atas(arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_atas-lab"));
    command
        .args(arguments)
        .env_remove("ATAS_BUS")
        .env_remove("RUST_LOG")
        .stdin(Stdio::null());
    command
}

fn run(arguments: &[&str]) -> (i32, String, String) {
    let Output {
        status,
        stdout,
        stderr,
    } = atas(arguments).output().expect("it starts");
    let text = |bytes| String::from_utf8(bytes).expect("UTF-8");
    (status.code().expect("a code"), text(stdout), text(stderr))
}

#[test]
fn wrong_usage_has_its_own_code() {
    let check = |arguments: &[&str], part: &str| {
        let (code, _, stderr) = run(arguments);
        assert_eq!(code, 2, "{arguments:?}: {stderr}");
        assert!(stderr.contains(part), "{arguments:?}: {stderr}");
    };
    check(
        &["eval", "grasp", "--objects", "botle"],
        "did you mean \"bottle\"?",
    );
    check(&["status"], "run `atas` instead");
}

#[test]
fn picture_format_follows_suffix_case_insensitively() {
    let folder = tempfile::tempdir().expect("a folder");
    for (name, begins) in [
        ("a.svg", &b"<svg"[..]),
        ("b.SVG", b"<svg"),
        ("c.Png", b"\x89PNG"),
        ("d.PDF", b"%PDF"),
    ] {
        let file = folder.path().join(name);
        let out = file.to_str().expect("UTF-8");
        let (code, _, stderr) = run(&["plot", "grasp", "--object", "sponge", "--out", out]);
        assert_eq!(code, 0, "{name}: {stderr}");
        let bytes = std::fs::read(&file).expect("a picture");
        assert!(bytes.starts_with(begins), "{name}");
    }
}

#[test]
fn foreign_file_is_rejected_as_recording() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("tasks.toml");
    std::fs::write(&file, "[[task]]\nname = \"polish\"\n").expect("written");
    let path = file.to_str().expect("UTF-8");
    let out = format!("{path}.svg");
    for line in [
        &["explain", path][..],
        &["replay", path],
        &["plot", path, "--out", &out],
    ] {
        let (code, _, stderr) = run(line);
        assert_eq!(code, 1, "{line:?}: {stderr}");
        assert!(
            stderr.contains("does not begin as a recording does") && !stderr.contains("repair"),
            "{line:?}: {stderr}"
        );
    }
}

/// Uses the default width, as the output is not a terminal.
#[test]
fn table_fits_eighty_columns() {
    let objects = "filled-paper-box,slippery-200";
    let (code, stdout, stderr) = run(&[
        "eval",
        "grasp",
        "--trials",
        "2",
        "--objects",
        objects,
        "--noise",
        "1",
    ]);
    assert_eq!(code, 0, "{stderr}");
    assert!(
        stdout.contains("1 of 1") && stdout.contains("otherwise"),
        "{stdout}"
    );
    // Lines from this one on are text of any length.
    for row in stdout.lines().take_while(|row| !row.starts_with("grasp: ")) {
        assert!(row.chars().count() <= 80, "{row}");
    }
}
