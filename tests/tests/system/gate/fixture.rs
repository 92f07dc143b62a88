//! Fixture of the gate tests: a daemon, a robot and a gate that run as the service user, and
//! clients of other users.

use std::fs::{self, File, Permissions};
use std::os::fd::OwnedFd;
use std::os::unix::fs::{MetadataExt, PermissionsExt, chown};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};

use atas_gate::message::{self, Reply};
use rustix::net::{
    AddressFamily, RecvFlags, SocketAddrUnix, SocketFlags, SocketType, bind, connect, listen, recv,
    socket_with,
};
use rustix::process::{Pid, geteuid};
use serde_json::Value;
use shm_bus::BusName;
use system_tests::{Process, binary, skip_or_fail, wait_for};

/// Unassigned user ids: above those of people, below the dynamic range of systemd.
pub(super) const SERVICE: u32 = 60_601;
pub(super) const MEMBER: u32 = 60_602;
pub(super) const OTHER_MEMBER: u32 = 60_603;
pub(super) const STRANGER: u32 = 60_604;

/// A daemon, a robot and a gate that run as the service user.
pub(super) struct GateFixture {
    pub(super) bus: BusName,
    pub(super) folder: tempfile::TempDir,
    pub(super) programs: PathBuf,
    pub(super) gate_socket: OwnedFd,
    pub(super) gate: Option<Child>,
    pub(super) daemon: Option<Process>,
    pub(super) _robot: Process,
}

impl GateFixture {
    /// Starts all processes; `None`, with a message, if this process may not change its user.
    pub(super) fn new() -> Option<Self> {
        if !geteuid().is_root() {
            skip_or_fail(
                "only root can switch to the users of the gate tests; run the tests as root",
            );
            return None;
        }
        let folder = tempfile::tempdir().expect("a folder");
        fs::set_permissions(folder.path(), Permissions::from_mode(0o755)).expect("set");
        let programs = executable_folder(folder.path());
        let bus = BusName::fresh("gate");
        let on = ["--lockstep", "--bus", bus.as_str()];
        let robot = [&["run", "--object", "wood"], &on[..]].concat();
        let robot = start_as(SERVICE, &programs.join("atas-sim"), &robot);
        let house = Self {
            gate_socket: create_gate_socket(&folder.path().join("gate.sock")),
            daemon: Some(daemon(&programs, &bus)),
            bus,
            folder,
            programs,
            gate: None,
            _robot: robot,
        };
        let mut house = house;
        house.set_group_access("observe");
        house.start_gate();
        wait_for("the daemon", || {
            (house.code(MEMBER, &["status"]) == 0).then_some(())
        });
        Some(house)
    }

    pub(super) fn config(&self) -> PathBuf {
        self.folder.path().join("atas.toml")
    }

    pub(super) fn set_group_access(&self, right: &str) {
        fs::write(self.config(), format!("access.group = \"{right}\"\n")).expect("written");
    }

    /// Starts the gate as systemd does: as the service user, with the socket as standard input.
    pub(super) fn start_gate(&mut self) {
        let log = File::options()
            .append(true)
            .create(true)
            .open(self.folder.path().join("log"));
        let gate = as_user(SERVICE, &[], &self.programs.join("atas-gate"))
            .arg("--config")
            .arg(self.config())
            .stdin(Stdio::from(
                self.gate_socket.try_clone().expect("another handle"),
            ))
            .stdout(Stdio::null())
            .stderr(log.expect("writable"))
            .spawn();
        self.gate = Some(gate.expect("the gate starts"));
    }

    pub(super) fn log(&self) -> String {
        fs::read_to_string(self.folder.path().join("log")).unwrap_or_default()
    }

    /// Kills the gate, but not the commands that it started.
    pub(super) fn kill_gate(&mut self) {
        let mut gate = self.gate.take().expect("a running gate");
        gate.kill().expect("killed");
        gate.wait().expect("ended");
    }

    pub(super) fn socket(&self) -> PathBuf {
        self.folder.path().join("gate.sock")
    }

    /// Returns an `atas` command of a user. All users except the stranger are in the service group.
    pub(super) fn atas(&self, user: u32, arguments: &[&str]) -> Command {
        let groups: &[u32] = if user == STRANGER { &[] } else { &[SERVICE] };
        let mut command = as_user(user, groups, &self.programs.join("atas"));
        command
            .args(arguments)
            .env(message::SOCKET_ENV, self.socket())
            .env("ATAS_BUS", self.bus.as_str())
            .env("TERM", "xterm-256color")
            .env_remove("NO_COLOR")
            .env_remove("RUST_LOG")
            .stdin(Stdio::null());
        command
    }

    pub(super) fn run(&self, user: u32, arguments: &[&str]) -> Output {
        self.atas(user, arguments).output().expect("atas starts")
    }

    pub(super) fn code(&self, user: u32, arguments: &[&str]) -> i32 {
        self.run(user, arguments)
            .status
            .code()
            .expect("an exit code")
    }

    /// Runs a command and returns its JSON output.
    pub(super) fn json(&self, user: u32, arguments: &[&str]) -> Value {
        let words = [arguments, &["--format", "json"]].concat();
        let output = self.run(user, &words);
        assert!(output.status.success(), "{arguments:?}: {output:?}");
        let text = String::from_utf8(output.stdout).expect("UTF-8");
        serde_json::from_str(text.lines().last().expect("a line")).expect("JSON")
    }

