use std::fs::File;
use std::time::SystemTime;

use shm_bus::{FreshBus, Realtime};

use super::*;
use crate::doctor::stale::SHM;
use crate::doctor::stale::tests::machine;

const GOVERNOR: &str = "sys/devices/system/cpu/cpu0/cpufreq/scaling_governor";

/// Writes a file of a bus below the root, with an age.
fn write_remains(root: &Root, bus: &BusName, age: Duration) -> PathBuf {
    let path = root
        .path(SHM)
        .join(format!("{bus}_0123456789abcdef_x.data"));
    fs::write(&path, [1; 100_000]).expect("written");
    let file = File::options().write(true).open(&path).expect("opened");
    file.set_modified(SystemTime::now() - age).expect("set");
    path
}

/// Returns the outcome for the files of a bus.
fn removal(root: &Root, bus: &BusName, dry_run: bool) -> Option<Outcome> {
    let fixes = remove_stale(root, dry_run).into_iter();
    let mut of_bus = fixes.filter(|fix| fix.action.contains(&format!("bus {bus},")));
    of_bus.next().map(|fix| fix.outcome)
}

/// Machine in a temporary folder without bus files.
fn empty_machine() -> (tempfile::TempDir, Root) {
    let (folder, root) = machine();
    for file in root.entries(SHM) {
        fs::remove_file(file).expect("removed");
    }
    (folder, root)
}

#[test]
fn old_file_without_bus_folder_is_removed() {
    let ((_folder, root), bus) = (empty_machine(), FreshBus::new("old"));
    let file = write_remains(&root, &bus, Duration::from_secs(60));
    assert_eq!(removal(&root, &bus, true), Some(Outcome::Planned));
    assert!(file.exists(), "a dry run changes nothing");
    assert_eq!(removal(&root, &bus, false), Some(Outcome::Done));
    assert!(!file.exists());
    assert_eq!(removal(&root, &bus, false), None);
}

#[test]
fn young_file_without_bus_folder_is_kept() {
    let ((_folder, root), bus) = (empty_machine(), FreshBus::new("young"));
    let file = write_remains(&root, &bus, Duration::ZERO);
    let outcome = removal(&root, &bus, false);
    assert!(
        matches!(outcome, Some(Outcome::Refused { .. })),
        "{outcome:?}"
    );
    assert!(file.exists());
}

#[test]
fn files_of_a_living_bus_are_kept() {
    let ((_folder, root), bus) = (empty_machine(), FreshBus::new("living"));
    let file = write_remains(&root, &bus, Duration::from_secs(60));
    let _peer = Bus::open(&bus, "test", Realtime::No).expect("a bus");
    // The machine of the test does not list this process, so only the bus protects the file.
    let outcome = removal(&root, &bus, false);
    let Some(Outcome::Refused { reason, .. }) = outcome else {
        panic!("{outcome:?}");
    };
    assert!(reason.contains("in use"), "{reason}");
    assert!(file.exists());
}

#[test]
fn bus_without_process_is_wiped() {
    let ((_folder, root), bus) = (empty_machine(), FreshBus::new("wiped"));
    let file = write_remains(&root, &bus, Duration::from_secs(60));
    drop(Bus::open(&bus, "test", Realtime::No).expect("a bus"));
    assert!(Bus::find(&bus).is_ok(), "its folder remains");
    assert_eq!(removal(&root, &bus, true), Some(Outcome::Planned));
    assert!(Bus::find(&bus).is_ok(), "a dry run changes nothing");
    assert_eq!(removal(&root, &bus, false), Some(Outcome::Done));
    assert!(Bus::find(&bus).is_err() && !file.exists());
}

#[test]
fn container_prints_the_command_only() {
    let ((_folder, root), bus) = (empty_machine(), FreshBus::new("hidden"));
    let file = write_remains(&root, &bus, Duration::from_secs(60));
    fs::remove_file(root.path("proc/self/ns/pid")).expect("removed");
    let Some(Outcome::Refused { command, .. }) = removal(&root, &bus, false) else {
        panic!("not refused");
    };
    assert_eq!(command, format!("rm /dev/shm/{}_*", bus.as_str()));
    assert!(file.exists());
}

#[test]
fn permitted_governor_is_set() {
    let (_folder, root) = empty_machine();
    let file = root.path(GOVERNOR);
    fs::create_dir_all(file.parent().expect("a folder")).expect("made");
    fs::write(&file, "powersave").expect("written");
    let governor = || fs::read_to_string(&file).expect("readable");
    let outcome = |dry_run| set_governor(&root, dry_run).map(|fix| fix.outcome);
    assert_eq!(outcome(true), Some(Outcome::Planned));
    assert_eq!(governor(), "powersave");
    assert_eq!(outcome(false), Some(Outcome::Done));
    assert_eq!(governor(), "performance");
    assert_eq!(outcome(false), None);
}

#[test]
fn refused_governor_prints_the_command() {
    // A folder cannot be opened for writing, not even by root.
    let folder = tempfile::tempdir().expect("a folder");
    for dry_run in [true, false] {
        let outcome = write_governors(&[folder.path().to_owned()], dry_run);
        let Outcome::Refused { command, .. } = outcome else {
            panic!("{outcome:?}");
        };
        assert_eq!(command, SET_GOVERNOR);
    }
}

#[test]
fn outcomes_are_printed_with_reason_and_command() {
    let with = |outcome| Fix {
        probe: checks::GOVERNOR,
        action: "set it".to_owned(),
        outcome,
    };
    assert_eq!(with(Outcome::Planned).text(), "planned: set it");
    assert_eq!(with(Outcome::Done).as_json()["result"], "done");
    let fix = with(refused("no right", "sudo set"));
    assert_eq!(fix.text(), "refused: set it: no right; run `sudo set`");
    assert_eq!(fix.as_json()["command"], "sudo set");
    assert_eq!(with(refused("no", "")).text(), "refused: set it: no");
}
