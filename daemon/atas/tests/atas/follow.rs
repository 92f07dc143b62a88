//! Teleoperation through the whole controller.

use atas_core::{Order, Outputs};
use robot_model::{Side, VIRTUAL_FINGERS};
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

struct Led {
    world: World,
    target: GraspTarget,
    sequence: u64,
    last: Outputs,
    warnings: Vec<Reason>,
}

fn follow() -> GoalRequest {
    GoalRequest {
        stamp: Stamp {
            writer_epoch: CLIENT,
            ..Stamp::default()
        },
        goal_id: 9,
        kind: GoalKind::FOLLOW,
        hand: Hand::RIGHT,
        ..GoalRequest::default()
    }
}

impl Led {
    fn new() -> Self {
        let mut world = World::ready();
        (world.has_object, world.object_m) = (true, OBJECT_M);
        world.log = Some(Vec::new());
        let last = world.order(start(follow()));
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
        self.warnings.extend(warnings.map(|event| event.reason));
    }

    fn lead(&mut self, ms: u64) {
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
        let mut led = Self::new();
        led.lead(4_000);
        led.target.opening_m = WIDTH_M - 0.006;
        led.lead(6_000);
        assert_eq!(led.step(), "carry");
        led
    }

    fn step(&self) -> &str {
        self.world.controller.step_name()
    }

    fn centre_m(&self) -> [f64; 3] {
        self.last.report.hands[Side::Right.index()].centre_m
    }

    fn off_m(&self, at_m: [f64; 3]) -> f64 {
        let off = self.centre_m().into_iter().zip(at_m);
        let off = off.map(|(is, at)| (is - at).powi(2));
        off.sum::<f64>().sqrt()
    }

    fn forces_n(&self) -> [f64; VIRTUAL_FINGERS] {
        let fingers = &self.last.report.hands[Side::Right.index()].fingers;
        core::array::from_fn(|finger| f64::from(fingers[finger].normal_n))
    }

    fn rests(&self) -> bool {
        self.last
            .command
            .velocity_rad_s
            .iter()
            .all(|v| v.abs() < 1e-4)
    }
}

#[test]
fn the_hand_goes_where_it_is_led_and_its_fingers_open_as_wanted() {
    let mut led = Led::new();
    led.target.centre_m = [0.36, -0.2, 0.12];
    led.lead(200);
    led.target.centre_m = [0.28, -0.25, 0.08];
    led.lead(5_000);
    assert!(
        led.off_m([0.28, -0.25, 0.08]) < 1e-6,
        "{:?}",
        led.centre_m()
    );
    let gap_m = crate::world::commanded_gap_m(&led.last);
    let radii_m = 2.0 * 0.015;
    assert!(
        (gap_m - radii_m - led.target.opening_m).abs() < 1e-3,
        "{gap_m}"
    );
    assert_eq!((led.step(), led.warnings.len()), ("follow", 0));
}

#[test]
fn fingers_that_meet_something_while_closing_hold_it_as_touch_allows() {
    let mut led = Led::carrying();
    let report = led.last.report.hands[Side::Right.index()];
    assert!(
        report.stiffness_n_m > 0.0 && report.f2_n > 0.7,
        "{report:?}"
    );
    for force_n in led.forces_n() {
        assert!(
            force_n > 0.3 && force_n < f64::from(report.f2_n),
            "{force_n}"
        );
    }
    led.target.centre_m[2] += 0.04;
    led.lead(3_000);
    assert!(led.off_m(led.target.centre_m) < 1e-4, "it is lifted");
    assert!(led.forces_n().iter().all(|n| *n > 0.3));
    led.target.opening_m = WIDTH_M + 0.02;
    led.lead(2_000);
    assert_eq!(
        (led.step(), led.forces_n().map(|n| n < 0.05)),
        ("follow", [true; 2])
    );
}

#[test]
fn an_order_to_hold_needs_no_width_and_ends_with_a_wider_one() {
    let mut led = Led::new();
    led.lead(4_000);
    led.target.grip = GripOrder::HOLD;
    led.lead(8_000);
    assert_eq!(led.step(), "carry");
    led.target.grip = GripOrder::WIDTH;
    led.target.opening_m = WIDTH_M + 0.0005;
    led.lead(500);
    assert_eq!(
        led.step(),
        "carry",
        "a width about the object's lets nothing go"
    );
    led.target.opening_m = WIDTH_M + 0.02;
    led.lead(2_000);
    assert_eq!(led.step(), "follow");
}

#[test]
fn fingers_that_meet_without_anything_between_them_wait_for_another_order() {
    let mut led = Led::new();
    led.world.has_object = false;
    led.target.opening_m = 0.012;
    led.lead(5_000);
    led.target.grip = GripOrder::HOLD;
    led.lead(6_000);
    assert_eq!((led.step(), led.rests()), ("follow", true));
    assert_eq!(led.world.mode(), Mode::RUN);
    led.target.grip = GripOrder::WIDTH;
    led.target.opening_m = 0.06;
    led.lead(3_000);
    assert!(crate::world::commanded_gap_m(&led.last) > 0.08);
}

