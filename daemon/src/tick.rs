//! Tick loop: wait, receive, step, publish, record ([`TickLoop::run_once`]).
//!
//! * **In:** frames, joint states, requests. **Out:** one command per tick, one record for the
//!   supervisor.
//! * **Invariants:** after the first ticks one allocation per tick (iceoryx2, for the published
//!   command), no lock, no log, no system call except the sleep (`tests/allocation.rs`). A tick
//!   publishes in every mode, also after a panic.
//!
//! The supervisor computes the statistics.

use atas_core::{Controller, Order, Tick};
use robot_model::RobotVector;
use shm_bus::{Bus, BusError, Publisher, now_ns};
use shm_schemas::capacity::STAGES;
use shm_schemas::{JointCommand, TickReport, service};

use crate::guard::{Guard, Step};
use crate::link::{TickEnd, TickRecord, Ticketed};
use crate::pacer::{Arrivals, Began, Pacer, TickStart};
use crate::ports::{InputPorts, STREAMS};
use crate::warm::DryTick;

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
    guard: Guard,
    dry_tick: DryTick,
    last_tick: Tick,
    period_ns: u64,
    commands: Publisher<JointCommand>,
    link: TickEnd,
    watch: Stopwatch,
    counts: Counts,
}

#[derive(Debug)]
struct Counts {
    ticks: u64,
    late: u64,
    on_arrival: u64,
    in_vain: u64,
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
        mut link: TickEnd,
        rate_hz: u32,
    ) -> Result<Self, BusError> {
        let commands = bus.publisher(service::JOINT_COMMAND)?;
        let status_every = (u64::from(rate_hz) / STATUS_HZ).max(1);
        let dry_tick = DryTick::new(&controller);
        let guard = Guard::new(controller);
        link.leave_snapshot(&guard.status(now_ns()));
        Ok(Self {
            pacer,
            ports: InputPorts::open(bus)?,
            guard,
            dry_tick,
            last_tick: Tick::default(),
            period_ns: 1_000_000_000 / u64::from(rate_hz.max(1)),
            commands,
            link,
            watch: Stopwatch::default(),
            counts: Counts {
                ticks: 0,
                late: 0,
                on_arrival: 0,
                in_vain: 0,
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
            guard,
            dry_tick,
            last_tick,
            period_ns,
            commands,
            link,
            watch,
            counts,
        } = self;
        let warm = |ports: &InputPorts| {
            if let Some(controller) = guard.controller() {
                dry_tick.run(controller, &ports.inputs(*last_tick, None), *period_ns);
            }
        };
        let Some(start) = pacer.wait(ports, link, guard.pursues_goal(), warm) else {
            return false;
        };
        watch.start();
        pacer.take_in(ports);
        *last_tick = start.tick;
        let order = order_for(link, &start, pacer.is_free());
        let inputs = ports.inputs(start.tick, order.as_ref().map(|o| &o.order));
        let step = guard.step(&inputs, |stage| watch.passed(stage as usize));
        watch.passed(REPORT);
        let sent = commands.send(step.command);
        link.published();
        watch.passed(PUBLISH);
        counts.count(&start, sent.is_ok());
        let body_ns = watch.total_ns();
        if let Some(input_log) = link.input_log() {
            input_log.keep(&inputs, step.command);
            watch.passed(RECORDING);
        }
        let mut record = record_of(&step, &start, watch.stage_ns, body_ns);
        record.bus_failures = counts.unsent + ports.failures();
        record.phase_locked = pacer.learn(&start, arrivals(&record.report, ports));
        let is_news = step.goal_update.is_some() || !step.events.is_empty();
        let ticket = order.map_or(0, |order| order.ticket);
        let goal_update = step.goal_update.copied();
        link.leave(&record, step.events);
        if is_news || ticket != 0 || counts.ticks.is_multiple_of(counts.status_every) {
            link.leave_snapshot(&counts.complete(guard.status(start.tick.now_ns), &start));
        }
        // After the snapshot: a client that reacts to the notification must not read an older
        // status.
        link.leave_news(ticket, goal_update.as_ref());
        if counts.ticks.is_multiple_of(counts.view_every) {
            link.leave_view(|view| ports.write_view(start.tick, view));
        }
        if let (Pacer::LockStep(pacer), Some(Order::Recover)) = (pacer, order.map(|o| o.order)) {
            pacer.settle();
        }
        true
    }
}

/// Request of the supervisor or stop socket; on the clock, a silent supervisor causes a hold.
fn order_for(link: &mut TickEnd, start: &TickStart, is_free: bool) -> Option<Ticketed> {
    let order = link.take_order(start.settling);
    if order.is_some() || !is_free {
        return order;
    }
    let reason = link.supervision(start.tick.now_ns);
    reason.is_some().then_some(Ticketed {
        ticket: 0,
        order: Order::Hold(reason),
    })
}

impl Counts {
    fn count(&mut self, start: &TickStart, sent: bool) {
        self.ticks += 1;
        self.late += u64::from(start.is_late);
        self.on_arrival += u64::from(start.began == Began::OnArrival);
        self.in_vain += u64::from(start.began == Began::InVain);
        self.unsent += u64::from(!sent);
    }

    fn complete(&self, mut status: shm_schemas::Status, start: &TickStart) -> shm_schemas::Status {
        status.ticks = self.ticks;
        status.late_ticks = self.late;
        status.ticks_on_arrival = self.on_arrival;
        status.ticks_in_vain = self.in_vain;
        status.missed_ticks = start.missed;
        status
    }
}

fn record_of(
    step: &Step<'_>,
    start: &TickStart,
    stage_ns: [u32; STAGES],
    body_ns: u32,
) -> TickRecord {
    let ages = step.report.hands.iter().map(|hand| hand.frame_age_ns);
    let frame_age_ns = ages.min().unwrap_or(u64::MAX);
    let report = TickReport {
        missed_ticks: start.missed,
        wake_late_ns: clipped(start.late_ns),
        stage_ns,
        sensor_to_command_ns: clipped(frame_age_ns.saturating_add(u64::from(body_ns))),
        ..*step.report
    };
    TickRecord {
        report,
        body_ns,
        frame_age_ns,
        at_rest: step.command.velocity_rad_s.iter().all(|v| *v == 0.0),
        commanded_rad: commanded_rad(step.command),
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

fn commanded_rad(command: &JointCommand) -> Option<RobotVector> {
    let positions_rad = command.position_rad.get(..command.joint_count as usize)?;
    (!positions_rad.is_empty()).then(|| RobotVector::from_slice(positions_rad))
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

    fn passed(&mut self, stage: usize) {
        let now = now_ns();
        self.stage_ns[stage] = clipped(now - self.last_ns);
        self.last_ns = now;
    }

    fn total_ns(&self) -> u32 {
        clipped(self.last_ns - self.started_ns)
    }
}

fn clipped(ns: u64) -> u32 {
    u32::try_from(ns).unwrap_or(u32::MAX)
}
