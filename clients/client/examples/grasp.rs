//! A client of a running daemon: grasps the object in front of the right hand.
//!
//! Start `atas-sim run --object wood` and `atasd`, then
//! `cargo run -p atas-client --example grasp`. The bus is `ATAS_BUS`, or `atas`.

#![allow(clippy::print_stdout, reason = "an example prints its result")]

use std::sync::atomic::AtomicBool;
use std::time::Duration;

use atas_client::goal::{HOLD_S, LIFT_M, Target, grasp};
use atas_client::{ClientError, GoalExecution, Session};
use shm_bus::BusName;
use shm_schemas::Hand;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let session = Session::existing(&BusName::from_env()?)?;
    let object = Target {
        at_m: [0.32, -0.15, 0.0345],
        yaw_rad: std::f64::consts::FRAC_PI_2,
        width_m: 0.05,
        ..Target::default()
    };
    let request = grasp(&object, Hand::RIGHT, LIFT_M, HOLD_S);
    let stop = AtomicBool::new(false);
    let execution = GoalExecution {
        session: &session,
        stop: &stop,
        timeout: Some(Duration::from_secs(60)),
    };
    let mut step = String::new();
    let (progress, _) = execution.run(&request, |progress| {
        if progress.step() != step {
            step = progress.step().to_owned();
            println!("{step}");
        }
        Ok::<(), ClientError>(())
    })?;
    println!("{}: {}", progress.last().state, progress.text());
    Ok(())
}
