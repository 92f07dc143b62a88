//! What one tick takes in and gives out.

use crate::goal::Goal;
use crate::settings::Settings;
use crate::tick::Tick;
use shm_schemas::capacity::HANDS;
use shm_schemas::{
    GoalUpdate, GraspTarget, HandFrame, JointCommand, JointState, ModuleEvent, Reason, TickReport,
};

/// Everything that one tick is a function of, besides the controller's own state. Recording these replays the run.
#[derive(Clone, Copy, Debug, Default)]
pub struct Inputs<'a> {
    /// The tick.
    pub tick: Tick,
    /// Per hand, the frames that arrived since the tick before, oldest first, as they came (nothing checked).
    pub frames: [&'a [HandFrame]; HANDS],
    /// The newest joint state, if one arrived since the tick before (nothing checked).
    pub joints: Option<&'a JointState>,
    /// The targets that arrived since the tick before, oldest first, as they came (nothing checked).
    pub targets: &'a [GraspTarget],
    /// What the supervisor asks, if anything.
    pub order: Option<&'a Order>,
}

/// What the supervisor asks of the controller. At most one per tick, so that the order of effects is defined.
#[derive(Clone, Copy, Debug, PartialEq)]
#[expect(
    clippy::large_enum_variant,
    reason = "an order travels by value to a loop that must not touch the heap"
)]
pub enum Order {
    /// Start a goal.
    Start(Goal),
    /// The client wants its goal to end; the hand stays as it is.
    Cancel {
        /// Which goal.
        goal_id: u64,
    },
    /// The client of a goal went away; attached goals are held.
    ClientGone {
        /// Which goal.
        goal_id: u64,
    },
    /// Stop and latch, for the given reason (`atas estop`, shutdown, a fault that the wiring saw).
    Stop(Reason),
    /// Hold in this tick, for the given reason; the wiring says it again as long as it lasts.
    Hold(Reason),
    /// Leave SAFE_STOP if its cause is gone.
    Recover,
    /// Set the parameter with this index of [`crate::settings::PARAMETERS`]; checked before by the supervisor.
    SetParameter {
        /// Index.
        index: usize,
        /// Value.
        value: f64,
    },
    /// Replace all settings at once; checked before by the supervisor.
    Configure(Settings),
    /// Take the present reading of this hand as zero force.
    Bias {
        /// 0 left, 1 right.
        hand: usize,
    },
}

/// Most targets that one tick can take in; more wait for the next tick, which makes the drain bounded.
pub const TARGETS_PER_TICK: usize = 16;

/// Events that one tick can raise; more than this in one tick are counted, not kept.
pub const EVENTS_PER_TICK: usize = 24;

/// Everything that one tick gives out.
#[derive(Clone, Copy, Debug)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Outputs {
    /// The command to publish, sealed by the safety gate.
    pub command: JointCommand,
    /// What the tick saw and did; the wiring adds its timings.
    pub report: TickReport,
    /// News of the goal, if any.
    pub goal_update: Option<GoalUpdate>,
    /// What happened.
    pub events: Events,
}

/// A bounded list of events.
#[derive(Clone, Copy, Debug)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Events {
    list: [ModuleEvent; EVENTS_PER_TICK],
    count: usize,
    dropped: u64,
    next_sequence: u64,
    tick: Tick,
}

impl Default for Events {
    fn default() -> Self {
        Self {
            list: [ModuleEvent::default(); EVENTS_PER_TICK],
            count: 0,
            dropped: 0,
            next_sequence: 0,
            tick: Tick::default(),
        }
    }
}

impl Events {
    /// Forgets the events of the tick before.
    pub(crate) fn begin(&mut self, tick: Tick) {
        self.count = 0;
        self.tick = tick;
    }

    /// Adds an event; its stamp and tick are filled in here. A full list counts it as dropped, which shows as a gap in
    /// the sequence.
    pub(crate) fn push(&mut self, mut event: ModuleEvent) {
        event.stamp.sequence = self.next_sequence;
        event.stamp.captured_ns = self.tick.now_ns;
        event.tick = self.tick.index;
        self.next_sequence += 1;
        match self.list.get_mut(self.count) {
            Some(slot) => {
                *slot = event;
                self.count += 1;
            }
            None => self.dropped += 1,
        }
    }

    /// The events of this tick, in the order in which they happened.
    #[must_use]
    pub fn as_slice(&self) -> &[ModuleEvent] {
        &self.list[..self.count]
    }

    /// Events dropped since the start because one tick raised too many.
    #[must_use]
    pub fn dropped(&self) -> u64 {
        self.dropped
    }
}
