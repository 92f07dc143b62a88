//! Text of every reason.

use proptest::prelude::*;
use shm_schemas::{
    Body, BodyPair, Cause, GoalField, GoalKind, JointLabel, Mode, ModuleId, Reason, ReasonRecord,
    TargetField,
};
use zerocopy::{FromBytes, IntoBytes};

/// One row per cause: a reason on the wire and its text.
fn table() -> Vec<(ReasonRecord, &'static str)> {
    let limit = |cause, value, limit, index| ReasonRecord {
        cause,
        value,
        limit,
        index,
        ..ReasonRecord::default()
    };
    let body = |hand, joint| Body { hand, joint };
    let collision = BodyPair([body(1, 2), body(0, 10)]).index();
    vec![
        (limit(Cause::NONE, 0.0, 0.0, 0), "nothing to report"),
        (
            limit(Cause::NOT_FINITE, 0.0, 0.0, 8),
            "width of the goal is not finite; send finite numbers",
        ),
        (
            limit(Cause::OUT_OF_RANGE, 0.2, 0.15, 9),
            "lift of the goal is 200.0 mm, the limit is 150.0 mm; choose a value within it",
        ),
        (
            limit(Cause::UNREACHABLE, 0.55, 0.4, 0),
            "goal out of reach: from x is 0.5500 m, the limit is 0.4000 m; use at most 0.4000 m",
        ),
        (
            limit(Cause::UNREACHABLE, 0.15, 0.11, 8),
            "goal out of reach: width is 150.0 mm, the limit is 110.0 mm; use at most 110.0 mm",
        ),
        (
            limit(Cause::UNREACHABLE, 0.01, 0.03, 2),
            "goal out of reach: from z is 0.0100 m, the limit is 0.0300 m; use at least 0.0300 m",
        ),
        (
            limit(Cause::UNREACHABLE, 0.24, 0.21, 9),
            "lift too high: place and lift together are 240.0 mm high, the limit is 210.0 mm; lift \
             less",
        ),
        (
            limit(Cause::UNREACHABLE, 0.0123, 0.0, 4),
            "no arm posture for the place \"to\" with this yaw, width and lift: the fingertips \
             stay 12.3 mm off; move the place or turn the closing axis",
        ),
        (
            limit(Cause::UNKNOWN_GOAL, 99.0, 0.0, 1),
            "field 1 of the goal has the unknown code 99; update the client",
        ),
        (
            limit(Cause::BUSY, 0.0, 0.0, 0),
            "another goal is active; wait for it or cancel it",
        ),
        (
            limit(Cause::BUSY, f64::from(GoalKind::TELEOP.0), 0.0, 0),
            "the goal `teleop` is active; wait for it or cancel it",
        ),
        (
            limit(Cause::TARGETS_STOPPED, 0.0, 0.0, 1),
            "the last target of the right hand has expired; the hand stops and keeps its grip \
             until the next one",
        ),
        (
            limit(Cause::TARGET_CORRUPT, 0.0, 0.0, 0),
            "a target failed its checksum; compute the checksum last",
        ),
        (
            limit(Cause::TARGET_FOREIGN, 0.0, 0.0, 0),
            "a target comes from a writer other than the client of the goal; send the writer epoch \
             of the goal request",
        ),
        (
            limit(Cause::TARGET_STALE, 2.5e6, 0.0, 0),
            "a target came 2.5 ms too late, or out of order; stamp it with CLOCK_MONOTONIC, \
             increase its sequence, and set valid_until_ns in the future",
        ),
        (
            limit(Cause::TARGET_UNKNOWN, 7.0, 0.0, 0),
            "a target names a hand or a grip command (7) that its goal does not have; check the \
             goal's kind and hand",
        ),
        (
            limit(Cause::TARGET_NOT_FINITE, 0.0, 0.0, 4),
            "opening of a target is not finite; send finite numbers",
        ),
        (
            limit(Cause::TARGET_OUT_OF_RANGE, 0.5, 0.4, 0),
            "x of a target is 0.5000 m, the limit is 0.4000 m; the hand keeps its previous target",
        ),
        (
            limit(Cause::ACROSS_THE_MIDDLE, -0.0093, 0.003, 1),
            "the right arm comes within -9.3 mm of the middle plane, needs 3.0 mm during \
             teleoperation; move it home with `atas release --hand right`",
        ),
        (
            limit(Cause::NOT_READY, f64::from(Mode::SAFE_STOP.0), 0.0, 0),
            "the daemon is in mode safe-stop, needs ready; see `atas status`",
        ),
        (
            limit(Cause::HAND_FULL, 0.0, 0.0, 1),
            "the right hand still holds an object; release it first with `atas release --hand right`",
        ),
        (
            limit(Cause::HAND_EMPTY, 0.0, 0.0, 1),
            "the right hand holds no object; grasp one first with `atas grasp`",
        ),
        (
            limit(Cause::NO_SENSOR, 0.0, 0.0, 0),
            "the left hand has no tactile sensor in the configuration; use the other hand",
        ),
        (
            limit(Cause::NO_HAND, 0.0, 0.0, 0),
            "the robot has no left hand; use the other one",
        ),
        (
            limit(Cause::CANNOT_TURN, 0.0, 0.0, 1),
            "the right hand cannot turn a cap: its fingertips cannot pass each other; `atas robot list` shows what each robot \
             can do",
        ),
        (
            limit(Cause::NO_WORKSPACE, 0.0, 0.0, 1),
            "teleoperation of the right hand needs a workspace in its robot file; `atas robot \
             check` prints one",
        ),
        (
            limit(Cause::FINGERTIPS_MISALIGNED, 0.3, 0.2, 0),
            "at the place \"from\" with this width a fingertip would be misaligned by 17.2°, the \
             limit is 11.5°; grasp at another object width, see `atas robot check`",
        ),
        (
            limit(Cause::UNREACHABLE, 1.5, 0.5, 3),
            "closing direction out of reach: from yaw is 85.9°, the nearest possible is 28.6°; \
             turn the closing axis or move the place",
        ),
        (
            limit(Cause::ARMS_COLLIDE, 0.003, 0.01, 0),
            "the arms would come within 3.0 mm of each other, needs 10.0 mm; move the places apart",
        ),
        (
            limit(Cause::ARMS_COLLIDE, 0.0031, 0.01, collision),
            "the right forearm would come within 3.1 mm of the left fingertip 2, needs 10.0 mm; move the places apart, or the \
             other arm away",
        ),
        (
            limit(Cause::NOTHING_TOUCHED, 0.0262, 0.026, 0),
            "closed to 26.2 mm and touched nothing; is the object there?",
        ),
        (
            // The force applied may lie just below the limit, so the text does not ask for more.
            limit(Cause::TOO_HEAVY, 7.93, 8.0, 0),
            "object too heavy: not held with 7.93 N, the limit is 8.00 N (`grasp.f2_max_n`)",
        ),
        (
            limit(Cause::TOO_SOFT, 0.812, 0.83, 0),
            "object too heavy for its stiffness: not held with 0.81 N, the limit F_2 is 0.83 N",
        ),
        (
            limit(Cause::ABOVE_MAX_FORCE, 2.013, 2.0, 0),
            "object not held with 2.01 N, the goal allows 2.00 N (`--max-force`)",
        ),
        (
            limit(Cause::GRIP_FOUND, 3.61, 4.33, 1),
            "the right hand was gripping with 3.61 N when the daemon started; it keeps its grip \
             with up to 4.33 N; `atas release --hand right` opens it",
        ),
        (
            limit(Cause::ROBOT_RESTARTED, 0.0, 0.0, 0),
            "the robot process restarted; the goal has ended, the hands keep their grip",
        ),
        (
            limit(Cause::FORCE_IMPLAUSIBLE, 170.9, 30.0, 0),
            "a fingertip of the left hand reports 170.90 N, the plausible maximum is 30.00 N; \
             check the sensor, or zero it with an empty hand (`atas zero`)",
        ),
        (
            limit(Cause::FORCE_AGAINST_JOINTS, 6.2, 3.9, 1),
            "tactile force 6.20 N and joint-estimated force 3.90 N of the right hand disagree; \
             does the zero drift? The hand keeps its grip; take the object, then `atas estop`, \
             `atas recover`, `atas zero`",
        ),
        (
            limit(Cause::FORCE_AGAINST_OPENING, 2.5, 1.2, 1),
            "the right hand reports a grip force of 2.50 N, after 1.20 N at the lift; its opening \
             does not explain the difference; does the zero drift? Take the object, then `atas zero`",
        ),
        (
            limit(Cause::ELEMENT_STUCK, 12.0, 1.0, 0),
            "element 12 of finger 2 of the left hand is stuck: its reading is constant; it is \
             masked until the reading changes",
        ),
        (
            limit(Cause::NOT_NOW, 0.0, 0.0, 0),
            "not now: zeroing needs mode ready and an empty hand, a change of `[safety]` needs a \
             stopped robot (`atas estop`)",
        ),
        (
            limit(Cause::LOST_OBJECT, 0.01, 0.03, 0),
            "the hand no longer feels the object: force 0.01 N, needs 0.03 N",
        ),
        (
            limit(Cause::TURNED_IN_HAND, 0.0021, 0.0038, 0),
            "the object turned in the hand: lever arm of its weight 2.1 mm, before 3.8 mm; grasp \
             nearer to its centre of mass",
        ),
        (
            limit(Cause::SLIPPED_IN_HAND, 0.0052, 0.0028, 0),
            "the object slipped in the hand by about 5.2 mm, allowed 2.8 mm; the hand keeps its \
             grip",
        ),
        (
            limit(Cause::OUT_OF_FORCE, 8.031, 8.0, 0),
            "still slipping at 8.03 N, the force limit F_2 is 8.00 N: the load is too high",
        ),
        (
            limit(Cause::TIMED_OUT, 20.001, 20.0, 0),
            "took 20.0 s, allowed 20.0 s",
        ),
        (
            limit(Cause::CANCELLED, 0.0, 0.0, 0),
            "cancelled by the client",
        ),
        (
            limit(Cause::CLIENT_GONE, 0.0, 0.0, 0),
            "the client of this attached goal disconnected",
        ),
        (
            limit(Cause::NO_SUPPORT, 0.0181, 0.033, 0),
            "no support found down to 18.1 mm, expected at 33.0 mm; the hand keeps the object",
        ),
        (
            limit(Cause::SLIDING, 0.051, 0.05, 0),
            "the object has been sliding between the fingertips for 0.05 s, allowed 0.05 s",
        ),
        (
            limit(Cause::OBSTRUCTED, 0.0914, 0.06, 1),
            "finger 2 touched an obstacle at 0.09 N, the limit is 0.06 N; clear the path or grasp \
             nearer to the object's top",
        ),
        (
            limit(Cause::UNKNOWN_TASK, 0.0, 0.0, 0),
            "the daemon's configuration has no task of this name; `atasd --check-config` lists the \
             configured tasks",
        ),
        (
            limit(Cause::TASK_TOO_LONG, 1e5, 1e5, 0),
            "the paths of the task are too long to check: more than 100000 postures; add meeting \
             points of the hands, or split the task",
        ),
        (
            limit(Cause::FRAMES_STOPPED, f64::INFINITY, 5e6, 0),
            "no tactile frame of hand left yet; is the sensor process running?",
        ),
        (
            limit(Cause::JOINTS_STOPPED, f64::INFINITY, 5e6, 0),
            "no joint state yet; is the robot process running?",
        ),
        (
            limit(Cause::FRAMES_STOPPED, 6e6, 5e6, 0),
            "no tactile frame of hand left for 6.0 ms, allowed 5.0 ms; is the sensor process running?",
        ),
        (
            limit(Cause::FRAME_STALE, 7.25e6, 5e6, 1),
            "the newest frame of hand right is 7.2 ms old, allowed 5.0 ms",
        ),
        (
            limit(Cause::FRAME_FUTURE, 2e6, 1e6, 1),
            "a frame of hand right is stamped 2.0 ms ahead, allowed 1.0 ms; use CLOCK_MONOTONIC of this machine",
        ),
        (
            limit(Cause::FRAMES_LOST, 6.0, 5.0, 0),
            "6 frames of hand left lost in a row, allowed 5",
        ),
        (
            limit(Cause::FRAME_CORRUPT, 3.0, 0.0, 1),
            "3 frames of hand right failed their checksum",
        ),
        (
            limit(Cause::FRAME_FOREIGN, 0.0, 0.0, 1),
            "a frame of hand right comes from another writer or follows another layout than configured",
        ),
        (
            limit(Cause::ELEMENTS_INVALID, 0.125, 0.1, 0),
            "12 % of the elements of hand left are invalid, allowed 10 %",
        ),
        (
            limit(Cause::FRAMES_FROZEN, 40.0, 40.0, 1),
            "the readings of hand right have not changed for 40 frames, allowed 40",
        ),
        (
            limit(Cause::SENSOR_RESTARTED, 0.0, 0.0, 0),
            "the sensor process of hand left restarted",
        ),
        (
            limit(Cause::JOINTS_STOPPED, 6e6, 5e6, 0),
            "no joint state for 6.0 ms, allowed 5.0 ms; is the robot process running?",
        ),
        (
            limit(Cause::SENSE_ONLY, 0.0, 0.0, 0),
            "sense-only mode: the daemon commands no robot because robot.joints_required is false",
        ),
        (
            limit(Cause::JOINTS_INVALID, 3.5, 0.25, 4),
            "joint 4 reports 3.5000 rad or m, last valid position 0.2500 rad or m",
        ),
        (
            limit(Cause::JOINTS_INVALID, 21.0, 22.0, u32::MAX),
            "a joint state has 21 joints, the robot has 22; start robot process and daemon with \
             the same robot",
        ),
        (
            limit(Cause::FOLLOWING_ERROR, 0.1, 0.08, 7),
            "joint 7 is 0.1000 rad or m off its command, allowed 0.0800 rad or m; is it blocked?",
        ),
        (
            limit(Cause::COMMAND_NOT_FINITE, 0.0, 0.0, 21),
            "the command for joint 21 was not finite",
        ),
        (
            limit(Cause::COMMAND_STEP, 0.5, 0.016, 3),
            "the command for joint 3 jumped by 0.5000 rad or m, allowed 0.0160 rad or m",
        ),
        (
            limit(Cause::GRIP_CEILING, 15.5, 15.0, 1),
            "grip force 15.50 N of grasp side 2 exceeds its limit 15.00 N",
        ),
        (
            limit(Cause::MODULE_PANICKED, 0.0, 0.0, 0),
            "a module panicked; restart the daemon and report this",
        ),
        (
            limit(Cause::LOOP_STALLED, 5.2e9, 3e6, 0),
            "the loop stood still for 5200.0 ms, allowed 3.0 ms",
        ),
        (
            limit(Cause::ESTOP, 0.0, 0.0, 0),
            "stopped by `atas estop`; `atas recover` re-arms",
        ),
        (
            limit(Cause::SHUTDOWN, 0.0, 0.0, 0),
            "the daemon is shutting down",
        ),
        (
            limit(Cause::SUPERVISOR_SILENT, 0.8, 0.5, 0),
            "the daemon's supervisor has not responded for 0.8 s, allowed 0.5 s",
        ),
    ]
}

