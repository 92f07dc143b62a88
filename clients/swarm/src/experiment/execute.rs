//! Runs the jobs of an experiment on all cores.

use std::collections::HashSet;
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::sync::mpsc;
use std::time::{Duration, Instant};

use super::plan::Plan;
use super::store::Store;
use crate::checkpoint::Checkpoint;
use crate::condition::{Condition, Setup};
use crate::error::{Error, Result};
use crate::files::{remove_if_exists, rename_damaged};
use crate::run::{Job, Record, Run, evolve};
use crate::workers::{Workers, pool};

/// Largest number of runs that one thread evolves together: fills the SIMD lanes although the memo
/// answers most trials. Measured: more gives no speed-up and loses more work on interruption.
const RUNS_PER_TASK_MAX: usize = 8;
/// Interval between checkpoints: the most work that a power cut loses.
const SAVE_EVERY: Duration = Duration::from_secs(10);
const REPORT_EVERY: u32 = 20;

/// Progress of an execution.
#[derive(Clone, Debug)]
pub enum Progress {
    /// Runs × generations done since the last report.
    Generations(u64),
    /// A run finished with this fitness.
    Finished(Job, f32),
    /// A run restarts because its checkpoint cannot be used.
    Restarted {
        /// Run.
        job: Job,
        /// File and its fault.
        why: String,
        /// New path of the file.
        kept: PathBuf,
    },
}

/// Runs every job without a record and stores each record when its run finishes. Returns all
/// records, sorted. The workers' flag stops the execution within a second; runs in progress are
/// saved.
///
/// # Errors
/// The store could not be written, or the flag was set; finished runs are stored.
pub fn execute(
    plan: &Plan,
    jobs: &[Job],
    (store, mut records): (&mut Store, Vec<Record>),
    (workers, threads): (&Workers, usize),
    mut watch: impl FnMut(Progress),
) -> Result<Vec<Record>> {
    let done: HashSet<Job> = records.iter().map(Record::job).collect();
    let open: Vec<Job> = jobs
        .iter()
        .copied()
        .filter(|job| !done.contains(job))
        .collect();
    let tasks = tasks(plan, &open, threads)?;
    let pool = pool(threads)?;
    store.prepare_checkpoints()?;
    let (sender, receiver) = mpsc::channel();
    let mut stored = Ok(());
    let files = &*store;
    let checkpoints: Vec<_> = tasks
        .iter()
        .map(|task| {
            task.jobs()
                .map(|job| files.checkpoint(job))
                .collect::<Vec<_>>()
        })
        .collect();
    pool.in_place_scope_fifo(|scope| {
        for (task, checkpoints) in tasks.iter().zip(&checkpoints) {
            let sender = sender.clone();
            scope.spawn_fifo(move |_| {
                let mut under_way = RunningTask {
                    plan,
                    task,
                    checkpoints,
                    workers: workers.single_threaded(),
                    sender,
                };
                if let Err(error) = under_way.run() {
                    // The receiver outlives this thread.
                    let _ = under_way.sender.send(Message::Failed(error));
                }
            });
        }
        drop(sender);
        for message in receiver {
            match message {
                Message::Progress(progress) => watch(progress),
                Message::Finished(record) if stored.is_ok() => {
                    stored = finish(store, &record);
                    watch(Progress::Finished(record.job(), record.fitness()));
                    records.push(*record);
                }
                Message::Finished(_) => {}
                Message::Failed(error) if stored.is_ok() => stored = Err(error),
                Message::Failed(_) => {}
            }
            if stored.is_err() {
                workers.stop();
            }
        }
    });
    stored?;
    if workers.is_stopped() {
        let sentence = format!(
            "interrupted: {} of {} runs are finished, runs in progress are saved; run the same \
             command again to continue",
            records.len(),
            jobs.len()
        );
        return Err(Error::Interrupted(sentence));
    }
    store.clear_checkpoints();
    records.sort_by_key(Record::job);
    Ok(records)
}

fn finish(store: &mut Store, record: &Record) -> Result<()> {
    store.append(record)?;
    remove_if_exists(&store.checkpoint(record.job()))
}

enum Message {
    Progress(Progress),
    Finished(Box<Record>),
    Failed(Error),
}

struct Task {
    condition: Condition,
    seeds: Vec<u64>,
}

