//! Goals and parameters over the bus, in lock-step if time matters.

use shm_bus::{FreshBus, GoalClient, PendingGoal};
use shm_schemas::layout::{FNV_OFFSET, fnv1a};
use shm_schemas::{
    Cause, ControlOp, ControlOutcome, ControlRequest, GoalKind, GoalPolicy, GoalRequest, GoalState,
    GoalUpdate, Hand, Mode, Status,
};

use crate::support::{Daemon, TIMEOUT, TOLERANT, World, wait_for};

const PERIOD_NS: u64 = 1_000_000;

pub(crate) fn grasp(goal_id: u64) -> GoalRequest {
    GoalRequest {
        goal_id,
        kind: GoalKind::GRASP,
        hand: Hand::RIGHT,
        policy: GoalPolicy::DETACHED,
        from_m: [0.3, -0.1, 0.08],
        width_m: 0.05,
        lift_m: 0.03,
        hold_s: 0.1,
        ..GoalRequest::default()
    }
}

pub(crate) struct LockStep {
    pub(crate) world: World,
    tick: u64,
    /// FNV-1a hash of the checksums of all commands so far.
    commands: u64,
}

impl LockStep {
    pub(crate) fn open(bus: &FreshBus) -> Self {
        let mut world = World::open(bus);
        world.publish(PERIOD_NS);
        Self {
            world,
            tick: 0,
            commands: FNV_OFFSET,
        }
    }

    /// Publishes the next state if the daemon has answered the last one.
    fn step(&mut self) {
        self.world.command.answers_sequence = u64::MAX;
        self.world.receive();
        if self.world.command.answers_sequence == self.tick {
            self.tick += 1;
            self.commands = fnv1a(self.commands, &self.world.command.crc32.to_le_bytes());
            self.world.publish((self.tick + 1) * PERIOD_NS);
        } else {
            self.world.connect_readers();
        }
    }

    pub(crate) fn until_update(
        &mut self,
        pending: &mut PendingGoal,
        wanted: impl Fn(&GoalUpdate) -> bool,
    ) -> GoalUpdate {
        let begin = std::time::Instant::now();
        loop {
            self.step();
            if let Some(update) = pending.next().expect("the daemon lives").filter(&wanted) {
                return update;
            }
            assert!(
                begin.elapsed() < TIMEOUT,
                "timed out waiting for an update in {:?}",
                self.world.newest
            );
            std::thread::yield_now();
        }
    }

    /// Runs until a condition holds.
    pub(crate) fn wait_for(&mut self, what: &str, holds: impl Fn() -> bool) {
        wait_for(what, || {
            self.step();
            holds().then_some(())
        });
    }

    /// Runs until the status matches.
    pub(crate) fn until(&mut self, what: &str, wanted: impl Fn(&Status) -> bool) {
        wait_for(what, || {
            self.step();
            wanted(&self.world.newest).then_some(())
        });
    }

    pub(crate) fn send(&mut self, goals: &GoalClient, goal: &GoalRequest) -> PendingGoal {
        wait_for("the goal server", || {
            self.step();
            goals.send(goal).ok()
        })
    }
}

#[test]
fn invalid_goals_are_rejected_with_reason() {
    let bus = FreshBus::new("reject");
    let mut world = LockStep::open(&bus);
    let _daemon = Daemon::start(&bus, &["--lockstep"]);
    let goals = world.world.bus.goal_client().expect("there is room");
    let good = grasp(1);
    let mut check = |goal: GoalRequest, cause: Cause, message: &str| {
        let mut pending = world.send(&goals, &goal);
        let update = world.until_update(&mut pending, |u| u.state.is_final());
        assert_eq!(
            (update.state, update.reason.cause, update.goal_id),
            (GoalState::REJECTED, cause, goal.goal_id)
        );
        assert!(
            update.reason.to_string().contains(message),
            "{}",
            update.reason
        );
    };
    check(
        GoalRequest {
            width_m: f64::NAN,
            ..good
        },
        Cause::NOT_FINITE,
        "width of the goal is not finite",
    );
    check(
        GoalRequest {
            hold_s: f64::INFINITY,
            ..good
        },
        Cause::NOT_FINITE,
        "hold",
    );
    check(
        GoalRequest {
            hold_s: -1.0,
            ..good
        },
        Cause::OUT_OF_RANGE,
        "hold of the goal is -1",
    );
    check(
        GoalRequest {
            from_m: [9.0, 0.0, 0.1],
            ..good
        },
        Cause::UNREACHABLE,
        "from x is 9",
    );
    check(
        GoalRequest {
            kind: GoalKind(77),
            ..good
        },
        Cause::UNKNOWN_GOAL,
        "field 0",
    );
    check(
        GoalRequest {
            hand: Hand(2),
            ..good
        },
        Cause::UNKNOWN_GOAL,
        "field 1",
    );
    check(
        GoalRequest {
            policy: GoalPolicy(9),
            ..good
        },
        Cause::UNKNOWN_GOAL,
        "field 2",
    );
}

