//! Teleoperation through the whole controller.

use atas_core::{OperatorRequest, Outputs};
use robot_model::{HandSide, PerSide};
use shm_schemas::{
    Cause, EventKind, GoalKind, GoalRequest, GoalState, GraspTarget, GripOrder, Hand, Mode, Reason,
    Stamp,
};
use zerocopy::IntoBytes;

use crate::support::MS_NS;
use crate::world::{WIDTH_M, World, grasp, start};

/// Writer epoch of the client.
const CLIENT: u64 = 31;
/// Object position, m, on the right hand's side of the table.
const OBJECT_M: [f64; 3] = [0.3, -0.16, 0.06];
/// Period and validity of targets, ms.
const EVERY: u64 = 20;
const VALID_MS: u64 = 100;

struct Teleop {
    world: World,
    target: GraspTarget,
    sequence: u64,
    last: Outputs,
    warnings: Vec<Reason>,
}

fn teleop_request() -> GoalRequest {
    GoalRequest {
        stamp: Stamp {
            writer_epoch: CLIENT,
            ..Stamp::default()
        },
        goal_id: 9,
        kind: GoalKind::TELEOP,
        hand: Hand::RIGHT,
        ..GoalRequest::default()
    }
}

impl Teleop {
    fn new() -> Self {
        let mut world = World::ready();
        (world.has_object, world.object_m) = (true, OBJECT_M);
        world.log = Some(Vec::new());
        let last = world.request(start(teleop_request()));
        assert_eq!(last.goal_update.map(|u| u.state), Some(GoalState::ACCEPTED));
        let target = GraspTarget {
            hand: Hand::RIGHT,
            centre_m: OBJECT_M,
            opening_m: WIDTH_M + 0.016,
            ..GraspTarget::default()
        };
        Self {
            world,
            target,
            sequence: 0,
            last,
            warnings: Vec::new(),
        }
    }

    fn tick(&mut self) {
        self.last = self.world.tick();
        let events = self.last.events.as_slice().iter();
        let warnings = events.filter(|event| event.kind == EventKind::WARNING);
        self.warnings
            .extend(warnings.map(|event| Reason::from(event.reason)));
    }

    fn stream(&mut self, ms: u64) {
        for tick in 0..ms {
            if tick.is_multiple_of(EVERY) {
                let now_ns = self.world.ms * MS_NS;
                self.target.stamp = Stamp {
                    sequence: self.sequence,
                    captured_ns: now_ns,
                    writer_epoch: CLIENT,
                };
                self.target.valid_until_ns = now_ns + VALID_MS * MS_NS;
                self.target.seal();
                self.sequence += 1;
                self.world.targets.push(self.target);
            }
            self.tick();
        }
    }

    fn pause(&mut self, ms: u64) {
        (0..ms).for_each(|_| self.tick());
    }

    /// Moves around the object and closes until it is carried.
    fn carrying() -> Self {
        let mut teleoperated = Self::new();
        teleoperated.stream(4_000);
        teleoperated.target.opening_m = WIDTH_M - 0.006;
        teleoperated.stream(6_000);
        assert_eq!(teleoperated.step(), "carry");
        teleoperated
    }

    fn step(&self) -> &str {
        self.world.controller.step_name()
    }

    fn centre_m(&self) -> [f64; 3] {
        self.last.report.hands[HandSide::Right.index()].centre_m
    }

    fn off_m(&self, at_m: [f64; 3]) -> f64 {
        let off = self.centre_m().into_iter().zip(at_m);
        let off = off.map(|(is, at)| (is - at).powi(2));
        off.sum::<f64>().sqrt()
    }

    fn forces_n(&self) -> PerSide<f64> {
        let fingers = &self.last.report.hands[HandSide::Right.index()].fingers;
        PerSide::from_fn(|side| f64::from(fingers[side.index()].normal_n))
    }

    fn is_at_rest(&self) -> bool {
        self.last.command.velocity.iter().all(|v| v.abs() < 1e-4)
    }
}