#[test]
fn every_cause_has_a_text() {
    for (reason, sentence) in table() {
        assert_eq!(reason.to_string(), sentence, "{}", reason.cause);
    }
    for cause in Cause::ALL {
        assert!(
            table().iter().any(|(r, _)| r.cause == *cause),
            "{cause} has no row"
        );
    }
}

/// Values are printed in the unit of the command line or the target file.
#[test]
fn values_are_printed_in_the_input_unit() {
    let goal = |index: u32, value: f64, limit: f64| Reason::OutOfRange {
        field: GoalField(index),
        value,
        limit,
    };
    let target = |index: u32, value: f64, limit: f64| Reason::TargetOutOfRange {
        field: TargetField(index),
        value,
        limit,
    };
    let deg = |degrees: f64| degrees.to_radians();
    for (reason, part) in [
        (
            goal(0, -0.5, 0.2),
            "from x of the goal is -0.5000 m, the limit is 0.2000 m;",
        ),
        (
            goal(3, deg(4000.0), deg(360.0)),
            "from yaw of the goal is 4000.0°, the limit is 360.0°;",
        ),
        (
            goal(6, 9.0, 0.35),
            "to z of the goal is 9.0000 m, the limit is 0.3500 m;",
        ),
        (
            goal(7, deg(-400.0), deg(-360.0)),
            "to yaw of the goal is -400.0°, the limit is -360.0°;",
        ),
        (
            goal(8, 0.5, 0.1),
            "width of the goal is 500.0 mm, the limit is 100.0 mm;",
        ),
        (
            goal(9, 0.9, 0.15),
            "lift of the goal is 900.0 mm, the limit is 150.0 mm;",
        ),
        (
            goal(10, -1.0, 0.0),
            "hold of the goal is -1.0 s, the limit is 0.0 s;",
        ),
        (
            goal(11, 0.5, 0.1),
            "helper width of the goal is 500.0 mm, the limit is 100.0 mm;",
        ),
        (
            goal(12, 5.0, 0.5),
            "top of the goal is 5000.0 mm, the limit is 500.0 mm;",
        ),
        (
            goal(13, 99.0, 8.0),
            "maximum force of the goal is 99.00 N, the limit is 8.00 N;",
        ),
        (
            goal(99, 1.5, 1.0),
            "a value of the goal is 1.5000, the limit is 1.0000;",
        ),
        (
            target(3, 7.0, 6.25),
            "yaw of a target is 7.0000 rad, the limit is 6.2500 rad;",
        ),
        (
            target(4, 0.2, 0.1),
            "opening of a target is 0.2000 m, the limit is 0.1000 m;",
        ),
    ] {
        let output = reason.to_string();
        assert!(output.starts_with(part), "{output}");
    }
}

