use super::super::Verdict::{self, Fail, Ok as Good, Warn};
use super::*;

fn check(finding: Finding, verdict: Verdict, part: &str) {
    assert_eq!(finding.verdict, verdict, "{finding:?}");
    assert!(finding.found.contains(part), "{finding:?}");
    assert_eq!(finding.fix.is_empty(), verdict == Good, "{finding:?}");
}

#[test]
fn real_time_limits_are_rated() {
    let refused = || Err(io::Error::from_raw_os_error(1));
    check(scheduling(&Ok(()), true), Good, "granted");
    check(
        scheduling(&refused(), false),
        Fail,
        "Operation not permitted",
    );
    check(scheduling(&refused(), true), Fail, "RT_GROUP_SCHED");
    check(throttling("950000\n"), Good, "950000");
    check(throttling("-1"), Good, "off");
    check(throttling("0"), Fail, "no time");
    check(throttling(""), Warn, "unknown");
}

#[test]
fn memory_limits_are_rated() {
    let without = "Name:\tatas\nCapEff:\t0000000000000000\n";
    let with = "CapEff:\t0000000000004000\n";
    check(memory_lock(Some(8 << 20), without), Fail, "8.0 MiB");
    check(memory_lock(Some(8 << 20), with), Good, "CAP_IPC_LOCK");
    check(memory_lock(Some(8 << 20), "CapEff: words"), Fail, "8.0 MiB");
    check(memory_lock(Some(512 << 20), without), Good, "512.0 MiB");
    check(memory_lock(None, ""), Good, "no limit");
    check(shared_memory(1 << 20), Fail, "1.0 MiB");
    check(shared_memory(32 << 20), Warn, "one bus");
    check(shared_memory(1 << 30), Good, "1024.0 MiB");
}

#[test]
fn kernels_and_clocks_are_rated() {
    check(
        kernel("6.12", "#1 SMP PREEMPT_RT Debian"),
        Good,
        "PREEMPT_RT",
    );
    check(
        kernel("6.18", "#1 SMP PREEMPT_DYNAMIC @0"),
        Warn,
        "PREEMPT_DYNAMIC",
    );
    check(kernel("5.10", "#1 SMP Debian"), Warn, "not preemptible");
    check(clock(1, "tsc\n"), Good, "tsc");
    check(clock(1, ""), Good, "1 ns");
    check(clock(1, "acpi_pm"), Warn, "acpi_pm");
    check(clock(4_000_000, "tsc"), Fail, "4000000 ns");
}

#[test]
fn governors_and_isolated_cores_are_rated() {
    let named = |names: &[&str]| {
        names
            .iter()
            .map(|name| format!("{name}\n"))
            .collect::<Vec<_>>()
    };
    check(governor(&[]), Good, "none");
    check(
        governor(&named(&["performance"; 2])),
        Good,
        "performance (2 cores)",
    );
    check(
        governor(&named(&["performance", "powersave"])),
        Warn,
        "powersave (1 core)",
    );
    check(isolated_cores("\n", "0-3\n"), Warn, "none of 4");
    check(isolated_cores("2-3,6\n", "0-7\n"), Good, "[2, 3, 6] of 8");
    check(
        isolated_cores("3\n", "0-1\n"),
        Warn,
        "[3] of the boot options do not exist; there are 2 cores",
    );
    check(isolated_cores("", "0\n"), Warn, "one core");
    check(isolated_cores("three", "0-3"), Warn, "three");
    check(isolated_cores("3-1", "0-3"), Warn, "3-1");
    check(
        isolated_cores("0-4294967295", "0-3"),
        Warn,
        "could not read",
    );
    let cure = isolated_cores("", "0-1\n").fix;
    assert!(
        cure.contains("realtime.cpu = 1"),
        "core does not exist: {cure}"
    );
}

#[test]
fn foreign_user_and_root_are_warned() {
    check(user(1000, None), Good, "1000");
    check(user(1000, Some(1000)), Good, "1000");
    check(user(1000, Some(998)), Warn, "998");
    check(user(0, None), Warn, "root");
}

#[test]
fn foreign_bus_without_gate_access_fails() {
    check(foreign_bus("of user atas", None), Warn, "of user atas");
    let missing = Some("not in group atas".to_owned());
    assert_eq!(
        foreign_bus("of user atas", missing.clone()).fix,
        "not in group atas"
    );
    check(foreign_bus("of user atas", missing), Fail, "of user atas");
}

#[test]
fn leftovers_of_killed_processes_are_found() {
    let file = |name: &str, bus| assert_eq!(bus_of_file(name), bus, "{name}");
    file("atas_0123456789abcdef_x.data", Some("atas"));
    file("fdemo-12-0_0123456789abcdef_y", Some("fdemo-12-0"));
    file("atas_0123456789abcde_x", None);
    file("sem.other", None);
    file("_0123456789abcdef_x", None);
    check(leftovers(&BTreeMap::new()), Good, "none");
    let with = |bytes| BTreeMap::from([("fdemo-1-0".to_owned(), bytes)]);
    check(leftovers(&with(4096)), Good, "none");
    check(
        leftovers(&with(3 << 20)),
        Warn,
        "3.0 MiB in 1 buses that no process uses, the first is \"fdemo-1-0\"",
    );
}

#[test]
fn daemon_status_is_rated() {
    let with = |flags, dropped_records| Status {
        flags,
        dropped_records,
        ..Status::default()
    };
    let frozen = Some(Duration::from_millis(2_500));
    check(daemon(Some(&with(0, 0)), frozen, "atas"), Fail, "2.5 s");
    check(daemon(None, None, "atas"), Warn, "\"atas\"");
    check(daemon(Some(&with(0, 0)), None, "atas"), Good, "mode init");
    check(
        daemon(Some(&with(StatusFlags::DEGRADED, 0)), None, "atas"),
        Fail,
        "DEGRADED",
    );
    check(daemon(Some(&with(0, 7)), None, "atas"), Warn, "7 records");
}

#[test]
fn inaccessible_idle_states_are_warned() {
    let refused = || Err(io::Error::from(io::ErrorKind::PermissionDenied));
    check(idle_states("none\n", &refused()), Good, "none");
    check(idle_states("", &Ok(())), Good, "none");
    check(idle_states("intel_idle\n", &Ok(())), Good, "intel_idle");
    check(
        idle_states("intel_idle\n", &refused()),
        Warn,
        "cpu_dma_latency",
    );
}
