//! Peers as separate processes: a test starts its own executable again, which then runs only the
//! test `peer`.
#![allow(dead_code, reason = "each test file uses its part")]

use std::io::{BufRead, BufReader, Read, Write};
use std::os::unix::process::CommandExt;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use shm_bus::{Bus, BusName, Realtime};

const ROLE: &str = "SHM_BUS_TEST_ROLE";

/// Runtime folder on a file system private to the peer process.
pub(crate) const PRIVATE_RUNTIME_DIR: &str = "/dev/shm/runtime";
/// Mounts the two file systems that a bus uses, then executes the given program.
const MOUNT_SMALL_FILE_SYSTEMS: &str = r#"
    mount -t tmpfs -o size=16m,nr_inodes=200 none /dev/shm &&
    mkdir "$XDG_RUNTIME_DIR" &&
    mount -t tmpfs -o size=1m,nr_inodes=200,mode=700 none "$XDG_RUNTIME_DIR" &&
    exec "$0" "$@""#;

/// Peer process, killed (SIGKILL) on drop.
pub(crate) struct Peer {
    child: Child,
}

impl Peer {
    /// Starts a peer and waits until it is ready.
    pub(crate) fn start(bus: &BusName, role: &str) -> Self {
        Self::spawn(bus, role).until_ready()
    }

    /// Waits until the peer is ready.
    pub(crate) fn until_ready(mut self) -> Self {
        let stderr = self.child.stderr.take().expect("piped");
        let mut message = Vec::new();
        let mut lines = BufReader::new(stderr).lines().map_while(Result::ok);
        let ready = lines.any(|line| {
            message.push(line);
            message.last().is_some_and(|line| line.contains("ready"))
        });
        assert!(
            ready,
            "the peer ended before it was ready:\n{}",
            message.join("\n")
        );
        self
    }

    pub(crate) fn spawn(bus: &BusName, role: &str) -> Self {
        let command = Command::new(std::env::current_exe().expect("own path"));
        Self::run(command, bus, role)
    }

    /// Starts a peer as another user, from a copy of the executable that this user can read.
    pub(crate) fn spawn_as(bus: &BusName, role: &str, uid: u32) -> Self {
        let copy = std::env::temp_dir().join(bus.as_str());
        // Copies in a child process: a file that another thread's child holds open for writing
        // cannot be executed.
        let program = std::env::current_exe().expect("own path");
        let copied = Command::new("cp").args([&program, &copy]).status();
        assert!(copied.expect("cp starts").success(), "copied");
        let mut command = Command::new(&copy);
        command.uid(uid).gid(uid).current_dir("/");
        command.env_remove("XDG_RUNTIME_DIR");
        let peer = Self::run(command, bus, role);
        // The process continues after its file is removed.
        std::fs::remove_file(&copy).expect("removed");
        peer
    }

    /// Starts a peer with a private, small bus folder and `/dev/shm`. Returns `None` with a message
    /// if this user may not mount.
    #[allow(clippy::print_stderr, reason = "reports that the test did not run")]
    pub(crate) fn spawn_on_small_file_systems(bus: &BusName, role: &str) -> Option<Self> {
        let apart = |script| {
            let mut command = Command::new("unshare");
            command.args(["--mount", "--map-root-user", "sh", "-c", script]);
            command
        };
        let tried = apart("mount -t tmpfs none /dev/shm").output();
        if !tried.as_ref().is_ok_and(|output| output.status.success()) {
            eprintln!("NOT RUN: could not mount private file systems: {tried:?}");
            return None;
        }
        let mut command = apart(MOUNT_SMALL_FILE_SYSTEMS);
        command
            .arg(std::env::current_exe().expect("own path"))
            .env("XDG_RUNTIME_DIR", PRIVATE_RUNTIME_DIR);
        Some(Self::run(command, bus, role))
    }

