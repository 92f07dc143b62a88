//! One trial: a course, its robots, tick by tick to the end.

use anyhow::Context;
use atas_core::Settings;
use robot_model::RobotModel;
use serde::Serialize;
use shm_schemas::WorldTruth;
use sim_backend::course::{self, Cast, DriveFigures, Host, Responses};

use super::coordinator::Ended;
use super::pilot::{PhaseTime, Pilot, Reflexes};
use super::robot::Robot;

/// Farthest that an object may stand from the goal, m (ours: a camera's errors and those of placing, together).
const OFF_GOAL_M: f64 = 0.010;

/// What became of one robot.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RobotTrial {
    /// Its object.
    pub object: String,
    /// Why it is no success; `None` if it is.
    pub failure: Option<String>,
    /// Its phases, in order.
    pub phases: Vec<PhaseTime>,
    /// How the grip fared on the way, if it came so far.
    pub drive: Option<DriveFigures>,
    /// What the fingers pressed with when they last held it, each, N, and F_2.
    pub grip_n: [f32; 2],
    /// See `grip_n`.
    pub f2_n: f32,
    /// Distance of the object from the goal in the end, m; `None` if it was never set down.
    pub off_goal_m: Option<f64>,
}

/// What became of a trial.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct HybridTrial {
    /// Its seed.
    pub seed: u64,
    /// Robot by robot.
    pub robots: Vec<RobotTrial>,
    /// Simulated time, s.
    pub simulated_s: f64,
}

impl HybridTrial {
    /// Why it is no success; `None` if every robot succeeded.
    #[must_use]
    pub fn failure(&self) -> Option<&str> {
        let mut failures = self.robots.iter().filter_map(|r| r.failure.as_deref());
        failures.next()
    }
}

impl RobotTrial {
    /// The judgement of a robot whose course is over, and whose hands' world is like this.
    #[must_use]
    pub fn of(pilot: &Pilot, ended: &course::Ended, truth: &WorldTruth) -> Self {
        let mishap = ended.mishap.clone();
        let failure = mishap.or_else(|| failure(pilot, truth, ended.off_goal_m));
        let figures = pilot.progress().figures();
        Self {
            object: ended.object.clone(),
            off_goal_m: failure.is_none().then_some(ended.off_goal_m),
            failure,
            phases: pilot.times().to_vec(),
            drive: ended.drive,
            grip_n: [figures.normal_n[0], figures.normal_n[1]],
            f2_n: figures.f2_n,
        }
    }
}

/// Runs a course to its end; `watch` hears of every phase that a robot begins: its index, the phase, the time in seconds.
///
/// # Errors
/// A world cannot be made, or cannot go on.
pub(super) fn run(
    model: &RobotModel,
    cast: &Cast,
    table: Responses,
    (number, reflexes): (u64, Reflexes),
    settings: &Settings,
    mut watch: impl FnMut(usize, &'static str, f64),
) -> anyhow::Result<HybridTrial> {
    let mut host = Host::new(cast);
    let players = cast.robots.iter().enumerate();
    let robots = players.map(|player| Robot::new(model, player, reflexes, settings));
    let mut robots: Vec<Robot> = robots.collect::<anyhow::Result<_>>()?;
    loop {
        if host.frame_begins() {
            for (index, robot) in robots.iter_mut().enumerate() {
                if let Some(phase) = robot.frame(&mut host, table) {
                    watch(index, phase, host.ticks() as f64 * 1e-3);
                }
            }
            if robots.iter().all(|robot| robot.pilot.ended().is_some()) {
                break;
            }
        }
        host.step();
        for robot in &mut robots {
            if robot.pilot.ended().is_none() {
                let ticked = robot.tick(&mut host);
                ticked.with_context(|| format!("seed {number}"))?;
            }
        }
    }
    let judge = |(index, robot): (usize, &Robot)| {
        let truth = robot.truth();
        RobotTrial::of(&robot.pilot, &host.ended(index, &truth), &truth)
    };
    Ok(HybridTrial {
        seed: number,
        robots: robots.iter().enumerate().map(judge).collect(),
        simulated_s: host.ticks() as f64 * 1e-3,
    })
}

/// Why a robot without mishap has not succeeded.
fn failure(pilot: &Pilot, truth: &WorldTruth, off_goal_m: f64) -> Option<String> {
    match pilot.ended() {
        Some(Ended::Done) => {
            let placed = pilot.placing(truth).failure;
            let near = off_goal_m <= OFF_GOAL_M;
            placed.or_else(|| (!near).then(|| "off the goal".to_owned()))
        }
        Some(Ended::Failed(how)) => Some(match pilot.gave_up() {
            Some(why) => format!("{how}: {why}"),
            None => how.to_owned(),
        }),
        None => Some("not done".to_owned()),
    }
}