/// Runs one goal in lock-step; returns ticks and states of its updates, and a hash of all commands.
fn run_goals() -> (Vec<(u64, GoalState)>, u64) {
    let bus = FreshBus::new("story");
    let mut world = LockStep::open(&bus);
    let _daemon = Daemon::start(&bus, &["--lockstep"]);
    let goals = world.world.bus.goal_client().expect("there is room");
    let mut pending = world.send(&goals, &grasp(5));
    let mut story = Vec::new();
    while !pending.has_ended() {
        let update = world.until_update(&mut pending, |_| true);
        story.push((update.tick, update.state));
    }
    (story, world.commands)
}

#[test]
fn lock_step_run_is_reproducible() {
    let (updates, commands) = run_goals();
    assert_eq!(
        updates.first(),
        Some(&(100, GoalState::ACCEPTED)),
        "after settling"
    );
    assert_eq!(
        updates.last().map(|last| last.1),
        Some(GoalState::FAILED),
        "there is no object"
    );
    assert_eq!(run_goals(), (updates, commands), "bit-exact");
}

#[test]
fn lock_step_advances_to_the_requested_tick() {
    let bus = FreshBus::new("advance");
    let mut world = LockStep::open(&bus);
    let _daemon = Daemon::start(&bus, &["--lockstep"]);
    let mut let_on = |ticks: f64, outcome, reached: u64| {
        let reply = wait_for("an answer", || {
            world.step();
            let request = ControlRequest {
                op: ControlOp::ADVANCE,
                value: ticks,
                ..ControlRequest::default()
            };
            let controls = world.world.bus.control_client().ok()?;
            controls.call(&request, TIMEOUT).ok()
        });
        assert_eq!(reply.outcome, outcome, "{ticks}: {}", reply.text);
        wait_for("the ticks that it may make", || {
            world.step();
            (world.tick == reached).then_some(())
        });
        // Further ticks would show before another answer.
        for _ in 0..1000 {
            world.step();
            std::thread::yield_now();
        }
        assert_eq!(world.tick, reached, "time stops there");
    };
    let (done, refused) = (ControlOutcome::DONE, ControlOutcome::REFUSED);
    let_on(0.0, done, 100);
    let_on(130.0, done, 130);
    let_on(f64::NAN, refused, 130);
    let_on(-1.0, refused, 130);
    let_on(150.0, done, 150);
}

#[test]
fn busy_cancelled_and_abandoned_goals_end() {
    let bus = FreshBus::new("busy");
    let mut world = LockStep::open(&bus);
    let _daemon = Daemon::start(&bus, &["--lockstep"]);
    let goals = world.world.bus.goal_client().expect("there is room");
    let mut first = world.send(&goals, &grasp(1));
    world.until_update(&mut first, |u| u.state == GoalState::ACCEPTED);
    for goal_id in [1, 2] {
        let mut second = world.send(&goals, &grasp(goal_id));
        let update = world.until_update(&mut second, |u| u.state.is_final());
        assert_eq!(
            (update.state, update.reason.cause),
            (GoalState::REJECTED, Cause::BUSY)
        );
    }
    first.cancel();
    let update = world.until_update(&mut first, |u| u.state.is_final());
    assert_eq!(update.state, GoalState::CANCELLED);

    let attached = GoalRequest {
        policy: GoalPolicy::ATTACHED,
        ..grasp(3)
    };
    let mut third = world.send(&goals, &attached);
    world.until_update(&mut third, |u| u.state == GoalState::ACCEPTED);
    drop(third);
    wait_for("the goal to end", || {
        world.step();
        (world.world.newest.goal_id == 3 && world.world.newest.goal_state == GoalState::FAILED)
            .then_some(())
    });
}

