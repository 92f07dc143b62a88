//! Real processes on a bus of their own, for whole-system tests and benches.
//!
//! In: names of our binaries and their arguments. Out: running processes that end with the test, their logs when it
//! fails, and views of the bus; and the daemon's tick with a simulated world in one thread. Nothing here asserts;
//! nothing depends on this crate.
#![forbid(unsafe_code)]

pub mod browser;
pub mod figures;
pub mod gates;
pub mod loopback;
pub mod terminal;

use std::fs::File;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitStatus, Stdio};
use std::sync::{PoisonError, RwLock, RwLockReadGuard, RwLockWriteGuard};
use std::time::{Duration, Instant};

/// The examples of the contributor's guide.
#[cfg(doctest)]
#[doc = include_str!("../../CONTRIBUTING.md")]
struct Contributing;

/// The examples of the guide.
#[cfg(doctest)]
#[doc = include_str!("../../clients/guide/src/module.md")]
struct Guide;

/// Long enough for any machine; nothing is measured against it.
pub const PATIENCE: Duration = Duration::from_secs(60);

/// One of our binaries, found beside the test's own executable.
///
/// # Panics
/// If it has not been built.
#[must_use]
pub fn binary(name: &str) -> PathBuf {
    let own = std::env::current_exe().expect("a test has an executable");
    let folder = own
        .ancestors()
        .nth(2)
        .expect("it lies in the target folder");
    let path = folder.join(name);
    assert!(
        path.exists(),
        "{} is missing: run `cargo build --workspace` first",
        path.display()
    );
    path
}

/// Several systems at once would contend for the machine's real time: each test that runs one by the clock holds this.
///
/// A test that failed has left nothing behind that the next one could trip over.
pub fn alone() -> RwLockWriteGuard<'static, ()> {
    MACHINE.write().unwrap_or_else(PoisonError::into_inner)
}

/// Systems in virtual time do each other no harm, but those by the clock would feel them: each test that runs one holds this.
pub fn in_virtual_time() -> RwLockReadGuard<'static, ()> {
    MACHINE.read().unwrap_or_else(PoisonError::into_inner)
}

/// What [`alone`] takes for itself.
static MACHINE: RwLock<()> = RwLock::new(());

/// A path beside the workspace, for the shared recordings; `None`, with a word about it, where there is none.
#[must_use]
pub fn shared(path: &str) -> Option<PathBuf> {
    let found = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../../shared")
        .join(path);
    if found.exists() {
        return Some(found);
    }
    skipped(&format!("{} is not there", found.display()));
    None
}

/// Says loudly that the rest of a test was skipped: past the harness, which keeps what a passing test prints to itself.
pub fn skipped(why: &str) {
    let test = std::thread::current().name().unwrap_or_default().to_owned();
    // If nobody can read it, nobody needs to be told.
    let _ = writeln!(std::io::stderr(), "SKIPPED: {test}: {why}");
}

/// A program that a test needs is not installed. Where everything must be tested, as `CI` says, that is a failure;
/// elsewhere the rest of the test is skipped, loudly.
///
/// # Panics
/// Where `CI` is set.
pub fn lacking(what: &str) {
    assert!(std::env::var_os("CI").is_none(), "{what}");
    skipped(what);
}

/// A process that is killed when it goes out of scope, and whose log is shown if the test failed.
#[derive(Debug)]
pub struct Process {
    name: String,
    child: Child,
    log: PathBuf,
    _folder: tempfile::TempDir,
}

impl Process {
    /// Starts one of our binaries.
    ///
    /// # Panics
    /// If it cannot be started.
    #[must_use]
    pub fn start(name: &str, arguments: &[&str]) -> Self {
        Self::start_program(&binary(name), arguments)
    }

    /// Starts any program.
    ///
    /// # Panics
    /// If it cannot be started.
    #[must_use]
    pub fn start_program(program: &Path, arguments: &[&str]) -> Self {
        let name = program.display().to_string();
        let folder = tempfile::TempDir::new().expect("a temporary folder");
        let log = folder.path().join("log");
        let output = File::create(&log).expect("writable");
        let child = Command::new(program)
            .args(arguments)
            .env_remove("NOTIFY_SOCKET")
            .env_remove("RUST_LOG")
            .stdin(Stdio::null())
            .stdout(output.try_clone().expect("a second handle"))
            .stderr(output)
            .spawn()
            .unwrap_or_else(|e| panic!("could not start {name}: {e}"));
        Self {
            name,
            child,
            log,
            _folder: folder,
        }
    }

    /// Its process id.
    #[must_use]
    pub fn pid(&self) -> u32 {
        self.child.id()
    }

    /// Sends it a signal.
    ///
    /// # Panics
    /// If it has ended.
    pub fn signal(&self, signal: rustix::process::Signal) {
        let pid = rustix::process::Pid::from_child(&self.child);
        rustix::process::kill_process(pid, signal).expect("the process lives");
    }

    /// Waits for its end.
    ///
    /// # Panics
    /// If it does not end.
    pub fn wait(&mut self) -> ExitStatus {
        wait_for(&format!("{} to end", self.name), || {
            self.child.try_wait().expect("waitable")
        })
    }

    /// What it has said so far, on both streams.
    #[must_use]
    pub fn log(&self) -> String {
        std::fs::read_to_string(&self.log).unwrap_or_default()
    }
}

impl Drop for Process {
    #[expect(
        clippy::print_stderr,
        reason = "the log of a process explains a failed test"
    )]
    fn drop(&mut self) {
        // It may have ended already; both calls then have nothing to do.
        let _ended = self.child.kill();
        let _status = self.child.wait();
        if std::thread::panicking() {
            eprintln!("--- log of {}:\n{}", self.name, self.log());
        }
    }
}

/// Asks again and again until there is an answer.
///
/// # Panics
/// If there is none for too long.
pub fn wait_for<T>(what: &str, mut ask: impl FnMut() -> Option<T>) -> T {
    let begin = Instant::now();
    loop {
        if let Some(answer) = ask() {
            return answer;
        }
        assert!(begin.elapsed() < PATIENCE, "waited in vain for {what}");
        std::thread::sleep(Duration::from_millis(1));
    }
}
