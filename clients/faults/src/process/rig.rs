//! Daemon process with a simulated robot. The runner is simulator, client and judge at once, so it
//! receives every command and knows the truth of every tick.

use std::time::{Duration, Instant};

use atas_judge::{Allowance, Judge, Promise};
use atas_processes::{Child, Logs};
use robot_model::HandSide;
use shm_bus::{
    Bus, ControlClient, FreshBus, GoalClient, PendingGoal, Realtime, now_ns, writer_epoch,
};
use shm_schemas::{GoalState, GoalUpdate, HandFrame, JointCommand, Mode, ObjectTruth};
use sim_backend::{TICK_NS, World};

use super::pace::{Pace, RobotPriority, TIMEOUT, sleep_until};
use super::ports::Ports;
use super::start::{Environment, Setup, start_daemon};
use crate::catalogue::Reaction;
use crate::course::{Course, Phase, SETTLE_TICKS};
use crate::verdict::WATCH_TICKS;

/// Ticks for which the daemon must be ready before the goal. Design choice: 200 ms; while a process
/// starts, the clock advances unevenly.
const STEADY_TICKS: u64 = 200;
/// Polls without a pause while waiting for a command: about the time of a tick. Design choice.
const YIELD_POLLS: u32 = 2_000;
pub(super) const PAUSE: Duration = Duration::from_micros(200);
/// Commands that their stream keeps for a reader.
const OVERFLOW_TICKS: u64 = 4;

/// Daemon process, and everything that the runner shares with it. Fields are dropped in this order.
pub(crate) struct Rig<'a> {
    pub(crate) course: &'a Course<'a>,
    pub(crate) judge: Judge,
    pub(crate) reaction: Reaction,
    pub(crate) setup: Setup,
    pub(crate) environment: &'a Environment,
    world: World,
    pub(crate) ports: Ports,
    pub(super) goals: Option<GoalClient>,
    pub(super) pending: Option<PendingGoal>,
    pub(super) control: Option<ControlClient>,
    pub(super) step: String,
    pub(crate) end: Option<GoalUpdate>,
    deadline_ns: u64,
    /// Time of the last poll of the commands.
    polled_ns: u64,
    /// Lock-step: slowed down to 1 kHz, for effects that take time by the clock.
    pub(crate) is_slow: bool,
    _priority: Option<RobotPriority>,
    pub(crate) observer: Bus,
    pub(crate) daemon: Child,
    pub(crate) bus: FreshBus,
    pub(crate) logs: Logs,
}

impl<'a> Rig<'a> {
    /// Starts a daemon and runs until it is ready.
    pub(crate) fn start(
        course: &'a Course<'a>,
        environment: &'a Environment,
        setup: Setup,
        reaction: Reaction,
    ) -> anyhow::Result<Self> {
        let bus = FreshBus::new("fault");
        let logs = Logs::new(&bus)?;
        let observer = Bus::open(&bus, "fault-runner", Realtime::No)?;
        let mut world = World::new(course.robot, &course.scene, course.seed)?;
        let mut judge = course.judge()?;
        if setup.pace == Pace::Clock {
            judge = judge
                .allowing(Allowance::MissedTicks)
                .allowing(Allowance::UnevenTicks);
            world.set_writer_epoch(writer_epoch());
            world.skip_to(now_ns());
        }
        let ports = Ports::open(&observer)?;
        let priority = (setup.pace == Pace::Clock).then(RobotPriority::enter);
        let daemon = start_daemon(&setup, environment, &bus, &logs.folder)?;
        let mut rig = Self {
            course,
            judge,
            reaction,
            setup,
            environment,
            deadline_ns: world.now_ns() + TICK_NS,
            world,
            ports,
            goals: None,
            pending: None,
            control: None,
            step: String::new(),
            end: None,
            polled_ns: now_ns(),
            is_slow: false,
            _priority: priority,
            observer,
            daemon,
            bus,
            logs,
        };
        rig.make_ready()?;
        Ok(rig)
    }

    fn make_ready(&mut self) -> anyhow::Result<()> {
        match self.setup.pace {
            Pace::LockStep => self.advance(SETTLE_TICKS),
            Pace::Clock => {
                let (begin, mut steady) = (Instant::now(), 0);
                while steady < STEADY_TICKS {
                    self.advance(1)?;
                    let is_ready = self.status()?.mode == Mode::READY;
                    steady = if is_ready { steady + 1 } else { 0 };
                    if begin.elapsed() > TIMEOUT {
                        let (mode, reason) = (self.ports.status.mode, self.ports.status.reason);
                        anyhow::bail!("the daemon was not ready in {TIMEOUT:?}: {mode}, {reason}");
                    }
                }
                Ok(())
            }
        }
    }

    /// Advances to a tick of a phase. In lock-step `phase` is exact; by the clock, the phase begins
    /// when the daemon reports it.
    pub(crate) fn advance_into(&mut self, phase: &Phase) -> anyhow::Result<()> {
        let tick = self.course.tick_in(phase);
        if self.setup.pace == Pace::LockStep {
            let now = self.world.tick();
            return self.advance(tick.saturating_sub(now));
        }
        while self.step != phase.name {
            self.advance(1)?;
            if let Some(end) = &self.end {
                anyhow::bail!("{} ended before {}: {}", end.state, phase.name, end.reason);
            }
        }
        self.advance(tick - phase.first_tick)
    }