    /// Starts a peer in its own PID, network and IPC namespaces, as in a container that shares the
    /// bus. Returns `None` with a message if this user may not make namespaces.
    #[allow(clippy::print_stderr, reason = "reports that the test did not run")]
    pub(crate) fn spawn_in_namespaces(bus: &BusName, role: &str) -> Option<Self> {
        let apart = |program: &std::ffi::OsStr| {
            let mut command = Command::new("unshare");
            command.args(["--pid", "--kill-child", "--net", "--ipc", "--map-root-user"]);
            command.arg(program);
            command
        };
        let tried = apart("true".as_ref()).output();
        if !tried.as_ref().is_ok_and(|output| output.status.success()) {
            eprintln!("NOT RUN: could not make namespaces: {tried:?}");
            return None;
        }
        let test = std::env::current_exe().expect("own path");
        Some(Self::run(apart(test.as_os_str()), bus, role))
    }

    fn run(mut command: Command, bus: &BusName, role: &str) -> Self {
        command
            .args(["--exact", "peer", "--nocapture"])
            .env(ROLE, role)
            .env(BusName::ENV, bus.as_str());
        let child = command
            .stdout(Stdio::null())
            .stderr(Stdio::piped())
            .spawn()
            .expect("peer starts");
        Self { child }
    }

    pub(crate) fn pid(&self) -> u32 {
        self.child.id()
    }

    pub(crate) fn signal(&self, signal: rustix::process::Signal) {
        let pid = rustix::process::Pid::from_child(&self.child);
        rustix::process::kill_process(pid, signal).expect("the peer lives");
    }

    /// Suspends the process and waits until all its threads have stopped.
    pub(crate) fn stop(&self) {
        use rustix::process::{Signal, WaitOptions, waitpid};
        self.signal(Signal::STOP);
        let pid = rustix::process::Pid::from_child(&self.child);
        let stands = waitpid(Some(pid), WaitOptions::UNTRACED).expect("a child");
        assert!(stands.is_some_and(|(_, status)| status.stopped()));
    }

    /// Waits until the process exits successfully.
    pub(crate) fn succeed(mut self) {
        let mut message = String::new();
        let stderr = self.child.stderr.take();
        // The remaining output contains the cause.
        stderr.map(|mut stderr| stderr.read_to_string(&mut message));
        let status = self.child.wait().expect("waited");
        assert!(status.success(), "{status}:\n{message}");
    }

    pub(crate) fn kill(mut self) {
        self.end();
    }

    fn end(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

impl Drop for Peer {
    fn drop(&mut self) {
        self.end();
    }
}

/// Role and bus of a peer process; `None` in the test itself.
pub(crate) fn peer_role() -> Option<(String, BusName)> {
    let role = std::env::var(ROLE).ok()?;
    Some((role, BusName::from_env().expect("a valid name")))
}

#[allow(clippy::print_stderr, reason = "output of a peer to its test")]
pub(crate) fn ready() {
    eprintln!("ready");
}

/// Reports ready, then sleeps until killed.
pub(crate) fn sleep_until_killed() {
    ready();
    std::thread::sleep(Duration::from_secs(60));
}

/// Holds the start-up lock, as a suspended process would.
pub(crate) fn hold_startup_lock(name: &BusName) {
    let bus = Bus::join(name, "starting", Realtime::No).expect("joins");
    let mut file = std::fs::File::options()
        .write(true)
        .open(bus.folder().join("startup.lock"))
        .expect("the lock is there");
    rustix::fs::flock(&file, rustix::fs::FlockOperation::LockExclusive).expect("locked");
    writeln!(file, "{} 0 starting", std::process::id()).expect("written");
    sleep_until_killed();
}

/// Waits until a condition holds, at most 10 s.
pub(crate) fn until(what: &str, mut holds: impl FnMut() -> bool) {
    let begin = Instant::now();
    while !holds() {
        assert!(
            begin.elapsed() < Duration::from_secs(10),
            "timed out waiting until {what}"
        );
        std::thread::sleep(Duration::from_millis(1));
    }
}
