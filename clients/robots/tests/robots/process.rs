//! Tests of `atas-robot run`: joint states, commands, and the end of either.

use std::time::Duration;

use rustix::process::Signal;
use shm_bus::now_ns;
use shm_schemas::JointCommand;

use crate::rig::{HAND, Rig, STEP_RAD, VALID_NS, middle_rad, shaft_rad, wait_until};

/// One fingertip joint of each hand.
const FINGERS: [usize; 2] = [6, HAND + 6];

#[test]
fn states_are_published_and_commands_executed() {
    let mut rig = Rig::start();
    assert_eq!((rig.state.joint_count, rig.state.commanded_count), (22, 22));
    assert_eq!(
        rig.state.command_epoch, rig.state.stamp.writer_epoch,
        "the held positions are not from a daemon's command"
    );
    for (joint, middle_rad) in middle_rad().into_iter().enumerate() {
        for told_rad in [
            rig.state.position[joint],
            rig.state.commanded_position[joint],
        ] {
            assert!(
                (told_rad - middle_rad).abs() <= STEP_RAD,
                "{joint}: {told_rad} {middle_rad}"
            );
        }
        assert!(rig.servo(joint, |servo| servo.holds()));
    }
    rig.reset_speeds();
    for joint in FINGERS {
        let wanted = middle_rad()[joint] + 0.2;
        rig.move_to(joint, wanted);
        wait_until("the joint", || {
            rig.has_new_state();
            (rig.state.position[joint] - wanted).abs() <= 2.0 * STEP_RAD
        });
        assert_eq!(rig.state.command_epoch, 7);
        assert!(rig.state.command_sequence > 0);
    }
    assert!(rig.fastest_rad_s() < 5.6, "the servos limit their speed");
    let (before, _) = (rig.state.stamp, rig.next_state());
    assert!(rig.state.stamp.captured_ns > before.captured_ns);
    assert_eq!(rig.state.stamp.writer_epoch, before.writer_epoch);

    rig.program.signal(Signal::TERM);
    assert_eq!(rig.program.finish(), Some(0));
    let log = rig.program.log();
    assert!(
        log.contains("the servos keep holding") && log.contains("Hz: a cycle every"),
        "{log}"
    );
    assert!((0..22).all(|joint| rig.servo(joint, |servo| servo.holds())));
}

#[test]
fn force_limits_match_the_map() {
    let rig = Rig::start();
    let limits = [0, HAND].map(|joint| rig.servo(joint, |servo| servo.current_max_a()));
    assert!(
        (limits[0] - 0.8).abs() < 0.003 && limits[0] <= 0.8,
        "{limits:?}"
    );
    assert!((limits[1] - 0.3 * 2.7).abs() < 0.003, "{limits:?}");
}

#[test]
fn servos_hold_after_commands_end() {
    let mut rig = Rig::start();
    for joint in FINGERS {
        rig.move_to(joint, middle_rad()[joint] - 0.15);
    }
    let mut expire_again = || {
        let expired_ns = now_ns() + VALID_NS;
        wait_until("the expiry", || {
            rig.next_state();
            now_ns() > expired_ns.max(rig.state.command_valid_until_ns + VALID_NS)
        });
        rig.goals_rad()
    };
    assert_eq!(expire_again(), expire_again());
    assert!((0..22).all(|joint| rig.servo(joint, |servo| servo.holds())));
    let told_rad = rig.state.commanded_position[FINGERS[0]];
    assert!((told_rad - (middle_rad()[FINGERS[0]] - 0.15)).abs() < 1e-9);
    // Another daemon may continue from there.
    rig.begin_commands(8);
    rig.move_to(FINGERS[0], middle_rad()[FINGERS[0]]);
    wait_until("the other daemon", || {
        rig.has_new_state();
        rig.state.command_epoch == 8
    });
}

/// Rules that depend on the expiry of the previous command are tested in
/// `sim-backend/src/drive.rs`, which uses the same validator.
#[test]
fn invalid_command_causes_no_motion() {
    let mut rig = Rig::start();
    let joint = FINGERS[0];
    rig.move_to(joint, middle_rad()[joint] + 0.1);
    type Change = fn(&mut JointCommand);
    let changes: [(&str, Change); 7] = [
        ("a jump", |c| c.position[6] += 0.7),
        ("beyond the limits", |c| c.position[6] = 9.0),
        ("not a number", |c| c.position[6] = f64::NAN),
        ("too fast", |c| c.velocity[6] = 30.0),
        ("too few joints", |c| c.joint_count = 21),
        ("unlimited validity", |c| c.valid_until_ns = u64::MAX),
        ("expired", |c| c.valid_until_ns = 1),
    ];
    for (what, change) in changes {
        rig.send();
        let goals_rad = rig.goals_rad();
        let good = rig.command;
        rig.command.position[joint] += 0.005;
        rig.command.stamp.sequence += 1;
        change(&mut rig.command);
        rig.command.seal();
        rig.send_unchanged();
        rig.has_new_state();
        let output = rig.state.stamp.sequence;
        wait_until("some states", || {
            rig.has_new_state();
            rig.state.stamp.sequence > output + 5
        });
        assert_eq!(rig.goals_rad(), goals_rad, "{what}");
        rig.command = good;
        rig.command.stamp.sequence += 2;
    }
    rig.program.signal(Signal::TERM);
    rig.program.finish();
    let log = rig.program.log();
    let refused = log
        .lines()
        .find_map(|line| line.strip_suffix(" commands rejected"));
    assert!(refused.unwrap().parse::<u32>().unwrap() >= 7, "{log}");
}

/// A grip is a commanded position beyond the measured one. It survives a restart and the next
/// process reports it.
#[test]
fn grip_survives_restart_without_jump() {
    let mut rig = Rig::start();
    let joint = FINGERS[1];
    let wall_rad = middle_rad()[joint];
    // The shaft may turn against its joint; the obstacle blocks the positive direction of the
    // shaft.
    let sign = if joint.is_multiple_of(2) { 1.0 } else { -1.0 };
    rig.servo(joint, |servo| {
        servo.block_at(Some(shaft_rad(joint, wall_rad)))
    });
    let pressed_rad = wall_rad + sign * 0.02;
    rig.move_to(joint, pressed_rad);
    std::thread::sleep(Duration::from_millis(100));
    rig.reset_speeds();
    let epoch = rig.state.stamp.writer_epoch;
    rig.restart();
    wait_until("the next process", || {
        rig.has_new_state();
        rig.state.stamp.writer_epoch != epoch
    });
    assert!((rig.state.commanded_position[joint] - pressed_rad).abs() <= STEP_RAD);
    assert!((rig.state.position[joint] - wall_rad).abs() <= STEP_RAD);
    assert_ne!(
        rig.state.command_epoch, 0,
        "the daemon requires a non-zero epoch"
    );
    assert!(rig.fastest_rad_s() < 0.05, "something moved");
    assert!((0..22).all(|joint| rig.servo(joint, |servo| servo.holds())));
}
