//! Runs the jobs of an experiment on all cores.

use std::collections::HashSet;
use std::ops::ControlFlow;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc;

use field::Engine;

use super::plan::{Job, Plan};
use super::store::Store;
use crate::condition::Condition;
use crate::error::{Error, Result};
use crate::run::{Record, Run, evolve};

/// Runs that one thread evolves together at most: enough to fill the SIMD lanes although most trials are remembered
/// (measured; more shortens nothing and loses more when interrupted).
const RUNS_TOGETHER: usize = 8;

/// What a person may want to know meanwhile.
#[derive(Clone, Copy, Debug)]
pub enum Progress {
    /// Runs × generations done since the last report.
    Generations(u64),
    /// A run finished with this fitness.
    Finished(Job, f32),
}

/// Runs every job that has no record yet and stores each as it finishes; `stop` ends it early. Returns all records of the
/// jobs, sorted.
///
/// # Errors
/// The store could not be written, or `stop` was set before the end: what had finished is stored.
pub fn execute(
    plan: &Plan,
    jobs: &[Job],
    (store, mut records): (&mut Store, Vec<Record>),
    (engine, threads): (Engine, usize),
    stop: &AtomicBool,
    mut watch: impl FnMut(Progress),
) -> Result<Vec<Record>> {
    let done: HashSet<(usize, u64)> = records
        .iter()
        .map(|record| (record.agents, record.seed))
        .collect();
    let open: Vec<Job> = jobs
        .iter()
        .copied()
        .filter(|job| !done.contains(&(job.agents, job.seed)))
        .collect();
    let tasks = tasks(plan, &open, threads)?;
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(threads)
        .build()
        .map_err(Error::from_part)?;
    let (sender, receiver) = mpsc::channel();
    let mut stored = Ok(());
    pool.in_place_scope_fifo(|scope| {
        for task in &tasks {
            let sender = sender.clone();
            scope.spawn_fifo(move |_| run_task(plan, task, engine, stop, &sender));
        }
        drop(sender);
        for message in receiver {
            match message {
                Message::Generations(count) => watch(Progress::Generations(count)),
                Message::Finished(record) if stored.is_ok() => {
                    stored = store.append(&record);
                    if stored.is_err() {
                        stop.store(true, Ordering::Relaxed);
                    }
                    watch(Progress::Finished(
                        Job {
                            agents: record.agents,
                            seed: record.seed,
                        },
                        record.fitness(),
                    ));
                    records.push(*record);
                }
                Message::Finished(_) => {}
            }
        }
    });
    stored?;
    if stop.load(Ordering::Relaxed) {
        let sentence = format!(
            "interrupted: {} of {} runs are stored; run the same command again to go on",
            records.len(),
            jobs.len()
        );
        return Err(Error::Interrupted(sentence));
    }
    records.sort_by_key(|record| Job {
        agents: record.agents,
        seed: record.seed,
    });
    Ok(records)
}

enum Message {
    Generations(u64),
    Finished(Box<Record>),
}

struct Task {
    condition: Condition,
    seeds: Vec<u64>,
}

/// Jobs of one condition together, the longest first, and no task longer than what an even share of the work allows.
fn tasks(plan: &Plan, jobs: &[Job], threads: usize) -> Result<Vec<Task>> {
    let mut tasks = Vec::new();
    for condition in plan.conditions()?.into_iter().rev() {
        let agents = condition.team.get();
        let seeds: Vec<u64> = jobs
            .iter()
            .filter(|job| job.agents == agents)
            .map(|job| job.seed)
            .collect();
        let together = seeds.len().div_ceil(threads.min(2)).clamp(1, RUNS_TOGETHER);
        tasks.extend(seeds.chunks(together).map(|seeds| Task {
            condition: condition.clone(),
            seeds: seeds.to_vec(),
        }));
    }
    Ok(tasks)
}

fn run_task(
    plan: &Plan,
    task: &Task,
    engine: Engine,
    stop: &AtomicBool,
    sender: &mpsc::Sender<Message>,
) {
    /// Generations between two looks at the stop flag and reports.
    const REPORT_EVERY: u32 = 20;
    let Task { condition, seeds } = task;
    let new_run = |&seed: &u64| Run::new(condition, plan.settings, plan.islands, seed);
    // The plan's settings were checked with its conditions.
    let Ok(mut runs) = seeds
        .iter()
        .map(new_run)
        .collect::<std::result::Result<Vec<_>, _>>()
    else {
        return;
    };
    let watch = |runs: &[Run]| {
        let generation = runs[0].generation().unwrap_or(0);
        if generation > 0 && generation.is_multiple_of(REPORT_EVERY) {
            // The receiver lives as long as the scope.
            let _ = sender.send(Message::Generations(
                u64::from(REPORT_EVERY) * runs.len() as u64,
            ));
            if stop.load(Ordering::Relaxed) {
                return ControlFlow::Break(());
            }
        }
        ControlFlow::Continue(())
    };
    if stop.load(Ordering::Relaxed)
        || evolve(condition, engine, &mut runs, plan.generations, watch).is_break()
    {
        return;
    }
    for record in runs.iter().filter_map(|run| run.record(condition)) {
        let _ = sender.send(Message::Finished(Box::new(record)));
    }
}
