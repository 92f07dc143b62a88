//! Emulated servos on one pseudo-terminal: dispatch of requests and timing of replies.

use std::collections::BTreeMap;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use super::dynamixel::Dynamixel;
use super::family::{ALL, Family, Request, RequestKind};
use super::feetech::Feetech;
use super::servo::Servo;
use super::terminal::Terminal;

/// Interval between checks for a stop request.
const POLL: Duration = Duration::from_millis(20);
/// Bits per byte on the wire, with start and stop bit.
const BITS_PER_BYTE: f64 = 10.0;

/// A servo to be emulated.
#[derive(Clone, Debug, PartialEq)]
pub struct PlannedServo {
    /// Servo id.
    pub id: u8,
    /// Model name.
    pub model: String,
    /// Initial shaft angle, rad.
    pub position: f64,
}

/// Servos behind a pseudo-terminal, emulated by a thread.
#[derive(Debug)]
pub struct Chain {
    path: PathBuf,
    shared: Arc<Mutex<ChainState>>,
    stop: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

struct ChainState {
    family: &'static dyn Family,
    servos: BTreeMap<u8, Servo>,
    /// Duration of a byte on the wire, s; 0 for immediate replies.
    byte_s: f64,
    /// Delay of everything that the adapter delivers.
    latency: Duration,
    /// Mean number of bytes per damaged byte; 0 for no damage.
    noise_every: u32,
    /// Bytes before each reply: glitches of the line.
    glitch: Vec<u8>,
    /// Sends requests back, as some adapters do.
    echoes: bool,
    random: u32,
    advanced: Instant,
}

impl std::fmt::Debug for ChainState {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{:?}", self.servos)
    }
}

impl Chain {
    /// Starts the emulation of servos of one family. With a `baud`, replies take their time on the
    /// wire.
    ///
    /// # Errors
    /// If no pseudo-terminal is available, or the family or a model is unknown.
    pub fn start(family: &str, servos: &[PlannedServo], baud: Option<u32>) -> io::Result<Self> {
        let inside = ChainState::new(family, servos, baud)?;
        let terminal = Terminal::open()?;
        let (path, stop) = (terminal.path().to_owned(), Arc::new(AtomicBool::new(false)));
        let shared = Arc::new(Mutex::new(inside));
        let (theirs, until) = (Arc::clone(&shared), Arc::clone(&stop));
        let thread = std::thread::spawn(move || run_emulation(&terminal, &theirs, &until));
        Ok(Self {
            path,
            shared,
            stop,
            thread: Some(thread),
        })
    }

    /// Returns the path of the pseudo-terminal.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Calls `act` with one servo.
    ///
    /// # Panics
    /// If the servo does not exist.
    pub fn servo<T>(&self, id: u8, act: impl FnOnce(&mut Servo) -> T) -> T {
        let mut inside = lock(&self.shared);
        inside.advance();
        let servo = inside.servos.get_mut(&id);
        act(servo.unwrap_or_else(|| panic!("the emulator has no servo {id}")))
    }

    /// Sends these bytes before each reply.
    pub fn set_glitch(&self, bytes: &[u8]) {
        lock(&self.shared).glitch = bytes.to_vec();
    }

    /// Sends requests back, as some adapters do.
    pub fn set_echo(&self, echoes: bool) {
        lock(&self.shared).echoes = echoes;
    }

    /// Delays echoes and replies, as adapters do that collect bytes.
    pub fn set_latency(&self, latency: Duration) {
        lock(&self.shared).latency = latency;
    }

    /// Damages one in `every` reply bytes at random; 0 for none.
    pub fn set_noise(&self, every: u32) {
        lock(&self.shared).noise_every = every;
    }
}

impl Drop for Chain {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::Relaxed);
        if let Some(thread) = self.thread.take() {
            // A panic of the thread has ended it as well.
            let _ = thread.join();
        }
    }
}

fn lock(shared: &Mutex<ChainState>) -> MutexGuard<'_, ChainState> {
    shared.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Replies to requests until a stop request or a failure of the terminal.
