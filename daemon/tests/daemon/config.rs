//! Configuration errors name location, value and permitted values.

use std::fs;
use std::path::PathBuf;

use atasd::config::{Config, Cpu, RealtimeMode, Source};
use proptest::prelude::*;
use tempfile::TempDir;

/// Writes the texts as files `0.toml`, `1.toml`, … and returns a source of them.
pub(crate) fn source(texts: &[&str], flags: &[&str]) -> (TempDir, Source) {
    let folder = TempDir::new().expect("a temporary folder");
    let write = |(i, text): (usize, &&str)| -> PathBuf {
        let path = folder.path().join(format!("{i}.toml"));
        fs::write(&path, text).expect("the folder is writable");
        path
    };
    // Without a text, an empty file replaces the machine's own configuration.
    let texts = if texts.is_empty() { &[""] } else { texts };
    let files = texts.iter().enumerate().map(write).collect();
    (
        folder,
        Source {
            files,
            flags: flags.iter().map(|f| (*f).to_owned()).collect(),
        },
    )
}

pub(crate) fn check_rejected(texts: &[&str], flags: &[&str], wanted: &str) {
    let (folder, source) = source(texts, flags);
    let message = source.load().expect_err("must be refused").to_string();
    let folder = format!("{}/", folder.path().display());
    let message = message.replace(&folder, "");
    assert_eq!(
        message,
        format!(
            "could not use the configuration:\n  {}",
            wanted.replace('|', "\n  ")
        )
    );
}

