//! One trial: a course, its robots, tick by tick to the end.

use anyhow::Context;
use atas_core::Settings;
use robot_model::RobotModel;
use serde::Serialize;
use sim_backend::Object;
use sim_backend::course::{Course, FRAME_S, FRAME_STEPS, Layout, Responses};

use super::coordinator::Ended;
use super::drive::{DriveFigures, Reflexes};
use super::robot::Robot;

/// Ticks of a step of the base: its 5 ms.
const STEP_TICKS: u64 = 5;
/// Farthest that an object may stand from the goal, m (ours: a camera's errors and those of placing, together).
const OFF_GOAL_M: f64 = 0.010;

/// How long a robot was in one phase.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PhaseTime {
    /// Its name.
    pub phase: &'static str,
    /// When it began, s.
    pub began_s: f64,
    /// How long it took, s.
    pub took_s: f64,
}

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

/// Runs a course to its end; `watch` hears of every phase that a robot begins: its index, the phase, the time in seconds.
///
/// # Errors
/// A world cannot be made, or cannot go on.
pub(super) fn run(
    model: &RobotModel,
    layout: &Layout,
    objects: &[Object],
    table: Responses,
    (seed, reflexes): (u64, Reflexes),
    settings: &Settings,
    mut watch: impl FnMut(usize, &'static str, f64),
) -> anyhow::Result<HybridTrial> {
    let mut course = Course::new(layout, Some(seed));
    let lanes = layout.lanes().iter().enumerate();
    let robots = lanes.zip(objects).map(|((index, lane), object)| {
        // Every robot has its own noise.
        let seed = crate::trial_seed(&format!("robot {index}"), seed);
        Robot::new(model, (index, lane), object, (seed, reflexes), settings)
    });
    let mut robots: Vec<Robot> = robots.collect::<anyhow::Result<_>>()?;
    let mut times: Vec<Vec<PhaseTime>> = vec![Vec::new(); robots.len()];
    let mut tick = 0_u64;
    while robots.iter().any(|r| r.coordinator.ended().is_none()) {
        let now_s = tick as f64 * 1e-3;
        if tick.is_multiple_of(STEP_TICKS * FRAME_STEPS) {
            for (index, (robot, times)) in robots.iter_mut().zip(&mut times).enumerate() {
                let began = robot.frame(&mut course, table, FRAME_S);
                let phase = robot.coordinator.phase().name;
                if began || times.is_empty() {
                    watch(index, phase, now_s);
                    let began_s = now_s;
                    times.push(PhaseTime {
                        phase,
                        began_s,
                        took_s: 0.0,
                    });
                }
                if let Some(last) = times.last_mut() {
                    last.took_s = now_s - last.began_s;
                }
            }
        }
        if tick.is_multiple_of(STEP_TICKS) {
            course.step();
        }
        for (index, robot) in robots.iter_mut().enumerate() {
            if robot.coordinator.ended().is_none() {
                robot.tick(&course.ride(index))?;
            }
        }
        tick += 1;
    }
    let mut ended = Vec::new();
    for (index, (robot, phases)) in robots.iter().zip(times).enumerate() {
        if let Some(fault) = robot.fault() {
            return Err(fault).with_context(|| format!("seed {seed}"));
        }
        let goal_m = layout.lanes()[index].goal_m;
        let off_goal_m = robot.off_goal_m(&course.place(index), goal_m);
        let mishap = course.mishap(index).map(|mishap| mishap.to_string());
        let failure = mishap.or_else(|| failure(robot, off_goal_m));
        let figures = robot.progress.figures();
        ended.push(RobotTrial {
            object: objects[index].name.clone(),
            off_goal_m: failure.is_none().then_some(off_goal_m),
            failure,
            phases,
            drive: robot.drive.as_ref().map(super::drive::Drive::figures),
            grip_n: [figures.normal_n[0], figures.normal_n[1]],
            f2_n: figures.f2_n,
        });
    }
    Ok(HybridTrial {
        seed,
        robots: ended,
        simulated_s: tick as f64 * 1e-3,
    })
}

/// Why a robot without mishap has not succeeded.
fn failure(robot: &Robot, off_goal_m: f64) -> Option<String> {
    match robot.coordinator.ended() {
        Some(Ended::Done) => {
            let placed = robot.placing().failure;
            let near = off_goal_m <= OFF_GOAL_M;
            placed.or_else(|| (!near).then(|| "off the goal".to_owned()))
        }
        Some(Ended::Failed(how)) => Some(match robot.gave_up() {
            Some(why) => format!("{how}: {why}"),
            None => how.to_owned(),
        }),
        None => None,
    }
}
