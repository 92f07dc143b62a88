//! Inverse kinematics of a built-in robot, or of a robot file.
//!
//! `cargo run -p robot-model --example reach -- [NAME|FILE.toml]`

#![allow(clippy::print_stdout, reason = "an example prints its result")]

use robot_model::{GraspPose, RobotModel};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let name = std::env::args().nth(1).unwrap_or("two-hand-arm".to_owned());
    let robot = RobotModel::find(&name)?;
    println!("{name}: {} joints", robot.joint_count());
    for side in robot.sides() {
        let hand = robot.hand(side);
        let home_m = hand.home_m();
        for down_mm in [0.0, 20.0, 40.0, 60.0, 80.0] {
            let mut centre_m = home_m;
            centre_m.z -= down_mm * 1e-3;
            let grasp = GraspPose::from_above(centre_m, hand.home_yaw_rad(), 0.04);
            match hand.posture_for(&grasp) {
                Ok(found) => println!(
                    "{side:?}: {down_mm:3.0} mm below home: reached within {:.1} µm",
                    found.tip_error_m * 1e6
                ),
                Err(error) => println!("{side:?}: {down_mm:3.0} mm below home: {error}"),
            }
        }
    }
    Ok(())
}