#[test]
fn hand_tracks_target_pose_and_opening() {
    let mut teleoperated = Teleop::new();
    teleoperated.target.centre_m = [0.36, -0.2, 0.12];
    teleoperated.stream(200);
    teleoperated.target.centre_m = [0.28, -0.25, 0.08];
    teleoperated.stream(5_000);
    assert!(
        teleoperated.off_m([0.28, -0.25, 0.08]) < 1e-6,
        "{:?}",
        teleoperated.centre_m()
    );
    let gap_m = crate::world::commanded_gap_m(&teleoperated.last);
    let radii_m = 2.0 * 0.015;
    assert!(
        (gap_m - radii_m - teleoperated.target.opening_m).abs() < 1e-3,
        "{gap_m}"
    );
    assert_eq!(
        (teleoperated.step(), teleoperated.warnings.len()),
        ("teleop", 0)
    );
}

#[test]
fn closing_on_an_object_grips_within_f2() {
    let mut teleoperated = Teleop::carrying();
    let report = teleoperated.last.report.hands[HandSide::Right.index()];
    assert!(
        report.stiffness_n_m > 0.0 && report.f2_n > 0.7,
        "{report:?}"
    );
    for force_n in teleoperated.forces_n() {
        assert!(
            force_n > 0.3 && force_n < f64::from(report.f2_n),
            "{force_n}"
        );
    }
    teleoperated.target.centre_m[2] += 0.04;
    teleoperated.stream(3_000);
    assert!(
        teleoperated.off_m(teleoperated.target.centre_m) < 1e-4,
        "object is lifted"
    );
    assert!(teleoperated.forces_n().iter().all(|n| *n > 0.3));
    teleoperated.target.opening_m = WIDTH_M + 0.02;
    teleoperated.stream(2_000);
    assert_eq!(
        (
            teleoperated.step(),
            teleoperated.forces_n().map(|n| n < 0.05)
        ),
        ("teleop", [true; 2].into())
    );
}

#[test]
fn hold_command_ends_with_a_wider_width() {
    let mut teleoperated = Teleop::new();
    teleoperated.stream(4_000);
    teleoperated.target.grip = GripOrder::HOLD;
    teleoperated.stream(8_000);
    assert_eq!(teleoperated.step(), "carry");
    teleoperated.target.grip = GripOrder::WIDTH;
    teleoperated.target.opening_m = WIDTH_M + 0.0005;
    teleoperated.stream(500);
    assert_eq!(
        teleoperated.step(),
        "carry",
        "a width near the object's keeps the grip"
    );
    teleoperated.target.opening_m = WIDTH_M + 0.02;
    teleoperated.stream(2_000);
    assert_eq!(teleoperated.step(), "teleop");
}

#[test]
fn closing_without_object_waits_for_next_target() {
    let mut teleoperated = Teleop::new();
    teleoperated.world.has_object = false;
    teleoperated.target.opening_m = 0.012;
    teleoperated.stream(5_000);
    teleoperated.target.grip = GripOrder::HOLD;
    teleoperated.stream(6_000);
    assert_eq!(
        (teleoperated.step(), teleoperated.is_at_rest()),
        ("teleop", true)
    );
    assert_eq!(teleoperated.world.mode(), Mode::RUN);
    teleoperated.target.grip = GripOrder::WIDTH;
    teleoperated.target.opening_m = 0.06;
    teleoperated.stream(3_000);
    assert!(crate::world::commanded_gap_m(&teleoperated.last) > 0.08);
}

#[test]
fn silence_brakes_the_hand_and_keeps_grip() {
    let mut teleoperated = Teleop::carrying();
    teleoperated.target.centre_m[2] = 0.18;
    teleoperated.stream(400);
    let held_n = teleoperated.forces_n();
    teleoperated.pause(1_000);
    assert!(
        teleoperated.is_at_rest() && teleoperated.off_m(teleoperated.target.centre_m) > 0.01,
        "stopped on the way"
    );
    assert_eq!(
        teleoperated.warnings.last().map(|r| r.cause()),
        Some(Cause::TARGETS_STOPPED)
    );
    for (force_n, held_n) in teleoperated.forces_n().into_iter().zip(held_n) {
        assert!(force_n > 0.8 * held_n, "{force_n} of {held_n}");
    }
    assert_eq!(
        (teleoperated.step(), teleoperated.world.mode()),
        ("carry", Mode::RUN)
    );
    teleoperated.stream(4_000);
    assert!(
        teleoperated.off_m(teleoperated.target.centre_m) < 1e-4,
        "motion continues"
    );
}

