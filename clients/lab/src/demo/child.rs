//! One process of a demo or a measurement: started, watched, ended.

use std::fs::File;
use std::os::unix::process::CommandExt;
use std::path::{Path, PathBuf};
use std::process::{Child as Process, Command, ExitStatus, Stdio};
use std::time::{Duration, Instant};

use anyhow::Context;
use rustix::process::{
    Pid, Signal, getpid, getppid, kill_process, set_parent_process_death_signal,
};

/// How long a process may take to end by itself (ours: the daemon promises 200 ms).
const END_WITHIN: Duration = Duration::from_secs(3);
/// Lines of a log that an error message repeats.
const TAIL_LINES: usize = 12;

/// A running program with its log. Ends with this value, and with this process, however that ends.
pub(crate) struct Child {
    name: &'static str,
    process: Process,
    log: PathBuf,
    results: PathBuf,
}

impl Child {
    /// Starts the program of this name that lies next to this one.
    ///
    /// It gets a process group of its own, so that Ctrl-C reaches this process only, which then ends it in good order.
    pub(crate) fn start(
        name: &'static str,
        arguments: &[&str],
        folder: &Path,
    ) -> anyhow::Result<Self> {
        Self::start_program(&beside_this_program(name)?, name, arguments, folder)
    }

    /// Starts a program by its path, or one that is found by its name as a shell finds it.
    pub(crate) fn start_program(
        program: &Path,
        name: &'static str,
        arguments: &[&str],
        folder: &Path,
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

    /// Its process id.
    pub(crate) fn pid(&self) -> u32 {
        self.process.id()
    }

    /// Sends it a signal.
    pub(crate) fn signal(&self, signal: Signal) -> std::io::Result<()> {
        Ok(kill_process(Pid::from_child(&self.process), signal)?)
    }

    /// Whether and how it has ended.
    pub(crate) fn ended(&mut self) -> std::io::Result<Option<ExitStatus>> {
        self.process.try_wait()
    }

    /// An error with the end of its log if it has ended, which it must not by itself.
    pub(crate) fn check(&mut self) -> anyhow::Result<()> {
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

    /// The whole lines that it has written to standard output so far.
    pub(crate) fn results(&self) -> Vec<String> {
        let text = std::fs::read_to_string(&self.results).unwrap_or_default();
        let whole = text.rfind('\n').map_or("", |end| &text[..end]);
        whole.lines().map(str::to_owned).collect()
    }

    /// The last lines of its log.
    pub(crate) fn tail(&self) -> String {
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
        // Fails only if it has ended already; as long as nobody waited for it, its id cannot be another's.
        let mut running = !matches!(self.process.try_wait(), Ok(Some(_)));
        if running {
            let _ = kill_process(pid, Signal::TERM);
        }
        while running && begin.elapsed() < END_WITHIN {
            std::thread::sleep(Duration::from_millis(2));
            running = !matches!(self.process.try_wait(), Ok(Some(_)));
        }
        if running {
            tracing::warn!(
                "{} did not end within {END_WITHIN:?} of SIGTERM; killed it",
                self.name
            );
            let _ = self.process.kill();
            let _ = self.process.wait();
        }
    }
}

/// Asks the kernel to send SIGTERM to the program when this process dies, even of `kill -9`: a simulator without its
/// observer ends like one that was asked to, and leaves nothing in `/dev/shm`.
///
/// Linux watches the thread that starts the program; here it is the main thread, which lives as long as the process.
fn end_with_this_process(command: &mut Command) {
    let parent = getpid();
    let before_exec = move || {
        set_parent_process_death_signal(Some(Signal::TERM))?;
        // This process may have died before the kernel was asked.
        if getppid() == Some(parent) {
            Ok(())
        } else {
            Err(std::io::Error::from_raw_os_error(
                rustix::io::Errno::SRCH.raw_os_error(),
            ))
        }
    };
    // SAFETY: between fork and exec only async-signal-safe calls are allowed: the closure makes two system calls,
    // allocates nothing and takes no lock.
    unsafe {
        command.pre_exec(before_exec);
    }
}

/// The path of a program that is built together with this one.
pub(crate) fn beside_this_program(name: &str) -> anyhow::Result<PathBuf> {
    let this = std::env::current_exe().context("could not find out where this program lies")?;
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
        "could not find {name} in {}, where this program lies; build everything with `cargo build --workspace{release}`",
        folder.display()
    )
}
