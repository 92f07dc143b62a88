//! Inputs of a tick: frames of both hands, newest joint state, grasp targets of a client. Buffers
//! are allocated at the start.

use atas_core::io::TARGETS_PER_TICK;
use atas_core::{Inputs, OperatorRequest, Tick};
use shm_bus::{Bus, BusError, Subscriber};
use shm_schemas::capacity::HANDS;
use shm_schemas::{GraspTarget, HandFrame, JointState, View, service};

/// Maximum number of frames per hand and tick. Further frames wait for the next tick, which bounds
/// the work per tick.
pub const FRAMES_PER_TICK: usize = 64;

/// Number of input streams that a tick can await: the frames of both hands, then the joint states.
pub const STREAMS: usize = HANDS + 1;

/// Subscribers of the tick thread.
#[derive(Debug)]
pub struct InputPorts {
    hands: [HandPort; HANDS],
    joints: Subscriber<JointState>,
    stream: Subscriber<GraspTarget>,
    targets: Box<[GraspTarget; TARGETS_PER_TICK]>,
    target_count: usize,
    newest: JointState,
    has_joints: bool,
    failures: u64,
}

#[derive(Debug)]
struct HandPort {
    port: Subscriber<HandFrame>,
    frames: Box<[HandFrame]>,
    count: usize,
    /// Index of the newest frame received so far.
    newest: Option<usize>,
    captured_ns: u64,
}

impl InputPorts {
    /// Opens the ports.
    ///
    /// # Errors
    /// [`BusError`] if a port cannot be opened.
    pub fn open(bus: &Bus) -> Result<Self, BusError> {
        let [left, right] = service::HAND_FRAME;
        Ok(Self {
            hands: [HandPort::open(bus, left)?, HandPort::open(bus, right)?],
            joints: bus.subscriber(service::JOINT_STATE)?,
            stream: bus.subscriber(service::GRASP_TARGET)?,
            targets: Box::default(),
            target_count: 0,
            newest: JointState::default(),
            has_joints: false,
            failures: 0,
        })
    }

    /// Discards the inputs of the last tick.
    pub fn begin_tick(&mut self) {
        self.hands.iter_mut().for_each(|hand| hand.count = 0);
        self.has_joints = false;
        self.target_count = 0;
    }

    /// Receives new payloads: hands before joints, in the order of sending, then targets. At most
    /// [`FRAMES_PER_TICK`] frames per hand between two calls of [`InputPorts::begin_tick`].
    pub fn poll(&mut self) {
        self.poll_frames();
        self.poll_joints();
        self.poll_targets();
    }

    /// Receives frames only.
    pub fn poll_frames(&mut self) {
        for hand in &mut self.hands {
            self.failures += u64::from(hand.receive().is_err());
        }
    }

    /// Receives targets of a teleoperation client; surplus targets wait for the next tick.
    pub fn poll_targets(&mut self) {
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

    /// Returns true if each of these streams has a waiting payload. Polls in reverse order of
    /// sending: the check ends early while the last stream has none.
    #[must_use]
    pub fn have_payloads(&self, streams: &[bool; STREAMS]) -> bool {
        let [left, right] = self.hands.each_ref().map(|hand| &hand.port);
        (!streams[2] || self.joints.has_payload())
            && (!streams[1] || right.has_payload())
            && (!streams[0] || left.has_payload())
    }

    /// Receives the newest joint state only; false if none has arrived since
    /// [`InputPorts::begin_tick`].
    pub fn poll_joints(&mut self) -> bool {
        let taken = self.joints.newest(&mut self.newest);
        self.failures += u64::from(taken.is_err());
        self.has_joints |= taken.unwrap_or(false);
        self.has_joints
    }

    /// Unvalidated stamp of the newest payload of each stream, ns; 0 if there is none. Only for the
    /// start time of a tick.
    #[must_use]
    pub fn captured_ns(&self) -> [u64; STREAMS] {
        let [left, right] = self.hands.each_ref().map(|hand| hand.captured_ns);
        [left, right, self.joints_captured_ns()]
    }

    /// Stamp of the newest joint state, ns.
    #[must_use]
    pub fn joints_captured_ns(&self) -> u64 {
        self.newest.stamp.captured_ns
    }

    /// Number of failed bus calls so far.
    #[must_use]
    pub fn failures(&self) -> u64 {
        self.failures
    }

    /// Writes the newest payloads into a view; a hand without a frame keeps its entry.
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

    /// The received inputs, for the controller.
    #[must_use]
    pub fn inputs<'a>(&'a self, tick: Tick, order: Option<&'a OperatorRequest>) -> Inputs<'a> {
        Inputs {
            tick,
            frames: self.hands.each_ref().map(|hand| &hand.frames[..hand.count]),
            joints: self.has_joints.then_some(&self.newest),
            targets: &self.targets[..self.target_count],
            request: order,
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

    fn receive(&mut self) -> Result<(), BusError> {
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