#[test]
fn silence_brakes_the_hand_and_keeps_the_grip() {
    let mut led = Led::carrying();
    led.target.centre_m[2] = 0.18;
    led.lead(400);
    let held_n = led.forces_n();
    led.pause(1_000);
    assert!(
        led.rests() && led.off_m(led.target.centre_m) > 0.01,
        "on its way"
    );
    assert_eq!(
        led.warnings.last().map(|r| r.cause),
        Some(Cause::TARGETS_STOPPED)
    );
    for (force_n, held_n) in led.forces_n().into_iter().zip(held_n) {
        assert!(force_n > 0.8 * held_n, "{force_n} of {held_n}");
    }
    assert_eq!((led.step(), led.world.mode()), ("carry", Mode::RUN));
    led.lead(4_000);
    assert!(led.off_m(led.target.centre_m) < 1e-4, "it goes on");
}

#[test]
fn the_end_of_the_client_ends_the_goal_and_keeps_the_grip() {
    for order in [
        Order::ClientGone { goal_id: 9 },
        Order::Cancel { goal_id: 9 },
    ] {
        let mut led = Led::carrying();
        led.target.centre_m[2] = 0.18;
        led.lead(300);
        let end = led.world.order(order).goal_update.expect("an end");
        assert!(end.state.is_final(), "{}", end.state);
        led.lead(1_000);
        assert!(
            led.rests() && led.off_m(led.target.centre_m) > 0.01,
            "nobody is heard"
        );
        assert_eq!(led.step(), "hold");
        assert!(
            led.forces_n().iter().all(|n| *n > 0.3),
            "{:?}",
            led.forces_n()
        );
    }
}

#[test]
fn goals_and_streams_exclude_each_other_by_name() {
    let reason = |world: &mut World, request: GoalRequest| {
        let update = world.order(start(request)).goal_update.expect("an answer");
        assert_eq!(update.state, GoalState::REJECTED);
        (update.reason.cause, update.reason.to_string())
    };
    let mut led = Led::new();
    let (cause, sentence) = reason(&mut led.world, grasp());
    assert_eq!(cause, Cause::BUSY);
    assert_eq!(
        sentence,
        "the goal `follow` is active; wait for it or cancel it"
    );
    let (cause, _) = reason(&mut led.world, follow());
    assert_eq!(cause, Cause::BUSY, "a second stream");
    let mut grasping = World::reaching();
    let (cause, sentence) = reason(&mut grasping, follow());
    assert_eq!(cause, Cause::BUSY);
    assert_eq!(
        sentence,
        "the goal `grasp` is active; wait for it or cancel it"
    );
}

#[test]
fn doubt_holds_a_led_hand_and_it_begins_again_from_rest() {
    let mut led = Led::new();
    led.target.centre_m = [0.38, -0.28, 0.2];
    led.lead(400);
    assert!(!led.rests());
    led.world.mute[1] = true;
    led.lead(100);
    assert_eq!((led.world.mode(), led.rests()), (Mode::HOLD, true));
    let stopped_m = led.centre_m();
    led.world.mute[1] = false;
    led.lead(60);
    assert_eq!(led.world.mode(), Mode::RUN);
    assert!(led.off_m(stopped_m) < 0.002, "no jump");
    led.lead(5_000);
    assert!(led.off_m(led.target.centre_m) < 1e-4);
}

#[test]
fn what_a_free_fingertip_touches_is_not_pressed() {
    let mut led = Led::new();
    led.world.has_object = false;
    led.lead(3_000);
    led.world.obstructed = true;
    // The force acts on the second fingertip along the closing axis, here x: motion one way
    // increases it, motion the other way does not.
    let x_m = led.centre_m()[0];
    let moved_m = [0.02, -0.02].map(|by_m| {
        led.target.centre_m[0] = x_m + by_m;
        led.lead(2_000);
        led.centre_m()[0] - x_m
    });
    let forth = moved_m[0] > 0.015 && moved_m[1] > 0.015;
    let back = moved_m[0].abs() < 0.002 && moved_m[1] < -0.015;
    assert!(forth || back, "{moved_m:?}");
    assert_eq!(led.step(), "follow");
}

#[test]
fn the_same_stream_gives_the_same_commands_to_the_bit() {
    let led = Led::carrying();
    let mut twin = World::ready();
    let log = led.world.log.as_ref().expect("kept");
    let commands = log
        .iter()
        .map(|heard| twin.controller.step(&heard.inputs()).command);
    let last = commands.last().expect("a tick");
    assert_eq!(last.as_bytes(), led.last.command.as_bytes());
    assert!(log.iter().any(|heard| !heard.inputs().targets.is_empty()));
}
