//! Observer commands as processes: exit codes and messages.

use std::process::{Command, Output, Stdio};

use shm_bus::FreshBus;

fn run(arguments: &[&str]) -> (i32, String) {
    let Output { status, stderr, .. } = Command::new(env!("CARGO_BIN_EXE_atas-live"))
        .args(arguments)
        .env_remove("ATAS_BUS")
        .stdin(Stdio::null())
        .output()
        .expect("it starts");
    let stderr = String::from_utf8(stderr).expect("UTF-8");
    (status.code().expect("a code"), stderr)
}

#[test]
fn command_of_another_program_is_rejected() {
    let (code, stderr) = run(&["status"]);
    assert_eq!(code, 2, "{stderr}");
    assert!(stderr.contains("run `atas` instead"), "{stderr}");
}

#[test]
fn teleoperation_without_daemon_exits_with_3() {
    let (bus, folder) = (
        FreshBus::new("noteleop"),
        tempfile::tempdir().expect("a folder"),
    );
    let file = folder.path().join("targets.csv");
    let targets = "t_s,hand,x_m,y_m,z_m,yaw_rad,opening_m\n0,right,0.3,-0.1,0.1,1.57,0.07\n";
    std::fs::write(&file, targets).expect("written");
    let file = file.to_str().expect("UTF-8");
    let (code, stderr) = run(&["teleop", file, "--bus", bus.as_str()]);
    assert_eq!(code, 3, "{stderr}");
    assert_eq!(stderr.lines().count(), 1, "{stderr}");
}
