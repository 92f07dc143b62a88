//! Tests of servo failures: each is named, stops the joint states, causes no motion, and is
//! recovered from.

use std::time::Duration;

use atas_robots::emulator::Servo;
use rustix::process::Signal;

use crate::rig::{HAND, Rig, STEP_RAD, middle_rad, shaft_rad, start_chains, two_hands, wait_until};

/// Time in which joint states would arrive.
const A_WHILE: Duration = Duration::from_millis(150);

/// A failure of a servo, its message, and its end.
struct Case {
    joint: usize,
    happens: fn(&mut Servo),
    words: &'static str,
    ends: fn(&mut Servo),
    /// External rotation of the shaft meanwhile, rad.
    turned_rad: f64,
}

fn turn_by(servo: &mut Servo, turn_rad: f64) {
    let there_rad = servo.position() + turn_rad;
    servo.turn_to(there_rad);
}

#[test]
fn servo_failures_are_named_and_recovered_without_jump() {
    let cases = [
        Case {
            joint: 3,
            happens: |servo| servo.set_silent(true),
            words: "servo 4 does not answer (left_wrist_pitch)",
            ends: |servo| servo.set_silent(false),
            turned_rad: 0.0,
        },
        Case {
            joint: HAND + 2,
            happens: |servo| servo.set_power(false),
            words: "servo 3 does not answer (right_elbow_pitch)",
            ends: |servo| {
                turn_by(servo, 0.2);
                servo.set_power(true);
            },
            turned_rad: 0.2,
        },
        Case {
            joint: 1,
            happens: |servo| servo.set_power(false),
            words: "servo 2 does not answer (left_shoulder_pitch)",
            ends: |servo| {
                turn_by(servo, -0.3);
                servo.set_power(true);
            },
            turned_rad: -0.3,
        },
        Case {
            joint: 4,
            happens: |servo| servo.set_torque(false),
            words: "servo 5 (left_wrist_roll) has no torque",
            ends: |_| (),
            turned_rad: 0.0,
        },
        Case {
            joint: HAND + 8,
            happens: |servo| servo.set_temperature(66.0),
            words: "servo 9 (right_finger2_root) is at",
            ends: |servo| servo.set_temperature(40.0),
            turned_rad: 0.0,
        },
        Case {
            joint: 9,
            happens: |servo| servo.set_errors(1 << 5),
            words: "servo 10 (left_finger2_knuckle) reports an error: overload",
            ends: |servo| servo.set_errors(0),
            turned_rad: 0.0,
        },
    ];
    let mut rig = Rig::start();
    let mut standing_rad = middle_rad();
    for (nth, case) in cases.iter().enumerate() {
        rig.begin_commands(20 + nth as u64);
        rig.move_to(0, standing_rad[0]);
        let (before, epoch) = (rig.command, rig.state.stamp.writer_epoch);
        rig.reset_speeds();
        rig.servo(case.joint, case.happens);
        rig.program.wait_for(case.words);
        let is_over = case.words.contains("no torque");
        rig.has_new_state();
        std::thread::sleep(A_WHILE);
        assert!(
            is_over || !rig.has_new_state(),
            "state received after: {}",
            case.words
        );
        let others = (0..22).filter(|joint| *joint != case.joint);
        for joint in others {
            assert!(
                rig.servo(joint, |servo| servo.holds()),
                "{joint} does not hold"
            );
        }
        rig.servo(case.joint, case.ends);
        wait_until("joint states again", || {
            rig.has_new_state();
            rig.state.stamp.writer_epoch != epoch
                && (0..22).all(|joint| rig.servo(joint, |servo| servo.holds()))
        });
        standing_rad[case.joint] += case.turned_rad
            * if case.joint.is_multiple_of(2) {
                1.0
            } else {
                -1.0
            };
        for (joint, here_rad) in standing_rad.iter().enumerate() {
            let told_rad = rig.state.commanded_position[joint];
            assert!(
                (told_rad - here_rad).abs() <= 2.0 * STEP_RAD,
                "{joint}: {told_rad} {here_rad}"
            );
        }
        // A daemon that missed the failure continues with old positions; no servo moves.
        rig.command = before;
        (0..5).for_each(|_| rig.send());
        std::thread::sleep(A_WHILE);
        assert!(rig.fastest_rad_s() < 0.1, "jump after: {}", case.words);
        rig.next_state();
    }
    rig.program.signal(Signal::TERM);
    assert_eq!(rig.program.finish(), Some(0));
}

#[test]
fn damaged_replies_are_counted_and_rejected() {
    let mut rig = Rig::start();
    for chain in &rig.chains {
        chain.set_noise(20_000);
    }
    let mut seen = 0;
    wait_until("500 states", || {
        if rig.has_new_state() {
            seen += 1;
            for (joint, here_rad) in middle_rad().into_iter().enumerate() {
                let told_rad = rig.state.position[joint];
                assert!((told_rad - here_rad).abs() < 0.05, "{joint}: {told_rad}");
            }
        }
        seen >= 500
    });
    rig.program.signal(Signal::TERM);
    rig.program.finish();
    let log = rig.program.log();
    let failures: u64 = log
        .lines()
        .filter_map(|line| {
            line.split_once("; ")
                .filter(|_| line.contains("a cycle every"))
        })
        .flat_map(|(_, counts)| counts.split(", ").take(2))
        .filter_map(|count| count.split_whitespace().next()?.parse::<u64>().ok())
        .sum();
    assert!(failures > 0, "{log}");
}