    /// Runs ticks with the daemon.
    pub(crate) fn advance(&mut self, ticks: u64) -> anyhow::Result<()> {
        for _ in 0..ticks {
            match self.setup.pace {
                Pace::LockStep => self.step_virtual()?,
                Pace::Clock => self.step_clock()?,
            }
            self.poll_goal();
        }
        Ok(())
    }

    /// Advances the robot while the daemon does not run.
    pub(crate) fn advance_alone(&mut self, ticks: u64) -> anyhow::Result<()> {
        if self.setup.pace == Pace::Clock {
            return self.advance(ticks);
        }
        for _ in 0..ticks {
            self.ports.sense(&mut self.world);
            self.world.advance(None);
        }
        Ok(())
    }

    fn step_virtual(&mut self) -> anyhow::Result<()> {
        let begin = Instant::now();
        let sequence = self.ports.publish(&mut self.world)?;
        let mut polls = 0;
        while !self.ports.has_answer(sequence)? {
            polls += 1;
            if polls < YIELD_POLLS {
                std::thread::yield_now();
                continue;
            }
            self.daemon.check()?;
            self.poll_goal();
            if let Some(end) = self.end.filter(|end| end.state.is_final()) {
                anyhow::ensure!(
                    end.state != GoalState::REJECTED,
                    "{} is rejected: {}",
                    self.course.task.name(),
                    end.reason
                );
            }
            anyhow::ensure!(
                begin.elapsed() < TIMEOUT,
                "the daemon sends no command for {TIMEOUT:?}"
            );
            self.ports.connect_readers()?;
            std::thread::sleep(PAUSE);
        }
        self.world.advance(Some(&self.ports.command));
        let truth = self.world.truth();
        self.judge.observe(&self.ports.command, &truth);
        if self.is_slow {
            std::thread::sleep(Duration::from_millis(1).saturating_sub(begin.elapsed()));
        }
        Ok(())
    }

    fn step_clock(&mut self) -> anyhow::Result<()> {
        sleep_until(self.deadline_ns);
        let missed = now_ns().saturating_sub(self.deadline_ns) / TICK_NS;
        self.deadline_ns += missed * TICK_NS;
        self.world.skip_to(self.deadline_ns - TICK_NS);
        let newest = self.receive()?;
        self.world.advance(newest.as_ref());
        self.ports.publish(&mut self.world)?;
        self.deadline_ns += TICK_NS;
        Ok(())
    }

    /// Begins the required reaction with the next command.
    pub(crate) fn promise(&mut self) {
        if let Some((modes, within)) = self.reaction.required() {
            self.judge.promise(Promise::reach(modes, within));
        }
        if !self.reaction.forbidden().is_empty() {
            let avoid = Promise::avoid(self.reaction.forbidden(), WATCH_TICKS);
            self.judge.promise(avoid);
        }
    }

    /// Judges the commands that have arrived so far, by the clock; returns the newest one.
    pub(crate) fn receive(&mut self) -> anyhow::Result<Option<JointCommand>> {
        let (now, commands) = (now_ns(), self.ports.receive()?);
        let polled_ns = std::mem::replace(&mut self.polled_ns, now);
        // A full stream has lost its oldest commands if this process did not run for longer.
        let is_full = commands.len() >= OVERFLOW_TICKS as usize;
        if is_full && now.saturating_sub(polled_ns) > (OVERFLOW_TICKS - 1) * TICK_NS {
            self.judge.observer_paused();
        }
        let truth = self.world.truth();
        for command in &commands {
            self.judge.observe(command, &truth);
        }
        Ok(commands.last().copied())
    }

    /// Returns the object in front of the acting hand.
    pub(crate) fn object(&self) -> ObjectTruth {
        self.world.truth().objects[0]
    }

    /// Returns the sum of the true normal forces of the acting hand, N.
    pub(crate) fn grip_force_n(&self) -> f64 {
        let side = self.course.robot.acting_side();
        self.world.truth().normal_n[side.index()].iter().sum()
    }

    /// Returns the frame that the acting hand has published last.
    pub(crate) fn last_frame(&self) -> Option<&HandFrame> {
        let side: HandSide = self.course.robot.acting_side();
        self.ports.sensed.frames[side.index()].as_ref()
    }

    /// Starts another daemon on the same bus, after the end of the first one.
    pub(crate) fn replace_daemon(&mut self) -> anyhow::Result<()> {
        self.pending = None;
        self.goals = None;
        self.control = None;
        self.judge.restarted();
        self.start_next()
    }

    /// Starts a daemon after the end of the former one.
    pub(crate) fn start_next(&mut self) -> anyhow::Result<()> {
        self.daemon = start_daemon(&self.setup, self.environment, &self.bus, &self.logs.folder)?;
        // The time of the start passes before the first command.
        self.deadline_ns = self.deadline_ns.max(now_ns());
        Ok(())
    }

    /// Returns true if the daemon has ended; then judges its last commands.
    pub(crate) fn has_ended(&mut self) -> anyhow::Result<Option<std::process::ExitStatus>> {
        let status = self.daemon.exit_status()?;
        if status.is_some() {
            self.receive()?;
        }
        Ok(status)
    }
}
