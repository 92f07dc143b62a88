//! The program as a process: exit codes, messages and files.

use std::fs;
use std::os::unix::fs::PermissionsExt;
use std::process::{Command, Output, Stdio};

fn run(arguments: &[&str]) -> (i32, String) {
    let Output { status, stderr, .. } = Command::new(env!("CARGO_BIN_EXE_atas-remote"))
        .args(arguments)
        .env_remove("ATAS_BUS")
        .stdin(Stdio::null())
        .output()
        .expect("it starts");
    let stderr = String::from_utf8(stderr).expect("UTF-8");
    (status.code().expect("a code"), stderr)
}

#[test]
fn local_command_is_rejected() {
    let (code, stderr) = run(&["status"]);
    assert_eq!(code, 2, "{stderr}");
    assert!(stderr.contains("run `atas` instead"), "{stderr}");
}

#[test]
fn check_without_server_is_rejected() {
    let (code, stderr) = run(&["remote", "check"]);
    assert_eq!(code, 2, "{stderr}");
    assert!(stderr.contains("--remote"), "{stderr}");
}

#[test]
fn only_the_owner_may_read_created_keys() {
    let folder = tempfile::tempdir().expect("a folder");
    let out = folder.path().to_str().expect("UTF-8");
    let line = ["remote", "keys", "--out", out, "--host", "localhost"];
    let (code, stderr) = run(&[&line[..], &["--client", "alice"]].concat());
    assert_eq!(code, 0, "{stderr}");
    for name in ["ca.key", "server/key.pem", "alice/key.pem"] {
        let file = fs::metadata(folder.path().join(name)).expect(name);
        assert_eq!(file.permissions().mode() & 0o777, 0o600, "{name}");
    }
}

#[test]
fn name_of_the_servers_folder_is_no_client() {
    let folder = tempfile::tempdir().expect("a folder");
    let out = folder.path().to_str().expect("UTF-8");
    let (code, stderr) = run(&["remote", "keys", "--out", out, "--client", "server"]);
    assert_eq!(code, 2, "{stderr}");
    assert!(!folder.path().join("ca.key").exists());
}
