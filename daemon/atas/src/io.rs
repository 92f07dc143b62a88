//! Inputs and outputs of one tick.

use crate::goal::Goal;
use crate::settings::Settings;
use crate::tick::Tick;
use shm_schemas::capacity::HANDS;
use shm_schemas::{
    GoalUpdate, GraspTarget, HandFrame, JointCommand, JointState, ModuleEvent, Reason, TickReport,
};

/// All inputs of one tick; a recording of them replays the run.
#[derive(Clone, Copy, Debug, Default)]
pub struct Inputs<'a> {
    /// Tick index and time.
    pub tick: Tick,
    /// Unchecked new tactile frames per hand, oldest first.
    pub frames: [&'a [HandFrame]; HANDS],
    /// Unchecked newest joint state, if new.
    pub joints: Option<&'a JointState>,
    /// Unchecked new teleoperation targets, oldest first.
    pub targets: &'a [GraspTarget],
    /// Request of the supervisor, if any.
    pub request: Option<&'a OperatorRequest>,
}

/// Request of the supervisor; at most one per tick, so that the order of effects is defined.
#[derive(Clone, Copy, Debug, PartialEq)]
#[expect(
    clippy::large_enum_variant,
    reason = "a request is passed by value to a real-time loop that must not allocate"
)]
pub enum OperatorRequest {
    /// Start a goal.
    Start(Goal),
    /// End a goal at its client's request.
    Cancel {
        /// Goal id.
        goal_id: u64,
    },
    /// Report a disconnected client; its goal fails if attached.
    ClientDisconnected {
        /// Goal id.
        goal_id: u64,
    },
    /// Stop and latch SAFE_STOP (`atas estop`, shutdown, a fault detected by the daemon).
    Stop(Reason),
    /// Hold in this tick; repeated by the daemon while the reason lasts.
    Hold(Reason),
    /// Leave SAFE_STOP if its cause is gone.
    Recover,
    /// Set a parameter, checked by the supervisor.
    SetParameter {
        /// Index in [`crate::settings::PARAMETERS`].
        index: usize,
        /// New value.
        value: f64,
    },
    /// Replace all settings, checked by the supervisor.
    Configure(Settings),
    /// Take the present tactile reading as zero force.
    Bias {
        /// 0 left, 1 right.
        hand: usize,
    },
}

/// Maximum number of targets per tick; the rest waits, so that the tick time is bounded.
pub const TARGETS_PER_TICK: usize = 16;

/// Maximum number of events per tick; the rest is dropped and counted.
pub const EVENTS_PER_TICK: usize = 24;

/// All outputs of one tick.
#[derive(Clone, Copy, Debug)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Outputs {
    /// Sealed command to publish.
    pub command: JointCommand,
    /// Report of the tick; the daemon adds the timings.
    pub report: TickReport,
    /// Goal update, if any.
    pub goal_update: Option<GoalUpdate>,
    /// Events of the tick.
    pub events: Events,
}

/// Bounded list of events.
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
    /// Clears the events of the previous tick.
    pub(crate) fn begin(&mut self, tick: Tick) {
        self.count = 0;
        self.tick = tick;
    }

    /// Adds an event with stamp and tick. A full list drops it, which leaves a sequence gap.
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

    /// Returns the events of this tick in order.
    #[must_use]
    pub fn as_slice(&self) -> &[ModuleEvent] {
        &self.list[..self.count]
    }

    /// Returns the number of dropped events.
    #[must_use]
    pub fn dropped(&self) -> u64 {
        self.dropped
    }
}
