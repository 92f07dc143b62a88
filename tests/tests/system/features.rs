//! Checks that tests, the README's first command and the Python package, which are built alone, use
//! the same dependency features as the workspace.
//!
//! Different features would build half of the workspace a second time.

use std::collections::BTreeSet;
use std::process::Command;

/// Returns the packages and features that a selection builds.
fn built(selection: &[&str]) -> BTreeSet<String> {
    let tree = Command::new(env!("CARGO"))
        .args(["tree", "--offline", "--locked", "--prefix", "none"])
        .args(["--no-dedupe", "--format", "{p} [{f}]"])
        .args(selection)
        .current_dir(concat!(env!("CARGO_MANIFEST_DIR"), "/.."))
        .output()
        .expect("cargo starts");
    let complaint = String::from_utf8_lossy(&tree.stderr);
    assert!(tree.status.success(), "{complaint}");
    let text = String::from_utf8(tree.stdout).expect("UTF-8");
    let lines = text.lines().filter(|line| !line.is_empty());
    lines.map(str::to_owned).collect()
}

/// Rejects packages that `of` builds with features other than `with`.
fn check(of: &[&str], with: &[&str]) {
    let (of, with) = (built(of), built(with));
    let again: Vec<&String> = of.difference(&with).collect();
    assert!(
        again.is_empty(),
        "built twice with different features: {again:#?}; request the same features in the \
         Cargo.toml of the workspace, clients/cli or clients/python"
    );
}

#[test]
fn tests_use_the_features_of_programs() {
    check(
        &["--workspace", "--edges", "normal,build"],
        &["--workspace", "--edges", "normal,build,dev"],
    );
}

/// `cargo build` in the root builds the default members.
#[test]
fn first_command_uses_workspace_features() {
    check(
        &["--edges", "normal,build"],
        &["--workspace", "--edges", "normal,build"],
    );
}

#[test]
fn python_package_uses_workspace_features() {
    check(
        &["--package", "atas-python", "--edges", "normal,build"],
        &["--workspace", "--edges", "normal,build"],
    );
}
