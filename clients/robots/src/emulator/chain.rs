//! Servos on one pseudo-terminal: who answers what, and when.

use std::collections::BTreeMap;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use super::dynamixel::Dynamixel;
use super::family::{ALL, Family, Request, What};
use super::feetech::Feetech;
use super::servo::Servo;
use super::terminal::Terminal;

/// How soon a stop request is seen.
const POLL: Duration = Duration::from_millis(20);
/// Bits of a byte on the wire: start and stop are two of them.
const BITS_PER_BYTE: f64 = 10.0;

/// A servo to be played.
#[derive(Clone, Debug, PartialEq)]
pub struct Planned {
    /// Its id.
    pub id: u8,
    /// Its model's name.
    pub model: String,
    /// Where its shaft stands, rad.
    pub position_rad: f64,
}

/// Servos behind a pseudo-terminal, played by a thread of their own.
#[derive(Debug)]
pub struct Chain {
    path: PathBuf,
    shared: Arc<Mutex<Inside>>,
    stop: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

struct Inside {
    family: &'static dyn Family,
    servos: BTreeMap<u8, Servo>,
    /// Time of a byte on the wire; zero for answers at once.
    byte_s: f64,
    /// One byte in so many is damaged; 0 for none.
    noise_every: u32,
    random: u32,
    advanced: Instant,
}

impl std::fmt::Debug for Inside {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{:?}", self.servos)
    }
}

impl Chain {
    /// Begins to play servos of a family. With a line speed, answers take their time on the wire.
    ///
    /// # Errors
    /// If there is no pseudo-terminal, or no such family or model.
    pub fn start(family: &str, servos: &[Planned], baud: Option<u32>) -> io::Result<Self> {
        let unknown = |what: &str| {
            let why = format!("{what} is not played");
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
            Ok((planned.id, Servo::new(family, table, planned.position_rad)))
        });
        let inside = Inside {
            family,
            servos: made.collect::<io::Result<_>>()?,
            byte_s: baud.map_or(0.0, |baud| BITS_PER_BYTE / f64::from(baud)),
            noise_every: 0,
            random: 1,
            advanced: Instant::now(),
        };
        let terminal = Terminal::open()?;
        let (path, stop) = (terminal.path().to_owned(), Arc::new(AtomicBool::new(false)));
        let shared = Arc::new(Mutex::new(inside));
        let (theirs, until) = (Arc::clone(&shared), Arc::clone(&stop));
        let thread = std::thread::spawn(move || play(&terminal, &theirs, &until));
        Ok(Self {
            path,
            shared,
            stop,
            thread: Some(thread),
        })
    }

    /// Its terminal.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Looks at one servo, or does something to it.
    ///
    /// # Panics
    /// If there is no such servo.
    pub fn servo<T>(&self, id: u8, act: impl FnOnce(&mut Servo) -> T) -> T {
        let mut inside = lock(&self.shared);
        inside.advance();
        let servo = inside.servos.get_mut(&id);
        act(servo.unwrap_or_else(|| panic!("no servo {id} is played")))
    }

    /// Damages one byte in so many of what is answered, at random; 0 for none.
    pub fn set_noise(&self, every: u32) {
        lock(&self.shared).noise_every = every;
    }
}

impl Drop for Chain {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::Relaxed);
        if let Some(thread) = self.thread.take() {
            // A thread that panicked has ended as well.
            let _ = thread.join();
        }
    }
}

fn lock(shared: &Mutex<Inside>) -> MutexGuard<'_, Inside> {
    shared.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Answers until it is stopped or the terminal fails.
fn play(terminal: &Terminal, shared: &Mutex<Inside>, stop: &AtomicBool) {
    let mut bytes = Vec::new();
    while !stop.load(Ordering::Relaxed) {
        if terminal.receive(&mut bytes, POLL).is_err() {
            return;
        }
        let began = Instant::now();
        loop {
            let (answer, takes) = {
                let mut inside = lock(shared);
                let before = bytes.len();
                let Some(request) = inside.family.take(&mut bytes) else {
                    break;
                };
                inside.answer_to(&request, before - bytes.len())
            };
            std::thread::sleep(takes.saturating_sub(began.elapsed()));
            if terminal.send(&answer).is_err() {
                return;
            }
        }
    }
}

impl Inside {
    fn advance(&mut self) {
        let now = Instant::now();
        let elapsed_s = (now - self.advanced).as_secs_f64();
        self.advanced = now;
        for servo in self.servos.values_mut() {
            servo.advance(elapsed_s);
        }
    }

    /// What is answered, and how long that takes after the request came.
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
        (answer, Duration::from_secs_f64(takes_s))
    }

    fn answer(&mut self, request: &Request) -> Vec<u8> {
        match &request.what {
            What::SyncRead {
                address,
                length,
                ids,
                fast,
            } => self.read_all(ids, *address, *length, *fast),
            What::SyncWrite { address, items } => {
                for (id, bytes) in items {
                    if let Some(servo) = self.servos.get_mut(id).filter(|servo| servo.is_powered())
                    {
                        // Nobody answers, so nobody says that it was refused.
                        let _ = servo.write(*address, bytes);
                    }
                }
                Vec::new()
            }
            What::Ping if request.id == ALL => {
                let ids: Vec<u8> = self.servos.keys().copied().collect();
                ids.iter()
                    .flat_map(|id| self.one(*id, &What::Ping))
                    .collect()
            }
            what => self.one(request.id, what),
        }
    }

    /// The answer of one servo.
    fn one(&mut self, id: u8, what: &What) -> Vec<u8> {
        let Some(servo) = self.servos.get_mut(&id).filter(|servo| servo.is_powered()) else {
            return Vec::new();
        };
        let (mut status, mut parameters) = (self.family.status(&servo.table), Vec::new());
        match what {
            What::Ping => parameters = self.family.ping(&servo.table),
            What::Read { address, length } => {
                let registers = servo.table.get(*address..address.saturating_add(*length));
                parameters = registers.unwrap_or_default().to_vec();
            }
            What::Write { address, bytes } => {
                if let Err(error) = servo.write(*address, bytes) {
                    status |= error;
                }
            }
            What::Reboot => servo.boot(),
            _ => return Vec::new(),
        }
        if servo.answers() {
            self.family.answer(id, status, &parameters)
        } else {
            Vec::new()
        }
    }

    /// Servos answer in the order in which they were asked; who does not hear the one before says nothing.
    fn read_all(&self, ids: &[u8], address: usize, length: usize, fast: bool) -> Vec<u8> {
        let heard = ids.iter().map_while(|id| {
            let servo = self.servos.get(id).filter(|servo| servo.answers())?;
            let registers = servo.table.get(address..address + length)?;
            Some((*id, self.family.status(&servo.table), registers.to_vec()))
        });
        let blocks: Vec<_> = heard.collect();
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
            // A linear congruential generator is random enough for noise, and the same in every run.
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
