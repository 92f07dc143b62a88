//! Simulation on the bus: world, faults and ports.

use std::time::Duration;

use robot_model::HandSide;
use shm_bus::{Bus, BusError, Publisher, Subscriber};
use shm_schemas::{HandFrame, JointCommand, JointState, WorldTruth, service};
use sim_backend::faults::{Delivery, Fault, FaultPipeline};
use sim_backend::{Sensed, World};

use crate::failure::Failure;

pub(crate) struct Session {
    pub(crate) world: World,
    injector: FaultPipeline,
    sensed: Sensed,
    frames: [Publisher<HandFrame>; 2],
    joints: Publisher<JointState>,
    truth: Publisher<WorldTruth>,
    commands: Subscriber<JointCommand>,
    command: JointCommand,
    truth_sequence: u64,
    first_ns: u64,
    missed_ticks: u64,
}

impl Session {
    pub(crate) fn open(
        bus: &Bus,
        world: World,
        faults: &[Fault],
        seed: u64,
    ) -> Result<Self, Failure> {
        let [left, right] = service::HAND_FRAME;
        Ok(Self {
            first_ns: world.now_ns(),
            world,
            injector: FaultPipeline::new(faults, seed),
            sensed: Sensed::default(),
            frames: [bus.publisher(left)?, bus.publisher(right)?],
            joints: bus.publisher(service::JOINT_STATE)?,
            truth: bus.publisher(service::WORLD_TRUTH)?,
            commands: bus.subscriber(service::JOINT_COMMAND)?,
            command: JointCommand::default(),
            truth_sequence: 0,
            missed_ticks: 0,
        })
    }

    /// Synchronises the world's clock to the machine's and takes a new epoch, for real time.
    pub(crate) fn use_real_time(&mut self, now_ns: u64) {
        self.world.set_writer_epoch(shm_bus::writer_epoch());
        self.world.skip_to(now_ns);
        self.first_ns = self.world.now_ns();
    }

    /// Publishes tactile frames, then joints. Returns the sequence number of the last joint state
    /// delivered in this tick.
    pub(crate) fn publish(&mut self) -> Result<Option<u64>, Failure> {
        let (frames, joints) = (&self.frames, &self.joints);
        let (mut failure, mut seen) = (None, None);
        self.world.sense(&mut self.sensed);
        self.injector
            .pass(self.world.tick(), &self.sensed, |delivery| {
                let sent = match delivery {
                    Delivery::Frame(side, frame) => frames[side.index()].send(frame),
                    Delivery::Joints(state) => {
                        seen = Some(state.stamp.sequence);
                        joints.send(state)
                    }
                };
                failure = failure.take().or(sent.err());
            });
        failure.map_or(Ok(seen), |failure: BusError| Err(failure.into()))
    }

    pub(crate) fn publish_truth(&mut self) -> Result<(), Failure> {
        let mut truth = self.world.truth();
        truth.stamp.sequence = self.truth_sequence;
        truth.missed_ticks = self.missed_ticks;
        self.truth_sequence += 1;
        Ok(self.truth.send(&truth)?)
    }

    /// Sends the last frames, joint state and truth to late readers.
    pub(crate) fn connect_readers(&self) -> Result<(), Failure> {
        for side in HandSide::BOTH {
            self.frames[side.index()].connect_readers()?;
        }
        self.joints.connect_readers()?;
        Ok(self.truth.connect_readers()?)
    }

    /// Returns the newest command since the last call.
    pub(crate) fn newest_command(&mut self) -> Result<Option<JointCommand>, Failure> {
        Ok(self
            .commands
            .newest(&mut self.command)?
            .then_some(self.command))
    }

    pub(crate) fn advance(&mut self, command: Option<&JointCommand>) -> Result<(), Failure> {
        self.world.advance(command);
        self.world.fault().map_or(Ok(()), |fault| Err(fault.into()))
    }

    /// Counts ticks missed while the process did not run.
    pub(crate) fn count_missed(&mut self, ticks: u64) {
        self.missed_ticks += ticks;
    }

    pub(crate) fn is_over(&self, duration: Option<Duration>) -> bool {
        let elapsed_ns = u128::from(self.world.now_ns() - self.first_ns);
        duration.is_some_and(|duration| elapsed_ns >= duration.as_nanos())
    }

    pub(crate) fn report(&self) {
        let truth = self.world.truth();
        tracing::info!(
            ticks = self.world.tick(),
            missed_ticks = self.missed_ticks,
            refused_or_expired_commands = truth.expired_commands,
            "simulation ended"
        );
    }
}
