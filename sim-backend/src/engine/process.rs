//! Engine as a child process: messages over its standard input and output.
//!
//! Each message has a header of two little-endian `u32`: kind and length of the payload, bytes.
//!
//! | direction | kind | payload |
//! |---|---|---|
//! | to the engine | 1 begin | [`EngineScene`] as JSON |
//! | to the engine | 2 tick | [`TickInput`]: little-endian `f64` in the order of its fields |
//! | from the engine | 3 ready | name and version of the engine, UTF-8 |
//! | from the engine | 4 state | [`PhysicsState`]: little-endian `f64` in the order of its fields |
//! | from the engine | 5 failed | reason, UTF-8: the scene or the tick is discarded |
//!
//! In a state, an untouched fingertip has object −1, and `engaged` is 0 or 1. The engine answers
//! each message with one message: `begin` within 60 s, a tick within 10 s. It ends within 2 s after
//! its standard input ends; otherwise it is killed. Its standard error goes to that of this
//! process.

use std::ffi::OsString;
use std::io::{self, BufReader, BufWriter, Read, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};
use std::str::FromStr;
use std::time::{Duration, Instant};

use super::pipe::{Timed, deadline};
use super::{Engine, EngineError, EngineScene, PhysicsState, TickInput};

const BEGIN: u32 = 1;
const TICK: u32 = 2;
const READY: u32 = 3;
const STATE: u32 = 4;
const FAILED: u32 = 5;
/// Largest payload from an engine, bytes. Design choice: ten times the state of the largest robot.
const PAYLOAD_MAX: usize = 1 << 20;
/// Time limits of an engine, s.
#[derive(Clone, Copy, Debug)]
struct Limits {
    begin_s: f64,
    tick_s: f64,
    end_s: f64,
}

/// Time limits. Design choice: MuJoCo builds a scene in 1 to 10 s, simulates a tick in milliseconds
/// and ends in 0.1 s on an idle core. Too short: a busy machine ends working engines. Too long: an
/// engine that hangs blocks the evaluation.
const LIMITS: Limits = Limits {
    begin_s: 60.0,
    tick_s: 10.0,
    end_s: 2.0,
};
/// Period of the check whether an engine has ended.
const END_CHECK: Duration = Duration::from_millis(5);
/// Name of the engine in the Python package.
const MUJOCO: &str = "mujoco";
/// Environment variable with the Python interpreter that has the package `atas`.
const PYTHON: &str = "ATAS_PYTHON";

/// Command line of an engine: `mujoco` with its options, or a program with its arguments.
///
/// ```
/// use sim_backend::engine::EngineCommand;
///
/// let command: EngineCommand = "mujoco --viewer".parse().expect("valid");
/// assert_eq!(command.to_string(), "mujoco --viewer");
/// assert!(" ".parse::<EngineCommand>().is_err());
/// ```
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct EngineCommand {
    text: String,
}

impl FromStr for EngineCommand {
    type Err = EngineError;

    fn from_str(text: &str) -> Result<Self, EngineError> {
        match text.split_whitespace().next() {
            Some(_) => Ok(Self {
                text: text.trim().to_owned(),
            }),
            None => Err(EngineError::Command(
                "the command is empty, needs mujoco or a program; correct --engine".to_owned(),
            )),
        }
    }
}

impl core::fmt::Display for EngineCommand {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str(&self.text)
    }
}

impl EngineCommand {
    /// Returns program and arguments. `mujoco` is the module of the Python package.
    fn words(&self) -> (OsString, Vec<String>) {
        let mut words = self.text.split_whitespace().map(str::to_owned);
        let first = words.next().unwrap_or_default();
        if first != MUJOCO {
            return (first.into(), words.collect());
        }
        let module = ["-m", "atas.mujoco"].map(str::to_owned);
        (python(), module.into_iter().chain(words).collect())
    }
}

/// Returns the Python interpreter: named by the environment, beside this program, or on the path.
fn python() -> OsString {
    let beside = || -> Option<PathBuf> {
        let program = std::env::current_exe().ok()?;
        let python = program
            .parent()
            .map(|folder: &Path| folder.join("python3"))?;
        python.exists().then_some(python)
    };
    std::env::var_os(PYTHON)
        .or_else(|| beside().map(Into::into))
        .unwrap_or_else(|| "python3".into())
}

/// Running engine. The process ends when this value is dropped.
#[derive(Debug)]
pub struct EngineProcess {
    child: Child,
    /// `None` after the drop has begun.
    input: Option<BufWriter<Timed<ChildStdin>>>,
    output: BufReader<Timed<ChildStdout>>,
    limits: Limits,
    message: Vec<u8>,
    /// The engine has broken the protocol or ended.
    is_lost: bool,
}