#[test]
fn invalid_values_are_reported_with_location() {
    let check = |text: &str, wanted: &str| check_rejected(&[text], &[], wanted);
    // Unknown keys.
    check(
        "\n[grasp]\ndrn = 1.0",
        "0.toml:3: grasp.drn is not a key; did you mean grasp.dr_n?",
    );
    check(
        "[grsp]\ndr_n = 1.0",
        "0.toml:2: grsp.dr_n is not a key; did you mean grasp.dr_n?",
    );
    check(
        "[safety]\ndisagree_n = 0.4",
        "0.toml:2: safety.disagree_n was renamed to safety.force_mismatch_n; use the new name",
    );
    check(
        "[follow]\nmove_m_s = 0.1",
        "0.toml:2: follow.move_m_s was renamed to teleop.move_m_s; use the new name",
    );
    check(
        "[follow]",
        "0.toml:1: follow was renamed to teleop; use the new name",
    );
    check("[grsp]", "0.toml:1: grsp is not a key; did you mean grasp?");
    check(
        "rate_hz = 5",
        "0.toml:1: rate_hz is not a key; did you mean realtime.rate_hz?",
    );
    check(
        "zzz = 5",
        "0.toml:1: zzz is not a key; `atasd --check-config` prints all keys",
    );
    check(
        "grasp = 5",
        "0.toml:1: grasp is 5, needs to be a section with keys",
    );
    check(
        "[hands.middle]\nfingers = 1",
        "0.toml:2: hands.middle.fingers is not a key; did you mean hands.left.fingers?",
    );
    // Ranges, types and invalid numbers.
    check(
        "grasp.dr_n = 11",
        "0.toml:1: grasp.dr_n is 11, needs a number from 0.005 to 10",
    );
    check(
        "grasp.dr_n = nan",
        "0.toml:1: grasp.dr_n is nan, needs a number from 0.005 to 10",
    );
    check(
        "grasp.dr_n = inf",
        "0.toml:1: grasp.dr_n is inf, needs a number from 0.005 to 10",
    );
    check(
        "grasp.dr_n = \"1\"",
        "0.toml:1: grasp.dr_n is \"1\", needs a number from 0.005 to 10",
    );
    check(
        "grasp.dr_n = [1.0]",
        "0.toml:1: grasp.dr_n is [1.0], needs a number from 0.005 to 10",
    );
    check(
        "grasp.dr_n.x = 1.0",
        "0.toml:1: grasp.dr_n is { x = 1.0 }, needs a number from 0.005 to 10",
    );
    check(
        "realtime.mode = \"yes\"",
        "0.toml:1: realtime.mode is \"yes\", needs \"require\", \"try\" or \"off\"",
    );
    check(
        "realtime.priority = 99",
        "0.toml:1: realtime.priority is 99, needs a whole number from 1 to 98",
    );
    check(
        "realtime.priority = 1.5",
        "0.toml:1: realtime.priority is 1.5, needs a whole number from 1 to 98",
    );
    check(
        "realtime.cpu = -1",
        "0.toml:1: realtime.cpu is -1, needs \"any\" or the number of a core, 0 to 1023",
    );
    check(
        "realtime.cpu = \"two\"",
        "0.toml:1: realtime.cpu is \"two\", needs \"any\" or the number of a core, 0 to 1023",
    );
    check(
        "realtime.rate_hz = 99",
        "0.toml:1: realtime.rate_hz is 99, needs a whole number from 100 to 10000",
    );
    check(
        "realtime.spin_us = 101",
        "0.toml:1: realtime.spin_us is 101, needs a whole number from 0 to 100",
    );
    check(
        "robot.model = \"\"",
        "0.toml:1: robot.model is \"\", needs the name of a shipped robot (`atas robot list`) or \
         the path of a robot file",
    );
    check(
        "robot.joints_required = 1",
        "0.toml:1: robot.joints_required is 1, needs true or false",
    );
    check(
        "hands.left.fingers = 5",
        "0.toml:1: hands.left.fingers is 5, needs a whole number from 1 to 4, or 0 for the number \
         in the robot file",
    );
    check(
        "hands.right.rate_hz = 0",
        "0.toml:1: hands.right.rate_hz is 0, needs a number from 1 to 10000",
    );
    check(
        "hands.right.required = \"no\"",
        "0.toml:1: hands.right.required is \"no\", needs true or false",
    );
    // Several findings, in order.
    check(
        "[grasp]\ndr_n = 0\nslip_onn = 1",
        "0.toml:2: grasp.dr_n is 0, needs a number from 0.005 to 10|\
         0.toml:3: grasp.slip_onn is not a key; did you mean grasp.slip_on?",
    );
    // Values in conflict with each other.
    check(
        "[grasp]\nslip_off = 0.6\nslip_on = 0.5\nrelax_below = 0.4\n",
        "0.toml:2: grasp.slip_off is 0.6, needs at most grasp.slip_on, which is 0.5",
    );
    check(
        "[realtime]\nrate_hz = 10000\nspin_us = 60\n",
        "0.toml:3: realtime.spin_us is 60, needs at most 50, 0.5 of a period at realtime.rate_hz = 10000",
    );
    check(
        "[realtime]\nrate_hz = 200\n",
        "safety.valid_s is 0.005 by default, needs at least 0.0075, 1.5 of a period at realtime.rate_hz = 200",
    );
    let default = Config::default().perception.touch_off_n;
    check(
        "[perception]\ntouch_on_n = 0.001\n",
        &format!(
            "perception.touch_off_n is {default} by default, needs at most perception.touch_on_n, which is 0.001"
        ),
    );
}

#[test]
fn invalid_layout_is_rejected() {
    let needs = "needs \"robot\", \"dome-41\", \"dome-1\", \"pad-N\", \"flat-RxC-P\", \"cylinder-RxC-P-Q\" or \
                 { normals = [[x, y, z], …], radius_m = … or positions_m = [[x, y, z], …], element_area_m2 = … } \
                 with 1 to 64 unit vectors that do not point along x";
    check_rejected(
        &["hands.left.layout = \"dome-42\""],
        &[],
        &format!("0.toml:1: hands.left.layout is \"dome-42\", {needs}"),
    );
    let own = "{ normals = [[0.0, 0.0, 2.0]], radius_m = 0.015, element_area_m2 = 0.0001 }";
    check_rejected(
        &[&format!("hands.left.layout = {own}")],
        &[],
        &format!(
            "0.toml:1: hands.left.layout is {{ element_area_m2 = 0.0001, normals = [[0.0, 0.0, 2.0]], radius_m = 0.015 }}, {needs}"
        ),
    );
}

