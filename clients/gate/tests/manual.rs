//! The manual page lists every option; a missing socket is reported.

use std::process::{Command, Stdio};

const MANUAL: &str = include_str!("../../../daemon/systemd/atas-gate.8");

fn gate() -> Command {
    Command::new(env!("CARGO_BIN_EXE_atas-gate"))
}

#[test]
fn manual_has_every_option() {
    let help = gate().arg("--help").output().expect("it starts");
    let help = String::from_utf8(help.stdout).expect("UTF-8");
    let flags = help
        .split_whitespace()
        .filter(|word| word.starts_with("--") && word.len() > 2);
    let mut seen = 0;
    for flag in flags {
        assert!(
            MANUAL.contains(&flag.replace('-', "\\-")),
            "the manual lacks {flag}"
        );
        seen += 1;
    }
    assert!(seen >= 3, "{help}");
    assert!(
        MANUAL.contains(atas_gate::message::SOCKET)
            && MANUAL.contains(atas_gate::message::SOCKET_ENV)
    );
}

#[test]
fn missing_socket_is_reported_with_its_remedy() {
    let output = gate().stdin(Stdio::null()).output().expect("it starts");
    assert_eq!(output.status.code(), Some(1));
    let printed = String::from_utf8_lossy(&output.stderr);
    assert!(
        printed.contains("start this program by `atas-gate.socket`"),
        "{printed}"
    );
}