#[test]
fn reason_text_names_the_module() {
    let reason = Reason::TooHeavy {
        force_n: 8.0,
        limit_n: 7.5,
        module: ModuleId::FORCE_LIMIT,
    };
    assert!(
        reason.to_string().ends_with(" (module 3, force limit)"),
        "{reason}"
    );
}

/// Bytes from the bus may have any value.
#[test]
fn reason_with_unknown_codes_prints() {
    let none = ReasonRecord::default();
    for (record, sentence) in [
        (
            ReasonRecord {
                cause: Cause(999),
                value: 1.0,
                limit: 2.0,
                ..none
            },
            "unknown(999): value 1, limit 2",
        ),
        (
            ReasonRecord {
                cause: Cause::BUSY,
                module: ModuleId(77),
                ..none
            },
            "another goal is active; wait for it or cancel it (unknown(77))",
        ),
        (
            ReasonRecord {
                cause: Cause::NOT_FINITE,
                index: u32::MAX,
                ..none
            },
            "a value of the goal is not finite; send finite numbers",
        ),
        (
            ReasonRecord {
                cause: Cause::HAND_FULL,
                index: 9,
                ..none
            },
            "the unknown(9) hand still holds an object; release it first with `atas release --hand unknown(9)`",
        ),
        (
            ReasonRecord {
                cause: Cause::NOT_READY,
                value: f64::NAN,
                ..none
            },
            "the daemon is in mode init, needs ready; see `atas status`",
        ),
        (
            ReasonRecord {
                cause: Cause::NOT_READY,
                value: 1e300,
                ..none
            },
            "the daemon is in mode unknown(4294967295), needs ready; see `atas status`",
        ),
    ] {
        assert_eq!(record.to_string(), sentence);
    }
}

