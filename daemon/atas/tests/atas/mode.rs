//! Mode machine: every transition.

use atas_core::ModeMachine;
use atas_core::limits::REARM_S;
use shm_schemas::{Hand, Mode, Reason};

const STEP_S: f64 = 1e-3;
const REARM_TICKS: u32 = 20;

const HAND: Hand = Hand::LEFT;
const ELEMENTS_INVALID: Reason = Reason::ElementsInvalid {
    hand: HAND,
    share: 0.2,
    limit: 0.1,
};
const FRAMES_STOPPED: Reason = Reason::FramesStopped {
    hand: HAND,
    age_ns: None,
    limit_ns: 5e6,
};
const FRAME_STALE: Reason = Reason::FrameStale {
    hand: HAND,
    age_ns: 6e6,
    limit_ns: 5e6,
};
const FRAMES_LOST: Reason = Reason::FramesLost {
    hand: HAND,
    lost: 6,
    limit: 5.0,
};
const JOINTS_STOPPED: Reason = Reason::JointsStopped {
    age_ns: None,
    limit_ns: 5e6,
};
const FOLLOWING_ERROR: Reason = Reason::FollowingError {
    joint: 0,
    error: 0.1,
    limit: 0.08,
};

fn fault_free(machine: &mut ModeMachine, ticks: u32, has_goal: bool) {
    for _ in 0..ticks {
        machine.update(Reason::None, has_goal, STEP_S);
    }
}

/// Machine that reached this mode by regular transitions.
fn machine_in(mode: Mode) -> ModeMachine {
    let mut machine = ModeMachine::default();
    if mode == Mode::INIT {
        return machine;
    }
    fault_free(&mut machine, REARM_TICKS, false);
    match mode {
        Mode::RUN => machine.update(Reason::None, true, STEP_S),
        Mode::HOLD => machine.update(ELEMENTS_INVALID, false, STEP_S),
        Mode::SAFE_STOP => machine.stop(Reason::Estop),
        Mode::FAULT => machine.fail(Reason::ModulePanicked),
        _ => {}
    }
    assert_eq!(machine.mode(), mode);
    machine
}

#[test]
fn transitions_match_the_diagram() {
    type Act = fn(&mut ModeMachine);
    let acts: [(&str, Act); 7] = [
        ("fault", |m| m.update(ELEMENTS_INVALID, false, STEP_S)),
        ("fault-free tick", |m| m.update(Reason::None, false, STEP_S)),
        ("fault-free tick with a goal", |m| {
            m.update(Reason::None, true, STEP_S)
        }),
        ("fault-free time", |m| fault_free(m, REARM_TICKS + 1, false)),
        ("stop", |m| m.stop(Reason::Estop)),
        ("fail", |m| m.fail(Reason::ModulePanicked)),
        ("recover", ModeMachine::recover),
    ];
    const I: Mode = Mode::INIT;
    const R: Mode = Mode::READY;
    const G: Mode = Mode::RUN;
    const H: Mode = Mode::HOLD;
    const S: Mode = Mode::SAFE_STOP;
    const F: Mode = Mode::FAULT;
    for (from, to) in [
        (I, [I, I, I, R, S, F, I]),
        (R, [H, R, G, R, S, F, R]),
        (G, [H, R, G, R, S, F, G]),
        (H, [H, H, H, R, S, F, H]),
        (S, [S, S, S, S, S, F, H]),
        (F, [F, F, F, F, F, F, F]),
    ] {
        for ((name, act), expected) in acts.iter().zip(to) {
            let mut machine = machine_in(from);
            act(&mut machine);
            assert_eq!(machine.mode(), expected, "{name} in {from}");
        }
    }
}

