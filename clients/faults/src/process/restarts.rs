//! Repeated death of the daemon: SIGKILL at random moments, as by the kernel or a supervisor.
//!
//! ```text
//!  episode: grasp with recording ─▶ 100 × ┬ random moment of goal or grip, a quarter after a reload
//!                                         └ random moment of the next start
//!                                   ─▶ SIGKILL ─▶ next daemon at once ─▶ ready? grip kept?
//! ```
//!
//! * **In:** robot, object, seed, number of kills. **Out:** a [`RestartReport`].
//! * **Invariants:** the judge sees every command of every daemon. A lifted object must stay in the
//!   hand over all kills of its episode. A daemon that is killed during its start counts as
//!   recovered by the next one. If a daemon finds the hand closed on an object that still stands,
//!   the episode ends: the hand keeps it until a client releases it.

use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use atas_core::Settings;
use atas_evaluation::Task;
use robot_model::RobotModel;
use rustix::process::Signal;
use shm_schemas::Mode;
use sim_backend::Object;
use sim_backend::random::split_mix;

use super::ends::{EARLY_KILL_MAX, wait_end};
use super::pace::TIMEOUT;
use super::{Environment, Pace, Rig, Setup};
use crate::catalogue::Reaction;
use crate::course::Course;
use crate::verdict::{WATCH_TICKS, is_lifted};

/// Kills in one world. Design choice: enough to add up a change of force per restart.
const KILLS_PER_EPISODE: u64 = 100;
/// Ticks from the readiness of a daemon until it holds a grip that it finds.
const FOUND_TICKS: u64 = 5;
/// Latest moment of a kill during a goal without a lifted object, ticks: a grasp is lifted by then.
const GOAL_TICKS: u64 = 8_000;
/// Latest moment of a kill of a daemon that holds an object, ticks. Design choice.
const GRIP_TICKS: u64 = 100;
/// Longest time from a reload to the kill, ticks: a reload takes some milliseconds.
const RELOAD_TICKS: u64 = 10;
/// Hold time of the goals, s: longer than an episode.
const HOLD_S: f64 = 3_000.0;

/// Kills of the daemon during grasps.
#[derive(Clone, Debug)]
pub struct RestartPlan {
    /// Robot.
    pub robot: RobotModel,
    /// Its name or file, and the configuration of the daemons.
    pub environment: Environment,
    /// Controller settings in that configuration.
    pub settings: Settings,
    /// Object of the grasps.
    pub object: Object,
    /// Number of kills.
    pub kills: u64,
    /// Seed: determines worlds and moments.
    pub seed: u64,
}

/// Result of all kills.
#[derive(Clone, Debug, Default)]
pub struct RestartReport {
    /// Kills.
    pub kills: u64,
    /// Of these, kills of a daemon during its start.
    pub during_start: u64,
    /// Of these, kills with a lifted object in the hand.
    pub in_grip: u64,
    /// Kills after which a daemon became ready.
    pub recovered: u64,
    /// Time from the start of a process to its first command in READY or, with a grip, RUN; ns.
    pub ready_ns: Vec<u64>,
    /// Grip force at the end of each episode over that at its first kill in the grip.
    pub force_ratios: Vec<f64>,
    /// Violations that the judge found, and daemons that did not start, with the seed.
    pub failures: Vec<String>,
}

impl RestartReport {
    /// Returns true if every kill was recovered without a failure.
    #[must_use]
    pub fn has_passed(&self) -> bool {
        self.failures.is_empty() && self.recovered == self.kills
    }
}

impl RestartPlan {
    /// Runs all kills; calls `done` after each; `None` if stopped.
    ///
    /// # Errors
    /// The world of a grasp cannot be created, or the machine does not permit a process or a bus.
    pub fn run(&self, stop: &AtomicBool, done: impl Fn()) -> anyhow::Result<Option<RestartReport>> {
        let mut report = RestartReport::default();
        let mut number = self.seed;
        while report.kills < self.kills && !stop.load(Ordering::Relaxed) {
            self.episode(number, &mut report, stop, &done)?;
            number += 1;
        }
        Ok((!stop.load(Ordering::Relaxed)).then_some(report))
    }

    fn episode(
        &self,
        number: u64,
        report: &mut RestartReport,
        stop: &AtomicBool,
        done: &impl Fn(),
    ) -> anyhow::Result<()> {
        let mut course = Course::new(
            &self.robot,
            Task::Grasp,
            &self.object,
            number,
            self.settings,
        )?;
        course.goal.hold_s = HOLD_S;
        let setup = Setup {
            records: true,
            has_own_file: true,
            ..Setup::new(Pace::Clock)
        };
        let rig = Rig::start(&course, &self.environment, setup, Reaction::Continue)?;
        let mut episode = Episode {
            random: course.fault_seed(),
            rig,
            starting: false,
            first_force_n: None,
        };
        let end = self.kills.min(report.kills + KILLS_PER_EPISODE);
        while report.kills < end && !stop.load(Ordering::Relaxed) {
            match episode.kill(report) {
                Ok(true) => done(),
                Ok(false) => break,
                Err(error) => {
                    report.failures.push(format!("seed {number}: {error:#}"));
                    return Ok(());
                }
            }
        }
        let closed = episode.finish(report);
        let violations = episode.rig.judge.violations().iter();
        let texts = violations.map(ToString::to_string);
        let errors = closed.err().map(|error| format!("{error:#}"));
        let all = texts.chain(errors);
        report
            .failures
            .extend(all.map(|text| format!("seed {number}: {text}")));
        Ok(())
    }
}

