//! Joint states out, commands in, and what happens when either ends.

use std::time::Duration;

use rustix::process::Signal;
use shm_bus::now_ns;
use shm_schemas::JointCommand;

use crate::rig::{HAND, Rig, STEP_RAD, VALID_NS, middle_rad, shaft_rad, wait_until};

/// A finger of each hand.
const FINGERS: [usize; 2] = [6, HAND + 6];

#[test]
fn joint_states_come_and_commands_are_obeyed() {
    let mut rig = Rig::start();
    assert_eq!((rig.state.joint_count, rig.state.commanded_count), (22, 22));
    assert_eq!(
        rig.state.command_epoch, rig.state.stamp.writer_epoch,
        "what it holds was no daemon's command"
    );
    for (joint, middle_rad) in middle_rad().into_iter().enumerate() {
        for told_rad in [
            rig.state.position_rad[joint],
            rig.state.commanded_rad[joint],
        ] {
            assert!(
                (told_rad - middle_rad).abs() <= STEP_RAD,
                "{joint}: {told_rad} {middle_rad}"
            );
        }
        assert!(rig.servo(joint, |servo| servo.holds()));
    }
    rig.forget_speeds();
    for joint in FINGERS {
        let wanted_rad = middle_rad()[joint] + 0.2;
        rig.move_to(joint, wanted_rad);
        wait_until("the joint", || {
            rig.has_new_state();
            (rig.state.position_rad[joint] - wanted_rad).abs() <= 2.0 * STEP_RAD
        });
        assert_eq!(rig.state.command_epoch, 7);
        assert!(rig.state.command_sequence > 0);
    }
    assert!(
        rig.fastest_rad_s() < 5.6,
        "the servos limit their speed themselves"
    );
    let (before, _) = (rig.state.stamp, rig.next_state());
    assert!(rig.state.stamp.captured_ns > before.captured_ns);
    assert_eq!(rig.state.stamp.writer_epoch, before.writer_epoch);

    rig.program.signal(Signal::TERM);
    assert_eq!(rig.program.finish(), Some(0));
    let log = rig.program.log();
    assert!(
        log.contains("the servos go on holding") && log.contains("Hz: a cycle every"),
        "{log}"
    );
    assert!((0..22).all(|joint| rig.servo(joint, |servo| servo.holds())));
}

#[test]
fn limits_of_force_are_those_of_the_map() {
    let rig = Rig::start();
    let limits = [0, HAND].map(|joint| rig.servo(joint, |servo| servo.current_max_a()));
    assert!(
        (limits[0] - 0.8).abs() < 0.003 && limits[0] <= 0.8,
        "{limits:?}"
    );
    assert!((limits[1] - 0.3 * 2.7).abs() < 0.003, "{limits:?}");
}

#[test]
fn when_commands_end_the_servos_hold_with_torque() {
    let mut rig = Rig::start();
    for joint in FINGERS {
        rig.move_to(joint, middle_rad()[joint] - 0.15);
    }
    let goals_rad = rig.goals_rad();
    wait_until("the expiry", || {
        rig.next_state();
        now_ns() > rig.state.command_valid_until_ns + VALID_NS
    });
    assert_eq!(rig.goals_rad(), goals_rad);
    assert!((0..22).all(|joint| rig.servo(joint, |servo| servo.holds())));
    let told_rad = rig.state.commanded_rad[FINGERS[0]];
    assert!((told_rad - (middle_rad()[FINGERS[0]] - 0.15)).abs() < 1e-9);
    // Another daemon may follow, from there.
    rig.begin_commands(8);
    rig.move_to(FINGERS[0], middle_rad()[FINGERS[0]]);
    wait_until("the other daemon", || {
        rig.has_new_state();
        rig.state.command_epoch == 8
    });
}

/// What also depends on whether the command before has expired is judged in `sim-backend/src/drive.rs`, by the same code.
#[test]
fn a_command_that_breaks_the_contract_moves_nothing() {
    let mut rig = Rig::start();
    let joint = FINGERS[0];
    rig.move_to(joint, middle_rad()[joint] + 0.1);
    type Change = fn(&mut JointCommand);
    let changes: [(&str, Change); 7] = [
        ("a jump", |c| c.position_rad[6] += 0.7),
        ("beyond the limits", |c| c.position_rad[6] = 9.0),
        ("not a number", |c| c.position_rad[6] = f64::NAN),
        ("too fast", |c| c.velocity_rad_s[6] = 30.0),
        ("too few joints", |c| c.joint_count = 21),
        ("for ever", |c| c.valid_until_ns = u64::MAX),
        ("expired", |c| c.valid_until_ns = 1),
    ];
    for (what, change) in changes {
        rig.send();
        let goals_rad = rig.goals_rad();
        let good = rig.command;
        rig.command.position_rad[joint] += 0.005;
        rig.command.stamp.sequence += 1;
        change(&mut rig.command);
        rig.command.seal();
        rig.send_as_it_is();
        rig.has_new_state();
        let told = rig.state.stamp.sequence;
        wait_until("some states", || {
            rig.has_new_state();
            rig.state.stamp.sequence > told + 5
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
        .find_map(|line| line.strip_suffix(" commands refused"));
    assert!(refused.unwrap().parse::<u32>().unwrap() >= 7, "{log}");
}

/// A grip is what the servos are commanded beyond where they are; it outlives this process and is told by the next.
#[test]
fn killed_and_started_again_it_keeps_the_grip_and_nothing_jumps() {
    let mut rig = Rig::start();
    let joint = FINGERS[1];
    let wall_rad = middle_rad()[joint];
    // This shaft turns against its joint or with it: the wall is upwards for the shaft.
    let sign = if joint.is_multiple_of(2) { 1.0 } else { -1.0 };
    rig.servo(joint, |servo| {
        servo.block_at(Some(shaft_rad(joint, wall_rad)))
    });
    let pressed_rad = wall_rad + sign * 0.02;
    rig.move_to(joint, pressed_rad);
    std::thread::sleep(Duration::from_millis(100));
    rig.forget_speeds();
    let epoch = rig.state.stamp.writer_epoch;
    rig.restart();
    wait_until("the next process", || {
        rig.has_new_state();
        rig.state.stamp.writer_epoch != epoch
    });
    assert!((rig.state.commanded_rad[joint] - pressed_rad).abs() <= STEP_RAD);
    assert!((rig.state.position_rad[joint] - wall_rad).abs() <= STEP_RAD);
    assert_ne!(
        rig.state.command_epoch, 0,
        "the daemon believes what is told only then"
    );
    assert!(rig.fastest_rad_s() < 0.05, "something moved");
    assert!((0..22).all(|joint| rig.servo(joint, |servo| servo.holds())));
}
