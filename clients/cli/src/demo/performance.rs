//! One object's performance: stage set, goal sent, truth watched, judged.

use std::time::{Duration, Instant};

use atas::Settings;
use robot_model::{FINGERS, Side};
use shm_bus::Subscriber;
use shm_schemas::{GraspFigures, Status, WorldTruth, service};
use sim_backend::{Object, Scene};

use super::stage::Stage;
use crate::arguments::{HOLD_S, LIFT_MM};
use crate::client::{Cancelled, POLL, Pursuit, Session};
use crate::exit::{Ended, Exit};
use crate::interrupt::Interrupt;
use crate::judge::{Load, Outcome};
use crate::progress::Progress;
use crate::rehearsal::grasp_goal;
use crate::story::Story;

/// The hand that grasps.
const SIDE: Side = Side::Right;
/// Longest time of one goal (ours: ten times what a clean grasp takes).
const GOAL_WITHIN: Duration = Duration::from_secs(180);
/// How long to wait for the truth of the goal's last tick, which the simulator publishes 50 times a second (ours).
const TRUTH_WITHIN: Duration = Duration::from_secs(1);

/// How one object's performance went.
#[derive(Clone, Debug)]
pub(super) struct Performance {
    pub(super) object: String,
    pub(super) load: Load,
    pub(super) outcome: Outcome,
    /// What the hand knew and pressed when it last tried.
    pub(super) figures: GraspFigures,
    /// True slip while it tried, the farther of the fingers, m.
    pub(super) slip_m: f64,
    /// True height at the end, m.
    pub(super) lifted_m: f64,
    /// Why it did not succeed; empty if it did.
    pub(super) reason: String,
    /// Share of the milliseconds in which daemon or simulator did not get to run in time. Zero in lock-step.
    pub(super) starved: f64,
}

impl Performance {
    /// Performs a grasp of one object, given by name or file, from start to clean-up.
    pub(super) fn of(
        name: &str,
        seed: u64,
        lockstep: bool,
        interrupt: &Interrupt,
    ) -> anyhow::Result<Self> {
        let object =
            Object::named_or_file(name).map_err(|e| Ended::with(Exit::Usage, e.to_string()))?;
        let mut progress = Progress::new(&object.name);
        progress.note("starting atasd and atas-sim");
        let mut stage = Stage::set(name, seed, lockstep)?;
        let session = Session::join(stage.bus())?;
        stage.wait_until_ready(&session, interrupt)?;
        let watched = watch(&mut stage, &session, &object, interrupt, &mut progress);
        // If a process died, its own words explain more than what its death led to.
        stage.check()?;
        let (story, truths, starved) = watched?;
        Ok(Self {
            starved,
            ..Self::judge(&object, &story, &truths)
        })
    }

    fn judge(object: &Object, story: &Story, truths: &Truths) -> Self {
        let hand = SIDE.index();
        let end = &truths.now;
        let outcome = Outcome::of(story.last(), end, hand, LIFT_MM * 1e-3);
        Self {
            object: object.name.clone(),
            load: Load::of_truth(
                &end.objects[0],
                object.stiffness_n_m,
                &Settings::default().grasp,
            ),
            outcome,
            figures: *story.figures(),
            slip_m: farthest(&truths.attempt.slip_m[hand][..FINGERS]),
            lifted_m: end.objects[0].lifted_m,
            reason: if story.last().reason.is_some() {
                story.sentence()
            } else {
                String::new()
            },
            starved: 0.0,
        }
    }

    /// Whether it ended as physics says it should.
    pub(super) fn is_expected(&self) -> bool {
        self.outcome.is_expected(self.load.is_feasible())
    }
}

/// The simulator's truth, now and when the hand last tried.
struct Truths {
    stream: Subscriber<WorldTruth>,
    now: WorldTruth,
    attempt: WorldTruth,
}

impl Truths {
    fn watch(session: &Session) -> anyhow::Result<Self> {
        Ok(Self {
            stream: session
                .bus()
                .subscriber::<WorldTruth>(service::WORLD_TRUTH)?,
            now: WorldTruth::default(),
            attempt: WorldTruth::default(),
        })
    }

    fn look(&mut self, story: &Story) -> anyhow::Result<()> {
        self.stream.newest(&mut self.now)?;
        if !story.is_backing_out() {
            self.attempt = self.now;
        }
        Ok(())
    }

    /// Waits for the truth of the goal's last tick.
    fn settle(&mut self, story: &Story) -> anyhow::Result<()> {
        let begin = Instant::now();
        while self.now.stamp.captured_ns < story.last().stamp.captured_ns {
            anyhow::ensure!(
                begin.elapsed() < TRUTH_WITHIN,
                "could not judge the outcome because the simulator published no truth for {TRUTH_WITHIN:?}"
            );
            self.look(story)?;
            std::thread::sleep(POLL);
        }
        Ok(())
    }
}

/// Sends the goal and watches it to its end.
fn watch(
    stage: &mut Stage,
    session: &Session,
    object: &Object,
    interrupt: &Interrupt,
    progress: &mut Progress,
) -> anyhow::Result<(Story, Truths, f64)> {
    let scene = Scene::grasp(object.clone(), SIDE);
    let hint = scene
        .grasp_hint(0)
        .ok_or_else(|| anyhow::anyhow!("the scene of a grasp has no object"))?;
    let goal = grasp_goal(&hint, SIDE, LIFT_MM * 1e-3, HOLD_S);
    let mut statuses = session.bus().subscriber::<Status>(service::STATUS)?;
    let (mut status, mut truths) = (Status::default(), Truths::watch(session)?);
    let mut first = None;
    let pursuit = Pursuit {
        session,
        interrupt,
        timeout: Some(GOAL_WITHIN),
    };
    let (story, cancelled) = pursuit.run(&goal, |story| {
        stage.check()?;
        if statuses.newest(&mut status)? {
            first.get_or_insert(status);
        }
        truths.look(story)?;
        progress.show(story, Some(&status), truths.now.objects[0].lifted_m);
        Ok(())
    })?;
    match cancelled {
        Some(Cancelled::Interrupted) => {
            interrupt.check("the demo ended its processes and wiped its bus")?
        }
        Some(Cancelled::TimedOut(limit)) => {
            anyhow::bail!("{} took longer than {limit:?}", object.name)
        }
        None => {}
    }
    truths.settle(&story)?;
    Ok((story, truths, starved(&first.unwrap_or(status), &status)))
}

/// Share of the milliseconds between two statuses that the daemon missed, or for which no joint state arrived.
fn starved(first: &Status, last: &Status) -> f64 {
    let count = |of: fn(&Status) -> u64| of(last).saturating_sub(of(first)) as f64;
    let missed = count(|status| status.missed_ticks);
    let all = count(|status| status.ticks) + missed;
    if all == 0.0 {
        return 0.0;
    }
    (missed + count(|status| status.joints.lost)) / all
}

fn farthest(slip_m: &[f64]) -> f64 {
    slip_m
        .iter()
        .fold(0.0, |farthest, slip_m| slip_m.max(farthest))
}
