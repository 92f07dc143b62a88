//! Nothing is built a second time because tests, or the Python package that is built alone, ask for other features of a
//! dependency: that would be half the workspace.

use std::collections::BTreeSet;
use std::process::Command;

/// Packages with their features, as a command builds them.
fn built(selection: &[&str]) -> BTreeSet<String> {
    let tree = Command::new(env!("CARGO"))
        .args(["tree", "--offline", "--locked", "--prefix", "none"])
        .args(["--no-dedupe", "--format", "{p} [{f}]"])
        .args(selection)
        .output()
        .expect("cargo starts");
    let complaint = String::from_utf8_lossy(&tree.stderr);
    assert!(tree.status.success(), "{complaint}");
    let text = String::from_utf8(tree.stdout).expect("UTF-8");
    let lines = text.lines().filter(|line| !line.is_empty());
    lines.map(str::to_owned).collect()
}

/// What `of` builds with other features than `with` does.
fn check(of: &[&str], with: &[&str]) {
    let (of, with) = (built(of), built(with));
    let again: Vec<&String> = of.difference(&with).collect();
    assert!(
        again.is_empty(),
        "built a second time, with other features: {again:#?}; ask for the same ones in the Cargo.toml of the workspace, or of \
         clients/python"
    );
}

#[test]
fn tests_ask_for_no_other_features_of_what_the_programs_are_built_of() {
    check(
        &["--workspace", "--edges", "normal,build"],
        &["--workspace", "--edges", "normal,build,dev"],
    );
}

#[test]
fn the_python_package_is_built_of_what_the_workspace_is_built_of() {
    check(
        &["--package", "atas-python", "--edges", "normal,build"],
        &["--workspace", "--edges", "normal,build"],
    );
}
