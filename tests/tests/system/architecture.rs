//! Checks the dependencies between the crates, the top-level files, and rules for source code.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use cargo_metadata::TargetKind;
use robot_model::RobotModel;

/// Permitted dependencies of each package of the workspace. Dev-dependencies are not restricted.
const DEPENDENCIES: &[(&str, &[&str])] = &[
    ("shm-schemas", &[]),
    ("atas-text-file", &[]),
    ("shm-bus", &["shm-schemas"]),
    ("robot-model", &["atas-text-file", "shm-schemas"]),
    ("atas-core", &["shm-schemas", "robot-model"]),
    ("atas-process", &[]),
    (
        "atasd",
        &[
            "atas-text-file",
            "atas-process",
            "atas-core",
            "shm-bus",
            "shm-schemas",
            "robot-model",
        ],
    ),
    ("atas-judge", &["shm-schemas"]),
    ("field", &[]),
    ("pinch", &[]),
    (
        "sim-backend",
        &[
            "atas-text-file",
            "atas-process",
            "shm-bus",
            "shm-schemas",
            "robot-model",
            "field",
        ],
    ),
    (
        "atas-console",
        &["atas-process", "atas-client", "shm-bus", "shm-schemas"],
    ),
    (
        "atas-recording",
        &[
            "atas-process",
            "atas-client",
            "robot-model",
            "shm-bus",
            "shm-schemas",
        ],
    ),
    (
        "atas-tasks",
        &[
            "atas-client",
            "atas-core",
            "robot-model",
            "shm-schemas",
            "sim-backend",
        ],
    ),
    ("atas-processes", &["shm-bus"]),
    (
        "atas-demo",
        &[
            "atas-client",
            "atas-console",
            "atas-core",
            "atas-processes",
            "atas-tasks",
            "robot-model",
            "shm-bus",
            "shm-schemas",
            "sim-backend",
        ],
    ),
    ("atas-controller-state", &["atas-core"]),
    (
        "atas-evaluation",
        &[
            "atas-text-file",
            "atas-client",
            "atas-controller-state",
            "atas-core",
            "atas-meshes",
            "atas-recording",
            "atas-tasks",
            "robot-model",
            "shm-schemas",
            "sim-backend",
        ],
    ),
    (
        "atas-faults",
        &[
            "atas-core",
            "atas-evaluation",
            "atas-judge",
            "atas-process",
            "atas-processes",
            "robot-model",
            "shm-bus",
            "shm-schemas",
            "sim-backend",
        ],
    ),
    ("atas-assurance", &["atas-faults"]),
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
            "ebts",
            "field",
            "robot-model",
            "shm-bus",
            "shm-schemas",
            "sim-backend",
        ],
    ),
    (
        "atas-gate",
        &["atas-text-file", "atas-process", "atas-console", "shm-bus"],
    ),
    (
        "atas-remote",
        &[
            "atas-text-file",
            "atas-client",
            "atas-console",
            "atas-gate",
            "shm-bus",
        ],
    ),
    (
        "atas-cli",
        &[
            "atas-process",
            "atas-client",
            "atas-console",
            "atas-gate",
            "atas-recording",
            "robot-model",
            "shm-bus",
            "shm-schemas",
        ],
    ),
    (
        "atas-lab",
        &[
            "atas-assurance",
            "atas-process",
            "atas-client",
            "atas-console",
            "atas-core",
            "atas-demo",
            "atas-evaluation",
            "atas-faults",
            "atas-processes",
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
            "atas-text-file",
            "atas-client",
            "atas-console",
            "atas-meshes",
            "atas-recording",
            "robot-model",
            "shm-bus",
            "shm-schemas",
        ],
    ),
    ("atas-meshes", &["robot-model"]),
    ("atas-client", &["atas-process", "shm-bus", "shm-schemas"]),
    (
        "ebts",
        &[
            "atas-text-file",
            "atas-process",
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
    (
        "atas-robots",
        &[
            "atas-text-file",
            "atas-process",
            "robot-model",
            "shm-bus",
            "shm-schemas",
        ],
    ),
    (
        "atas-sensors",
        &[
            "atas-text-file",
            "atas-process",
            "atas-recording",
            "shm-bus",
            "shm-schemas",
        ],
    ),
    (
        "atas-fuzz",
        &[
            "atas-controller-state",
            "atas-core",
            "atas-gate",
            "atas-live",
            "atas-recording",
            "atas-remote",
            "atas-robots",
            "atas-sensors",
            "atasd",
            "ebts",
            "field",
            "robot-model",
            "shm-bus",
            "shm-schemas",
            "sim-backend",
        ],
    ),
    (
        "system-tests",
        &[
            "atas-core",
            "atas-evaluation",
            "atas-process",
            "atasd",
            "robot-model",
            "shm-bus",
            "shm-schemas",
            "sim-backend",
        ],
    ),
];

/// Permitted names at the top level.
const TOP_LEVEL: &[&str] = &[
    "Cargo.toml",
    "Cargo.lock",
    "CONTRIBUTING.md",
    "ARCHITECTURE.md",
    "CHANGELOG.md",
    "CITATION.cff",
    "SECURITY.md",
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
fn packages_have_only_permitted_dependencies() {
    let allowed: BTreeMap<&str, &[&str]> = DEPENDENCIES.iter().copied().collect();
    for package in &packages() {
        let name = package.name.as_str();
        let may = allowed.get(name).unwrap_or_else(|| {
            panic!("{name} has no entry in DEPENDENCIES; add its permitted dependencies")
        });
        for dependency in &package.dependencies {
            let ours = allowed.contains_key(dependency.name.as_str());
            let built = dependency.kind != cargo_metadata::DependencyKind::Development;
            assert!(
                !ours || !built || may.contains(&dependency.name.as_str()),
                "{name} must not depend on {}: see the dependency diagram in ARCHITECTURE.md",
                dependency.name
            );
        }
    }
}

/// `cargo test` builds the programs of a package only if it has an integration test. The system
/// tests run programs of other packages.
#[test]
fn each_package_with_a_program_has_an_integration_test() {
    for package in &packages() {
        let has = |kind: TargetKind| package.targets.iter().any(|t| t.is_kind(kind.clone()));
        assert!(
            !has(TargetKind::Bin) || has(TargetKind::Test),
            "{}: `cargo test --workspace` does not build its programs; add an integration test",
            package.name
        );
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
            "{name} uses dev_permissions, which opens the bus to every user; remove it"
        );
    }
}

#[test]
fn top_level_has_only_permitted_entries() {
    for entry in std::fs::read_dir(root()).expect("readable") {
        let name = entry
            .expect("readable")
            .file_name()
            .into_string()
            .expect("UTF-8");
        assert!(
            TOP_LEVEL.contains(&name.as_str()),
            "{name} is not a permitted top-level name; move it or add it to TOP_LEVEL"
        );
    }
}

/// Only the robot files and the robot model may know a robot's joint count.
#[test]
fn no_code_outside_the_model_contains_a_robots_joint_count() {
    let mut counts = BTreeSet::new();
    for name in robot_model::shipped_names() {
        let robot = RobotModel::find(&name).expect("the robot is built in");
        let of_hands = robot.sides().map(|side| robot.hand(side).joints().len());
        counts.extend(of_hands.chain([robot.joint_count()]));
    }
    // Smaller numbers have other meanings as well.
    counts.retain(|count| *count >= 8);
    assert!(counts.contains(&22), "{counts:?}");
    let packages = packages();
    let others = packages
        .iter()
        .filter(|package| *package.name != "robot-model");
    for package in others {
        let folder = package.manifest_path.parent().expect("a folder");
        for (path, line) in code_lines(folder.join("src").as_std_path()) {
            let words = || line.split(|c: char| !c.is_alphanumeric() && c != '_');
            let of_joints = words().any(|word| word.to_lowercase().contains("joint"));
            let count = words().find_map(|word| counts.get(&word.parse().ok()?));
            assert!(
                !of_joints || count.is_none(),
                "{} contains the joint count {count:?}: {line}; use the robot model",
                path.display()
            );
        }
    }
}

/// A grasp side may have several fingertips, so its number is not an index of fingertip data.
#[test]
fn fingertip_data_is_not_cut_to_grasp_sides() {
    for package in &packages() {
        let folder = package.manifest_path.parent().expect("a folder");
        for (path, line) in code_lines(folder.join("src").as_std_path()) {
            let line = line.replace("robot_model::", "");
            let cut = ["[..GRASP_SIDES]", "take(GRASP_SIDES)"];
            assert!(
                !cut.iter().any(|cut| line.contains(cut)),
                "{} takes the first fingertips as grasp sides: {line}; use GraspSides",
                path.display()
            );
        }
    }
}

/// Returns all lines of production code below a folder, without comments.
fn code_lines(folder: &Path) -> Vec<(PathBuf, String)> {
    let mut lines = Vec::new();
    for entry in std::fs::read_dir(folder).into_iter().flatten() {
        let path = entry.expect("readable").path();
        if path.is_dir() {
            lines.extend(code_lines(&path));
            continue;
        }
        let is_production = path.extension().is_some_and(|ending| ending == "rs")
            && path.file_name().is_some_and(|name| name != "tests.rs");
        if is_production {
            let text = std::fs::read_to_string(&path).expect("readable");
            let tested = text.find("#[cfg(test)]").unwrap_or(text.len());
            let code = text[..tested].lines().map(|line| {
                let code = line.split("//").next().unwrap_or_default();
                (path.clone(), code.to_owned())
            });
            lines.extend(code);
        }
    }
    lines
}

/// CI builds once, so its test results hold for a release only if both profiles are equal.
#[test]
fn release_profile_equals_dev_profile() {
    let text = std::fs::read_to_string(root().join("Cargo.toml")).expect("readable");
    let profile = |name: &str| {
        let rest = text.split_once(name).expect("a profile").1;
        let lines = rest.lines().skip(1).take_while(|l| !l.starts_with('['));
        let settings = lines.filter(|l| l.contains('=') && !l.starts_with('#'));
        settings.map(str::to_string).collect::<BTreeSet<_>>()
    };
    assert_eq!(profile("[profile.dev]"), profile("[profile.release]"));
}

/// Returns the packages of the workspace.
pub(crate) fn packages() -> Vec<cargo_metadata::Package> {
    let metadata = cargo_metadata::MetadataCommand::new()
        .manifest_path(root().join("Cargo.toml"))
        .no_deps()
        .other_options(["--offline".to_string()])
        .exec();
    metadata.expect("cargo metadata").packages
}

fn manifests() -> Vec<(String, String)> {
    let mut all: Vec<(String, String)> = packages()
        .iter()
        .map(|package| {
            let text = std::fs::read_to_string(&package.manifest_path).expect("readable");
            (package.name.to_string(), text)
        })
        .collect();
    all.push((
        "workspace".into(),
        std::fs::read_to_string(root().join("Cargo.toml")).expect("readable"),
    ));
    all
}
