//! Start-up and shutdown of the daemon.

use std::io;
use std::thread::{Builder, JoinHandle};

use atas_core::Controller;
use atas_process::exit::Exit;
use atas_process::fatal_signals;
use crossbeam::channel::{Sender, bounded};
use robot_model::ModelError;
use rustix::process::{Resource, Rlimit, getrlimit, setrlimit};
use shm_bus::{Bus, BusError, BusName, OwnerLock, Realtime as Deadline, stop, writer_epoch};
use shm_schemas::StatusFlags;

use crate::args::Args;
use crate::config::{self, Config, ConfigError};
use crate::link::{self, RealtimeSide, SupervisorSide};
use crate::pacer::{FreePacer, LockStep, Pacer};
use crate::panics::{self, TICK_THREAD};
use crate::realtime::{self, Granted, Refused};
use crate::stop_thread::StopThread;
use crate::supervisor::{OpenError, Signals, Supervisor, SupervisorState, TickThreadEnded};
use crate::tick::TickLoop;

const ROLE: &str = "atasd";
/// Stack of the tick thread, bytes, all of it locked. Copies of a controller are built on it, 210
/// kB each.
const TICK_STACK_BYTES: usize = 3 << 19;

/// Error that ends the daemon.
#[derive(Debug, thiserror::Error)]
pub enum Failure {
    /// Invalid configuration.
    #[error(transparent)]
    Config(#[from] ConfigError),
    /// Robot file.
    #[error("could not load the robot: {0}")]
    Robot(#[from] ModelError),
    /// Bus.
    #[error(transparent)]
    Bus(#[from] BusError),
    /// Real time is required but not available.
    #[error(transparent)]
    Realtime(#[from] Refused),
    /// Operating system.
    #[error("could not start: {0}")]
    System(#[from] io::Error),
    /// Tick thread.
    #[error(transparent)]
    Ticks(#[from] TickThreadEnded),
}

impl From<OpenError> for Failure {
    fn from(error: OpenError) -> Self {
        match error {
            OpenError::Bus(error) => error.into(),
            OpenError::Thread(error) => error.into(),
        }
    }
}

impl Failure {
    /// Returns the exit code.
    #[must_use]
    pub fn exit_code(&self) -> Exit {
        match self {
            Self::System(_) | Self::Ticks(_) => Exit::Failed,
            Self::Config(_) | Self::Robot(_) => Exit::Input,
            Self::Bus(error) if error.is_in_use() => Exit::InUse,
            Self::Bus(_) => Exit::Bus,
            Self::Realtime(_) => Exit::Realtime,
        }
    }
}

/// Runs the daemon until a signal ends it.
///
/// # Errors
/// [`Failure`].
pub fn run(args: &Args) -> Result<(), Failure> {
    let source = args.source();
    let config = source.load()?;
    let (version, bus, hash) = (env!("CARGO_PKG_VERSION"), &args.bus, config.hash());
    raise_descriptor_limit();
    tracing::info!(version, %bus, configuration = %source, hash = format_args!("{hash:016x}"), "starting");
    let owner = OwnerLock::take(&args.bus, ROLE)?;
    if let Some(end) = owner.former_end() {
        tracing::warn!("{end}");
    }
    let ended = run_as_owner(args, source, config, &owner);
    if let Err(failure) = &ended {
        owner.record_end(&format!("ended: {failure}"));
    }
    ended.inspect(|()| tracing::info!("stopped"))
}

/// Raises the limit of open files to the permitted maximum: every peer on the bus needs some, and
/// without them no request would arrive.
fn raise_descriptor_limit() {
    let limit = getrlimit(Resource::Nofile);
    let current = limit.maximum;
    // The kernel permits every limit up to the maximum.
    let _ = setrlimit(Resource::Nofile, Rlimit { current, ..limit });
}

fn run_as_owner(
    args: &Args,
    source: config::Source,
    config: Config,
    owner: &OwnerLock,
) -> Result<(), Failure> {
    fatal_signals::record_to(owner.end_record().try_clone()?.into());
    let signals = Signals::install()?;
    panics::install_hook();
    let robot = config.robot_model()?;
    let wiring = config.sensor_setup(&robot, if args.lockstep { 1 } else { writer_epoch() })?;
    let controller = Box::new(Controller::new(&robot, wiring, config.settings()));
    let mut granted = realtime::lock_memory(&config.realtime)?;
    if let Err(refused) = realtime::limit_idle_latency(&config.realtime, &mut granted) {
        tracing::info!("{refused}");
    }
    let stops = StopThread::start(stop::Listener::open(owner)?, &config.realtime)?;
    let (tick_end, supervisor_end) = link::link(config.recording.stream, stops.signal());
    let start = Start {
        bus: args.bus.clone(),
        config: config.clone(),
        lockstep: args.lockstep,
        controller,
        granted,
    };
    let (ticks, granted) = start.spawn(tick_end)?;
    let flags = flags(&granted, args.lockstep, wiring.joints_required);
    let state = SupervisorState::new(source, config, robot, wiring, flags);
    supervise(args, supervisor_end, state, signals, ticks)
}

fn supervise(
    args: &Args,
    link: SupervisorSide,
    state: SupervisorState,
    signals: Signals,
    ticks: JoinHandle<()>,
) -> Result<(), Failure> {
    let quit = link.quit_handle();
    let opened = Bus::open(&args.bus, ROLE, Deadline::No)
        .map_err(OpenError::from)
        .and_then(|bus| Supervisor::open(bus, link, state, signals));
    let supervised = opened.map(|mut supervisor| (supervisor.run(&ticks), supervisor));
    quit.quit();
    // `supervised` contains a panic of the tick thread.
    let _joined = ticks.join();
    let (ended, mut supervisor) = supervised?;
    supervisor.finish();
    Ok(ended?)
}

fn flags(granted: &Granted, lockstep: bool, joints_required: bool) -> u32 {
    for refused in &granted.refused {
        tracing::warn!("degraded: {refused}");
    }
    [
        (!granted.refused.is_empty(), StatusFlags::DEGRADED),
        (lockstep, StatusFlags::LOCKSTEP),
        (granted.fifo, StatusFlags::REALTIME),
        (granted.locked, StatusFlags::MEMORY_LOCKED),
        (granted.idle_latency.is_some(), StatusFlags::KEPT_AWAKE),
        (!joints_required, StatusFlags::SENSE_ONLY),
    ]
    .into_iter()
    .filter_map(|(is_set, flag)| is_set.then_some(flag))
    .sum()
}

fn free_pacer(realtime: &config::Realtime) -> FreePacer {
    let period_ns = 1_000_000_000 / u64::from(realtime.rate_hz);
    let pacer = FreePacer::new(period_ns, u64::from(realtime.spin_us) * 1000);
    if realtime.phase_lock {
        pacer.with_phase_lock(
            u64::from(realtime.phase_offset_us) * 1000,
            u64::from(realtime.arrival_wait_us) * 1000,
        )
    } else {
        pacer
    }
}

struct Start {
    bus: BusName,
    config: Config,
    lockstep: bool,
    controller: Box<Controller>,
    granted: Granted,
}

impl Start {
    /// Starts the tick thread and waits until its ports and scheduling are set up, or failed.
    fn spawn(self, link: RealtimeSide) -> Result<(JoinHandle<()>, Granted), Failure> {
        let (send, receive) = bounded(1);
        let ticks = Builder::new()
            .name(TICK_THREAD.to_owned())
            .stack_size(TICK_STACK_BYTES)
            .spawn(move || self.run(link, &send))?;
        match receive.recv() {
            Ok(started) => Ok((ticks, started?)),
            Err(_) => {
                let note = panics::take_message().unwrap_or_default();
                Err(io::Error::other(format!("the tick thread panicked: {note}")).into())
            }
        }
    }

    fn run(self, link: RealtimeSide, started: &Sender<Result<Granted, Failure>>) {
        // The receiver waits for exactly one message.
        match self.set_up(link) {
            Ok((mut ticks, granted, _bus)) => {
                let _sent = started.send(Ok(granted));
                ticks.run();
                realtime::leave_realtime();
            }
            Err(failure) => {
                let _sent = started.send(Err(failure));
            }
        }
    }

    fn set_up(self, link: RealtimeSide) -> Result<(TickLoop, Granted, Bus), Failure> {
        let Self {
            bus,
            config,
            lockstep,
            controller,
            mut granted,
        } = self;
        let bus = Bus::open(&bus, ROLE, Deadline::Yes)?;
        let realtime = &config.realtime;
        let pacer = if lockstep {
            Pacer::LockStep(LockStep::new())
        } else {
            Pacer::Free(free_pacer(realtime))
        };
        let ticks = TickLoop::open(&bus, controller, pacer, link, realtime.rate_hz)?;
        realtime::enter_tick_thread(realtime, &mut granted)?;
        realtime::lock_later_memory_on_use(realtime, &mut granted)?;
        Ok((ticks, granted, bus))
    }
}
