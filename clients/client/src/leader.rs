//! Leading a hand: the goal that opens a stream of targets, and the stream itself.

use shm_bus::{GoalClient, PendingGoal, Publisher, Subscriber, writer_epoch};
use shm_schemas::{
    GoalKind, GoalPolicy, GoalRequest, GraspTarget, GripOrder, Hand, Stamp, TickReport, service,
};

use crate::{ClientError, GoalProgress, Session};

/// Most reports taken in one look: all that can wait.
const AT_ONCE: usize = 256;

/// Which hands a client leads.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Led {
    /// One.
    One(Hand),
    /// Both.
    Both,
}

/// Where a hand shall be, as a client thinks of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wanted {
    /// Which hand.
    pub hand: Hand,
    /// Point between the fingertips, base frame, m.
    pub centre_m: [f64; 3],
    /// Direction of the closing axis, rad from x towards y.
    pub yaw_rad: f64,
    /// Distance between the fingertips, m; `None` to hold what is there.
    pub opening_m: Option<f64>,
}

/// A client that leads a hand, from the goal that opens the stream to its end.
pub struct Leader {
    targets: Publisher<GraspTarget>,
    reports: Subscriber<TickReport>,
    pending: PendingGoal,
    _client: GoalClient,
    progress: GoalProgress,
    report: TickReport,
    epoch: u64,
    sequence: u64,
}

impl Leader {
    /// Asks the daemon to follow. Its answer comes with [`Leader::look`].
    ///
    /// # Errors
    /// Another client leads a hand already (it is named), or there is no daemon.
    pub fn open(session: &Session, led: Led) -> Result<Self, ClientError> {
        let bus = session.bus();
        let targets = bus.publisher(service::GRASP_TARGET)?;
        let reports = bus.subscriber(service::TICK_REPORT)?;
        let (kind, hand) = match led {
            Led::One(hand) => (GoalKind::FOLLOW, hand),
            Led::Both => (GoalKind::FOLLOW_BOTH, Hand::RIGHT),
        };
        let stamp = session.stamp();
        let request = GoalRequest {
            stamp,
            goal_id: writer_epoch(),
            kind,
            hand,
            policy: GoalPolicy::ATTACHED,
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

    /// Takes in what the daemon has said; how the goal stands.
    ///
    /// # Errors
    /// The daemon has gone.
    pub fn look(&mut self) -> Result<&GoalProgress, ClientError> {
        let report = &mut self.report;
        self.reports.drain(AT_ONCE, |newest| *report = *newest)?;
        while let Some(update) = self.pending.next()? {
            self.progress.add(&update);
        }
        Ok(&self.progress)
    }

    /// Whether the goal has ended.
    #[must_use]
    pub fn ended(&self) -> bool {
        self.pending.ended()
    }

    /// The newest report of a tick; all zero before the first.
    #[must_use]
    pub fn report(&self) -> &TickReport {
        &self.report
    }

    /// Time of that tick, ns of the daemon's clock.
    #[must_use]
    pub fn now_ns(&self) -> u64 {
        self.report.stamp.captured_ns
    }

    /// Sends a target that may be followed for so long without a newer one, ns.
    ///
    /// # Errors
    /// The bus is damaged.
    pub fn lead(&mut self, wanted: &Wanted, valid_ns: u64) -> Result<(), ClientError> {
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

    /// Ends the stream: the hand brakes and keeps what it holds. The goal's end comes with [`Leader::look`].
    pub fn end(&self) {
        self.pending.cancel();
    }
}
