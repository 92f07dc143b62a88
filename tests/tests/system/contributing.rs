//! Consistency of CONTRIBUTING.md and the module guide with the source tree.

use std::path::{Path, PathBuf};

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

fn read(path: &str) -> String {
    std::fs::read_to_string(root().join(path)).unwrap_or_else(|e| panic!("{path}: {e}"))
}

/// Returns the attributes of the first type in a text.
fn attributes(text: &str) -> Vec<&str> {
    let before = text.lines().take_while(|line| !line.contains("struct "));
    before.filter(|line| line.starts_with("#[")).collect()
}

/// Module states are fields of the list's type, so they need its derives: an example without them
/// would not compile there.
#[test]
fn example_modules_have_required_attributes() {
    let listed = read("daemon/atas/src/modules/list.rs");
    let (_, asked) = listed
        .split_once("State of all modules of one hand.\n")
        .expect("a type");
    let asked: Vec<&str> = asked.lines().map(str::trim).take(2).collect();
    assert!(asked.iter().all(|line| line.starts_with("#[")), "{asked:?}");
    for page in ["CONTRIBUTING.md", "clients/guide/src/module.md"] {
        let text = read(page);
        let (_, example) = text.split_once("```rust\n").expect(page);
        assert_eq!(attributes(example), asked, "{page}");
    }
}

/// Paths in the guide exist. `NAME` is a placeholder.
#[test]
fn files_named_in_guide_exist() {
    let text = read("CONTRIBUTING.md");
    let folders = [
        "daemon/",
        "clients/",
        "shm-schemas/",
        "sim-backend/",
        "tests/",
    ];
    let quoted = text.split('`').skip(1).step_by(2);
    let paths = quoted.filter(|path| folders.iter().any(|folder| path.starts_with(folder)));
    let mut seen = 0;
    for path in paths.filter(|path| !path.contains("NAME")) {
        assert!(root().join(path).exists(), "{path}");
        seen += 1;
    }
    assert!(seen > 20, "{seen}");
}

/// The guide names the generated files that the schemas' tests compare, and the places of a new
/// goal.
#[test]
fn guide_names_generated_files_and_goal_places() {
    let text = read("CONTRIBUTING.md");
    let (_, of_module) = text.split_once("\n## A module\n").expect("a section");
    let (of_module, rest) = of_module.split_once("\n## A task\n").expect("a section");
    let (of_task, _) = rest.split_once("\n## ").expect("a section");
    for made in [
        "shm-schemas/atas.h",
        "clients/protocol.md",
        "clients/python/python/atas/codes.py",
    ] {
        assert!(of_module.contains(made), "{made}");
    }
    for place in [
        "clients/client/src/goal.rs",
        "arguments/goals.rs",
        "arguments/access.rs",
        "arguments/examples.rs",
        "clients/cli/src/main.rs",
    ] {
        assert!(of_task.contains(place), "{place}");
    }
}
