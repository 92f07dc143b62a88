//! Clients that are killed or stopped during their goal.

use std::time::{Duration, Instant};

use atas_evaluation::Task;
use atas_processes::{Child, sibling_program};
use rustix::process::Signal;
use shm_schemas::{GoalState, Hand};
use sim_backend::random::split_mix;

use super::pace::TIMEOUT;
use super::{Drill, Effect, Moment, Pace, Rig};

/// Ticks after the start of a goal by another process: the hand is on its way or has grasped.
const CLIENT_TICKS: [u64; 2] = [500, 8_000];
/// Ticks between two polls of the status.
const BETWEEN_TICKS: u64 = 20;
/// Time of a client that does not run.
const SILENCE: Duration = Duration::from_secs(2);

/// The client of an attached goal is killed.
pub(super) const CLIENT_KILLED: Drill =
    Drill::new(Pace::LockStep, |rig| client(rig, Signal::KILL)).at(Moment::Client);

/// The client of an attached goal is stopped by SIGSTOP.
pub(super) const CLIENT_HANGS: Drill =
    Drill::new(Pace::LockStep, |rig| client(rig, Signal::STOP)).at(Moment::Client);

/// Starts a client of an attached grasp and sends it a signal.
fn client(rig: &mut Rig<'_>, signal: Signal) -> anyhow::Result<Effect> {
    let goal = rig.course.goal;
    debug_assert_eq!(rig.course.task, Task::Grasp);
    let at = goal.from_m.map(|metres| metres.to_string()).join(",");
    let (width, yaw) = (goal.width_m * 1e3, goal.from_yaw_rad.to_degrees());
    let (width, yaw) = (width.to_string(), yaw.to_string());
    let hand = if goal.hand == Hand::LEFT {
        "left"
    } else {
        "right"
    };
    let words = [
        "grasp",
        "--attached",
        "--at",
        &at,
        "--width",
        &width,
        "--yaw",
        &yaw,
        "--hand",
        hand,
        "--hold",
        "3600",
        "--bus",
        rig.bus.as_str(),
    ];
    let program = sibling_program("atas")?;
    let mut client = Child::start_program(&program, "client", &words, &rig.logs.folder)?;
    rig.begin_pursuit()?;
    let [lowest, highest] = CLIENT_TICKS;
    rig.advance(lowest + split_mix(rig.course.fault_seed()) % (highest - lowest))?;
    if super::is_lifted(&rig.object()) {
        rig.judge.expect_grip_kept(0)?;
    }
    client.signal(signal)?;
    while signal == Signal::KILL && client.exit_status()?.is_none() {
        std::thread::sleep(Duration::from_millis(1));
    }
    // Dead and silent clients are found by the clock.
    rig.is_slow = true;
    rig.promise();
    let begin = Instant::now();
    loop {
        rig.advance(BETWEEN_TICKS)?;
        let has_failed = rig.status()?.goal_state == GoalState::FAILED;
        match signal {
            Signal::KILL if has_failed => return Ok(Effect::Done),
            Signal::KILL if begin.elapsed() > TIMEOUT => {
                let text = "the goal of the killed client goes on";
                return Ok(Effect::Failed(text.to_owned()));
            }
            Signal::STOP if begin.elapsed() > SILENCE => {
                client.signal(Signal::KILL)?;
                return Ok(Effect::Done);
            }
            _ => {}
        }
    }
}
