//! Plan of the runs: faults, tasks, phases and seeds.

use std::collections::BTreeSet;
use std::sync::atomic::{AtomicBool, Ordering};

use anyhow::Context;
use atas_core::Settings;
use atas_evaluation::{Task, run_indexed};
use robot_model::{RobotFiles, RobotModel};
use sim_backend::Object;

use crate::catalogue::{Evidence, Fault, Reaction};
use crate::course::Course;
use crate::injection::Injection;
use crate::process::{Environment, is_for_grasp_only, process_verdict};
use crate::process_fault::ProcessFault;
use crate::report::{Extent, FaultReport};
use crate::verdict::{Verdict, verdict};

/// Faults that are injected into tasks.
#[derive(Clone, Debug)]
pub struct FaultPlan {
    /// Faults; those without injection are reported with what shows them.
    pub faults: Vec<&'static Fault>,
    /// Tasks.
    pub tasks: Vec<Task>,
    /// Phase of the tasks; `None`: each one.
    pub phase: Option<String>,
    /// Object of grasp and pick and place.
    pub object: Object,
    /// Its name or file, as the user gave it.
    pub object_name: String,
    /// Seeds per task.
    pub seeds: u64,
    /// First seed.
    pub first_seed: u64,
    /// Robot.
    pub robot: RobotFiles,
    /// Controller settings.
    pub settings: Settings,
    /// Configuration of daemon processes.
    pub environment: Environment,
    /// Threads; 0: one per core.
    pub threads: usize,
}

impl FaultPlan {
    /// Returns the number of runs of a task without fault, each with all faults in all its phases,
    /// and of runs with a daemon process.
    #[must_use]
    pub fn runs(&self) -> u64 {
        let processes = self
            .faults
            .iter()
            .filter_map(|&fault| process(fault, &self.settings));
        self.courses() * (1 + processes.count() as u64)
    }

    fn courses(&self) -> u64 {
        self.tasks.len() as u64 * self.seeds
    }

    /// Runs all; calls `done` after each course, from any thread; `None` if stopped.
    ///
    /// # Errors
    /// The robot or a world cannot be created, a task fails without a fault, or no task has the
    /// requested phase.
    pub fn run(
        &self,
        stop: &AtomicBool,
        done: impl Fn() + Sync,
    ) -> anyhow::Result<Option<FaultReport>> {
        let robot = self.robot.load()?;
        for task in &self.tasks {
            task.check(&robot)?;
        }
        let judged = run_indexed(self.courses(), self.threads, stop, |index| {
            let task = self.tasks[(index / self.seeds) as usize];
            let judged = self.course(&robot, task, self.first_seed + index % self.seeds)?;
            done();
            Ok(judged)
        })?;
        let Some(judged) = judged else {
            return Ok(None);
        };
        let (phases, verdicts): (Vec<_>, Vec<_>) = judged.into_iter().unzip();
        let phases: BTreeSet<String> = phases.into_iter().flatten().collect();
        let mut verdicts: Vec<Verdict> = verdicts.into_iter().flatten().collect();
        if let Some(phase) = self.phase.as_ref().filter(|&phase| !phases.contains(phase))
            && !phases.is_empty()
        {
            let known = Vec::from_iter(phases).join(", ");
            anyhow::bail!("could not inject at {phase:?}: no such phase, needs one of {known}");
        }
        for index in 0..self.courses() {
            let task = self.tasks[(index / self.seeds) as usize];
            let seed = self.first_seed + index % self.seeds;
            let Some(of_course) = self.processes(&robot, task, seed, stop, &done)? else {
                return Ok(None);
            };
            verdicts.extend(of_course);
        }
        let extent = Extent {
            robot: &self.robot.name,
            tasks: self.tasks.iter().map(|task| task.name()).collect(),
            faults: &self.faults,
            object: &self.object_name,
            config: self.environment.config.as_deref(),
            settings: &self.settings,
        };
        Ok(Some(FaultReport::new(&extent, &verdicts)))
    }

