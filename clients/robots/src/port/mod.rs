//! One serial port: takes its servos over, then reads all, writes all and looks after one, cycle for cycle, on a thread of its own.
//!
//! * **In:** goals from the robot ([`Shared`]). **Out:** [`Report`]s: that the servos hold, what they measured, what is wrong.
//! * **A cycle** is one bulk read, one bulk write and the health of one servo, in turn. It begins when its time has come and the
//!   one before has ended: the bus sets the rate.
//! * **Trouble** (a servo that does not answer three times in a row, is loose, too hot, or complains; a port that is gone) ends the
//!   cycles. Nothing is written any more, so every servo that can hold goes on holding. Then the port is taken over anew, again and
//!   again, until all is well.
//! * **Nothing jumps:** a servo gets torque only when its goal is where it stands. Goals of an earlier life of the port are not
//!   written: after trouble the robot must have said where it goes from there.

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

/// Failed exchanges in a row that are noise; one more is trouble. Ours: below it the daemon's own limit of age decides.
const MISSES_MAX: u32 = 2;
/// Time between two attempts to take a port over. Ours.
const RETRY_EVERY: Duration = Duration::from_millis(200);
/// Attempts to take a port over before that is trouble: an exchange with each of its servos may meet noise. Ours.
const ATTEMPTS: u32 = 3;
/// How soon a stop request is seen while waiting.
const POLL: Duration = Duration::from_millis(20);
/// Multiple of a shaft's top speed above which a reading that passed its checksum is damaged all the same. Ours.
const JUMP_FACTOR: f64 = 4.0;
/// Jump that is always believed, rad: a few steps of the encoder. Ours.
const JUMP_FLOOR_RAD: f64 = 0.02;

/// What a port tells the robot.
#[derive(Clone, Debug, PartialEq)]
pub enum Report {
    /// All servos hold: where, rad, each with its joint. A new life begins.
    Holding {
        /// Which life of the port this is.
        life: u32,
        /// Joint and position.
        held_rad: Vec<(usize, f64)>,
    },
    /// All servos were read.
    Read {
        /// When the question went out.
        captured_ns: u64,
        /// Joint and what it measured.
        joints: Vec<(usize, JointReading)>,
    },
    /// Something is wrong, in words. What holds goes on holding.
    Trouble(String),
}

/// What the robot tells a port.
#[derive(Debug)]
pub struct Shared {
    goals: Mutex<Goals>,
    /// Set to end the thread.
    pub stop: Arc<AtomicBool>,
    /// What the port counted and timed so far.
    pub figures: Mutex<Figures>,
}

/// Goals for one life of a port.
#[derive(Clone, Copy, Debug, Default)]
struct Goals {
    life: u32,
    position_rad: Option<[f64; JOINTS]>,
}

impl Shared {
    /// Without goals.
    #[must_use]
    pub fn new(stop: Arc<AtomicBool>) -> Self {
        Self {
            goals: Mutex::default(),
            stop,
            figures: Mutex::default(),
        }
    }

    /// Orders these positions, rad, in this life of the port.
    pub fn order(&self, life: u32, position_rad: &[f64; JOINTS]) {
        *lock(&self.goals) = Goals {
            life,
            position_rad: Some(*position_rad),
        };
    }

    fn ordered(&self, life: u32) -> Option<[f64; JOINTS]> {
        let goals = *lock(&self.goals);
        goals.position_rad.filter(|_| goals.life == life)
    }

    fn is_stopped(&self) -> bool {
        self.stop.load(Ordering::Relaxed)
    }
}

