//! What comes in on the tick: both hands' frames, the newest joint state, a client's targets, in memory that was set aside at the start.

use atas_core::io::TARGETS_PER_TICK;
use atas_core::{Inputs, Order, Tick};
use shm_bus::{Bus, BusError, Subscriber};
use shm_schemas::capacity::HANDS;
use shm_schemas::{GraspTarget, HandFrame, JointState, View, service};

/// Most frames of one hand that one tick takes in. More wait for the next tick, which makes the drain bounded.
pub const FRAMES_PER_TICK: usize = 64;

/// Streams that a tick takes in: the frames of both hands, and the joint states behind them.
pub const STREAMS: usize = HANDS + 1;

/// The subscribers of the tick thread.
#[derive(Debug)]
pub struct InputPorts {
    hands: [HandPort; HANDS],
    joints: Subscriber<JointState>,
    stream: Subscriber<GraspTarget>,
    targets: Box<[GraspTarget; TARGETS_PER_TICK]>,
    target_count: usize,
    newest: JointState,
    has_news: bool,
    failures: u64,
}

#[derive(Debug)]
struct HandPort {
    port: Subscriber<HandFrame>,
    frames: Box<[HandFrame]>,
    count: usize,
    /// Place of the newest frame that ever came.
    newest: Option<usize>,
    captured_ns: u64,
}

impl InputPorts {
    /// Opens the ports.
    ///
    /// # Errors
    /// [`BusError`] if the bus refuses.
    pub fn open(bus: &Bus) -> Result<Self, BusError> {
        let [left, right] = service::HAND_FRAME;
        Ok(Self {
            hands: [HandPort::open(bus, left)?, HandPort::open(bus, right)?],
            joints: bus.subscriber(service::JOINT_STATE)?,
            stream: bus.subscriber(service::GRASP_TARGET)?,
            targets: Box::default(),
            target_count: 0,
            newest: JointState::default(),
            has_news: false,
            failures: 0,
        })
    }

    /// Forgets what the last tick used.
    pub fn begin(&mut self) {
        self.hands.iter_mut().for_each(|hand| hand.count = 0);
        self.has_news = false;
        self.target_count = 0;
    }

    /// Takes in what has come since the last look, hands before joints, as they are sent, and then what clients want. At most [`FRAMES_PER_TICK`]
    /// frames of each hand fit between two calls of [`InputPorts::begin`].
    pub fn look(&mut self) {
        self.look_for_frames();
        self.look_for_joints();
        self.look_for_targets();
    }

    /// Takes in the frames alone.
    pub fn look_for_frames(&mut self) {
        for hand in &mut self.hands {
            self.failures += u64::from(hand.take().is_err());
        }
    }

    /// Takes in the targets of a client that leads a hand; what finds no room waits for the next tick.
    pub fn look_for_targets(&mut self) {
        let Self {
            stream,
            targets,
            target_count,
            failures,
            ..
        } = self;
        let taken = stream.drain(TARGETS_PER_TICK - *target_count, |target| {
            targets[*target_count] = *target;
            *target_count += 1;
        });
        *failures += u64::from(taken.is_err());
    }

    /// Whether something waits in each of these streams. Asked in the reverse of the order in which they are sent, so that
    /// as long as the last one has not come nothing else is looked at.
    #[must_use]
    pub fn have_news(&self, streams: &[bool; STREAMS]) -> bool {
        let [left, right] = self.hands.each_ref().map(|hand| &hand.port);
        (!streams[2] || self.joints.has_news())
            && (!streams[1] || right.has_news())
            && (!streams[0] || left.has_news())
    }

    /// Takes in the newest joint state alone; `false` if none has come since [`InputPorts::begin`].
    pub fn look_for_joints(&mut self) -> bool {
        let taken = self.joints.newest(&mut self.newest);
        self.failures += u64::from(taken.is_err());
        self.has_news |= taken.unwrap_or(false);
        self.has_news
    }

    /// When the newest payload of each stream was captured, ns, as its writer says; 0 if there was none yet. Nobody has
    /// checked it: good enough to begin a tick by, and for nothing else.
    #[must_use]
    pub fn captured_ns(&self) -> [u64; STREAMS] {
        let [left, right] = self.hands.each_ref().map(|hand| hand.captured_ns);
        [left, right, self.joints_captured_ns()]
    }

    /// When the newest joint state was captured, ns.
    #[must_use]
    pub fn joints_captured_ns(&self) -> u64 {
        self.newest.stamp.captured_ns
    }

    /// Calls on which the bus failed so far.
    #[must_use]
    pub fn failures(&self) -> u64 {
        self.failures
    }

    /// Writes what came last into a view; what it has of the hands stays where nothing came.
    pub fn write_view(&self, tick: Tick, view: &mut View) {
        view.stamp.captured_ns = tick.now_ns;
        view.tick = tick.index;
        for (index, hand) in self.hands.iter().enumerate() {
            if let Some(newest) = hand.newest {
                view.frames[index] = hand.frames[newest];
                view.has_frame[index] = 1;
            }
        }
        if self.joints_captured_ns() != 0 {
            view.joints = self.newest;
            view.has_joints = 1;
        }
    }

    /// What was taken in, for the controller.
    #[must_use]
    pub fn inputs<'a>(&'a self, tick: Tick, order: Option<&'a Order>) -> Inputs<'a> {
        Inputs {
            tick,
            frames: self.hands.each_ref().map(|hand| &hand.frames[..hand.count]),
            joints: self.has_news.then_some(&self.newest),
            targets: &self.targets[..self.target_count],
            order,
        }
    }
}

impl HandPort {
    fn open(bus: &Bus, name: &str) -> Result<Self, BusError> {
        let frames = vec![HandFrame::default(); FRAMES_PER_TICK].into_boxed_slice();
        Ok(Self {
            port: bus.subscriber(name)?,
            frames,
            count: 0,
            newest: None,
            captured_ns: 0,
        })
    }

    fn take(&mut self) -> Result<(), BusError> {
        let Self {
            port,
            frames,
            count,
            newest,
            captured_ns,
        } = self;
        port.drain(FRAMES_PER_TICK - *count, |frame| {
            frames[*count] = *frame;
            *captured_ns = frame.stamp.captured_ns;
            *newest = Some(*count);
            *count += 1;
        })?;
        Ok(())
    }
}
