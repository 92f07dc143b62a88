//! A robot's coordinator on the bus: its pilot's eyes, ears and mouth.
//!
//! ```text
//!  BaseState, WorldTruth ─┐                     ┌─▶ BaseCommand
//!  TickReport ────────────┼─ at every frame ─▶ Pilot ─▶ GoalRequest
//!  GoalUpdate ────────────┘                     └─▶ ADVANCE
//! ```
//!
//! Time stands still while a frame is decided: the simulator waits for the command, and the daemon does not tick beyond what it
//! was allowed to without a goal. A goal is sent with no ticks allowed, so it begins in the very tick of its frame; when it has ended,
//! ticks are allowed up to the next frame.

use atas_client::Session;
use atas_evaluation::hybrid::Pilot;
use shm_bus::{BusError, ControlClient, GoalClient, PendingGoal, Publisher, Subscriber};
use shm_schemas::{
    BaseCommand, BaseState, ControlOp, ControlOutcome, ControlRequest, GoalRequest, TickReport,
    WorldTruth, service,
};
use sim_backend::course::{FRAME_TICKS, SETTLE_TICKS};
use sim_backend::{START_NS, TICK_NS};
use std::time::Duration;

/// How long the daemon may take to answer (ours: two hundred of its rounds).
const ANSWER: Duration = Duration::from_millis(900);

/// A coordinator at its place.
pub(super) struct Coordinator {
    session: Session,
    pilot: Pilot,
    states: Subscriber<BaseState>,
    truths: Subscriber<WorldTruth>,
    reports: Subscriber<TickReport>,
    commands: Publisher<BaseCommand>,
    goals: GoalClient,
    controls: ControlClient,
    pending: Option<PendingGoal>,
    /// The newest of each.
    state: BaseState,
    truth: WorldTruth,
    report: TickReport,
    /// A state waits for its command.
    is_asked: bool,
}

impl Coordinator {
    /// Joins a robot's bus, once its daemon answers requests.
    pub(super) fn join(session: Session, pilot: Pilot) -> anyhow::Result<Self> {
        let bus = session.bus();
        Ok(Self {
            states: bus.subscriber(service::BASE_STATE)?,
            truths: bus.subscriber(service::WORLD_TRUTH)?,
            reports: bus.subscriber(service::TICK_REPORT)?,
            commands: bus.publisher(service::BASE_COMMAND)?,
            goals: bus.goal_client()?,
            controls: bus.control_client()?,
            session,
            pilot,
            pending: None,
            state: BaseState::default(),
            truth: WorldTruth::default(),
            report: TickReport::default(),
            is_asked: false,
        })
    }

    /// Takes in what has come, and answers a frame if all that it needs is there. The phase that has begun, if one has, and when, s.
    pub(super) fn look(&mut self) -> anyhow::Result<Option<(&'static str, f64)>> {
        self.hear_goal()?;
        self.reports.newest(&mut self.report)?;
        self.truths.newest(&mut self.truth)?;
        self.is_asked |= self.states.newest(&mut self.state)?;
        if !self.is_asked || !self.knows_all() {
            return Ok(None);
        }
        self.is_asked = false;
        self.pilot.hear_report(&self.report);
        let decision = self.pilot.frame(&self.state, &self.truth);
        if let Some(goal) = decision.goal {
            self.send(&goal)?;
        } else if self.pending.is_none() && self.pilot.ended().is_none() {
            self.advance()?;
        }
        self.commands.send(&decision.command)?;
        let now_s = (self.state.frame * FRAME_TICKS) as f64 * 1e-3;
        Ok(decision.began.map(|phase| (phase, now_s)))
    }

    /// Whether the daemon's last tick before the frame was heard of, and with it the end of a goal, and where the object is in it.
    fn knows_all(&self) -> bool {
        let tick = self.first_tick(self.state.frame);
        // Ticks before the first frame may have been before this process came, and no hand had anything to feel in them.
        let has_heard = self.state.frame == 0 || self.report.tick + 1 == tick;
        let has_ended = self.pending.is_some() && self.report.goal_id == 0;
        self.truth.stamp.captured_ns == START_NS + tick * TICK_NS && has_heard && !has_ended
    }

    /// The tick with which a frame begins.
    fn first_tick(&self, frame: u64) -> u64 {
        SETTLE_TICKS + frame * FRAME_TICKS
    }

    fn hear_goal(&mut self) -> anyhow::Result<()> {
        while let Some(pending) = &mut self.pending
            && let Some(update) = pending.next()?
        {
            self.pilot.hear_goal(&update);
            if update.state.is_final() {
                self.pending = None;
                self.advance()?;
            }
        }
        Ok(())
    }

    fn send(&mut self, goal: &GoalRequest) -> Result<(), BusError> {
        let stamp = self.session.stamp();
        self.pending = Some(self.goals.send(&GoalRequest { stamp, ..*goal })?);
        Ok(())
    }

    /// Allows ticks up to the next frame.
    fn advance(&self) -> anyhow::Result<()> {
        let request = ControlRequest {
            stamp: self.session.stamp(),
            op: ControlOp::ADVANCE,
            value: self.first_tick(self.state.frame + 1) as f64,
            ..ControlRequest::default()
        };
        let reply = self.controls.call(&request, ANSWER)?;
        anyhow::ensure!(
            reply.outcome == ControlOutcome::DONE,
            "the daemon did not let time go on: {}",
            reply.text
        );
        Ok(())
    }

    /// Whether its robot's course is over.
    pub(super) fn is_done(&self) -> bool {
        self.pilot.ended().is_some()
    }

    /// The pilot, and the world in the end.
    pub(super) fn end(&self) -> (&Pilot, &WorldTruth) {
        (&self.pilot, &self.truth)
    }
}
