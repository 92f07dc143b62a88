//! Tick loop: wait, receive, step, publish, record ([`TickLoop::run_once`]).
//!
//! * **In:** frames, joint states, requests. **Out:** one command per tick, one record for the
//!   supervisor.
//! * **Invariants:** after the first ticks one allocation per tick (iceoryx2, for the published
//!   command), no lock, no log, no system call except the sleep (`tests/allocation.rs`). A tick
//!   publishes in every mode, also after a panic.
//!
//! The supervisor computes the statistics.

use atas_core::{Controller, OperatorRequest, Tick};
use robot_model::RobotVector;
use shm_bus::{Bus, BusError, Publisher, now_ns};
use shm_schemas::capacity::STAGES;
use shm_schemas::{JointCommand, TickReport, service};

use crate::cache_warm_up::CacheWarmUp;
use crate::link::{RealtimeSide, TickRecord, Ticketed};
use crate::pacer::{Arrivals, Pacer, StartReason, TickStart};
use crate::panic_guard::{PanicGuard, Step};
use crate::ports::{InputPorts, STREAMS};

/// Indices in [`TickReport::stage_ns`] after the controller's stages.
const PUBLISH: usize = 5;
const REPORT: usize = 6;
const RECORDING: usize = 7;
/// Minimum status rate, Hz.
const STATUS_HZ: u64 = 50;
/// View rate, Hz: a screen's refresh rate.
const VIEW_HZ: u64 = 60;

/// State of the tick thread.
#[derive(Debug)]
pub struct TickLoop {
    pacer: Pacer,
    ports: InputPorts,
    panic_guard: PanicGuard,
    cache_warm_up: CacheWarmUp,
    last_tick: Tick,
    period_ns: u64,
    commands: Publisher<JointCommand>,
    link: RealtimeSide,
    stopwatch: Stopwatch,
    counts: Counts,
}

#[derive(Debug)]
struct Counts {
    ticks: u64,
    late: u64,
    on_arrival: u64,
    timed_out: u64,
    unsent: u64,
    status_every: u64,
    view_every: u64,
}

impl TickLoop {
    /// Opens the ports of the tick thread. `rate_hz` is the tick rate.
    ///
    /// # Errors
    /// [`BusError`] if a port cannot be opened.
    pub fn open(
        bus: &Bus,
        controller: Box<Controller>,
        pacer: Pacer,
        mut link: RealtimeSide,
        rate_hz: u32,
    ) -> Result<Self, BusError> {
        let commands = bus.publisher(service::JOINT_COMMAND)?;
        let status_every = (u64::from(rate_hz) / STATUS_HZ).max(1);
        let dry_tick = CacheWarmUp::new(&controller);
        let panic_guard = PanicGuard::new(controller);
        link.push_snapshot(&panic_guard.status(now_ns()));
        Ok(Self {
            pacer,
            ports: InputPorts::open(bus)?,
            panic_guard,
            cache_warm_up: dry_tick,
            last_tick: Tick::default(),
            period_ns: 1_000_000_000 / u64::from(rate_hz.max(1)),
            commands,
            link,
            stopwatch: Stopwatch::default(),
            counts: Counts {
                ticks: 0,
                late: 0,
                on_arrival: 0,
                timed_out: 0,
                unsent: 0,
                status_every,
                view_every: (u64::from(rate_hz) / VIEW_HZ).max(1),
            },
        })
    }

    /// Ticks until [`crate::link::Quit::quit`].
    pub fn run(&mut self) {
        while self.run_once() {}
    }

    /// Runs one tick; returns false when the loop must end.
    pub fn run_once(&mut self) -> bool {
        let Self {
            pacer,
            ports,
            panic_guard,
            cache_warm_up,
            last_tick,
            period_ns,
            commands,
            link,
            stopwatch,
            counts,
        } = self;
        let warm = |ports: &InputPorts| {
            if let Some(controller) = panic_guard.controller() {
                cache_warm_up.run(controller, &ports.inputs(*last_tick, None), *period_ns);
            }
        };
        let Some(start) = pacer.wait(ports, link, panic_guard.has_active_goal(), warm) else {
            return false;
        };
        stopwatch.start();
        let tick = pacer.receive(ports, &start);
        *last_tick = tick;
        let order = request_for(link, &start, pacer.is_free());
        let inputs = ports.inputs(tick, order.as_ref().map(|o| &o.request));
        let step = panic_guard.step(&inputs, |stage| stopwatch.lap(stage as usize));
        stopwatch.lap(REPORT);
        let sent = commands.send(step.command);
        stopwatch.lap(PUBLISH);
        counts.count(&start, sent.is_ok());
        let body_ns = stopwatch.total_ns();
        if let Some(input_log) = link.input_log() {
            input_log.record(&inputs, step.command);
            stopwatch.lap(RECORDING);
        }
        // The age of a frame at the tick's time contains the intake.
        let intake_ns = tick.now_ns.saturating_sub(start.tick.now_ns);
        let mut record = record_of(
            &step,
            &start,
            stopwatch.stage_ns,
            [body_ns, saturated_u32(intake_ns)],
        );
        record.bus_failures = counts.unsent + ports.failures();
        record.phase_locked = pacer.adapt(&start, arrivals(&record.report, ports));
        let is_news = step.goal_update.is_some() || !step.events.is_empty();
        let ticket = order.map_or(0, |order| order.ticket);
        let goal_update = step.goal_update.copied();
        link.push_record(&record, step.events);
        if is_news
            || ticket != 0
            || link.takes_stop()
            || counts.ticks.is_multiple_of(counts.status_every)
        {
            link.push_snapshot(&counts.complete(panic_guard.status(tick.now_ns), &start));
        }
        // After the snapshot: a client that reacts to the stop or notification must not read an
        // older status.
        link.confirm_stop(sent.is_ok());
        link.push_notifications(ticket, goal_update.as_ref());
        if counts.ticks.is_multiple_of(counts.view_every) {
            link.push_view(|view| ports.write_view(tick, view));
        }
        if let (Pacer::LockStep(pacer), Some(OperatorRequest::Recover)) =
            (pacer, order.map(|o| o.request))
        {
            pacer.restart_settling();
        }
        true
    }
}

