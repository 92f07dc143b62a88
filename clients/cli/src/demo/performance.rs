//! One performance: stage set, goal sent, truth watched to the end.

use std::time::{Duration, Instant};

use robot_model::Side;
use shm_bus::Subscriber;
use shm_schemas::{Status, WorldTruth, service};

use super::piece::Piece;
use super::punctuality::Punctuality;
use super::stage::Stage;
use super::turns::Turns;
use crate::arguments::Running;
use crate::client::{Cancelled, POLL, Pursuit, Session};
use crate::interrupt::Interrupt;
use crate::progress::Progress;
use crate::story::Story;

/// The hand that acts.
pub(super) const SIDE: Side = Side::Right;
/// Longest time of one goal (ours: several times what the longest clean task takes).
const GOAL_WITHIN: Duration = Duration::from_secs(600);
/// How long to wait for truth and status of the goal's last tick, which come 50 times a second (ours).
const SETTLED_WITHIN: Duration = Duration::from_secs(1);

/// What was seen of a performance.
pub(super) struct Seen {
    pub(super) story: Story,
    /// The truth at the end.
    pub(super) truth: WorldTruth,
    /// The truth when the hand last tried, before it backed out of a refused object.
    pub(super) attempt: WorldTruth,
    /// Turns of a cap.
    pub(super) turns: u32,
    pub(super) punctuality: Punctuality,
}

/// Performs a piece from start to clean-up.
pub(super) fn perform(
    piece: &dyn Piece,
    running: &Running,
    interrupt: &Interrupt,
) -> anyhow::Result<Seen> {
    let mut progress = Progress::new(piece.name());
    progress.note("starting atasd and atas-sim");
    let mut stage = Stage::set(&piece.setting(), running)?;
    let session = Session::join(stage.bus())?;
    stage.wait_until_ready(&session, interrupt)?;
    let watched = watch(&mut stage, &session, piece, interrupt, &mut progress);
    // If a process died, its own words explain more than what its death led to.
    stage.check()?;
    watched
}

/// Sends the goal and watches it to its end.
fn watch(
    stage: &mut Stage,
    session: &Session,
    piece: &dyn Piece,
    interrupt: &Interrupt,
    progress: &mut Progress,
) -> anyhow::Result<Seen> {
    let mut audience = Audience::join(session)?;
    let pursuit = Pursuit {
        session,
        interrupt,
        timeout: Some(GOAL_WITHIN),
    };
    let (story, cancelled) = pursuit.run(&piece.goal(), |story| {
        stage.check()?;
        audience.look(story)?;
        progress.show(story, Some(&audience.status), &piece.live(&audience.now));
        Ok(())
    })?;
    match cancelled {
        Some(Cancelled::Interrupted) => {
            interrupt.check("the demo ended its processes and wiped its bus")?
        }
        Some(Cancelled::TimedOut(limit)) => {
            anyhow::bail!("{} took longer than {limit:?}", piece.name())
        }
        None => {}
    }
    audience.settle(&story)?;
    Ok(audience.recount(story))
}

/// Who watches truth and status.
struct Audience {
    truths: Subscriber<WorldTruth>,
    statuses: Subscriber<Status>,
    first: Option<(WorldTruth, Status)>,
    now: WorldTruth,
    attempt: WorldTruth,
    status: Status,
    turns: Turns,
}

impl Audience {
    fn join(session: &Session) -> anyhow::Result<Self> {
        let bus = session.bus();
        Ok(Self {
            truths: bus.subscriber(service::WORLD_TRUTH)?,
            statuses: bus.subscriber(service::STATUS)?,
            first: None,
            now: WorldTruth::default(),
            attempt: WorldTruth::default(),
            status: Status::default(),
            turns: Turns::default(),
        })
    }

    fn look(&mut self, story: &Story) -> anyhow::Result<()> {
        self.truths.newest(&mut self.now)?;
        self.statuses.newest(&mut self.status)?;
        if self.now.object_count > 0 && self.status.pid > 0 {
            self.first.get_or_insert((self.now, self.status));
        }
        if !story.lets_go() {
            self.attempt = self.now;
        }
        self.turns.look(&self.now, SIDE.index());
        Ok(())
    }

    /// Waits for truth and status of the goal's last tick.
    fn settle(&mut self, story: &Story) -> anyhow::Result<()> {
        let begin = Instant::now();
        let end_ns = story.last().stamp.captured_ns;
        while self.now.stamp.captured_ns < end_ns || self.status.stamp.captured_ns < end_ns {
            anyhow::ensure!(
                begin.elapsed() < SETTLED_WITHIN,
                "could not judge the outcome because truth and status of the goal's last tick did not come within \
                 {SETTLED_WITHIN:?}"
            );
            self.look(story)?;
            std::thread::sleep(POLL);
        }
        Ok(())
    }

    fn recount(self, story: Story) -> Seen {
        let (first, status) = self.first.unwrap_or((self.now, self.status));
        let ticks = (story.took_s() * f64::from(self.status.rate_hz)).round() as u64;
        let ends = [(&first, &status), (&self.now, &self.status)];
        Seen {
            punctuality: Punctuality::between(ends, ticks),
            story,
            truth: self.now,
            attempt: self.attempt,
            turns: self.turns.count,
        }
    }
}