    /// Injects all faults into each requested phase of one task. Returns the names of all phases,
    /// and the verdicts.
    fn course(
        &self,
        robot: &RobotModel,
        task: Task,
        seed: u64,
    ) -> anyhow::Result<(Vec<String>, Vec<Verdict>)> {
        let faults: Vec<_> = self
            .faults
            .iter()
            .filter_map(|&fault| injected(fault, &self.settings))
            .collect();
        if faults.is_empty() {
            return Ok((Vec::new(), Vec::new()));
        }
        let course = Course::new(robot, task, &self.object(task)?, seed, self.settings)?;
        let is_requested = |name: &str| self.phase.as_deref().is_none_or(|phase| phase == name);
        let (mut verdicts, mut progress) = (Vec::new(), course.begin()?);
        let phases = course.phases()?;
        for phase in &phases {
            if !is_requested(&phase.name) {
                continue;
            }
            course.advance_into(phase, &mut progress);
            for &fault in &faults {
                verdicts.push(verdict(&course, phase, &progress, fault)?);
            }
        }
        let names = phases.into_iter().map(|phase| phase.name);
        Ok((names.collect(), verdicts))
    }

    /// Runs one task with a daemon process per fault, each in the requested phase or a random one.
    /// Returns `None` if stopped.
    fn processes(
        &self,
        robot: &RobotModel,
        task: Task,
        seed: u64,
        stop: &AtomicBool,
        done: impl Fn(),
    ) -> anyhow::Result<Option<Vec<Verdict>>> {
        let faults = self.faults.iter();
        let faults: Vec<_> = faults
            .filter_map(|&fault| process(fault, &self.settings))
            .collect();
        if faults.is_empty() {
            return Ok(Some(Vec::new()));
        }
        let course = Course::new(robot, task, &self.object(task)?, seed, self.settings)?;
        let phases = course.lockstep_phases()?;
        let names = phases.iter().map(|phase| phase.name.as_str());
        let Some(phase) = (match &self.phase {
            None => course.random_phase(&phases),
            Some(name) => phases.iter().find(|phase| phase.name == *name),
        }) else {
            anyhow::ensure!(
                self.tasks.len() > 1,
                "could not inject at {:?}: no such phase, needs one of {}",
                self.phase.as_deref().unwrap_or_default(),
                names.collect::<Vec<_>>().join(", ")
            );
            return Ok(Some(Vec::new()));
        };
        let mut verdicts = Vec::new();
        for (fault, process, reaction) in faults {
            if stop.load(Ordering::Relaxed) {
                return Ok(None);
            }
            if !is_for_grasp_only(process) || task == Task::Grasp {
                let of = (fault, process, reaction);
                let verdict = process_verdict(&course, phase, &self.environment, of)
                    .with_context(|| format!("{} {}", fault.id, fault.name))?;
                verdicts.push(verdict);
            }
            done();
        }
        Ok(Some(verdicts))
    }

    fn object(&self, task: Task) -> anyhow::Result<Object> {
        Ok(match task {
            Task::Grasp | Task::PickPlace => self.object.clone(),
            Task::Screw | Task::Assembly => Object::built_in("cap")?,
        })
    }
}

/// Returns a fault with its injection in virtual time; `None` if other evidence shows it.
fn injected(
    fault: &'static Fault,
    settings: &Settings,
) -> Option<(&'static Fault, Injection, Reaction)> {
    match fault.evidence {
        Evidence::Injected(injection, reaction) => {
            Some((fault, injection, reaction.with_settings(settings)))
        }
        _ => None,
    }
}

/// Returns a fault with its injection into processes; `None` if other evidence shows it.
fn process(
    fault: &'static Fault,
    settings: &Settings,
) -> Option<(&'static Fault, ProcessFault, Reaction)> {
    match fault.evidence {
        Evidence::Process(process, reaction) => {
            Some((fault, process, reaction.with_settings(settings)))
        }
        _ => None,
    }
}