/// Request of the supervisor or stop socket; on the clock, a silent supervisor causes a hold.
fn request_for(link: &mut RealtimeSide, start: &TickStart, is_free: bool) -> Option<Ticketed> {
    let order = link.take_request(start.settling);
    if order.is_some() || !is_free {
        return order;
    }
    let reason = link.supervisor_timeout(start.tick.now_ns);
    reason.is_some().then_some(Ticketed {
        ticket: 0,
        request: OperatorRequest::Hold(reason),
    })
}

impl Counts {
    fn count(&mut self, start: &TickStart, sent: bool) {
        self.ticks += 1;
        self.late += u64::from(start.is_late);
        self.on_arrival += u64::from(start.reason == StartReason::OnArrival);
        self.timed_out += u64::from(start.reason == StartReason::TimedOut);
        self.unsent += u64::from(!sent);
    }

    fn complete(&self, mut status: shm_schemas::Status, start: &TickStart) -> shm_schemas::Status {
        status.ticks = self.ticks;
        status.late_ticks = self.late;
        status.ticks_on_arrival = self.on_arrival;
        status.ticks_without_frame = self.timed_out;
        status.missed_ticks = start.missed;
        status
    }
}

fn record_of(
    step: &Step<'_>,
    start: &TickStart,
    stage_ns: [u32; STAGES],
    [body_ns, intake_ns]: [u32; 2],
) -> TickRecord {
    let ages = step.report.hands.iter().map(|hand| hand.frame_age_ns);
    let frame_age_ns = ages.min().unwrap_or(u64::MAX);
    let report = TickReport {
        missed_ticks: start.missed,
        wake_late_ns: saturated_u32(start.late_ns),
        stage_ns,
        sensor_to_command_ns: saturated_u32(
            frame_age_ns.saturating_add(body_ns.saturating_sub(intake_ns).into()),
        ),
        ..*step.report
    };
    TickRecord {
        report,
        body_ns,
        frame_age_ns,
        at_rest: step.command.velocity.iter().all(|v| *v == 0.0),
        commanded_position: commanded_position(step.command),
        bus_failures: 0,
        phase_locked: false,
    }
}

/// Stamps and counts for the phase lock: accepted frames of the hands, unvalidated joint state.
fn arrivals(report: &TickReport, ports: &InputPorts) -> [Option<Arrivals>; STREAMS] {
    let [left, right] = report.hands.map(|hand| {
        let captured_ns = report.stamp.captured_ns.checked_sub(hand.frame_age_ns)?;
        Some(Arrivals {
            captured_ns,
            count: hand.frames,
        })
    });
    let captured_ns = ports.joints_captured_ns();
    let joints = Arrivals {
        captured_ns,
        count: 1,
    };
    [left, right, (captured_ns != 0).then_some(joints)]
}

fn commanded_position(command: &JointCommand) -> Option<RobotVector> {
    let positions = command.position.get(..command.joint_count as usize)?;
    (!positions.is_empty()).then(|| RobotVector::from_slice(positions))
}

#[derive(Debug, Default)]
struct Stopwatch {
    started_ns: u64,
    last_ns: u64,
    stage_ns: [u32; STAGES],
}

impl Stopwatch {
    fn start(&mut self) {
        self.started_ns = now_ns();
        self.last_ns = self.started_ns;
        self.stage_ns = [0; STAGES];
    }

    fn lap(&mut self, stage: usize) {
        let now = now_ns();
        self.stage_ns[stage] = saturated_u32(now - self.last_ns);
        self.last_ns = now;
    }

    fn total_ns(&self) -> u32 {
        saturated_u32(self.last_ns - self.started_ns)
    }
}

fn saturated_u32(ns: u64) -> u32 {
    u32::try_from(ns).unwrap_or(u32::MAX)
}