/// A thread that panicked left nothing half-done in there.
fn lock<T>(mutex: &Mutex<T>) -> std::sync::MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Runs one port until it is stopped, or until nobody takes its reports any more, which go out with its index.
pub fn run(map: &PortMap, index: usize, to: &Sender<(usize, Report)>, shared: &Shared) {
    let mut port = Port {
        map,
        servos: map.servos.iter().map(|mapped| mapped.servo).collect(),
        shared,
        life: 0,
        readings: Vec::new(),
        before: Vec::new(),
        read_ns: 0,
        looked_after: 0,
    };
    let tell = |report| to.send((index, report)).is_ok();
    while !shared.is_stopped() {
        let trouble = match take_over_patiently(map) {
            Ok((mut wire, held_rad)) => {
                port.life += 1;
                let life = port.life;
                if !tell(Report::Holding { life, held_rad }) {
                    return;
                }
                port.cycles(&mut wire, &tell)
            }
            Err(trouble) => trouble,
        };
        if shared.is_stopped() || !tell(Report::Trouble(trouble)) {
            return;
        }
        lock(&shared.figures).troubles += 1;
        wait(shared, RETRY_EVERY);
    }
}

fn take_over_patiently(map: &PortMap) -> Result<take_over::Taken, String> {
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
    life: u32,
    readings: Vec<Reading>,
    /// The readings of the cycle before, and when.
    before: Vec<Reading>,
    read_ns: u64,
    /// Whose turn it is.
    looked_after: usize,
}

impl Port<'_> {
    /// Cycles until something is wrong, and says what; until a stop request, and says nothing.
    fn cycles(&mut self, wire: &mut Wire, tell: &impl Fn(Report) -> bool) -> String {
        let (mut misses, mut due_ns) = (0, now_ns());
        self.before.clear();
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

    /// One cycle; trouble if a servo has some.
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
        if let Some(goals_rad) = self.shared.ordered(self.life) {
            let shaft = |mapped: &MappedServo| mapped.shaft_rad(goals_rad[mapped.joint]);
            let goals_rad: Vec<f64> = self.map.servos.iter().map(shaft).collect();
            driver.write_goals(wire, &self.servos, &goals_rad)?;
        }
        let trouble = self.look_after(wire)?;
        lock(&self.shared.figures).time(begun_ns, read_ns, now_ns());
        Ok(trouble)
    }

    /// A shaft that moved faster than it can was misread: the checksum of protocol 1.0 lets one damage in 256 pass.
    fn check_jumps(&mut self, now_ns: u64) -> Result<(), WireError> {
        let elapsed_s = now_ns.saturating_sub(self.read_ns) as f64 * 1e-9;
        let pairs = self.before.iter().zip(&self.readings).zip(&self.servos);
        for ((before, reading), servo) in pairs {
            let allowed_rad = JUMP_FLOOR_RAD + JUMP_FACTOR * servo.speed_max_rad_s * elapsed_s;
            if (reading.position_rad - before.position_rad).abs() > allowed_rad {
                return Err(WireError::Damaged(servo.id));
            }
        }
        self.before.clone_from(&self.readings);
        self.read_ns = now_ns;
        Ok(())
    }

    /// Asks one servo how it is: the first that gave an alert, otherwise the next in turn.
    fn look_after(&mut self, wire: &mut Wire) -> Result<Option<String>, WireError> {
        let alerted = self.readings.iter().position(|reading| reading.alert);
        self.looked_after = (self.looked_after + 1) % self.servos.len();
        let mapped = &self.map.servos[alerted.unwrap_or(self.looked_after)];
        let health = self.map.driver.health(wire, mapped.servo.id)?;
        let called = mapped.called();
        if let [complaint, ..] = health.complaints[..] {
            return Ok(Some(format!("{called} says that {complaint}")));
        }
        if health.temperature_c >= mapped.temperature_limit_c {
            let (now_c, limit_c) = (health.temperature_c, mapped.temperature_limit_c);
            return Ok(Some(format!(
                "{called} is at {now_c} °C, allowed are {limit_c}"
            )));
        }
        if !health.torque_on {
            return Ok(Some(format!(
                "{called} is loose: its torque was switched off, or its power was lost"
            )));
        }
        Ok(None)
    }

    fn explained(&self, error: &WireError) -> String {
        take_over::explained(self.map, error)
    }
}
