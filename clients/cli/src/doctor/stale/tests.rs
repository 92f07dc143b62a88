use std::os::unix::fs::symlink;

use super::*;

const FILE: &str = "fdemo-1-0_0123456789abcdef_x.data";

pub(crate) fn own_user() -> u32 {
    rustix::process::geteuid().as_raw()
}

/// Machine in a temporary folder that lists all processes, with one file of the bus `fdemo-1-0`.
pub(crate) fn machine() -> (tempfile::TempDir, Root) {
    let folder = tempfile::tempdir().expect("a folder");
    let root = Root::new(folder.path());
    for made in [SHM, "proc/7", "proc/self/ns"] {
        fs::create_dir_all(root.path(made)).expect("made");
    }
    symlink("pid:[4026531836]", root.path("proc/self/ns/pid")).expect("a link");
    fs::write(root.path(SHM).join(FILE), [1; 100_000]).expect("written");
    (folder, root)
}

fn write_maps(root: &Root, file: &str) {
    let line = format!("7f00-7f01 rw-s 00000000 00:1a 5 /dev/shm/{file}\n");
    fs::write(root.path("proc/7/maps"), line).expect("written");
}

#[test]
fn unmapped_file_is_stale() {
    let (_folder, root) = machine();
    write_maps(&root, "other_0123456789abcdef_x.data");
    let stale = Stale::find(&root, own_user());
    assert_eq!(stale.doubt, None);
    assert!(stale.is_abandoned("fdemo-1-0") && !stale.is_abandoned("other"));
    assert!(stale.bytes()["fdemo-1-0"] >= 100_000);
    let remains = &stale.buses["fdemo-1-0"];
    assert_eq!(remains.files, [root.path(SHM).join(FILE)]);
}

#[test]
fn bus_of_a_living_process_is_kept() {
    let (_folder, root) = machine();
    // Another file of the same bus is mapped.
    write_maps(&root, "fdemo-1-0_ffffffffffffffff_y.data");
    assert!(Stale::find(&root, own_user()).buses.is_empty());
}

#[test]
fn files_of_other_users_are_kept() {
    let (_folder, root) = machine();
    assert!(Stale::find(&root, own_user() + 1).buses.is_empty());
}

#[test]
fn links_and_foreign_names_are_kept() {
    let (_folder, root) = machine();
    let folder = root.path(SHM);
    fs::remove_file(folder.join(FILE)).expect("removed");
    fs::write(folder.join("sem.other"), "x").expect("written");
    fs::write(root.path("target"), "x").expect("written");
    symlink(root.path("target"), folder.join(FILE)).expect("a link");
    assert!(Stale::find(&root, own_user()).buses.is_empty());
}

#[test]
fn container_leaves_doubt() {
    let (_folder, root) = machine();
    fs::remove_file(root.path("proc/self/ns/pid")).expect("removed");
    let stale = Stale::find(&root, own_user());
    assert_eq!(stale.doubt, Some(Doubt::Container));
    assert!(!stale.is_abandoned("fdemo-1-0"));
}

#[test]
fn user_of_a_process_is_read_from_its_status() {
    let (_folder, root) = machine();
    let process = root.path("proc/7");
    fs::write(process.join("status"), "Name:\tatasd\nUid:\t5\t6\t6\t6\n").expect("written");
    assert!(belongs_to(&process, 5) && belongs_to(&process, 6));
    assert!(!belongs_to(&process, 7));
}