#[test]
fn every_cause_survives_the_round_trip() {
    for (mut record, _) in table() {
        let reason = Reason::from(record);
        if has_module(reason) {
            record.module = ModuleId::BEHAVIOUR_TABLE;
        }
        let reason = Reason::from(record);
        let back = ReasonRecord::from(reason);
        assert_eq!(back.as_bytes(), record.as_bytes(), "{reason:?}");
        assert_eq!(reason.cause(), record.cause);
        assert!(!matches!(reason, Reason::Unknown(_)), "{reason:?}");
    }
}

/// Returns true for a reason that names the module that reports it.
fn has_module(reason: Reason) -> bool {
    matches!(
        reason,
        Reason::NothingTouched { .. }
            | Reason::TooHeavy { .. }
            | Reason::TooSoft { .. }
            | Reason::AboveMaxForce { .. }
            | Reason::OutOfForce { .. }
            | Reason::NoSupport { .. }
            | Reason::Obstructed { .. }
    )
}

proptest! {
    #[test]
    fn arbitrary_bytes_decode_and_print(mut bytes in any::<[u8; 32]>(), cause in 0..100u32) {
        for known in [false, true] {
            if known {
                bytes[..4].copy_from_slice(&cause.to_le_bytes());
            }
            let record = ReasonRecord::read_from_bytes(&bytes).expect("the size of a reason");
            let reason = Reason::from(record);
            prop_assert!(!record.to_string().is_empty() && !reason.to_string().is_empty());
            prop_assert_eq!(reason.cause(), record.cause);
            // A typed reason survives the round trip.
            let typed = ReasonRecord::from(reason);
            let again = ReasonRecord::from(Reason::from(typed));
            prop_assert_eq!(again.as_bytes(), typed.as_bytes());
        }
    }
}

#[test]
fn reason_without_cause_is_none() {
    assert!(!Reason::default().is_some());
    for cause in Cause::ALL.iter().copied() {
        let record = ReasonRecord {
            cause,
            ..ReasonRecord::default()
        };
        let is_some = cause != Cause::NONE;
        assert_eq!(
            (record.is_some(), Reason::from(record).is_some()),
            (is_some, is_some)
        );
    }
}

#[test]
fn reason_names_the_joint_and_its_unit() {
    let reason = Reason::FollowingError {
        joint: 7,
        error: 0.03,
        limit: 0.02,
    };
    let label = JointLabel {
        name: "gantry",
        unit: "m",
    };
    assert_eq!(
        ReasonRecord::from(reason)
            .text(reason.joint().map(|_| label))
            .to_string(),
        "joint gantry is 0.0300 m off its command, allowed 0.0200 m; is it blocked?"
    );
    let of_side = Reason::GripCeiling {
        side: 1,
        force_n: 15.5,
        limit_n: 15.0,
    };
    assert_eq!(of_side.joint(), None);
}