#[test]
fn echoes_and_glitches_disturb_no_exchange() {
    let mut rig = Rig::start_with(|chain| {
        chain.set_echo(true);
        chain.set_glitch(&[0x00, 0xFF, 0x3C]);
    });
    for joint in [0, HAND] {
        rig.move_to(joint, middle_rad()[joint] + 0.05);
    }
    assert_no_exchange_failed(&rig);
}

/// The echo of a request without reply then arrives after the next request.
#[test]
fn late_echoes_disturb_no_exchange() {
    let mut rig = Rig::start_with(|chain| {
        chain.set_echo(true);
        chain.set_latency(std::time::Duration::from_millis(4));
    });
    (0..20).for_each(|_| rig.next_state());
    assert_no_exchange_failed(&rig);
}

fn assert_no_exchange_failed(rig: &Rig) {
    let log = rig.program.log();
    let warned = log.matches("the adapter echoes requests");
    assert_eq!(warned.count(), rig.chains.len(), "{log}");
    assert!(!log.contains("does not answer") && !log.contains("damaged"));
}

/// At this noise, 2 to 4 % of the replies of single servos are damaged. The cycles, which read all
/// servos at once, fail often: a port that holds its servos takes them over again.
#[test]
fn damaged_replies_do_not_prevent_the_take_over() {
    let mut rig = Rig::start_with(|chain| chain.set_noise(500));
    rig.program.signal(Signal::TERM);
    let exit = rig.program.finish();
    assert_eq!(exit, Some(0), "{}", rig.program.log());
}

/// A goal cannot be below zero: a servo there would turn to zero, or all the way round.
#[test]
fn servo_below_zero_of_its_encoder_gets_no_torque() {
    let (bus, folder) = (
        shm_bus::FreshBus::new("robot"),
        tempfile::TempDir::new().unwrap(),
    );
    let mut map = two_hands();
    let chains = start_chains(&mut map, &middle_rad());
    let lower = atas_robots::joints::load("two-hand-arm").unwrap()[HAND].lower;
    let servo = &mut map.ports[1].servos[0];
    (servo.direction, servo.zero_rad) = (1, -lower);
    let path = folder.path().join("robot.toml");
    std::fs::write(&path, toml::to_string(&map).unwrap()).unwrap();
    for shaft_rad in [-0.02, core::f64::consts::TAU - 0.02] {
        chains[1].servo(1, |servo| servo.turn_to(shaft_rad));
        let arguments = ["run", path.to_str().unwrap(), "--bus", bus.as_str()];
        let mut program = crate::rig::Program::start(&arguments);
        assert_eq!(program.finish(), Some(11), "{}", program.log());
        let log = program.log();
        assert!(log.contains("is below the zero of its encoder"), "{log}");
        assert!(!chains[1].servo(1, |servo| servo.holds()));
    }
}

#[test]
fn servos_must_match_map_at_start() {
    type Change = fn(&mut atas_robots::map::file::MapFile);
    let cases: [(Change, &str); 4] = [
        (
            |map| map.ports[0].servos[2].id = 99,
            "servo 99 does not answer (left_elbow_pitch); check its power, cable and id",
        ),
        (
            |map| map.ports[0].servos[2].model = "xm430-w210".to_owned(),
            "servo 3 (left_elbow_pitch) is xm430-w350, the map requires xm430-w210",
        ),
        (
            |map| map.ports[0].servos[0].zero_rad += 2.5,
            "servo 1 (left_shoulder_yaw) is at -2.",
        ),
        (
            |map| map.ports[1].device = "/dev/nothing-there".to_owned(),
            "could not open /dev/nothing-there",
        ),
    ];
    for (change, words) in cases {
        let bus = shm_bus::FreshBus::new("robot");
        let folder = tempfile::TempDir::new().unwrap();
        let mut map = two_hands();
        let chains = start_chains(&mut map, &middle_rad());
        change(&mut map);
        let path = folder.path().join("robot.toml");
        std::fs::write(&path, toml::to_string(&map).unwrap()).unwrap();
        let mut program =
            crate::rig::Program::start(&["run", path.to_str().unwrap(), "--bus", bus.as_str()]);
        assert_eq!(program.finish(), Some(11), "{}", program.log());
        assert!(program.log().contains(words), "{}", program.log());
        let first_rad = chains[0].servo(1, |servo| servo.position());
        let moved_rad = first_rad - shaft_rad(0, middle_rad()[0]);
        assert!(moved_rad.abs() <= STEP_RAD, "moved by {moved_rad}");
    }
}
