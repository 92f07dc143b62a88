use super::*;
use crate::doctor::finding::Verdict::{self, Fail, Ok as Good, Warn};

fn check(finding: Finding, verdict: Verdict, part: &str) {
    assert_eq!(finding.verdict, verdict, "{finding:?}");
    assert!(finding.found.contains(part), "{finding:?}");
    assert_eq!(finding.fix.is_empty(), verdict == Good, "{finding:?}");
    assert_eq!(finding.cost.is_empty(), verdict == Good, "{finding:?}");
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
    check(shared_memory(1 << 20, 64 << 20), Fail, "1.0 MiB");
    check(shared_memory(32 << 20, 64 << 20), Warn, "one bus");
    check(
        shared_memory(1 << 30, 1 << 31),
        Good,
        "1024.0 MiB of 2048.0 MiB",
    );
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

#[test]
fn small_real_time_limits_fail() {
    let limits = |priority, time_us| RealtimeLimits { priority, time_us };
    let nice = "CapEff:\t0000000000800000\n";
    check(
        realtime_limits(limits(None, None), ""),
        Good,
        "no time limit",
    );
    check(
        realtime_limits(limits(Some(80), Some(20_000)), ""),
        Good,
        "20000 µs",
    );
    check(realtime_limits(limits(Some(79), None), ""), Fail, "79");
    check(realtime_limits(limits(Some(0), None), nice), Good, "80");
    check(
        realtime_limits(limits(None, Some(200)), nice),
        Fail,
        "RLIMIT_RTTIME is 200 µs",
    );
}

#[test]
fn interrupts_on_isolated_cores_are_warned() {
    let on = |lists: &[&str]| {
        let numbered = lists.iter().zip(24..);
        numbered
            .map(|(cores, number)| Interrupt {
                number,
                cores: (*cores).to_owned(),
            })
            .collect::<Vec<_>>()
    };
    check(interrupts(&on(&["0-3"]), "", "0-3"), Good, "no isolated");
    check(interrupts(&on(&["0-3"]), "0-3", "0-3"), Good, "no isolated");
    check(interrupts(&on(&["0", "1-2"]), "3\n", "0-3\n"), Good, "[3]");
    check(interrupts(&on(&["", "three"]), "3", "0-3"), Good, "none on");
    let warned = interrupts(&on(&["0-3\n", "0", "3"]), "3\n", "0-3\n");
    assert!(
        warned.fix.contains("for i in 24 26; do echo 0,1,2"),
        "{warned:?}"
    );
    check(warned, Warn, "[24, 26]");
}

#[test]
fn saving_power_modes_are_warned() {
    let mode = |profile: &str, preference: &str, is_on_battery| PowerMode {
        profile: profile.to_owned(),
        preferences: vec!["performance".to_owned(), preference.to_owned()],
        is_on_battery,
    };
    let check_mode = |mode: PowerMode, verdict, part| check(power_mode(&mode), verdict, part);
    check_mode(PowerMode::default(), Good, "no limit");
    check_mode(
        mode("balanced\n", "balance_performance\n", false),
        Good,
        "balanced",
    );
    check_mode(mode("low-power\n", "performance", false), Warn, "low-power");
    check_mode(mode("", "balance_power\n", false), Warn, "balance_power");
    check_mode(mode("performance\n", "performance", true), Warn, "battery");
}

#[test]
fn restrictions_of_containers_are_warned() {
    let texts = |texts: &[&str]| texts.iter().map(|text| (*text).to_owned()).collect();
    let free = Confinement {
        container: Some("docker".to_owned()),
        quotas: texts(&["max 100000\n", "-1 100000"]),
        memory: texts(&["max\n", "8589934592\n"]),
        allowed: "0-3\n".to_owned(),
        isolated: "3\n".to_owned(),
    };
    check(container(&Confinement::default()), Good, "no container");
    check(container(&free), Good, "docker");
    let quota = Confinement {
        quotas: texts(&["150000 100000\n", "50000 100000\n"]),
        ..free.clone()
    };
    check(container(&quota), Warn, "0.50 cores");
    let memory = Confinement {
        memory: texts(&["max\n", "134217728\n"]),
        ..free.clone()
    };
    check(container(&memory), Warn, "128.0 MiB");
    let cores = Confinement {
        allowed: "0-1\n".to_owned(),
        ..free.clone()
    };
    check(container(&cores), Warn, "[3]");
    let unknown = Confinement {
        allowed: String::new(),
        ..free
    };
    check(container(&unknown), Good, "docker");
}

#[test]
fn differing_versions_are_warned() {
    let same = Versions {
        own: "1.0",
        daemon: Some("1.0".to_owned()),
        installed: vec![("atas-lab".to_owned(), "1.0".to_owned())],
        replaced: Vec::new(),
    };
    check(versions(&same), Good, "1.0");
    let daemon = Versions {
        daemon: Some("0.9".to_owned()),
        ..same.clone()
    };
    check(versions(&daemon), Warn, "daemon is 0.9");
    let installed = Versions {
        installed: vec![("atas-lab".to_owned(), "0.8".to_owned())],
        ..same.clone()
    };
    check(versions(&installed), Warn, "atas-lab 0.8");
    let replaced = Versions {
        replaced: vec!["atasd (process 7)".to_owned()],
        ..same
    };
    check(versions(&replaced), Warn, "process 7");
}

#[test]
fn unused_and_absent_buses_are_warned() {
    check(unused_bus("atas"), Warn, "\"atas\"");
    check(absent_bus("it is not there"), Warn, "not there");
    assert!(!is_leftover(4096) && is_leftover(3 << 20));
}
