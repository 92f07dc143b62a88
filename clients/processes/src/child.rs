//! Child process of a demo or measurement: start, supervision, termination.

use std::fs::File;
use std::os::unix::process::CommandExt;
use std::path::{Path, PathBuf};
use std::process::{Child as Process, Command, ExitStatus, Stdio};
use std::time::{Duration, Instant};

use anyhow::Context;
use rustix::process::{
    Pid, Signal, getpid, getppid, kill_process, set_parent_process_death_signal,
};

/// Time until a terminated process is killed (design choice: the daemon ends within 200 ms).
const TERMINATION_TIMEOUT: Duration = Duration::from_secs(3);
const TAIL_LINES: usize = 12;

/// Running program with its log. It ends when this value is dropped or when this process dies for
/// any reason.
pub struct Child {
    name: &'static str,
    process: Process,
    log: PathBuf,
    results: PathBuf,
}

impl Child {
    /// Starts the program of this name from the folder of this program.
    ///
    /// It gets a separate process group: Ctrl-C reaches only this process, which then terminates
    /// the child in order.
    ///
    /// # Errors
    /// The program is not in the folder of this program, or did not start.
    pub fn start(name: &'static str, arguments: &[&str], folder: &Path) -> anyhow::Result<Self> {
        Self::start_program(&sibling_program(name)?, name, arguments, folder)
    }

    /// Starts a program by path or by name, searched in `PATH`.
    ///
    /// # Errors
    /// The log files cannot be created, or the program did not start.
    pub fn start_program(
        program: &Path,
        name: &'static str,
        arguments: &[&str],
        folder: &Path,
    ) -> anyhow::Result<Self> {
        Self::start_adjusted(program, name, arguments, folder, |_| ())
    }

    /// Starts a program whose environment or outputs `adjust` changes.
    ///
    /// # Errors
    /// The log files cannot be created, or the program did not start.
    pub fn start_adjusted(
        program: &Path,
        name: &'static str,
        arguments: &[&str],
        folder: &Path,
        adjust: impl FnOnce(&mut Command),
    ) -> anyhow::Result<Self> {
        let (log, results) = (
            folder.join(format!("{name}.log")),
            folder.join(format!("{name}.out")),
        );
        let create = |path: &Path| {
            File::create(path)
                .with_context(|| format!("could not make the log file {}", path.display()))
        };
        let mut command = Command::new(program);
        command
            .args(arguments)
            .env("NO_COLOR", "1")
            .stdin(Stdio::null())
            .stdout(create(&results)?)
            .stderr(create(&log)?)
            .process_group(0);
        adjust(&mut command);
        end_with_this_process(&mut command);
        let process = command
            .spawn()
            .with_context(|| format!("could not start {}", program.display()))?;
        Ok(Self {
            name,
            process,
            log,
            results,
        })
    }

    /// Returns the process id.
    #[must_use]
    pub fn pid(&self) -> u32 {
        self.process.id()
    }

    /// Sends a signal to the process.
    ///
    /// # Errors
    /// The process has ended.
    pub fn signal(&self, signal: Signal) -> std::io::Result<()> {
        Ok(kill_process(Pid::from_child(&self.process), signal)?)
    }

    /// Returns the exit status if the process has ended.
    ///
    /// # Errors
    /// The operating system refuses the query.
    pub fn exit_status(&mut self) -> std::io::Result<Option<ExitStatus>> {
        self.process.try_wait()
    }

    /// Checks that the process is running.
    ///
    /// # Errors
    /// The process has ended; the error contains the end of its log.
    pub fn check(&mut self) -> anyhow::Result<()> {
        let Some(status) = self.process.try_wait()? else {
            return Ok(());
        };
        anyhow::bail!(
            "{} ended unexpectedly ({status}); the end of its log {}:\n{}",
            self.name,
            self.log.display(),
            self.tail()
        )
    }

    /// Returns the whole log so far.
    #[must_use]
    pub fn log(&self) -> String {
        std::fs::read_to_string(&self.log).unwrap_or_default()
    }

    /// Returns the complete lines of its standard output so far.
    #[must_use]
    pub fn results(&self) -> Vec<String> {
        let text = std::fs::read_to_string(&self.results).unwrap_or_default();
        let whole = text.rfind('\n').map_or("", |end| &text[..end]);
        whole.lines().map(str::to_owned).collect()
    }

    /// Returns the last lines of its log, indented.
    #[must_use]
    pub fn tail(&self) -> String {
        let text = std::fs::read_to_string(&self.log).unwrap_or_default();
        let lines: Vec<&str> = text.lines().collect();
        let first = lines.len().saturating_sub(TAIL_LINES);
        lines[first..]
            .iter()
            .map(|line| format!("  {line}\n"))
            .collect()
    }
}

impl Drop for Child {
    fn drop(&mut self) {
        let begin = Instant::now();
        let pid = Pid::from_child(&self.process);
        // Fails only if it has ended already. Its id is not reused before it has been waited for.
        let mut running = !matches!(self.process.try_wait(), Ok(Some(_)));
        if running {
            let _ = kill_process(pid, Signal::TERM);
        }
        while running && begin.elapsed() < TERMINATION_TIMEOUT {
            std::thread::sleep(Duration::from_millis(2));
            running = !matches!(self.process.try_wait(), Ok(Some(_)));
        }
        if running {
            tracing::warn!(
                "{} did not end within {TERMINATION_TIMEOUT:?} of SIGTERM; it was killed",
                self.name
            );
            let _ = self.process.kill();
            let _ = self.process.wait();
        }
    }
}

/// Makes the kernel send SIGTERM to the program when this process dies, even by `kill -9`. A
/// simulator then ends in order and leaves nothing in `/dev/shm`.
///
/// Linux ties this to the thread that starts the program, here the main thread.
fn end_with_this_process(command: &mut Command) {
    let parent = getpid();
    let before_exec = move || {
        set_parent_process_death_signal(Some(Signal::TERM))?;
        // This process may have died before the call.
        if getppid() == Some(parent) {
            Ok(())
        } else {
            Err(std::io::Error::from_raw_os_error(
                rustix::io::Errno::SRCH.raw_os_error(),
            ))
        }
    };
    // SAFETY: only async-signal-safe calls are allowed between fork and exec. The closure makes two
    // system calls, allocates nothing and takes no lock.
    unsafe {
        command.pre_exec(before_exec);
    }
}

/// Returns the path of a program in the folder of this one.
///
/// # Errors
/// The folder does not contain the program.
pub fn sibling_program(name: &str) -> anyhow::Result<PathBuf> {
    let this = std::env::current_exe().context("could not find the folder of this program")?;
    let folder = this.parent().unwrap_or(Path::new("."));
    let program = folder.join(name);
    if program.is_file() {
        return Ok(program);
    }
    let release = if folder.ends_with("release") {
        " --release"
    } else {
        ""
    };
    anyhow::bail!(
        "could not find {name} in {}, the folder of this program; build everything with `cargo \
         build --workspace{release}`",
        folder.display()
    )
}
