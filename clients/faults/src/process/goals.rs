//! Faulty goals of clients: floods, invalid values, conflicts.

use std::time::{Duration, Instant};

use shm_bus::{BusError, GoalClient, PendingGoal};
use shm_schemas::{GoalRequest, GoalState, GoalUpdate};
use sim_backend::random::split_mix;

use super::pace::TIMEOUT;
use super::{Drill, Effect, Moment, Pace, Rig};

/// Time between two polls without a tick.
const POLL: Duration = Duration::from_micros(200);
/// Goals of a flood, and open goals of one client.
const FLOOD: usize = 2_000;
const OPEN_GOALS: usize = 4;
/// Most ticks during a flood. Design choice: on a busy machine the answers take long, and the goal
/// of the course must not end before them.
const FLOOD_TICKS: u64 = 200;
/// Malformed goals with random bytes, besides those with one invalid number.
const RANDOM_GOALS: u64 = 64;
/// Goal id of the faulty clients.
const FAULTY_GOAL_ID: u64 = 0xFA17;

/// Two clients send thousands of goals.
pub(super) const GOAL_FLOOD: Drill = Drill::new(Pace::LockStep, goal_flood);

/// A client sends goals with invalid numbers and random bytes, before a valid goal.
pub(super) const MALFORMED_GOALS: Drill =
    Drill::new(Pace::LockStep, malformed_goals).at(Moment::Ready);

/// A client sends a valid goal during another one.
pub(super) const CONFLICTING_GOALS: Drill = Drill::new(Pace::LockStep, conflicting_goals);

fn goal_flood(rig: &mut Rig<'_>) -> anyhow::Result<Effect> {
    rig.promise();
    let clients = [rig.observer.goal_client()?, rig.observer.goal_client()?];
    let (mut sent, mut answers, mut ticks, mut open) = (0, 0, 0, Vec::new());
    let begin = Instant::now();
    while answers < FLOOD {
        for client in &clients {
            if sent < FLOOD && open.len() < 2 * OPEN_GOALS {
                match client.send(&other_goal(rig)) {
                    Ok(pending) => {
                        open.push(pending);
                        sent += 1;
                    }
                    Err(BusError::TooManyRequests { .. } | BusError::Send { .. }) => {}
                    Err(error) => return Err(error.into()),
                }
            }
        }
        if ticks < FLOOD_TICKS {
            rig.advance(1)?;
            ticks += 1;
        } else {
            std::thread::sleep(POLL);
        }
        let mut accepted = None;
        open.retain_mut(|pending: &mut PendingGoal| match pending.next() {
            Ok(None) => true,
            Ok(Some(update)) => {
                answers += 1;
                accepted = Some(update).filter(|u| u.state != GoalState::REJECTED);
                false
            }
            Err(_) => {
                answers += 1;
                false
            }
        });
        // After the end of the course's goal, the daemon may accept another one.
        let has_ended = rig.end.is_some_and(|end| end.state.is_final());
        if let Some(update) = accepted.filter(|_| !has_ended) {
            return Ok(Effect::Failed(format!(
                "a goal of the flood is {} during another goal",
                update.state
            )));
        }
        if begin.elapsed() > 4 * TIMEOUT {
            let text = format!("the daemon answers {answers} of {FLOOD} goals");
            return Ok(Effect::Failed(text));
        }
    }
    Ok(Effect::Done)
}

/// Returns the goal of the course under another id.
pub(crate) fn other_goal(rig: &Rig<'_>) -> GoalRequest {
    GoalRequest {
        goal_id: FAULTY_GOAL_ID,
        ..rig.course.goal
    }
}

fn conflicting_goals(rig: &mut Rig<'_>) -> anyhow::Result<Effect> {
    rig.promise();
    let client = rig.observer.goal_client()?;
    // Once the first goal has ended, the daemon may accept the second one.
    let update = answer(rig, &client, &other_goal(rig), 1)?;
    Ok(Effect::require(update.state == GoalState::REJECTED, || {
        format!("a second goal is {} during the first", update.state)
    }))
}

fn malformed_goals(rig: &mut Rig<'_>) -> anyhow::Result<Effect> {
    rig.promise();
    let client = rig.observer.goal_client()?;
    let mut goals = Vec::new();
    for value in [f64::NAN, f64::INFINITY, -1e300] {
        for change in [
            |goal: &mut GoalRequest, value| goal.from_m[0] = value,
            |goal: &mut GoalRequest, value| goal.from_m[2] = value,
            |goal: &mut GoalRequest, value| goal.from_yaw_rad = value,
            |goal: &mut GoalRequest, value| goal.width_m = value,
            |goal: &mut GoalRequest, value| goal.lift_m = value,
            |goal: &mut GoalRequest, value| goal.hold_s = value,
            |goal: &mut GoalRequest, value| goal.top_m = value,
        ] as [fn(&mut GoalRequest, f64); 7]
        {
            let mut goal = other_goal(rig);
            change(&mut goal, value);
            goals.push(goal);
        }
    }
    let mut random = rig.course.fault_seed();
    for _ in 0..RANDOM_GOALS {
        let mut number = || {
            random = split_mix(random);
            f64::from_bits(random)
        };
        let mut goal = other_goal(rig);
        goal.from_m = [number(), number(), number()];
        goal.to_m = [number(), number(), number()];
        (goal.width_m, goal.lift_m, goal.hold_s) = (number(), number(), number());
        goal.kind.0 = number().to_bits() as u32;
        goal.hand.0 = number().to_bits() as u32;
        goals.push(goal);
    }
    for goal in goals {
        // No tick: an accepted goal would wait for the next one.
        let update = answer(rig, &client, &goal, 0)?;
        if update.state != GoalState::REJECTED {
            let text = format!("a malformed goal is {}: {goal:?}", update.state);
            return Ok(Effect::Failed(text));
        }
    }
    Ok(Effect::Done)
}

/// Sends a goal and returns the first update, with this number of ticks between two polls.
pub(crate) fn answer(
    rig: &mut Rig<'_>,
    client: &GoalClient,
    goal: &GoalRequest,
    ticks: u64,
) -> anyhow::Result<GoalUpdate> {
    let begin = Instant::now();
    let mut pending = loop {
        match client.send(goal) {
            Err(BusError::NoServer { .. }) if begin.elapsed() < TIMEOUT => {
                std::thread::sleep(Duration::from_millis(1));
            }
            sent => break sent?,
        }
    };
    loop {
        if let Some(update) = pending.next()? {
            return Ok(update);
        }
        anyhow::ensure!(
            begin.elapsed() < TIMEOUT,
            "the daemon does not answer a goal within {TIMEOUT:?}"
        );
        rig.advance(ticks)?;
        if ticks == 0 {
            std::thread::sleep(POLL);
        }
    }
}