    /// Asserts the exit code and a part of the one-line error.
    #[track_caller]
    pub(super) fn check(&self, user: u32, arguments: &[&str], code: i32, part: &str) {
        let output = self.run(user, arguments);
        let printed = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(code), "{arguments:?}: {printed}");
        assert!(printed.contains(part), "{arguments:?}: {printed}");
        assert!(printed.lines().count() <= 1, "{arguments:?}: {printed}");
    }

    /// Returns the service user's processes whose command line contains this word.
    pub(super) fn running(&self, word: &str) -> Vec<Pid> {
        let processes = fs::read_dir("/proc").expect("proc").flatten();
        let ours = processes.filter(|process| process.metadata().is_ok_and(|m| m.uid() == SERVICE));
        let states = |path: &Path| {
            let line = fs::read(path.join("cmdline")).unwrap_or_default();
            line.split(|b| *b == 0)
                .any(|stderr_text| stderr_text == word.as_bytes())
        };
        ours.filter(|process| states(&process.path()))
            .filter_map(|process| process.file_name().to_str()?.parse().ok())
            .filter_map(Pid::from_raw)
            .collect()
    }

    /// Connects as root, without a client program.
    pub(super) fn connect_as_root(&self) -> OwnedFd {
        let socket = socket_with(
            AddressFamily::UNIX,
            SocketType::SEQPACKET,
            SocketFlags::CLOEXEC,
            None,
        );
        let socket = socket.expect("a socket");
        connect(&socket, &SocketAddrUnix::new(self.socket()).expect("short")).expect("connected");
        socket
    }
}

impl Drop for GateFixture {
    fn drop(&mut self) {
        if let Some(mut gate) = self.gate.take() {
            // The gate may already have ended.
            let _ended = gate.kill();
            let _status = gate.wait();
        }
        if std::thread::panicking() {
            system_tests::report_skipped(&format!("log of the gate:\n{}", self.log()));
        }
        drop(self.daemon.take());
        // Another user owns the bus and only that user may wipe it; root removes its files.
        for user in [SERVICE, MEMBER] {
            let _ = fs::remove_dir_all(format!("/dev/shm/atas-{user}"));
        }
        for entry in fs::read_dir("/dev/shm").into_iter().flatten().flatten() {
            if entry
                .metadata()
                .is_ok_and(|meta| [SERVICE, MEMBER].contains(&meta.uid()))
            {
                let _ = fs::remove_file(entry.path());
            }
        }
    }
}

/// Returns a command that runs as another user in exactly these groups.
pub(super) fn as_user(uid: u32, groups: &[u32], program: &Path) -> Command {
    let mut command = Command::new("setpriv");
    command
        .arg(format!("--reuid={uid}"))
        .arg(format!("--regid={uid}"));
    if groups.is_empty() {
        command.arg("--clear-groups");
    } else {
        let groups: Vec<String> = groups.iter().map(u32::to_string).collect();
        command.arg(format!("--groups={}", groups.join(",")));
    }
    command.arg("--").arg(program).env_remove("XDG_RUNTIME_DIR");
    command
}

pub(super) fn start_as(uid: u32, program: &Path, arguments: &[&str]) -> Process {
    let user = [format!("--reuid={uid}"), format!("--regid={uid}")];
    let program = program.to_str().expect("UTF-8");
    let words = [
        &[&user[0], &user[1], "--clear-groups", "--", program],
        arguments,
    ]
    .concat();
    Process::start_program(Path::new("setpriv"), &words)
}

pub(super) fn daemon(programs: &Path, bus: &BusName) -> Process {
    let words = ["--lockstep", "--config", "/dev/null", "--bus", bus.as_str()];
    start_as(SERVICE, &programs.join("atasd"), &words)
}

/// Returns a folder of programs that every user may run: the build folder, or copies.
pub(super) fn executable_folder(folder: &Path) -> PathBuf {
    let built = binary("atas");
    let may_run = as_user(STRANGER, &[], &built).arg("--version").output();
    if may_run.expect("setpriv starts").status.success() {
        return built.parent().expect("a folder").to_owned();
    }
    for name in [
        "atas",
        "atas-demo",
        "atas-gate",
        "atas-lab",
        "atas-sim",
        "atasd",
    ] {
        // `cp` runs in its own process: a file that a child of another thread holds open for
        // writing cannot be executed.
        let copied = Command::new("cp")
            .args([binary(name), folder.join(name)])
            .status();
        assert!(copied.expect("cp starts").success(), "{name} copied");
    }
    folder.to_owned()
}

/// Creates the socket as its systemd unit does.
pub(super) fn create_gate_socket(path: &Path) -> OwnedFd {
    let door = socket_with(
        AddressFamily::UNIX,
        SocketType::SEQPACKET,
        SocketFlags::CLOEXEC,
        None,
    );
    let door = door.expect("a socket");
    bind(&door, &SocketAddrUnix::new(path).expect("short")).expect("bound");
    chown(path, Some(0), Some(SERVICE)).expect("the group owns the socket");
    fs::set_permissions(path, Permissions::from_mode(0o660)).expect("set");
    listen(&door, 64).expect("listening");
    door
}

pub(super) fn receive_reply(socket: &OwnedFd) -> Option<Reply> {
    let mut packet = [0; 4096];
    let mut receive = || recv(socket, &mut packet, RecvFlags::empty());
    // If the peer closed with unread data, the first call returns the reset and the second its
    // message.
    let (_, bytes) = receive().or_else(|_| receive()).unwrap_or((0, 0));
    (bytes > 0).then(|| serde_json::from_slice(&packet[..bytes]).expect("a reply"))
}