impl Task {
    fn jobs(&self) -> impl Iterator<Item = Job> {
        let agents = self.condition.team.get();
        self.seeds.iter().map(move |&seed| Job { agents, seed })
    }
}

/// Groups jobs by condition, the longest first. Tasks are small enough to distribute evenly.
fn tasks(plan: &Plan, jobs: &[Job], threads: usize) -> Result<Vec<Task>> {
    let mut tasks = Vec::new();
    for condition in plan.conditions()?.into_iter().rev() {
        let agents = condition.team.get();
        let seeds: Vec<u64> = jobs
            .iter()
            .filter(|job| job.agents == agents)
            .map(|job| job.seed)
            .collect();
        let together = seeds
            .len()
            .div_ceil(threads.min(2))
            .clamp(1, RUNS_PER_TASK_MAX);
        tasks.extend(seeds.chunks(together).map(|seeds| Task {
            condition: condition.clone(),
            seeds: seeds.to_vec(),
        }));
    }
    Ok(tasks)
}

struct RunningTask<'a> {
    plan: &'a Plan,
    task: &'a Task,
    checkpoints: &'a [PathBuf],
    workers: Workers,
    sender: mpsc::Sender<Message>,
}

impl RunningTask<'_> {
    fn run(&mut self) -> Result<()> {
        if self.workers.is_stopped() {
            return Ok(());
        }
        let mut runs = self.begin()?;
        let (mut saved_at, mut failure) = (Instant::now(), None);
        let watch = |runs: &[Run]| {
            let generation = runs.iter().filter_map(Run::generation).max().unwrap_or(0);
            if generation > 0 && generation.is_multiple_of(REPORT_EVERY) {
                self.report(Progress::Generations(
                    u64::from(REPORT_EVERY) * runs.len() as u64,
                ));
            }
            if saved_at.elapsed() > SAVE_EVERY {
                failure = self.save(runs).err();
                saved_at = Instant::now();
            }
            match self.workers.is_stopped() || failure.is_some() {
                true => ControlFlow::Break(()),
                false => ControlFlow::Continue(()),
            }
        };
        let Task { condition, .. } = self.task;
        let flow = evolve(
            condition,
            self.workers.clone(),
            &mut runs,
            self.plan.generations,
            watch,
        );
        failure.map_or(Ok(()), Err)?;
        if flow.is_break() {
            return self.save(&runs);
        }
        for record in runs.iter().filter_map(|run| run.record(condition)) {
            let _ = self.sender.send(Message::Finished(Box::new(record)));
        }
        Ok(())
    }

    fn report(&self, progress: Progress) {
        // The receiver outlives this thread.
        let _ = self.sender.send(Message::Progress(progress));
    }

    /// Returns every run, resumed from its checkpoint or new. An unusable checkpoint is renamed.
    fn begin(&self) -> Result<Vec<Run>> {
        let Plan {
            settings, islands, ..
        } = self.plan;
        let begin = |(job, path): (Job, &PathBuf)| {
            if path.exists() {
                match self.resume(job, path) {
                    Ok(run) => return Ok(run),
                    Err(why) => {
                        let why = format!("{} {why}", path.display());
                        let kept = rename_damaged(path)?;
                        self.report(Progress::Restarted { job, why, kept });
                    }
                }
            }
            Run::new(&self.task.condition, *settings, *islands, job.seed).map_err(Error::from_part)
        };
        self.task.jobs().zip(self.checkpoints).map(begin).collect()
    }

    fn resume(&self, job: Job, path: &Path) -> std::result::Result<Run, String> {
        let saved = Checkpoint::read_or_fault(path)?;
        let Plan {
            settings,
            islands,
            generations,
            ..
        } = self.plan;
        let same = Setup::from(&saved.condition) == Setup::from(&self.task.condition)
            && (saved.settings, saved.islands, saved.generations)
                == (*settings, *islands, *generations)
            && saved.run.seed == job.seed;
        match same {
            true => Ok(saved.run),
            false => Err("is of another run".to_owned()),
        }
    }

    fn save(&self, runs: &[Run]) -> Result<()> {
        for (run, path) in runs.iter().zip(self.checkpoints) {
            let checkpoint = Checkpoint {
                condition: self.task.condition.clone(),
                settings: self.plan.settings,
                islands: self.plan.islands,
                generations: self.plan.generations,
                run: run.clone(),
            };
            checkpoint.write_unsynced(path)?;
        }
        Ok(())
    }
}
