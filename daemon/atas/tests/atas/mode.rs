//! Mode machine: every transition.

use atas_core::ModeMachine;
use atas_core::limits::REARM_S;
use shm_schemas::{Cause, Mode, Reason};

const STEP_S: f64 = 1e-3;
const REARM_TICKS: u32 = 20;

fn hold_reason() -> Reason {
    Reason::new(Cause::ELEMENTS_INVALID)
}

fn fault_free(machine: &mut ModeMachine, ticks: u32, has_goal: bool) {
    for _ in 0..ticks {
        machine.update(Reason::default(), has_goal, STEP_S);
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
        Mode::RUN => machine.update(Reason::default(), true, STEP_S),
        Mode::HOLD => machine.update(hold_reason(), false, STEP_S),
        Mode::SAFE_STOP => machine.stop(Reason::new(Cause::ESTOP)),
        Mode::FAULT => machine.fail(Reason::new(Cause::MODULE_PANICKED)),
        _ => {}
    }
    assert_eq!(machine.mode(), mode);
    machine
}

#[test]
fn transitions_match_the_diagram() {
    type Act = fn(&mut ModeMachine);
    let acts: [(&str, Act); 7] = [
        ("fault", |m| m.update(hold_reason(), false, STEP_S)),
        ("fault-free tick", |m| {
            m.update(Reason::default(), false, STEP_S)
        }),
        ("fault-free tick with a goal", |m| {
            m.update(Reason::default(), true, STEP_S)
        }),
        ("fault-free time", |m| fault_free(m, REARM_TICKS + 1, false)),
        ("stop", |m| m.stop(Reason::new(Cause::ESTOP))),
        ("fail", |m| m.fail(Reason::new(Cause::MODULE_PANICKED))),
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
        machine.update(hold_reason(), has_goal, STEP_S);
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
    machine.update(hold_reason(), true, STEP_S);
    machine.update(Reason::new(Cause::JOINTS_STOPPED), true, STEP_S);
    assert_eq!(machine.reason().cause, hold_reason().cause);
    machine.stop(Reason::new(Cause::FOLLOWING_ERROR));
    machine.stop(Reason::new(Cause::ESTOP));
    assert_eq!(machine.reason().cause, Cause::FOLLOWING_ERROR);
    machine.recover();
    assert_eq!(
        (machine.mode(), machine.reason().cause),
        (Mode::HOLD, Cause::FOLLOWING_ERROR)
    );
    machine.fail(Reason::new(Cause::MODULE_PANICKED));
    machine.stop(Reason::new(Cause::ESTOP));
    assert_eq!(machine.reason().cause, Cause::MODULE_PANICKED);
}

#[test]
fn init_reports_the_present_reason() {
    let mut machine = ModeMachine::default();
    for cause in [Cause::FRAMES_STOPPED, Cause::JOINTS_STOPPED] {
        machine.update(Reason::new(cause), false, STEP_S);
        assert_eq!(
            (machine.mode(), machine.reason().cause),
            (Mode::INIT, cause)
        );
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
            machine.update(Reason::default(), false, 1.0 / f64::from(rate_hz));
            ticks += 1;
        }
        assert_eq!(ticks, (REARM_S * f64::from(rate_hz)) as u32, "{rate_hz} Hz");
    }
}

/// Regression: a frame 0.1 ms too late paused a goal for 20 ms. On a busy machine, such pauses
/// added up until the goal failed.
#[test]
fn late_data_pause_as_long_as_they_are_missing() {
    use Cause as C;
    let held_ticks = |causes: &[(Cause, u32)]| {
        let mut machine = machine_in(Mode::RUN);
        for (cause, ticks) in causes {
            for _ in 0..*ticks {
                machine.update(Reason::new(*cause), true, STEP_S);
            }
        }
        let mut ticks = 0;
        while machine.mode() == Mode::HOLD {
            fault_free(&mut machine, 1, true);
            ticks += 1;
        }
        ticks
    };
    for (causes, expected) in [
        (&[(C::FRAMES_STOPPED, 1)][..], 5),
        (&[(C::JOINTS_STOPPED, 5)], 5),
        (&[(C::FRAMES_STOPPED, 8), (C::FRAMES_LOST, 1)], 9),
        (&[(C::FRAME_STALE, 500)], 20),
        (&[(C::SENSOR_RESTARTED, 1)], 20),
        (&[(C::FRAMES_STOPPED, 1), (C::ELEMENTS_INVALID, 1)], 20),
        (&[(C::ELEMENTS_INVALID, 1), (C::FRAMES_STOPPED, 1)], 20),
    ] {
        assert_eq!(held_ticks(causes), expected, "{causes:?}");
    }
}