#[test]
fn client_end_ends_goal_and_keeps_grip() {
    for order in [
        OperatorRequest::ClientDisconnected { goal_id: 9 },
        OperatorRequest::Cancel { goal_id: 9 },
    ] {
        let mut teleoperated = Teleop::carrying();
        teleoperated.target.centre_m[2] = 0.18;
        teleoperated.stream(300);
        let end = teleoperated
            .world
            .request(order)
            .goal_update
            .expect("an end");
        assert!(end.state.is_final(), "{}", end.state);
        teleoperated.stream(1_000);
        assert!(
            teleoperated.is_at_rest() && teleoperated.off_m(teleoperated.target.centre_m) > 0.01,
            "targets are ignored"
        );
        assert_eq!(teleoperated.step(), "hold");
        assert!(
            teleoperated.forces_n().iter().all(|n| *n > 0.3),
            "{:?}",
            teleoperated.forces_n()
        );
    }
}

#[test]
fn second_goal_is_rejected_during_teleoperation() {
    let reason = |world: &mut World, request: GoalRequest| {
        let update = world
            .request(start(request))
            .goal_update
            .expect("an answer");
        assert_eq!(update.state, GoalState::REJECTED);
        (update.reason.cause, update.reason.to_string())
    };
    let mut teleoperated = Teleop::new();
    let (cause, sentence) = reason(&mut teleoperated.world, grasp());
    assert_eq!(cause, Cause::BUSY);
    assert_eq!(
        sentence,
        "the goal `teleop` is active; wait for it or cancel it"
    );
    let (cause, _) = reason(&mut teleoperated.world, teleop_request());
    assert_eq!(cause, Cause::BUSY, "second stream");
    let mut grasping = World::reaching();
    let (cause, sentence) = reason(&mut grasping, teleop_request());
    assert_eq!(cause, Cause::BUSY);
    assert_eq!(
        sentence,
        "the goal `grasp` is active; wait for it or cancel it"
    );
}

#[test]
fn hold_stops_teleoperation_and_it_restarts_from_rest() {
    let mut teleoperated = Teleop::new();
    teleoperated.target.centre_m = [0.38, -0.28, 0.2];
    teleoperated.stream(400);
    assert!(!teleoperated.is_at_rest());
    teleoperated.world.silent[1] = true;
    teleoperated.stream(100);
    assert_eq!(
        (teleoperated.world.mode(), teleoperated.is_at_rest()),
        (Mode::HOLD, true)
    );
    let stopped_m = teleoperated.centre_m();
    teleoperated.world.silent[1] = false;
    teleoperated.stream(60);
    assert_eq!(teleoperated.world.mode(), Mode::RUN);
    assert!(teleoperated.off_m(stopped_m) < 0.002, "no jump");
    teleoperated.stream(5_000);
    assert!(teleoperated.off_m(teleoperated.target.centre_m) < 1e-4);
}

#[test]
fn free_fingertip_does_not_press_obstacle() {
    let mut teleoperated = Teleop::new();
    teleoperated.world.has_object = false;
    teleoperated.stream(3_000);
    teleoperated.world.obstructed = true;
    // The force acts on the second fingertip along the closing axis, here x: motion one way
    // increases it, motion the other way does not.
    let x_m = teleoperated.centre_m()[0];
    let moved_m = [0.02, -0.02].map(|by_m| {
        teleoperated.target.centre_m[0] = x_m + by_m;
        teleoperated.stream(2_000);
        teleoperated.centre_m()[0] - x_m
    });
    let forth = moved_m[0] > 0.015 && moved_m[1] > 0.015;
    let back = moved_m[0].abs() < 0.002 && moved_m[1] < -0.015;
    assert!(forth || back, "{moved_m:?}");
    assert_eq!(teleoperated.step(), "teleop");
}

#[test]
fn equal_streams_give_bit_equal_commands() {
    let teleoperated = Teleop::carrying();
    let mut twin = World::ready();
    let log = teleoperated.world.log.as_ref().expect("recorded");
    let commands = log
        .iter()
        .map(|received| twin.controller.step(&received.inputs()).command);
    let last = commands.last().expect("a tick");
    assert_eq!(last.as_bytes(), teleoperated.last.command.as_bytes());
    assert!(
        log.iter()
            .any(|received| !received.inputs().targets.is_empty())
    );
}
