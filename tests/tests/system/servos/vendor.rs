//! The servo emulator, checked by the vendors' own Python clients: what `atas-robot` is tested against is what their servos say.

use std::path::Path;
use std::process::Command;

use atas_robots::emulator::{Chain, Planned};
use system_tests::lacking;

/// What the script ends with where the clients are not installed.
const NOT_INSTALLED: i32 = 77;

#[test]
fn dynamixel_servos_answer_as_their_vendors_client_expects() {
    check("dynamixel", ["xm430-w350", "xl330-m288", "xl430-w250"]);
}

#[test]
fn feetech_servos_answer_as_their_vendors_client_expects() {
    check("feetech", ["sts3215"; 3]);
}

fn check(family: &str, models: [&str; 3]) {
    let planned = (1..).zip(models).map(|(id, model)| Planned {
        id,
        model: model.to_owned(),
        position_rad: 3.0,
    });
    let chain = Chain::start(family, &planned.collect::<Vec<_>>(), None).expect("played");
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
    let said = format!(
        "{}{}",
        String::from_utf8_lossy(&output.stdout),
        String::from_utf8_lossy(&output.stderr)
    );
    match output.status.code() {
        Some(0) => {}
        Some(NOT_INSTALLED) => lacking(&format!(
            "{} `pip install dynamixel-sdk feetech-servo-sdk` into target/venv",
            said.trim()
        )),
        code => panic!("ended with {code:?}: {said}"),
    }
}
