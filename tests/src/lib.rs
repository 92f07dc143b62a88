//! Test harness of whole-system tests and benchmarks: real processes on a private bus.
//!
//! Inputs: names of this workspace's binaries and their arguments. Outputs: processes that end with
//! the test, their logs on failure, views of the bus, and the daemon's tick with a simulated world
//! in one thread. No other crate depends on it.
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

/// Examples of CONTRIBUTING.md, compiled as doctests.
#[cfg(doctest)]
#[doc = include_str!("../../CONTRIBUTING.md")]
struct Contributing;

/// Examples of the module guide, compiled as doctests.
#[cfg(doctest)]
#[doc = include_str!("../../clients/guide/src/module.md")]
struct Guide;

/// Timeout of waits. Long enough for slow machines; not a measured limit.
pub const TIMEOUT: Duration = Duration::from_secs(60);

/// Returns the path of a workspace binary in the target folder of the test.
///
/// # Panics
/// If the binary does not exist.
#[must_use]
pub fn binary(name: &str) -> PathBuf {
    let own = std::env::current_exe().expect("a test has an executable");
    let folder = own
        .ancestors()
        .nth(2)
        .expect("the test runs from the target folder");
    let path = folder.join(name);
    assert!(
        path.exists(),
        "{} is missing; run `cargo build --workspace` first",
        path.display()
    );
    path
}

/// Takes the machine exclusively. Real-time tests hold this lock so that they do not compete for
/// processor time.
///
/// The lock ignores poisoning: a failed test leaves no state behind.
pub fn lock_exclusive() -> RwLockWriteGuard<'static, ()> {
    MACHINE.write().unwrap_or_else(PoisonError::into_inner)
}

/// Takes the machine shared. Tests in virtual time hold this lock: they may run in parallel, but
/// not with real-time tests.
pub fn lock_shared() -> RwLockReadGuard<'static, ()> {
    MACHINE.read().unwrap_or_else(PoisonError::into_inner)
}

/// Lock behind [`lock_exclusive`] and [`lock_shared`].
static MACHINE: RwLock<()> = RwLock::new(());

/// Returns a path in the `shared` folder next to the workspace; `None`, with a message, if it does
/// not exist.
#[must_use]
pub fn shared_path(path: &str) -> Option<PathBuf> {
    let found = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../../shared")
        .join(path);
    if found.exists() {
        return Some(found);
    }
    report_skipped(&format!("{} does not exist", found.display()));
    None
}

/// Reports on stderr that the rest of a test is skipped. Bypasses the harness, which hides the
/// output of passing tests.
pub fn report_skipped(why: &str) {
    let test = std::thread::current().name().unwrap_or_default().to_owned();
    // A failed write is ignored: without stderr there is no reader.
    let _ = writeln!(std::io::stderr(), "SKIPPED: {test}: {why}");
}

/// Handles a missing program: skips the rest of the test with a message, or fails if `CI` is set.
///
/// # Panics
/// If `CI` is set.
pub fn skip_or_fail(what: &str) {
    assert!(std::env::var_os("CI").is_none(), "{what}");
    report_skipped(what);
}

/// A process that is killed on drop. Its log is printed if the test failed.
#[derive(Debug)]
pub struct Process {
    name: String,
    child: Child,
    log: PathBuf,
    _folder: tempfile::TempDir,
}

impl Process {
    /// Starts a workspace binary.
    ///
    /// # Panics
    /// If it does not start.
    #[must_use]
    pub fn start(name: &str, arguments: &[&str]) -> Self {
        Self::start_program(&binary(name), arguments)
    }

    /// Starts any program.
    ///
    /// # Panics
    /// If it does not start.
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

    /// Returns the process id.
    #[must_use]
    pub fn pid(&self) -> u32 {
        self.child.id()
    }

    /// Sends a signal.
    ///
    /// # Panics
    /// If the process has ended.
    pub fn signal(&self, signal: rustix::process::Signal) {
        let pid = rustix::process::Pid::from_child(&self.child);
        rustix::process::kill_process(pid, signal).expect("the process is running");
    }

    /// Waits for the exit status.
    ///
    /// # Panics
    /// On timeout.
    pub fn wait(&mut self) -> ExitStatus {
        wait_for(&format!("{} to end", self.name), || {
            self.child.try_wait().expect("waitable")
        })
    }

    /// Returns the output so far, stdout and stderr.
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
        // Both calls fail harmlessly if the process has already ended.
        let _ended = self.child.kill();
        let _status = self.child.wait();
        if std::thread::panicking() {
            eprintln!("--- log of {}:\n{}", self.name, self.log());
        }
    }
}

/// Calls `ask` repeatedly until it returns a value.
///
/// # Panics
/// On timeout.
pub fn wait_for<T>(what: &str, mut ask: impl FnMut() -> Option<T>) -> T {
    let begin = Instant::now();
    loop {
        if let Some(answer) = ask() {
            return answer;
        }
        assert!(begin.elapsed() < TIMEOUT, "timed out waiting for {what}");
        std::thread::sleep(Duration::from_millis(1));
    }
}
