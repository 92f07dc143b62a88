//! Correct streams pass, at any start of the observation and any tick rate.

use atas_judge::{Allowance, Judge};
use shm_schemas::Mode;

use crate::reference::{
    CRUISE, END, Event, HOLD, RUN, TICK_NS, VALID_NS, bounds, correct, judge, observe, observed,
};

#[test]
fn correct_stream_passes() {
    let judge = observed(&correct());
    assert_eq!(judge.violations(), []);
    assert_eq!(judge.violation_count(), 0);
    assert_eq!(judge.reached_after(), Some(0));
}

#[test]
fn observation_may_begin_at_any_command() {
    let mut ticks = correct();
    for tick in &mut ticks {
        let needs_history = |event: &Event| matches!(event, Event::Promise(_) | Event::ExpectGrip);
        tick.events.retain(|event| !needs_history(event));
    }
    for begin in (0..END).step_by(7) {
        let judge = observed(&ticks[begin..]);
        assert_eq!(judge.violations(), [], "from command {begin}");
    }
}

/// A panic stops the commands at once: the robot does the same when they expire.
#[test]
fn fault_freezes_a_moving_joint() {
    let mut ticks = correct();
    ticks.truncate(CRUISE + 20);
    let last = ticks[CRUISE].command;
    for tick in &mut ticks[CRUISE + 1..] {
        tick.command.mode = Mode::FAULT;
        tick.command.position = last.position;
        tick.command.velocity.fill(0.0);
        tick.command.seal();
    }
    assert_eq!(observed(&ticks).violations(), []);
}

#[test]
fn allowed_deviations_pass() {
    let mut ticks = correct();
    let mut late_ns = 0;
    for (index, tick) in ticks.iter_mut().enumerate() {
        late_ns += if index == CRUISE { 3 * TICK_NS } else { 0 };
        let captured_ns = &mut tick.command.stamp.captured_ns;
        *captured_ns += late_ns + 70_000 * (index as u64 % 3);
        tick.command.valid_until_ns = *captured_ns + VALID_NS;
        tick.command.tick += late_ns / TICK_NS;
        tick.command.seal();
        tick.truth.objects[0].spilt = 1;
    }
    let allowances = [
        Allowance::MissedTicks,
        Allowance::UnevenTicks,
        Allowance::SpiltObject,
    ];
    let mut judge = allowances.into_iter().fold(judge(), Judge::allowing);
    observe(&mut judge, &ticks);
    assert_eq!(judge.violations(), []);
}

/// The tolerance of rounding follows from the period.
#[test]
fn ten_kilohertz_stream_passes() {
    let mut ticks = correct();
    ticks.truncate(HOLD);
    let mut position = ticks[RUN - 1].command.position;
    for (index, tick) in ticks.iter_mut().enumerate() {
        let command = &mut tick.command;
        command.stamp.captured_ns = 1_000_000_000 + index as u64 * TICK_NS / 10;
        command.valid_until_ns = command.stamp.captured_ns + VALID_NS;
        for (position, speed) in position.iter_mut().zip(&mut command.velocity) {
            // A tenth of the speed: the changes per tick are steeper.
            *speed *= 0.1;
            *position += *speed * 1e-4;
        }
        if command.joint_count > 0 {
            command.position = position;
        }
        command.seal();
    }
    let mut judge = Judge::new(bounds(), TICK_NS / 10, VALID_NS).expect("valid bounds");
    observe(&mut judge, &ticks);
    assert_eq!(judge.violations(), []);
}