#[test]
fn syntax_errors_name_the_line() {
    let (_folder, source) = source(&["[grasp]\ndr_n = \n"], &[]);
    let message = source.load().expect_err("must be refused").to_string();
    assert!(message.contains("0.toml:2: is not TOML: "), "{message}");
}

#[test]
fn unreadable_flags_and_files_are_named() {
    check_rejected(
        &[],
        &["grasp.dr_n"],
        "--set: is not TOML: \"grasp.dr_n\" needs the form section.key=value",
    );
    check_rejected(
        &[],
        &["grasp.dr_n=x"],
        "--set: grasp.dr_n is \"x\", needs a number from 0.005 to 10",
    );
    let missing = Source {
        files: vec!["/nowhere/atas.toml".into()],
        flags: vec![],
    };
    let message = missing.load().expect_err("must be refused").to_string();
    assert!(
        message.contains("/nowhere/atas.toml: could not read the file: No such file"),
        "{message}"
    );
    check_rejected(
        &[],
        &["robot.model=/nowhere/robot.toml"],
        &format!(
            "robot.model: {}",
            robot_model::RobotModel::find("/nowhere/robot.toml").expect_err("missing")
        ),
    );
}

#[test]
fn later_value_wins_and_text_reads_back() {
    let texts = [
        "[grasp]\ndr_n = 0.1\nslip_on = 0.95\n[realtime]\ncpu = 3",
        "grasp.dr_n = 1",
    ];
    let (_folder, files) = source(&texts, &["realtime.mode=off", "grasp.f1_max_n = 2"]);
    let config = files.load().expect("valid");
    assert_eq!(
        (
            config.grasp.dr_n,
            config.grasp.slip_on,
            config.grasp.f1_max_n
        ),
        (1.0, 0.95, 2.0)
    );
    assert_eq!(
        (config.realtime.mode, &config.realtime.cpu),
        (RealtimeMode::Off, &Cpu::Core(3))
    );
    let (_folder, again) = source(&[&config.text()], &[]);
    assert_eq!(again.load().expect("valid"), config);
    assert_ne!(config.hash(), Config::default().hash());
}

#[test]
fn single_optoforce_sensor_works_without_a_robot() {
    let text = "\
        [robot]\njoints_required = false\n\
        [hands.left]\nlayout = \"dome-1\"\nfingers = 1\n\
        [hands.right]\nrequired = false\n\
        [intake]\nelement_force_n = 2000.0\n\
        [perception]\ntouch_on_n = 19.8\ntouch_off_n = 9.9\n";
    let (_folder, source) = source(&[text], &[]);
    let robot = robot_model::RobotModel::two_hand_arm().expect("the robot is shipped");
    let wiring = source
        .load()
        .expect("valid")
        .sensor_setup(&robot, 1)
        .expect("valid");
    assert!(!wiring.joints_required && wiring.hands[0].required && !wiring.hands[1].required);
    assert_eq!(
        (wiring.hands[0].layout.count, wiring.hands[0].fingers),
        (1, 1)
    );
}

proptest! {
    #[test]
    fn any_text_causes_no_panic(text in "(?s).{0,200}") {
        let (_folder, source) = source(&[&text], &[]);
        let _either = source.load();
    }

    #[test]
    fn any_flag_causes_no_panic(flag in "[a-z_.]{0,20}=?.{0,20}") {
        let (_folder, source) = source(&[], &[&flag]);
        let _either = source.load();
    }

    #[test]
    fn accepted_numbers_are_valid_settings(key in proptest::sample::select(atasd::config::known_keys().collect::<Vec<_>>()), value: f64) {
        let (_folder, source) = source(&[&format!("{key} = {value:?}")], &[]);
        if let Ok(config) = source.load() {
            prop_assert!(config.settings().check().is_ok());
        }
    }
}
