//! Processes of a course: one simulator, and for each robot a bus with a daemon, a table process
//! and a coordinator.

use std::time::{Duration, Instant};

use anyhow::Context;
use atas_client::{POLL, Session};
use atas_console::Interrupt;
use atas_console::arguments::DemoHybrid;
use atas_evaluation::hybrid::{HybridTrial, Pilot, Reflexes, RobotTrial};
use robot_model::RobotModel;
use shm_bus::FreshBus;
use sim_backend::course::{RobotResult, Scenario};

use super::coordinator::Coordinator;
use atas_processes::child::Child;
use atas_processes::logs::{self, Logs};

/// Longest time for a daemon to start, and for the simulator to report and end (design choice:
/// allows for a loaded machine).
const TIMEOUT: Duration = Duration::from_secs(15);
/// Poll interval (design choice: short compared with a round of the daemon).
const POLL_INTERVAL: Duration = Duration::from_micros(200);
/// Configuration of the task without slip reaction while driving.
const FROZEN: &str = include_str!("fetch-frozen.toml");

/// All processes of a course. Fields are dropped in this order.
pub(super) struct Processes {
    coordinators: Vec<Coordinator>,
    robots: Vec<Child>,
    simulator: Child,
    seed: u64,
    logs: Vec<Logs>,
    buses: Vec<FreshBus>,
}

impl Processes {
    pub(super) fn start(
        arguments: &DemoHybrid,
        cast: &Scenario,
        reflexes: Reflexes,
    ) -> anyhow::Result<Self> {
        logs::remove_stale();
        let buses: Vec<FreshBus> = cast.robots.iter().map(|_| FreshBus::new("demo")).collect();
        let logs = buses.iter().map(|bus| Logs::new(bus));
        let logs: Vec<Logs> = logs.collect::<anyhow::Result<_>>()?;
        let seed = arguments.seed.to_string();
        let mut host = vec!["course", "--seed", &seed, "--format", "json"];
        for (bus, option) in buses.iter().zip(["--bus", "--second-bus"]) {
            host.extend([option, bus.as_str(), "--object", &arguments.object]);
        }
        let simulator = Child::start("atas-sim", &host, &logs[0].folder)?;
        let mut robots = Vec::new();
        for (bus, logs) in buses.iter().zip(&logs) {
            let config = logs.folder.join("atasd.toml");
            let tasks = match reflexes {
                Reflexes::On => "",
                Reflexes::Frozen => FROZEN,
            };
            std::fs::write(&config, tasks)
                .with_context(|| format!("could not write {}", config.display()))?;
            let (bus, config) = (bus.as_str(), config.to_string_lossy());
            let control = ["--bus", bus, "--config", &*config, "--lockstep"];
            robots.push(Child::start("atasd", &control, &logs.folder)?);
            let drive = ["agents", "--bus", bus, "--table", &arguments.table];
            robots.push(Child::start("ebts", &drive, &logs.folder)?);
        }
        let mut processes = Self {
            coordinators: Vec::new(),
            robots,
            simulator,
            seed: arguments.seed,
            logs,
            buses,
        };
        let robot = RobotModel::two_hand_arm()?;
        for (player, index) in cast.robots.iter().zip(0..) {
            let session = processes.session(index)?;
            let pilot = Pilot::new(player, &robot, reflexes);
            let coordinator = Coordinator::join(session, pilot)?;
            processes.coordinators.push(coordinator);
        }
        Ok(processes)
    }

    fn session(&mut self, index: usize) -> anyhow::Result<Session> {
        let session = Session::join(&self.buses[index])?;
        let begin = Instant::now();
        while let Err(error) = session.watch_status() {
            self.check()?;
            if begin.elapsed() > TIMEOUT {
                self.keep_logs();
                return Err(error.into());
            }
            std::thread::sleep(POLL);
        }
        Ok(session)
    }

    /// Coordinates the robots to the end of their courses. Calls `began` for each new phase: robot
    /// index, phase, time, s.
    pub(super) fn watch(
        mut self,
        interrupt: &Interrupt,
        began: impl FnMut(usize, &'static str, f64),
    ) -> anyhow::Result<HybridTrial> {
        if let Err(error) = self.coordinate(interrupt, began) {
            if !interrupt.is_set() {
                self.keep_logs();
                // If a process died, its log explains more than the subsequent error.
                self.check()?;
            }
            return Err(error);
        }
        self.evaluate()
    }

    fn coordinate(
        &mut self,
        interrupt: &Interrupt,
        mut began: impl FnMut(usize, &'static str, f64),
    ) -> anyhow::Result<()> {
        while !self.coordinators.iter().all(Coordinator::is_done) {
            interrupt.check("the demo terminated its processes and removed its buses")?;
            self.check()?;
            for (index, coordinator) in self.coordinators.iter_mut().enumerate() {
                if let Some((phase, now_s)) = coordinator.poll()? {
                    began(index, phase, now_s);
                }
            }
            std::thread::sleep(POLL_INTERVAL);
        }
        Ok(())
    }

    fn evaluate(&mut self) -> anyhow::Result<HybridTrial> {
        let begin = Instant::now();
        let mut lines = self.simulator.results();
        while lines.len() < self.coordinators.len() {
            if begin.elapsed() > TIMEOUT {
                self.keep_logs();
                anyhow::bail!(
                    "atas-sim did not report the results of the course within {TIMEOUT:?}; the end \
                     of its log:\n{}",
                    self.simulator.tail()
                );
            }
            std::thread::sleep(POLL);
            lines = self.simulator.results();
        }
        let parse = |line: &String| {
            serde_json::from_str(line).context(
                "could not parse the output \
            of atas-sim as JSON",
            )
        };
        let ended: Vec<RobotResult> = lines.iter().map(parse).collect::<anyhow::Result<_>>()?;
        let robots = self.coordinators.iter().zip(&ended);
        let robots = robots.map(|(coordinator, ended)| {
            let (pilot, truth) = coordinator.result();
            RobotTrial::evaluate(pilot, ended, truth)
        });
        Ok(HybridTrial {
            seed: self.seed,
            robots: robots.collect(),
            simulated_s: ended.first().map_or(0.0, |ended| ended.simulated_s),
        })
    }

    fn check(&mut self) -> anyhow::Result<()> {
        let robots = self.robots.iter_mut().try_for_each(Child::check);
        let checked = robots.and_then(|()| self.simulator.check());
        if checked.is_err() {
            self.keep_logs();
        }
        checked
    }

    fn keep_logs(&mut self) {
        self.logs.iter_mut().for_each(|logs| logs.keep = true);
    }
}
