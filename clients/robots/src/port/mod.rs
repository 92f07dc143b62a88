//! One serial port: takes over its servos, then cyclically reads and writes all servos and monitors
//! one, on a separate thread.
//!
//! * **Input:** set-points from the robot ([`Shared`]). **Output:** [`Report`]s: servos hold,
//!   measurements, failures.
//! * **A cycle** is one bulk read, one bulk write and a health check of one servo in turn. It
//!   starts when it is due and the previous one has ended, so the servo bus limits the rate.
//! * **A failure** ends the cycles: three missing replies in a row, torque off, overheating, a
//!   servo error, or loss of the port. No more goals are written, so working servos keep holding.
//!   The port then retries the take-over until it succeeds.
//! * **No jumps:** a servo gets torque only with its current position as goal. Set-points of an
//!   earlier session of the port are discarded.

pub mod figures;
mod take_over;

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::Sender;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use shm_bus::now_ns;
use shm_schemas::capacity::JOINTS;

use crate::drivers::Reading;
use crate::drivers::wire::{Wire, WireError};
use crate::map::{JointReading, MappedServo, PortMap};
use figures::Figures;

/// Tolerated consecutive failed exchanges. Design choice: noise; the daemon's own age limit applies
/// before one more.
const MISSES_MAX: u32 = 2;
/// Interval between take-over attempts after a failure. Design choice.
const RETRY_EVERY: Duration = Duration::from_millis(200);
/// Immediate take-over attempts before a failure is reported. Design choice: noise may disturb an
/// exchange with any servo.
const ATTEMPTS: u32 = 3;
/// Interval between checks for a stop request.
const POLL: Duration = Duration::from_millis(20);
/// Multiple of the shaft's speed limit above which a reading with a valid checksum is rejected as
/// damaged. Design choice.
const JUMP_FACTOR: f64 = 4.0;
/// Jump that is always accepted, rad: a few encoder steps. Design choice.
const JUMP_FLOOR_RAD: f64 = 0.02;

/// Report of a port to the robot.
#[derive(Clone, Debug, PartialEq)]
pub enum Report {
    /// All servos hold; a new session starts.
    Holding {
        /// Number of the session.
        session: u32,
        /// Joint index and held position, rad or m.
        held: Vec<(usize, f64)>,
    },
    /// All servos were read.
    Read {
        /// Time of the request.
        captured_ns: u64,
        /// Joint index and measurement.
        joints: Vec<(usize, JointReading)>,
    },
    /// Failure text. Working servos keep holding.
    Failure(String),
}

/// Data that the robot and a port thread share.
#[derive(Debug)]
pub struct Shared {
    goals: Mutex<Goals>,
    /// Stop request to the thread.
    pub stop: Arc<AtomicBool>,
    /// Counts and times of the port so far.
    pub figures: Mutex<Figures>,
}

/// Set-points for one session of a port.
#[derive(Clone, Copy, Debug, Default)]
struct Goals {
    session: u32,
    position: Option<[f64; JOINTS]>,
}

impl Shared {
    /// Creates shared data without set-points.
    #[must_use]
    pub fn new(stop: Arc<AtomicBool>) -> Self {
        Self {
            goals: Mutex::default(),
            stop,
            figures: Mutex::default(),
        }
    }

    /// Sets the positions, rad or m, for one session of the port.
    pub fn set_goals(&self, session: u32, position: &[f64; JOINTS]) {
        *lock(&self.goals) = Goals {
            session,
            position: Some(*position),
        };
    }

    fn goals(&self, session: u32) -> Option<[f64; JOINTS]> {
        let goals = *lock(&self.goals);
        goals.position.filter(|_| goals.session == session)
    }

    fn is_stopped(&self) -> bool {
        self.stop.load(Ordering::Relaxed)
    }
}

/// Ignores poisoning: a panic leaves the data consistent.
fn lock<T>(mutex: &Mutex<T>) -> std::sync::MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Runs one port until a stop request or until the receiver of its reports is dropped. Reports
/// carry `index`.
pub fn run(map: &PortMap, index: usize, to: &Sender<(usize, Report)>, shared: &Shared) {
    let mut port = Port {
        map,
        servos: map.servos.iter().map(|mapped| mapped.servo).collect(),
        shared,
        session: 0,
        readings: Vec::new(),
        previous: Vec::new(),
        read_ns: 0,
        monitored: 0,
    };
    let tell = |report| to.send((index, report)).is_ok();
    while !shared.is_stopped() {
        let trouble = match take_over_with_retries(map) {
            Ok((mut wire, held)) => {
                port.session += 1;
                let life = port.session;
                if !tell(Report::Holding {
                    session: life,
                    held,
                }) {
                    return;
                }
                port.cycles(&mut wire, &tell)
            }
            Err(trouble) => trouble,
        };
        if shared.is_stopped() || !tell(Report::Failure(trouble)) {
            return;
        }
        lock(&shared.figures).failures += 1;
        wait(shared, RETRY_EVERY);
    }
}

