//! One trial: runs a course with its robots, tick by tick, to the end.

use anyhow::Context;
use atas_core::Settings;
use robot_model::RobotModel;
use serde::Serialize;
use shm_schemas::WorldTruth;
use sim_backend::course::{self, DriveFigures, Host, Responses, Scenario};

use super::coordinator::Ended;
use super::pilot::{PhaseTime, Pilot, Reflexes};
use super::robot::Robot;

/// Largest distance of the object from the goal, m. Design choice: sum of camera and placing
/// errors.
const GOAL_DISTANCE_MAX_M: f64 = 0.010;

/// Result of one robot.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RobotTrial {
    /// Name of its object.
    pub object: String,
    /// Failure key.
    pub failure: Option<String>,
    /// Phases in order, with their times.
    pub phases: Vec<PhaseTime>,
    /// Grip statistics of the drive, if the robot carried its object.
    pub drive: Option<DriveFigures>,
    /// Normal force per side at the last contact, N.
    pub grip_n: [f32; 2],
    /// F_2 at that time, N.
    pub f2_n: f32,
    /// Distance of the object from the goal at the end, m; `None` without success.
    pub off_goal_m: Option<f64>,
}

/// Result of a trial.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct HybridTrial {
    /// Seed of the trial.
    pub seed: u64,
    /// Result of each robot.
    pub robots: Vec<RobotTrial>,
    /// Simulated time, s.
    pub simulated_s: f64,
}

impl HybridTrial {
    /// Returns the first robot's failure key; `None` if every robot succeeded.
    #[must_use]
    pub fn failure(&self) -> Option<&str> {
        let mut failures = self.robots.iter().filter_map(|r| r.failure.as_deref());
        failures.next()
    }
}

impl RobotTrial {
    /// Evaluates a robot after its course, with the ground truth of its hands' world.
    #[must_use]
    pub fn evaluate(pilot: &Pilot, ended: &course::RobotResult, truth: &WorldTruth) -> Self {
        let mishap = ended.mishap.clone();
        let failure = mishap.or_else(|| failure(pilot, truth, ended.off_goal_m));
        let figures = pilot.progress().figures();
        Self {
            object: ended.object.clone(),
            off_goal_m: failure.is_none().then_some(ended.off_goal_m),
            failure,
            phases: pilot.times().to_vec(),
            drive: ended.drive,
            grip_n: pilot.grip_n(),
            f2_n: figures.f2_n,
        }
    }
}

/// Runs a course to its end; calls `watch` when a phase begins: robot index, phase, time (s).
///
/// # Errors
/// A world cannot be created, or has a fault.
pub(super) fn run(
    model: &RobotModel,
    cast: &Scenario,
    table: Responses,
    (number, reflexes): (u64, Reflexes),
    settings: &Settings,
    mut watch: impl FnMut(usize, &'static str, f64),
) -> anyhow::Result<HybridTrial> {
    let mut host = Host::new(cast, model);
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
        RobotTrial::evaluate(&robot.pilot, &host.result(index, &truth), &truth)
    };
    Ok(HybridTrial {
        seed: number,
        robots: robots.iter().enumerate().map(judge).collect(),
        simulated_s: host.ticks() as f64 * 1e-3,
    })
}

fn failure(pilot: &Pilot, truth: &WorldTruth, off_goal_m: f64) -> Option<String> {
    match pilot.ended() {
        Some(Ended::Done) => {
            let placed = pilot.placing(truth).failure;
            let near = off_goal_m <= GOAL_DISTANCE_MAX_M;
            placed.or_else(|| (!near).then(|| "off the goal".to_owned()))
        }
        Some(Ended::Failed(how)) => Some(match pilot.hand_failure() {
            Some(why) => format!("{how}: {why}"),
            None => how.to_owned(),
        }),
        None => Some("not done".to_owned()),
    }
}
