//! One run of a scenario: starts processes, sends the goal, observes the ground truth until the
//! end.

use std::time::{Duration, Instant};

use atas_client::GoalProgress;
use atas_client::{Cancelled, GoalExecution, POLL, Run, Session};
use atas_console::arguments::DemoOptions;
use atas_console::{Interrupt, Progress};
use robot_model::HandModel;
use shm_bus::Subscriber;
use shm_schemas::{GoalState, Status, WorldTruth, service};

use crate::observed::ObservedRun;
use crate::page::Page;
use crate::processes::Processes;
use crate::punctuality::Punctuality;
use crate::scenario::Scenario;
use crate::turns::Turns;

/// Longest duration of a goal (design choice: several times that of the longest normal task).
const GOAL_TIMEOUT: Duration = Duration::from_secs(600);
/// Time to wait for truth and status of the goal's last tick; both are published at 50 Hz (design
/// choice).
const LAST_TICK_TIMEOUT: Duration = Duration::from_secs(1);

pub(crate) fn run(
    scenario: &dyn Scenario,
    running: &DemoOptions,
    interrupt: &Interrupt,
) -> anyhow::Result<ObservedRun> {
    let mut live = Progress::new(scenario.name());
    live.show_activity("starting atasd and atas-sim");
    let mut processes = Processes::start(&scenario.scene_arguments(), running)?;
    let session = Session::join(processes.bus())?;
    processes.wait_until_ready(&session, interrupt)?;
    let mut page = running
        .dashboard
        .then(|| Page::serve(processes.bus(), processes.logs()))
        .transpose()?;
    if let Some(page) = &mut page {
        page.wait_until_open(&mut live, interrupt)?;
    }
    let watched = run_goal(&mut processes, &session, scenario, interrupt, &mut live);
    // If a process died, its log explains more than the subsequent error.
    processes.check()?;
    if let (Some(page), Ok(_)) = (&mut page, &watched) {
        page.keep_running(&mut live, interrupt)?;
    }
    watched
}

fn run_goal(
    processes: &mut Processes,
    session: &Session,
    scenario: &dyn Scenario,
    interrupt: &Interrupt,
    live: &mut Progress,
) -> anyhow::Result<ObservedRun> {
    let hand = scenario.goal().hand;
    let (_, status) = session.watch_status()?;
    let fingers = Run::read(session.bus(), &status)?.fingertips(&status);
    let fingers = fingers[hand.index().unwrap_or(0)];
    let mut observer = Observer::join(session, scenario.hand())?;
    let pursuit = GoalExecution {
        session,
        stop: interrupt.flag(),
        timeout: Some(GOAL_TIMEOUT),
    };
    let (progress, cancelled) = pursuit.run(&scenario.goal(), |progress| {
        processes.check()?;
        observer.poll()?;
        live.show_goal(
            progress,
            fingers,
            Some(&observer.status),
            &scenario.progress_text(&observer.now),
        );
        anyhow::Ok(())
    })?;
    match cancelled {
        Some(Cancelled::Interrupted) => {
            interrupt.check("the demo terminated its processes and removed its bus")?
        }
        Some(Cancelled::TimedOut(limit)) => {
            anyhow::bail!("{} took longer than {limit:?}", scenario.name())
        }
        None => {}
    }
    // A rejected goal has no tick.
    if progress.last().state != GoalState::REJECTED {
        observer.wait_for_last_tick(&progress)?;
    }
    Ok(observer.into_observed(progress))
}

struct Observer<'a> {
    truths: Subscriber<WorldTruth>,
    statuses: Subscriber<Status>,
    first: Option<(WorldTruth, Status)>,
    now: WorldTruth,
    status: Status,
    hand: &'a HandModel,
    turns: Turns,
}

impl<'a> Observer<'a> {
    fn join(session: &Session, hand: &'a HandModel) -> anyhow::Result<Self> {
        let bus = session.bus();
        Ok(Self {
            truths: bus.subscriber(service::WORLD_TRUTH)?,
            statuses: bus.subscriber(service::STATUS)?,
            first: None,
            now: WorldTruth::default(),
            status: Status::default(),
            hand,
            turns: Turns::default(),
        })
    }

    fn poll(&mut self) -> anyhow::Result<()> {
        self.truths.newest(&mut self.now)?;
        self.statuses.newest(&mut self.status)?;
        if self.now.object_count > 0 && self.status.pid > 0 {
            self.first.get_or_insert((self.now, self.status));
        }
        self.turns.update(&self.now, self.hand);
        Ok(())
    }

    fn wait_for_last_tick(&mut self, progress: &GoalProgress) -> anyhow::Result<()> {
        let begin = Instant::now();
        let end_ns = progress.last().stamp.captured_ns;
        while self.now.stamp.captured_ns < end_ns || self.status.stamp.captured_ns < end_ns {
            anyhow::ensure!(
                begin.elapsed() < LAST_TICK_TIMEOUT,
                "could not evaluate the outcome: truth and status of the goal's last tick did not \
                 arrive within {LAST_TICK_TIMEOUT:?}"
            );
            self.poll()?;
            std::thread::sleep(POLL);
        }
        Ok(())
    }

    fn into_observed(self, progress: GoalProgress) -> ObservedRun {
        let (first, status) = self.first.unwrap_or((self.now, self.status));
        let ticks = (progress.took_s() * f64::from(self.status.rate_hz)).round() as u64;
        let ends = [(&first, &status), (&self.now, &self.status)];
        ObservedRun {
            punctuality: Punctuality::between(ends, ticks),
            progress,
            start: first,
            truth: self.now,
            turns: self.turns.count,
        }
    }
}
