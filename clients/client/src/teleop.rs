//! Teleoperation client: the goal that opens a stream of targets, and the stream.

use shm_bus::{GoalClient, PendingGoal, Publisher, Subscriber, writer_epoch};
use shm_schemas::{
    GoalKind, GoalPolicy, GoalRequest, GraspTarget, GripOrder, Hand, Stamp, TickReport, service,
};

use crate::{ClientError, GoalProgress, Session};

/// Largest number of reports per poll.
const REPORTS_PER_POLL: usize = 256;

/// Teleoperated hands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TeleopHands {
    /// One hand.
    One(Hand),
    /// Both hands.
    Both,
}

/// Target of one hand, in client units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TeleopTarget {
    /// Hand.
    pub hand: Hand,
    /// Point between the fingertips, base frame, m.
    pub centre_m: [f64; 3],
    /// Direction of the closing axis, rad from x towards y.
    pub yaw_rad: f64,
    /// Distance between the fingertips, m; `None` keeps the present grip.
    pub opening_m: Option<f64>,
}

/// Sender of teleoperation targets, from the goal that opens the stream to its end.
pub struct TeleopSender {
    targets: Publisher<GraspTarget>,
    reports: Subscriber<TickReport>,
    pending: PendingGoal,
    _client: GoalClient,
    progress: GoalProgress,
    report: TickReport,
    epoch: u64,
    sequence: u64,
}

impl TeleopSender {
    /// Sends the teleoperation goal. [`TeleopSender::poll`] returns the daemon's answer.
    ///
    /// # Errors
    /// Another client teleoperates a hand already (the error names it), or there is no daemon.
    pub fn open(session: &Session, teleoperated: TeleopHands) -> Result<Self, ClientError> {
        Self::open_limited(session, teleoperated, 0.0)
    }

    /// Sends the teleoperation goal with the largest force per grasp side, N; 0 leaves the force to
    /// the measured stiffness. The limit applies to the right hand if both are teleoperated.
    ///
    /// # Errors
    /// As [`TeleopSender::open`].
    pub fn open_limited(
        session: &Session,
        teleoperated: TeleopHands,
        max_force_n: f64,
    ) -> Result<Self, ClientError> {
        let bus = session.bus();
        let targets = bus.publisher(service::GRASP_TARGET)?;
        let reports = bus.subscriber(service::TICK_REPORT)?;
        let (kind, hand) = match teleoperated {
            TeleopHands::One(hand) => (GoalKind::TELEOP, hand),
            TeleopHands::Both => (GoalKind::TELEOP_BOTH, Hand::RIGHT),
        };
        let stamp = session.stamp();
        let request = GoalRequest {
            stamp,
            goal_id: writer_epoch(),
            kind,
            hand,
            policy: GoalPolicy::ATTACHED,
            max_force_n,
            ..GoalRequest::default()
        };
        let client = bus.goal_client()?;
        let pending = client.send(&request)?;
        Ok(Self {
            targets,
            reports,
            pending,
            _client: client,
            progress: GoalProgress::default(),
            report: TickReport::default(),
            epoch: stamp.writer_epoch,
            sequence: 0,
        })
    }

    /// Reads all updates and returns the progress of the goal.
    ///
    /// # Errors
    /// The daemon is gone.
    pub fn poll(&mut self) -> Result<&GoalProgress, ClientError> {
        let report = &mut self.report;
        self.reports
            .drain(REPORTS_PER_POLL, |newest| *report = *newest)?;
        while let Some(update) = self.pending.next()? {
            self.progress.add(&update);
        }
        Ok(&self.progress)
    }

    /// Returns true if the goal has ended.
    #[must_use]
    pub fn has_ended(&self) -> bool {
        self.pending.has_ended()
    }

    /// Returns the newest tick report; all zero before the first.
    #[must_use]
    pub fn report(&self) -> &TickReport {
        &self.report
    }

    /// Returns the time of that tick, ns of the daemon's clock.
    #[must_use]
    pub fn now_ns(&self) -> u64 {
        self.report.stamp.captured_ns
    }

    /// Sends a target that is valid for `valid_ns` unless a newer one arrives.
    ///
    /// # Errors
    /// The bus is damaged.
    pub fn send(&mut self, wanted: &TeleopTarget, valid_ns: u64) -> Result<(), ClientError> {
        let now_ns = self.now_ns();
        let mut target = GraspTarget {
            stamp: Stamp {
                sequence: self.sequence,
                captured_ns: now_ns,
                writer_epoch: self.epoch,
            },
            valid_until_ns: now_ns.saturating_add(valid_ns),
            hand: wanted.hand,
            grip: match wanted.opening_m {
                Some(_) => GripOrder::WIDTH,
                None => GripOrder::HOLD,
            },
            centre_m: wanted.centre_m,
            closing_yaw_rad: wanted.yaw_rad,
            opening_m: wanted.opening_m.unwrap_or(0.0),
            ..GraspTarget::default()
        };
        target.seal();
        self.sequence += 1;
        Ok(self.targets.send(&target)?)
    }

    /// Ends the stream: the hand decelerates and keeps its grip. [`TeleopSender::poll`] returns
    /// the end of the goal.
    pub fn end(&self) {
        self.pending.cancel();
    }
}