/// Daemon, world, and state of the kills.
struct Episode<'a> {
    rig: Rig<'a>,
    random: u64,
    /// The present daemon was started and is not yet ready.
    starting: bool,
    /// Grip force at the first kill in the grip, N.
    first_force_n: Option<f64>,
}

impl Episode<'_> {
    /// Returns a random number below a limit.
    fn below(&mut self, limit: u64) -> u64 {
        self.random = split_mix(self.random);
        self.random % limit.max(1)
    }

    /// Kills the daemon at a random moment and starts the next one; false if no goal can begin.
    fn kill(&mut self, report: &mut RestartReport) -> anyhow::Result<bool> {
        if self.starting && self.below(2) == 0 {
            report.during_start += 1;
            self.wait_in_start()?;
        } else {
            self.finish_start(report)?;
            if self.holds_standing_object() {
                return Ok(false);
            }
            self.wait_in_task()?;
        }
        let is_held = is_lifted(&self.rig.object());
        report.in_grip += u64::from(is_held);
        if is_held && self.first_force_n.is_none() {
            self.first_force_n = Some(self.rig.grip_force_n());
            self.rig.judge.expect_grip_kept(0)?;
        }
        self.rig.daemon.signal(Signal::KILL)?;
        wait_end(&mut self.rig)?;
        report.kills += 1;
        self.rig.replace_daemon()?;
        self.starting = true;
        Ok(true)
    }

    fn holds_standing_object(&self) -> bool {
        self.rig.ports.command.mode == Mode::RUN && !is_lifted(&self.rig.object())
    }

    /// Waits for a random part of the start.
    fn wait_in_start(&mut self) -> anyhow::Result<()> {
        let share = self.below(1_000) as f64 / 1e3;
        let until = Instant::now() + EARLY_KILL_MAX.mul_f64(share);
        while Instant::now() < until {
            self.rig.advance(1)?;
        }
        Ok(())
    }

    /// Waits until the present daemon is ready.
    fn finish_start(&mut self, report: &mut RestartReport) -> anyhow::Result<()> {
        if !std::mem::replace(&mut self.starting, false) {
            return Ok(());
        }
        let pending = report.kills - report.recovered;
        let begin = Instant::now();
        let before = self.rig.ports.command.stamp.writer_epoch;
        loop {
            self.rig.advance(1)?;
            let command = &self.rig.ports.command;
            let is_ready = matches!(command.mode, Mode::READY | Mode::RUN);
            if command.stamp.writer_epoch != before && is_ready {
                break;
            }
            self.rig.daemon.check()?;
            if begin.elapsed() > TIMEOUT {
                let status = self.rig.status()?;
                anyhow::bail!(
                    "the daemon is not ready within {TIMEOUT:?}: mode {} ({}), goal {}, pid {}",
                    status.mode,
                    status.reason,
                    status.goal_id,
                    status.pid
                );
            }
        }
        report.ready_ns.push(nanoseconds(begin.elapsed()));
        report.recovered += pending;
        self.rig.advance(FOUND_TICKS)
    }

    /// Waits for a random moment of a goal, or of a grip.
    fn wait_in_task(&mut self) -> anyhow::Result<()> {
        let ticks = if is_lifted(&self.rig.object()) {
            self.below(GRIP_TICKS)
        } else {
            self.rig.begin_goal()?;
            self.below(GOAL_TICKS)
        };
        self.rig.advance(ticks)?;
        if self.below(4) == 0 {
            self.rig.daemon.signal(Signal::HUP)?;
            let ticks = self.below(RELOAD_TICKS);
            self.rig.advance(ticks)?;
        }
        Ok(())
    }

    /// Lets the last daemon become ready, and watches it.
    fn finish(&mut self, report: &mut RestartReport) -> anyhow::Result<()> {
        self.finish_start(report)?;
        self.rig.advance(WATCH_TICKS)?;
        self.rig.judge.finish();
        if let Some(first_n) = self.first_force_n {
            report.force_ratios.push(self.rig.grip_force_n() / first_n);
        }
        Ok(())
    }
}

fn nanoseconds(time: Duration) -> u64 {
    u64::try_from(time.as_nanos()).unwrap_or(u64::MAX)
}
