//! Execution of task goals: one goal of the daemon per goal of a client.

use std::time::{Duration, Instant};

use atas_client::GoalProgress;
use shm_bus::{GoalClient, PendingGoal, writer_epoch};
use shm_schemas::{GoalPolicy, GoalRequest, GoalState};

use super::Journal;
use super::grippers::Grippers;
use super::scene::Scene;
use super::server::{ActionServer, Wanted};
use super::tasks::{TaskAction, check, outcome, task_progress, unsent};
use crate::link::BusLink;
use crate::middleware::Node;
use crate::wire::action::status;
use crate::wire::atas::TaskOutcome;
use crate::wire::standard::Uuid;

/// Longest wait of a goal for a daemon that starts or re-arms; as `atas_client`.
const ARMING: Duration = Duration::from_secs(2);
/// Longest wait for the daemon's confirmation of a cancellation; as `atas_client`.
const CONFIRMATION: Duration = Duration::from_secs(1);

struct Run {
    id: Uuid,
    request: GoalRequest,
    since: Instant,
    /// The goal at the daemon; `None` before it is sent.
    sent: Option<(GoalClient, PendingGoal)>,
    progress: GoalProgress,
    /// Last published step.
    step: String,
    /// Tick of the last published update.
    reported: u64,
    cancelled: Option<Instant>,
}

/// Server of one task action.
pub(super) struct TaskServer<A: TaskAction> {
    server: ActionServer<A>,
    runs: Vec<Run>,
}

/// End of a goal: state and outcome.
type End = (i8, TaskOutcome);

impl<A: TaskAction> TaskServer<A> {
    pub(super) fn open(node: &mut Node, namespace: &str) -> anyhow::Result<Self> {
        let name = format!("{namespace}/{}", A::NAME);
        Ok(Self {
            server: ActionServer::new(&name, node.action(&name)?),
            runs: Vec::new(),
        })
    }

    /// Continues with another participant.
    pub(super) fn reopen(&mut self, node: &mut Node) -> anyhow::Result<()> {
        self.server.reopen(node)
    }

    /// Returns true if no goal runs.
    pub(super) fn is_idle(&self) -> bool {
        self.runs.is_empty()
    }

    pub(super) fn poll(
        &mut self,
        link: &mut BusLink,
        scene: Option<&Scene>,
        journal: &Journal,
        grippers: &mut Grippers,
    ) {
        for wanted in self.server.poll() {
            match wanted {
                Wanted::Goal(id, goal) => self.receive(id, &goal, journal),
                Wanted::Cancel(id) => self.cancel(&id),
            }
        }
        let mut runs = std::mem::take(&mut self.runs);
        runs.retain_mut(|run| match run.advance(link, scene, grippers) {
            Some(end) => {
                self.finish(&run.id, end, journal);
                false
            }
            None => {
                self.report(run, journal);
                true
            }
        });
        self.runs = runs;
    }

    fn receive(&mut self, id: Uuid, goal: &A::Goal, journal: &Journal) {
        let request = A::request(goal).and_then(|request| check(&request).map(|()| request));
        match request {
            Ok(request) => self.runs.push(Run::new(id, request)),
            Err(cause) => self.finish(&id, (status::ABORTED, unsent(&cause)), journal),
        }
    }

    fn cancel(&mut self, id: &Uuid) {
        if let Some(run) = self.runs.iter_mut().find(|run| run.id == *id) {
            run.cancelled = Some(Instant::now());
            if let Some((_, pending)) = &run.sent {
                pending.cancel();
            }
        }
    }

    /// Publishes progress after an update of the daemon.
    fn report(&mut self, run: &mut Run, journal: &Journal) {
        let last = run.progress.last();
        if last.goal_id == 0 || std::mem::replace(&mut run.reported, last.tick) == last.tick {
            return;
        }
        let step = last.step.to_string();
        if step != run.step {
            let name = self.server.name();
            journal.write(name, &run.id, status::EXECUTING, &step, "");
            run.step = step;
            self.server.execute(&run.id);
        }
        let feedback = A::feedback(task_progress(&run.progress));
        self.server.feedback(&run.id, feedback);
    }

    fn finish(&mut self, id: &Uuid, (status, outcome): End, journal: &Journal) {
        let cause = outcome.cause.clone();
        self.server.finish(id, status, &A::result(outcome));
        journal.write(self.server.name(), id, status, "", &cause);
    }
}

impl Run {
    fn new(id: Uuid, request: GoalRequest) -> Self {
        Self {
            id,
            request,
            since: Instant::now(),
            sent: None,
            progress: GoalProgress::default(),
            step: String::new(),
            reported: 0,
            cancelled: None,
        }
    }

    /// Advances the goal; returns its end.
    fn advance(
        &mut self,
        link: &mut BusLink,
        scene: Option<&Scene>,
        grippers: &mut Grippers,
    ) -> Option<End> {
        let failed = |cause: String| Some((status::ABORTED, unsent(&cause)));
        let Some((_, pending)) = &mut self.sent else {
            if self.cancelled.is_some() {
                let state = GoalState::CANCELLED.name().to_owned();
                let outcome = TaskOutcome {
                    state,
                    ..TaskOutcome::default()
                };
                return Some((status::CANCELED, outcome));
            }
            let is_arming = scene.is_none_or(Scene::is_arming);
            if !grippers.make_way() || (is_arming && self.since.elapsed() < ARMING) {
                return None;
            }
            return match self.send(link) {
                Ok(()) => None,
                Err(cause) => failed(format!("goal not sent: {cause}")),
            };
        };
        loop {
            match pending.next() {
                Ok(Some(update)) => self.progress.add(&update),
                Ok(None) => break,
                Err(error) => return failed(format!("goal lost: {error}")),
            }
        }
        if pending.has_ended() {
            let status = match self.progress.last().state {
                GoalState::SUCCEEDED => status::SUCCEEDED,
                GoalState::CANCELLED if self.cancelled.is_some() => status::CANCELED,
                _ => status::ABORTED,
            };
            return Some((status, outcome(&self.progress)));
        }
        let is_unconfirmed = self
            .cancelled
            .is_some_and(|since| since.elapsed() > CONFIRMATION);
        if is_unconfirmed {
            return failed(format!(
                "goal cancelled, but the daemon did not confirm it within {CONFIRMATION:?}; see \
                 `atas status`, and call the stop service if in doubt"
            ));
        }
        None
    }

    fn send(&mut self, link: &mut BusLink) -> Result<(), String> {
        let session = link.session().map_err(|error| error.to_string())?;
        let request = GoalRequest {
            stamp: session.stamp(),
            goal_id: writer_epoch(),
            // A killed bridge cannot cancel: the robot then holds.
            policy: GoalPolicy::ATTACHED,
            ..self.request
        };
        let client = session
            .bus()
            .goal_client()
            .map_err(|error| error.to_string())?;
        let pending = client.send(&request).map_err(|error| error.to_string())?;
        self.sent = Some((client, pending));
        Ok(())
    }
}