fn run_emulation(terminal: &Terminal, shared: &Mutex<ChainState>, stop: &AtomicBool) {
    let mut bytes = Vec::new();
    while !stop.load(Ordering::Relaxed) {
        if terminal.receive(&mut bytes, POLL).is_err() {
            return;
        }
        let began = Instant::now();
        loop {
            let (answer, is_permitted) = {
                let mut inside = lock(shared);
                let before = bytes.clone();
                let Some(request) = inside.family.take_request(&mut bytes) else {
                    break;
                };
                let request_bytes = before.len() - bytes.len();
                let (answer, delay) = inside.answer_to(&request, request_bytes);
                let echo = &before[..if inside.echoes { request_bytes } else { 0 }];
                let glitch: &[u8] = if answer.is_empty() {
                    &[]
                } else {
                    &inside.glitch
                };
                ([echo, glitch, &answer].concat(), delay)
            };
            std::thread::sleep(is_permitted.saturating_sub(began.elapsed()));
            if terminal.send(&answer).is_err() {
                return;
            }
        }
    }
}

/// Time that a [`Responder`] passes per request, s. Design choice: about a cycle of a port.
const REQUEST_S: f64 = 1e-3;

/// Servos that reply at once, without terminal and clock: bytes of requests in, bytes of replies
/// out.
#[derive(Debug)]
pub struct Responder {
    state: ChainState,
    received: Vec<u8>,
}

impl Responder {
    /// Creates servos of one family.
    ///
    /// # Errors
    /// If the family or a model is unknown.
    pub fn new(family: &str, servos: &[PlannedServo]) -> io::Result<Self> {
        Ok(Self {
            state: ChainState::new(family, servos, None)?,
            received: Vec::new(),
        })
    }

    /// Returns the replies to all requests that these bytes complete.
    pub fn respond(&mut self, bytes: &[u8]) -> Vec<u8> {
        self.received.extend_from_slice(bytes);
        let mut replies = Vec::new();
        while let Some(request) = self.state.family.take_request(&mut self.received) {
            for servo in self.state.servos.values_mut() {
                servo.advance(REQUEST_S);
            }
            replies.extend(self.state.answer(&request));
        }
        replies
    }
}

