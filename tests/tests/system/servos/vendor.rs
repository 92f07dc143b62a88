//! Verifies the servo emulator with the vendors' Python clients.

use std::path::Path;
use std::process::Command;

use atas_robots::emulator::{Chain, PlannedServo};
use system_tests::skip_or_fail;

/// Exit code of the script if the clients are not installed.
const NOT_INSTALLED: i32 = 77;

#[test]
fn dynamixel_emulator_works_with_vendor_client() {
    check("dynamixel", ["xm430-w350", "xl330-m288", "xl430-w250"]);
}

#[test]
fn feetech_emulator_works_with_vendor_client() {
    check("feetech", ["sts3215"; 3]);
}

fn check(family: &str, models: [&str; 3]) {
    let planned = (1..).zip(models).map(|(id, model)| PlannedServo {
        id,
        model: model.to_owned(),
        position: 3.0,
    });
    let chain =
        Chain::start(family, &planned.collect::<Vec<_>>(), None).expect("the emulator starts");
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let installed = root.join("../target/venv/bin/python");
    let python = if installed.exists() {
        installed
    } else {
        "python3".into()
    };
    let output = Command::new(python)
        .arg(root.join("tests/system/servos/vendor.py"))
        .arg(family)
        .arg(chain.path())
        .output()
        .expect("Python runs");
    let message = format!(
        "{}{}",
        String::from_utf8_lossy(&output.stdout),
        String::from_utf8_lossy(&output.stderr)
    );
    match output.status.code() {
        Some(0) => {}
        Some(NOT_INSTALLED) => skip_or_fail(&format!(
            "{} `pip install dynamixel-sdk feetech-servo-sdk` into target/venv",
            message.trim()
        )),
        code => panic!("vendor.py ended with {code:?}: {message}"),
    }
}