impl EngineProcess {
    /// Starts the engine.
    ///
    /// # Errors
    /// [`EngineError::Start`] if the program does not start.
    pub fn start(command: &EngineCommand) -> Result<Self, EngineError> {
        let (program, arguments) = command.words();
        let failed = |reason: String| EngineError::Start {
            program: program.to_string_lossy().into_owned(),
            reason,
        };
        let mut child = Command::new(&program)
            .args(arguments)
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
            .map_err(|error| failed(error.to_string()))?;
        let (Some(input), Some(output)) = (child.stdin.take(), child.stdout.take()) else {
            return Err(failed("it has no pipes".to_owned()));
        };
        Ok(Self {
            child,
            input: Some(BufWriter::new(Timed::new(input))),
            output: BufReader::new(Timed::new(output)),
            limits: LIMITS,
            message: Vec::new(),
            is_lost: false,
        })
    }

    /// Returns true if the engine has ended or broken the protocol.
    pub(crate) fn is_lost(&self) -> bool {
        self.is_lost
    }

    /// Sends `self.message` and receives the answer into it within `limit_s`; returns the answer's
    /// kind.
    fn exchange(&mut self, kind: u32, limit_s: f64) -> Result<u32, EngineError> {
        if self.is_lost {
            return Err(EngineError::Connection("it has ended before".to_owned()));
        }
        let answer = self.send_and_receive(kind, deadline(limit_s));
        answer.map_err(|error| {
            self.is_lost = true;
            match error.kind() {
                io::ErrorKind::TimedOut => EngineError::Timeout { seconds: limit_s },
                io::ErrorKind::UnexpectedEof | io::ErrorKind::BrokenPipe => {
                    EngineError::Connection("it ended".to_owned())
                }
                _ => EngineError::Connection(error.to_string()),
            }
        })
    }

    fn send_and_receive(&mut self, kind: u32, deadline: Instant) -> io::Result<u32> {
        let input = self.input.as_mut().ok_or(io::ErrorKind::BrokenPipe)?;
        input.get_mut().set_deadline(deadline);
        self.output.get_mut().set_deadline(deadline);
        let length = u32::try_from(self.message.len()).map_err(io::Error::other)?;
        input.write_all(&kind.to_le_bytes())?;
        input.write_all(&length.to_le_bytes())?;
        input.write_all(&self.message)?;
        input.flush()?;
        let mut word = [0; 4];
        self.output.read_exact(&mut word)?;
        let answer = u32::from_le_bytes(word);
        self.output.read_exact(&mut word)?;
        let length = u32::from_le_bytes(word) as usize;
        if length > PAYLOAD_MAX {
            let text = format!("its message has {length} bytes, allowed {PAYLOAD_MAX}");
            return Err(io::Error::other(text));
        }
        self.message.resize(length, 0);
        self.output.read_exact(&mut self.message)?;
        Ok(answer)
    }

    fn text(&self) -> String {
        String::from_utf8_lossy(&self.message).into_owned()
    }

    fn unexpected(&mut self, kind: u32) -> EngineError {
        self.is_lost = true;
        EngineError::Connection(format!("its message of kind {kind} is unexpected"))
    }
}

impl Engine for EngineProcess {
    fn begin(&mut self, scene: &EngineScene) -> Result<(), EngineError> {
        self.message =
            serde_json::to_vec(scene).map_err(|error| EngineError::Scene(error.to_string()))?;
        match self.exchange(BEGIN, self.limits.begin_s)? {
            READY => Ok(()),
            FAILED => Err(EngineError::Scene(self.text())),
            kind => Err(self.unexpected(kind)),
        }
    }

    fn advance(&mut self, input: &TickInput, state: &mut PhysicsState) -> Result<(), EngineError> {
        self.message.clear();
        input.write(&mut self.message);
        match self.exchange(TICK, self.limits.tick_s)? {
            STATE => state.read(&self.message).ok_or_else(|| {
                let (found, needed) = (self.message.len(), state.message_bytes());
                EngineError::Tick(format!(
                    "its state has {found} bytes, needs {needed}, all finite"
                ))
            }),
            FAILED => Err(EngineError::Tick(self.text())),
            kind => Err(self.unexpected(kind)),
        }
    }
}

impl Drop for EngineProcess {
    /// Closes the engine's input, so that it ends; kills it if it is lost or does not end in time.
    fn drop(&mut self) {
        // Drops the buffer without writing: a lost engine may no longer read.
        if let Some(input) = self.input.take() {
            drop(input.into_parts());
        }
        let end = deadline(self.limits.end_s);
        while !self.is_lost && Instant::now() < end {
            if !matches!(self.child.try_wait(), Ok(None)) {
                return;
            }
            std::thread::sleep(END_CHECK);
        }
        // Both fail only if the process has ended.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

#[cfg(test)]
mod tests;