fn take_over_with_retries(map: &PortMap) -> Result<take_over::Taken, String> {
    let mut taken = take_over::take_over(map);
    for _ in 1..ATTEMPTS {
        if taken.is_err() {
            taken = take_over::take_over(map);
        }
    }
    taken
}

fn wait(shared: &Shared, time: Duration) {
    let until_ns = now_ns() + time.as_nanos() as u64;
    while now_ns() < until_ns && !shared.is_stopped() {
        std::thread::sleep(POLL);
    }
}

struct Port<'a> {
    map: &'a PortMap,
    servos: Vec<crate::drivers::Servo>,
    shared: &'a Shared,
    session: u32,
    readings: Vec<Reading>,
    /// Readings of the previous cycle.
    previous: Vec<Reading>,
    read_ns: u64,
    /// Index of the servo whose health was read last.
    monitored: usize,
}

impl Port<'_> {
    /// Runs cycles until a failure, which it returns as text, or a stop request (empty text).
    fn cycles(&mut self, wire: &mut Wire, tell: &impl Fn(Report) -> bool) -> String {
        let (mut misses, mut due_ns) = (0, now_ns());
        self.previous.clear();
        while !self.shared.is_stopped() {
            let begun_ns = now_ns();
            if begun_ns < due_ns {
                std::thread::sleep(Duration::from_nanos(due_ns - begun_ns));
                continue;
            }
            due_ns = begun_ns + self.map.period.as_nanos() as u64;
            match self.cycle(wire, begun_ns, tell) {
                Ok(None) => misses = 0,
                Ok(Some(trouble)) => return trouble,
                Err(WireError::Port(why)) => return format!("{}: {why}", self.map.device),
                Err(error) => {
                    lock(&self.shared.figures).count(&error);
                    misses += 1;
                    if misses > MISSES_MAX {
                        return self.explained(&error);
                    }
                }
            }
        }
        String::new()
    }

    /// Runs one cycle; returns a failure of a servo.
    fn cycle(
        &mut self,
        wire: &mut Wire,
        begun_ns: u64,
        tell: &impl Fn(Report) -> bool,
    ) -> Result<Option<String>, WireError> {
        let driver = self.map.driver;
        driver.read(wire, &self.servos, &mut self.readings)?;
        self.check_jumps(begun_ns)?;
        let read_ns = now_ns();
        let joints = self.map.servos.iter().zip(&self.readings);
        let joints = joints.map(|(mapped, reading)| (mapped.joint, mapped.joint_reading(reading)));
        let report = Report::Read {
            captured_ns: begun_ns,
            joints: joints.collect(),
        };
        if !tell(report) {
            self.shared.stop.store(true, Ordering::Relaxed);
        }
        if let Some(goals_rad) = self.shared.goals(self.session) {
            let shaft = |mapped: &MappedServo| mapped.shaft_rad(goals_rad[mapped.joint]);
            let goals_rad: Vec<f64> = self.map.servos.iter().map(shaft).collect();
            driver.write_goals(wire, &self.servos, &goals_rad)?;
        }
        let trouble = self.monitor(wire)?;
        lock(&self.shared.figures).time(begun_ns, read_ns, now_ns());
        Ok(trouble)
    }

    /// Rejects a reading faster than the shaft can move: the checksum of protocol 1.0 misses one in
    /// 256 errors.
    fn check_jumps(&mut self, now_ns: u64) -> Result<(), WireError> {
        let elapsed_s = now_ns.saturating_sub(self.read_ns) as f64 * 1e-9;
        let pairs = self.previous.iter().zip(&self.readings).zip(&self.servos);
        for ((before, reading), servo) in pairs {
            let allowed_rad = JUMP_FLOOR_RAD + JUMP_FACTOR * servo.speed_max_rad_s * elapsed_s;
            if (reading.position - before.position).abs() > allowed_rad {
                return Err(WireError::Damaged(servo.id));
            }
        }
        self.previous.clone_from(&self.readings);
        self.read_ns = now_ns;
        Ok(())
    }

    /// Checks the health of one servo: the first with an alert, otherwise the next in turn.
    fn monitor(&mut self, wire: &mut Wire) -> Result<Option<String>, WireError> {
        let alerted = self.readings.iter().position(|reading| reading.alert);
        self.monitored = (self.monitored + 1) % self.servos.len();
        let mapped = &self.map.servos[alerted.unwrap_or(self.monitored)];
        let health = self.map.driver.health(wire, mapped.servo.id)?;
        let called = mapped.label();
        if let [complaint, ..] = health.errors[..] {
            return Ok(Some(format!("{called} reports an error: {complaint}")));
        }
        if health.temperature_c >= mapped.temperature_limit_c {
            let (now_c, limit_c) = (health.temperature_c, mapped.temperature_limit_c);
            return Ok(Some(format!(
                "{called} is at {now_c} °C, the limit is {limit_c} °C"
            )));
        }
        if !health.torque_on {
            return Ok(Some(format!(
                "{called} has no torque: it was switched off, or its power was lost"
            )));
        }
        Ok(None)
    }

    fn explained(&self, error: &WireError) -> String {
        take_over::error_text(self.map, error)
    }
}