#[test]
fn stop_works_during_a_flood_of_goals() {
    let bus = FreshBus::new("flood");
    let mut world = World::open(&bus);
    let config = "intake.hold_age_s = 0.3\nintake.reject_age_s = 5.0\n";
    let _daemon = Daemon::start_with(&bus, config, &[], |_| ());
    world.until_mode(Mode::READY);
    let goals = world.bus.goal_client().expect("there is room");
    for goal_id in 1..200 {
        drop(goals.send(&grasp(goal_id)));
    }
    assert_eq!(
        world.control(ControlOp::ESTOP, "", 0.0).outcome,
        ControlOutcome::DONE
    );
    world.until_mode(Mode::SAFE_STOP);
}

#[test]
fn parameters_are_read_listed_and_set() {
    let bus = FreshBus::new("params");
    let mut world = World::open(&bus);
    // Zeroing needs mode ready.
    let _daemon = Daemon::start_with(&bus, TOLERANT, &[], |_| ());
    world.until_mode(Mode::READY);
    let before = world.until("a status", |s| s.ticks > 0).config_hash;
    let mut ask = |op, name, value| {
        let reply = world.control(op, name, value);
        (reply.outcome, reply.value, reply.text.as_str().to_owned())
    };
    let default = atas_core::Settings::default().grasp.dr_n;
    let (done, refused, unknown) = (
        ControlOutcome::DONE,
        ControlOutcome::REFUSED,
        ControlOutcome::UNKNOWN,
    );
    let (outcome, value, text) = ask(ControlOp::PARAM_GET, "grasp.dr_n", 0.0);
    assert_eq!((outcome, value), (done, default));
    assert_eq!(
        text.lines().next(),
        Some("grasp.dr_n"),
        "the name, then its meaning"
    );
    assert_eq!(ask(ControlOp::PARAM_SET, "grasp.dr_n", 0.08).0, done);
    assert_eq!(ask(ControlOp::PARAM_GET, "grasp.dr_n", 0.0).1, 0.08);
    for (value, message) in [(99.0, "grasp.dr_n is 99"), (f64::NAN, "grasp.dr_n is NaN")] {
        let (outcome, now, text) = ask(ControlOp::PARAM_SET, "grasp.dr_n", value);
        assert_eq!((outcome, now), (refused, 0.08));
        assert!(text.contains(message), "{text}");
    }
    let (outcome, _, text) = ask(ControlOp::PARAM_SET, "grasp.slip_off", 1.0);
    assert_eq!(outcome, refused);
    assert!(
        text.contains("grasp.slip_off is 1, needs at most grasp.slip_on, which is"),
        "{text}"
    );
    let (outcome, _, text) = ask(ControlOp::PARAM_GET, "grasp.drn", 0.0);
    assert_eq!(
        (outcome, text.contains("did you mean grasp.dr_n")),
        (unknown, true)
    );
    let first = &atas_core::settings::PARAMETERS[0];
    assert_eq!(
        ask(ControlOp::PARAM_LIST, "", 0.0).2,
        format!("{}\n{}", first.name, first.doc.trim())
    );
    for index in [-1.0, 0.5, 1e9, f64::NAN] {
        assert_eq!(ask(ControlOp::PARAM_LIST, "", index).0, unknown);
    }
    assert_eq!(ask(ControlOp::BIAS, "", 1.0).0, done);
    assert_eq!(ask(ControlOp::BIAS, "", 2.0).0, refused);
    assert_eq!(ask(ControlOp(99), "", 0.0).0, unknown);
    assert_eq!(
        ask(ControlOp::ADVANCE, "", 1.0).0,
        refused,
        "the daemon follows the clock"
    );
    world.until("the new configuration", |s| s.config_hash != before);
}
