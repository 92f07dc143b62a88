//! Coordinator of one robot: connects its [`Pilot`] to the bus.
//!
//! ```text
//!  BaseState, WorldTruth ─┐                     ┌─▶ BaseCommand
//!  TickReport ────────────┼─ at every frame ─▶ Pilot ─▶ GoalRequest
//!  GoalUpdate ────────────┘                     └─▶ ADVANCE
//! ```
//!
//! Virtual time stops during a decision: the simulator waits for the command and the daemon for
//! permission to tick. A goal is sent without permitted ticks and begins in the first tick of its
//! frame. After its end, ticks are permitted up to the next frame.

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

/// Longest time until the daemon replies (design choice: two hundred of its rounds).
const REPLY_TIMEOUT: Duration = Duration::from_millis(900);

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
    state: BaseState,
    truth: WorldTruth,
    report: TickReport,
    /// True while a base state waits for its command.
    has_request: bool,
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
            has_request: false,
        })
    }

    /// Polls all topics and answers a frame when its inputs are complete. Returns the phase that
    /// has begun, with its time, s.
    pub(super) fn poll(&mut self) -> anyhow::Result<Option<(&'static str, f64)>> {
        self.receive_goal_updates()?;
        self.reports.newest(&mut self.report)?;
        self.truths.newest(&mut self.truth)?;
        self.has_request |= self.states.newest(&mut self.state)?;
        if !self.has_request || !self.is_frame_complete() {
            return Ok(None);
        }
        self.has_request = false;
        self.pilot.process_report(&self.report);
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

    /// Returns true if the report of the tick before the frame, the end of the goal and the
    /// object's state have arrived.
    fn is_frame_complete(&self) -> bool {
        let tick = self.first_tick(self.state.frame);
        // Ticks before frame 0 may precede this process; no hand is in contact then.
        let has_heard = self.state.frame == 0 || self.report.tick + 1 == tick;
        let has_ended = self.pending.is_some() && self.report.goal_id == 0;
        self.truth.stamp.captured_ns == START_NS + tick * TICK_NS && has_heard && !has_ended
    }

    fn first_tick(&self, frame: u64) -> u64 {
        SETTLE_TICKS + frame * FRAME_TICKS
    }

    fn receive_goal_updates(&mut self) -> anyhow::Result<()> {
        while let Some(pending) = &mut self.pending
            && let Some(update) = pending.next()?
        {
            self.pilot.process_goal_update(&update);
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

    fn advance(&self) -> anyhow::Result<()> {
        let request = ControlRequest {
            stamp: self.session.stamp(),
            op: ControlOp::ADVANCE,
            value: self.first_tick(self.state.frame + 1) as f64,
            ..ControlRequest::default()
        };
        let reply = self.controls.call(&request, REPLY_TIMEOUT)?;
        anyhow::ensure!(
            reply.outcome == ControlOutcome::DONE,
            "the daemon rejected the request to advance virtual time: {}",
            reply.text
        );
        Ok(())
    }

    pub(super) fn is_done(&self) -> bool {
        self.pilot.ended().is_some()
    }

    pub(super) fn result(&self) -> (&Pilot, &WorldTruth) {
        (&self.pilot, &self.truth)
    }
}