impl ChainState {
    fn new(family: &str, servos: &[PlannedServo], baud: Option<u32>) -> io::Result<Self> {
        let unknown = |what: &str| {
            let why = format!("the emulator does not support {what}");
            io::Error::new(io::ErrorKind::InvalidInput, why)
        };
        let family: &'static dyn Family = match family {
            "dynamixel" => &Dynamixel,
            "feetech" => &Feetech,
            other => return Err(unknown(other)),
        };
        let made = servos.iter().map(|planned| {
            let table = family.registers(&planned.model, planned.id);
            let table = table.ok_or_else(|| unknown(&planned.model))?;
            Ok((planned.id, Servo::new(family, table, planned.position)))
        });
        Ok(Self {
            family,
            servos: made.collect::<io::Result<_>>()?,
            byte_s: baud.map_or(0.0, |baud| BITS_PER_BYTE / f64::from(baud)),
            latency: Duration::ZERO,
            noise_every: 0,
            glitch: Vec::new(),
            echoes: false,
            random: 1,
            advanced: Instant::now(),
        })
    }

    fn advance(&mut self) {
        let now = Instant::now();
        let elapsed_s = (now - self.advanced).as_secs_f64();
        self.advanced = now;
        for servo in self.servos.values_mut() {
            servo.advance(elapsed_s);
        }
    }

    /// Returns the reply and its delay after the request.
    fn answer_to(&mut self, request: &Request, request_bytes: usize) -> (Vec<u8>, Duration) {
        self.advance();
        let mut answer = self.answer(request);
        let delay_us = self
            .servos
            .values()
            .map(|servo| self.family.return_delay_us(&servo.table));
        let delay_s = delay_us.max().unwrap_or(0) as f64 * 1e-6;
        let wire_s = (request_bytes + answer.len()) as f64 * self.byte_s;
        let takes_s = if self.byte_s > 0.0 {
            wire_s + delay_s
        } else {
            0.0
        };
        self.damage(&mut answer);
        (answer, Duration::from_secs_f64(takes_s) + self.latency)
    }

    fn answer(&mut self, request: &Request) -> Vec<u8> {
        match &request.kind {
            RequestKind::SyncRead {
                address,
                length,
                ids,
                fast,
            } => self.read_all(ids, *address, *length, *fast),
            RequestKind::SyncWrite { address, items } => {
                for (id, bytes) in items {
                    if let Some(servo) = self.servos.get_mut(id).filter(|servo| servo.is_powered())
                    {
                        // Sync writes have no reply, so a rejection is not reported.
                        let _ = servo.write(*address, bytes);
                    }
                }
                Vec::new()
            }
            RequestKind::Ping if request.id == ALL => {
                let ids: Vec<u8> = self.servos.keys().copied().collect();
                ids.iter()
                    .flat_map(|id| self.one(*id, &RequestKind::Ping))
                    .collect()
            }
            what => self.one(request.id, what),
        }
    }

    /// Returns the reply of one servo.
    fn one(&mut self, id: u8, what: &RequestKind) -> Vec<u8> {
        let Some(servo) = self.servos.get_mut(&id).filter(|servo| servo.is_powered()) else {
            return Vec::new();
        };
        let (mut status, mut parameters) = (self.family.status(&servo.table), Vec::new());
        match what {
            RequestKind::Ping => parameters = self.family.ping(&servo.table),
            RequestKind::Read { address, length } => {
                let registers = servo.table.get(*address..address.saturating_add(*length));
                parameters = registers.unwrap_or_default().to_vec();
            }
            RequestKind::Write { address, bytes } => {
                if let Err(error) = servo.write(*address, bytes) {
                    status |= error;
                }
            }
            RequestKind::Reboot => servo.boot(),
            _ => return Vec::new(),
        }
        if servo.answers() {
            self.family.answer(id, status, &parameters)
        } else {
            Vec::new()
        }
    }

    /// Servos reply in the order of the request. A servo that misses its predecessor's reply does
    /// not reply.
    fn read_all(&self, ids: &[u8], address: usize, length: usize, fast: bool) -> Vec<u8> {
        let received = ids.iter().map_while(|id| {
            let servo = self.servos.get(id).filter(|servo| servo.answers())?;
            let registers = servo.table.get(address..address + length)?;
            Some((*id, self.family.status(&servo.table), registers.to_vec()))
        });
        let blocks: Vec<_> = received.collect();
        if fast {
            return self.family.answer_together(ids.len(), &blocks);
        }
        let answers = blocks.iter();
        answers
            .flat_map(|(id, status, bytes)| self.family.answer(*id, *status, bytes))
            .collect()
    }

    fn damage(&mut self, answer: &mut [u8]) {
        if self.noise_every == 0 {
            return;
        }
        for byte in answer {
            // A linear congruential generator is reproducible and sufficient for noise.
            self.random = self
                .random
                .wrapping_mul(1_664_525)
                .wrapping_add(1_013_904_223);
            if (self.random >> 8).is_multiple_of(self.noise_every) {
                *byte ^= 1 << (self.random >> 29);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn responder(family: &str, model: &str) -> Responder {
        let servos = [PlannedServo {
            id: 1,
            model: model.to_owned(),
            position: 0.0,
        }];
        Responder::new(family, &servos).expect("a known family")
    }

    /// Regression: a write without data to the torque register panicked.
    #[test]
    fn empty_write_is_answered_without_panic() {
        let mut servos = responder("dynamixel", "xl330-m288");
        let write = [0xFF, 0xFF, 0xFD, 0, 1, 5, 0, 3, 64, 0];
        let sum = |bytes: &[u8]| {
            bytes.iter().fold(0, |sum: u16, byte| {
                (0..8).fold(sum ^ u16::from(*byte) << 8, |sum, _| match sum & 0x8000 {
                    0 => sum << 1,
                    _ => sum << 1 ^ 0x8005,
                })
            })
        };
        let request = [&write[..], &sum(&write).to_le_bytes()].concat();
        let reply = servos.respond(&request);
        assert!(reply.starts_with(&[0xFF, 0xFF, 0xFD, 0, 1]), "{reply:x?}");
    }

    /// Regression: the length of a reply with all registers overflowed.
    #[test]
    fn read_of_all_registers_has_no_reply() {
        let mut servos = responder("feetech", "sts3215");
        let read = |length: u8| {
            let body = [1, 4, 2, 0, length];
            let sum = body.iter().fold(0_u8, |sum, byte| sum.wrapping_add(*byte));
            [&[0xFF, 0xFF][..], &body, &[!sum]].concat()
        };
        assert!(servos.respond(&read(254)).is_empty());
        assert!(servos.respond(&read(255)).is_empty());
        assert_eq!(servos.respond(&read(253)).len(), 259);
    }
}
