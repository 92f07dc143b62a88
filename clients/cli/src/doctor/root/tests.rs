use std::os::unix::fs::symlink;

use super::*;

/// Machine in a temporary folder, from pairs of path and content.
fn machine(files: &[(&str, &str)]) -> (tempfile::TempDir, Root) {
    let folder = tempfile::tempdir().expect("a folder");
    for (file, content) in files {
        let path = folder.path().join(file);
        fs::create_dir_all(path.parent().expect("a folder")).expect("made");
        fs::write(path, content).expect("written");
    }
    let root = Root::new(folder.path());
    (folder, root)
}

#[test]
fn missing_files_read_as_empty() {
    let (_folder, root) = machine(&[]);
    assert_eq!(root.read("proc/self/status"), "");
    assert_eq!(root.owner("run/atas"), None);
    assert_eq!(root.interrupts(), []);
    assert_eq!(root.container(), None);
    assert!(root.frequency_settings("scaling_governor").is_empty());
    assert!(root.processor_quotas().is_empty() && root.processes().is_empty());
    assert!(!root.is_on_battery() && !root.lists_all_processes() && !root.is_replaced(1));
}

#[test]
fn frequency_settings_of_all_cores_are_read() {
    let (_folder, root) = machine(&[
        ("sys/devices/system/cpu/cpu0/cpufreq/scaling_governor", "a"),
        ("sys/devices/system/cpu/cpu1/cpufreq/scaling_governor", "b"),
        ("sys/devices/system/cpu/cpu2/online", "1"),
        ("sys/devices/system/cpu/isolated", "1\n"),
    ]);
    assert_eq!(root.frequency_settings("scaling_governor"), ["a", "b"]);
    assert_eq!(root.cores("isolated"), "1\n");
}

#[test]
fn interrupts_without_handler_are_skipped() {
    let (_folder, root) = machine(&[
        ("proc/irq/24/nvme0/name", ""),
        ("proc/irq/24/smp_affinity_list", "0-3\n"),
        ("proc/irq/24/effective_affinity_list", "3\n"),
        ("proc/irq/25/eth0/name", ""),
        ("proc/irq/25/smp_affinity_list", "0\n"),
        ("proc/irq/26/smp_affinity_list", "0\n"),
        ("proc/irq/default_smp_affinity", "f"),
    ]);
    let served = |number, cores: &str| Interrupt {
        number,
        cores: cores.to_owned(),
    };
    assert_eq!(root.interrupts(), [served(24, "3\n"), served(25, "0\n")]);
}

#[test]
fn battery_of_a_mouse_is_ignored() {
    let battery = [
        ("sys/class/power_supply/BAT0/type", "Battery\n"),
        ("sys/class/power_supply/BAT0/status", "Discharging\n"),
    ];
    let (_folder, root) = machine(&battery);
    assert!(root.is_on_battery());
    let scope = ("sys/class/power_supply/BAT0/scope", "Device\n");
    let (_folder, root) = machine(&[battery[0], battery[1], scope]);
    assert!(!root.is_on_battery());
}

#[test]
fn containers_are_recognised_by_their_marks() {
    let check = |file: &str, content: &str, kind: &str| {
        let (_folder, root) = machine(&[(file, content)]);
        assert_eq!(root.container().as_deref(), Some(kind), "{file}");
    };
    check(".dockerenv", "", "docker");
    check("run/.containerenv", "", "podman");
    check("run/systemd/container", "lxc\n", "lxc");
}

#[test]
fn quotas_of_all_parent_groups_are_read() {
    let (_folder, root) = machine(&[
        ("proc/self/cgroup", "0::/user.slice/shell\n"),
        ("sys/fs/cgroup/user.slice/shell/cpu.max", "max 100000\n"),
        ("sys/fs/cgroup/user.slice/cpu.max", "50000 100000\n"),
    ]);
    assert_eq!(root.processor_quotas(), ["max 100000\n", "50000 100000\n"]);
    let (_folder, root) = machine(&[
        ("sys/fs/cgroup/cpu/cpu.cfs_quota_us", "-1\n"),
        ("sys/fs/cgroup/cpu/cpu.cfs_period_us", "100000\n"),
    ]);
    assert_eq!(root.processor_quotas(), ["-1 100000"]);
}

#[test]
fn process_links_are_interpreted() {
    let (folder, root) = machine(&[("proc/self/ns/net", ""), ("proc/7/maps", "")]);
    let process = folder.path().join("proc");
    symlink("pid:[4026531836]", process.join("self/ns/pid")).expect("a link");
    symlink("/usr/bin/atasd (deleted)", process.join("7/exe")).expect("a link");
    assert!(root.lists_all_processes() && root.is_replaced(7));
    assert_eq!(root.processes(), [process.join("7")]);
}
