//! The arrows between the crates, the top level, and what must not be in the tree.

use std::collections::BTreeMap;
use std::path::Path;

/// Which of our packages each of our packages may use. Tests and benches (dev-dependencies) are free.
const ARROWS: &[(&str, &[&str])] = &[
    ("shm-schemas", &[]),
    ("shm-bus", &["shm-schemas"]),
    ("robot-model", &[]),
    ("atas-core", &["shm-schemas", "robot-model"]),
    (
        "atasd",
        &["atas-core", "shm-bus", "shm-schemas", "robot-model"],
    ),
    ("field", &[]),
    ("pinch", &[]),
    (
        "sim-backend",
        &["shm-bus", "shm-schemas", "robot-model", "field"],
    ),
    ("atas-console", &["atas-client", "shm-bus", "shm-schemas"]),
    (
        "atas-recording",
        &["atas-client", "robot-model", "shm-bus", "shm-schemas"],
    ),
    (
        "atas-evaluation",
        &[
            "atas-client",
            "atas-core",
            "atas-recording",
            "robot-model",
            "shm-schemas",
            "sim-backend",
        ],
    ),
    (
        "atas-learning",
        &["atas-core", "robot-model", "shm-schemas", "sim-backend"],
    ),
    (
        "atas-python",
        &[
            "atas-client",
            "atas-core",
            "atas-evaluation",
            "atas-learning",
            "atas-recording",
            "robot-model",
            "shm-bus",
            "shm-schemas",
            "sim-backend",
        ],
    ),
    (
        "atas-cli",
        &[
            "atas-client",
            "atas-console",
            "atas-recording",
            "shm-bus",
            "shm-schemas",
        ],
    ),
    (
        "atas-lab",
        &[
            "atas-client",
            "atas-console",
            "atas-core",
            "atas-evaluation",
            "atas-recording",
            "atas-sensors",
            "ebts",
            "robot-model",
            "shm-bus",
            "shm-schemas",
            "sim-backend",
        ],
    ),
    (
        "atas-live",
        &[
            "atas-client",
            "atas-console",
            "atas-recording",
            "robot-model",
            "shm-bus",
            "shm-schemas",
        ],
    ),
    ("atas-client", &["shm-bus", "shm-schemas"]),
    (
        "ebts",
        &[
            "atas-core",
            "atas-evaluation",
            "field",
            "pinch",
            "robot-model",
            "shm-bus",
            "shm-schemas",
            "sim-backend",
        ],
    ),
    ("atas-robots", &["robot-model", "shm-bus", "shm-schemas"]),
    ("atas-sensors", &["shm-bus", "shm-schemas"]),
    (
        "system-tests",
        &[
            "atas-core",
            "atas-evaluation",
            "atasd",
            "robot-model",
            "shm-bus",
            "shm-schemas",
            "sim-backend",
        ],
    ),
];

/// What may lie at the top level besides the folders of the packages.
const TOP_LEVEL: &[&str] = &[
    ".clippy.toml",
    "Cargo.toml",
    "Cargo.lock",
    "CONTRIBUTING.md",
    "README.md",
    "rust-toolchain.toml",
    "LICENSE-MIT",
    "LICENSE-APACHE",
    ".gitignore",
    ".cargo",
    ".ci",
    ".git",
    "daemon",
    "clients",
    "shm-schemas",
    "sim-backend",
    "tests",
    "target",
];

pub(crate) fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .parent()
        .expect("the workspace")
}

#[test]
fn packages_depend_only_along_the_arrows() {
    let metadata = cargo_metadata::MetadataCommand::new()
        .manifest_path(root().join("Cargo.toml"))
        .no_deps()
        .other_options(["--offline".to_string()])
        .exec()
        .expect("cargo metadata");
    let allowed: BTreeMap<&str, &[&str]> = ARROWS.iter().copied().collect();
    for package in &metadata.packages {
        let name = package.name.as_str();
        let may = allowed
            .get(name)
            .unwrap_or_else(|| panic!("{name} is not in the table of arrows; add it on purpose"));
        for dependency in &package.dependencies {
            let ours = allowed.contains_key(dependency.name.as_str());
            let built = dependency.kind != cargo_metadata::DependencyKind::Development;
            assert!(
                !ours || !built || may.contains(&dependency.name.as_str()),
                "{name} must not depend on {}: the arrows are drawn in the README",
                dependency.name
            );
        }
    }
}

#[test]
fn only_the_bus_crate_names_the_transport() {
    for (name, text) in manifests() {
        let names_it = text.contains("iceoryx2.workspace") || text.contains("iceoryx2 =");
        assert!(
            !names_it || name == "shm-bus" || name == "workspace",
            "{name} names iceoryx2; only shm-bus may"
        );
        assert!(
            !text.contains("dev_permissions"),
            "{name} opens the bus to every user: dev_permissions is banned"
        );
    }
}

#[test]
fn the_top_level_holds_only_what_is_agreed() {
    for entry in std::fs::read_dir(root()).expect("readable") {
        let name = entry
            .expect("readable")
            .file_name()
            .into_string()
            .expect("UTF-8");
        assert!(
            TOP_LEVEL.contains(&name.as_str()),
            "{name} does not belong at the top level"
        );
    }
}

fn manifests() -> Vec<(String, String)> {
    let read = |path: &str| std::fs::read_to_string(root().join(path)).expect("readable");
    let folders = [
        "shm-schemas",
        "shm-schemas/bus",
        "daemon",
        "daemon/robot",
        "daemon/atas",
        "sim-backend",
        "sim-backend/field",
        "sim-backend/pinch",
        "clients/client",
        "clients/console",
        "clients/recording",
        "clients/evaluation",
        "clients/cli",
        "clients/lab",
        "clients/learning",
        "clients/live",
        "clients/python",
        "clients/robots",
        "clients/swarm",
        "clients/sensors",
        "tests",
    ];
    let mut all: Vec<(String, String)> = folders
        .iter()
        .map(|folder| {
            let text = read(&format!("{folder}/Cargo.toml"));
            let name = text.split('"').nth(1).expect("a name").to_string();
            (name, text)
        })
        .collect();
    all.push(("workspace".into(), read("Cargo.toml")));
    all
}