#[test]
fn hold_ends_after_uninterrupted_fault_free_time() {
    for has_goal in [false, true] {
        let mut machine = machine_in(Mode::HOLD);
        fault_free(&mut machine, REARM_TICKS - 1, has_goal);
        machine.update(ELEMENTS_INVALID, has_goal, STEP_S);
        fault_free(&mut machine, REARM_TICKS - 1, has_goal);
        assert_eq!(machine.mode(), Mode::HOLD, "a fault restarts the time");
        fault_free(&mut machine, 1, has_goal);
        assert_eq!(
            machine.mode(),
            if has_goal { Mode::RUN } else { Mode::READY }
        );
        assert!(!machine.reason().is_some());
    }
}

#[test]
fn first_hold_reason_is_kept() {
    let mut machine = machine_in(Mode::RUN);
    machine.update(ELEMENTS_INVALID, true, STEP_S);
    machine.update(JOINTS_STOPPED, true, STEP_S);
    assert_eq!(machine.reason(), ELEMENTS_INVALID);
    machine.stop(FOLLOWING_ERROR);
    machine.stop(Reason::Estop);
    assert_eq!(machine.reason(), FOLLOWING_ERROR);
    machine.recover();
    assert_eq!(
        (machine.mode(), machine.reason()),
        (Mode::HOLD, FOLLOWING_ERROR)
    );
    machine.fail(Reason::ModulePanicked);
    machine.stop(Reason::Estop);
    assert_eq!(machine.reason(), Reason::ModulePanicked);
}

#[test]
fn init_reports_the_present_reason() {
    let mut machine = ModeMachine::default();
    for reason in [FRAMES_STOPPED, JOINTS_STOPPED] {
        machine.update(reason, false, STEP_S);
        assert_eq!((machine.mode(), machine.reason()), (Mode::INIT, reason));
    }
}

#[test]
fn recovery_waits_in_hold_for_fault_free_time() {
    let mut machine = machine_in(Mode::SAFE_STOP);
    fault_free(&mut machine, 10 * REARM_TICKS, false);
    machine.recover();
    fault_free(&mut machine, REARM_TICKS - 1, false);
    assert_eq!(machine.mode(), Mode::HOLD);
    fault_free(&mut machine, 1, false);
    assert_eq!(machine.mode(), Mode::READY);
}

#[test]
fn fault_free_time_is_independent_of_tick_rate() {
    for rate_hz in [100, 1000, 4000, 10_000] {
        let mut machine = machine_in(Mode::HOLD);
        let mut ticks = 0;
        while machine.mode() == Mode::HOLD {
            machine.update(Reason::None, false, 1.0 / f64::from(rate_hz));
            ticks += 1;
        }
        assert_eq!(ticks, (REARM_S * f64::from(rate_hz)) as u32, "{rate_hz} Hz");
    }
}

/// Regression: a frame 0.1 ms too late paused a goal for 20 ms. On a busy machine, such pauses
/// added up until the goal failed.
#[test]
fn late_data_pause_as_long_as_they_are_missing() {
    let held_ticks = |reasons: &[(Reason, u32)]| {
        let mut machine = machine_in(Mode::RUN);
        for (reason, ticks) in reasons {
            for _ in 0..*ticks {
                machine.update(*reason, true, STEP_S);
            }
        }
        let mut ticks = 0;
        while machine.mode() == Mode::HOLD {
            fault_free(&mut machine, 1, true);
            ticks += 1;
        }
        ticks
    };
    for (reasons, expected) in [
        (&[(FRAMES_STOPPED, 1)][..], 5),
        (&[(JOINTS_STOPPED, 5)], 5),
        (&[(FRAMES_STOPPED, 8), (FRAMES_LOST, 1)], 9),
        (&[(FRAME_STALE, 500)], 20),
        (&[(Reason::SensorRestarted { hand: HAND }, 1)], 20),
        (&[(FRAMES_STOPPED, 1), (ELEMENTS_INVALID, 1)], 20),
        (&[(ELEMENTS_INVALID, 1), (FRAMES_STOPPED, 1)], 20),
    ] {
        assert_eq!(held_ticks(reasons), expected, "{reasons:?}");
    }
}
