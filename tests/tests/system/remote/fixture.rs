//! Fixture of the tests of remote operation: a daemon, a simulator and a server on a private bus,
//! and certificates of two laboratories.

use std::fs;
use std::io::Write;
use std::net::{SocketAddr, TcpListener, TcpStream};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use atas_remote::frame::{Kind, encode};
use rustix::process::Signal;
use rustls::pki_types::pem::PemObject;
use rustls::pki_types::{CertificateDer, PrivateKeyDer, ServerName};
use rustls::{ClientConfig, ClientConnection, RootCertStore, StreamOwned};
use serde_json::Value;
use shm_bus::FreshBus;
use system_tests::{Process, binary, wait_for};

/// Connection of a test without the program.
pub(super) type RawLink = StreamOwned<ClientConnection, TcpStream>;

/// A daemon, a simulator and a server.
pub(super) struct RemoteFixture {
    pub(super) server: Process,
    pub(super) address: String,
    pub(super) folder: tempfile::TempDir,
    pub(super) bus: FreshBus,
    pub(super) daemon: Process,
    _simulator: Process,
}

impl RemoteFixture {
    /// In virtual time, which stands still without a goal.
    pub(super) fn new() -> Self {
        Self::start(&["--lockstep"])
    }

    /// By the clock: the daemon ticks and publishes always.
    pub(super) fn by_the_clock() -> Self {
        Self::start(&[])
    }

    fn start(pace: &[&str]) -> Self {
        let bus = FreshBus::new("remote");
        let folder = tempfile::tempdir().expect("a folder");
        let name = bus.as_str();
        let on = [pace, &["--bus", name]].concat();
        let simulate = [&["run", "--object", "wood"], &on[..]].concat();
        let simulator = Process::start("atas-sim", &simulate);
        let control = [&["--config", "/dev/null"], &on[..]].concat();
        let daemon = Process::start("atasd", &control);
        let clients = ["alice", "display", "pendant", "stranger"];
        create_keys(
            &folder.path().join("lab"),
            &["localhost", "127.0.0.1"],
            &clients,
        );
        fs::create_dir(folder.path().join("tapes")).expect("made");
        write_config(folder.path(), name, "");
        let (server, address) = start_server(folder.path());
        let rig = Self {
            server,
            address,
            folder,
            bus,
            daemon,
            _simulator: simulator,
        };
        wait_for("the daemon", || {
            (rig.local("status").status.success()).then_some(())
        });
        rig
    }

    pub(super) fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    /// Runs a command on this machine.
    pub(super) fn local(&self, line: &str) -> Output {
        let mut command = atas(line);
        command.env("ATAS_BUS", self.bus.as_str());
        command.output().expect("it starts")
    }

    /// Ends the server by a signal; it ends within a second.
    pub(super) fn end_server(&mut self) {
        let begin = Instant::now();
        self.server.signal(Signal::TERM);
        assert!(self.server.wait().success());
        let took = begin.elapsed();
        assert!(took <= Duration::from_secs(1), "{took:?}");
    }

    /// Returns a command of a client at the server.
    pub(super) fn remote(&self, client: &str, line: &str) -> Command {
        self.remote_at(&self.address, client, line)
    }

    pub(super) fn remote_at(&self, address: &str, client: &str, line: &str) -> Command {
        let mut command = atas(line);
        command
            .args(["--remote", address, "--remote-config"])
            .arg(self.path("lab").join(client).join("remote.toml"))
            .current_dir(self.folder.path());
        command
    }

    pub(super) fn run(&self, client: &str, line: &str) -> Output {
        self.remote(client, line).output().expect("it starts")
    }

    /// Starts a goal that holds its object, and waits until it runs.
    pub(super) fn start_goal(&self, address: &str) -> Child {
        let line = "grasp --at 0.32,-0.15,0.0345 --width 50 --hold 3600 --attached";
        let child = self
            .remote_at(address, "alice", line)
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn()
            .expect("it starts");
        wait_for("the goal", || {
            (self.goal()["state"] == "running").then_some(())
        });
        child
    }

    /// Returns the goal in the daemon's status.
    pub(super) fn goal(&self) -> Value {
        last_json(&self.local("status --format json"))["goal"].clone()
    }

    /// Asserts exit code and a part of the error.
    #[track_caller]
    pub(super) fn check(&self, client: &str, line: &str, code: i32, part: &str) {
        let output = self.run(client, line);
        let printed = String::from_utf8_lossy(&output.stderr).into_owned();
        let found = output.status.code();
        assert_eq!(found, Some(code), "{client}: {line}: {printed}");
        assert!(printed.contains(part), "{client}: {line}: {printed}");
    }

    /// Opens a TLS connection with the certificate of a folder, or without one.
    pub(super) fn raw(&self, keys: Option<&Path>) -> RawLink {
        let authority = self.path("lab/ca.pem");
        let mut roots = RootCertStore::empty();
        let authority = CertificateDer::from_pem_file(authority).expect("a certificate");
        roots.add(authority).expect("an authority");
        let provider = Arc::new(rustls::crypto::ring::default_provider());
        let config = ClientConfig::builder_with_provider(provider)
            .with_protocol_versions(&[&rustls::version::TLS13])
            .expect("TLS 1.3")
            .with_root_certificates(roots);
        let mut config = match keys {
            None => config.with_no_client_auth(),
            Some(keys) => {
                let chain = CertificateDer::from_pem_file(keys.join("certificate.pem"));
                let key = PrivateKeyDer::from_pem_file(keys.join("key.pem"));
                config
                    .with_client_auth_cert(vec![chain.expect("valid")], key.expect("valid"))
                    .expect("a pair")
            }
        };
        config.alpn_protocols = vec![atas_remote::ALPN.to_vec()];
        let name = ServerName::try_from("localhost").expect("a name");
        let tls = ClientConnection::new(Arc::new(config), name).expect("a connection");
        StreamOwned::new(tls, self.socket())
    }

    /// Opens a TCP connection without TLS.
    pub(super) fn socket(&self) -> TcpStream {
        let socket = TcpStream::connect(&self.address).expect("connected");
        let timeout = Some(Duration::from_secs(30));
        socket.set_read_timeout(timeout).expect("set");
        socket
    }

    /// Sends a request with the certificate of a client and returns its connection.
    pub(super) fn raw_request(&self, client: &str, payload: &[u8]) -> RawLink {
        let mut link = self.raw(Some(&self.path("lab").join(client)));
        link.write_all(&encode(Kind::Request, payload))
            .expect("sent");
        link
    }
}

/// Creates certificates as a user does.
pub(super) fn create_keys(folder: &Path, hosts: &[&str], clients: &[&str]) {
    let mut command = atas("remote keys");
    command.arg("--out").arg(folder);
    for host in hosts {
        command.args(["--host", host]);
    }
    for client in clients {
        command.args(["--client", client]);
    }
    let output = command.output().expect("it starts");
    assert!(output.status.success(), "{output:?}");
}

/// Writes the server's configuration.
pub(super) fn write_config(folder: &Path, bus: &str, more: &str) {
    let text = format!(
        "listen = '127.0.0.1:0'\nbus = '{bus}'\ncertificate = 'lab/server/certificate.pem'\n\
         key = 'lab/server/key.pem'\nclient_ca = 'lab/server/ca.pem'\nrecordings = 'tapes'\n{more}\n\
         [clients]\nalice = 'command'\ndisplay = 'observe'\npendant = 'stop'\nformer = 'command'\n"
    );
    fs::write(folder.join("remote.toml"), text).expect("written");
}

/// Starts a server and returns its address.
pub(super) fn start_server(folder: &Path) -> (Process, String) {
    let config = folder.join("remote.toml");
    let config = config.to_str().expect("UTF-8");
    let server = Process::start("atas", &["remote", "serve", "--config", config]);
    let address = wait_for("the server", || {
        let log = server.log();
        let (_, rest) = log.split_once("certificate on ")?;
        Some(rest.lines().next()?.trim().to_owned())
    });
    (server, address)
}

/// Returns a command that depends on no user's environment.
pub(super) fn atas(line: &str) -> Command {
    let mut command = Command::new(binary("atas"));
    command
        .args(line.split_whitespace())
        .env_remove("ATAS_BUS")
        .env_remove("RUST_LOG")
        .env("HOME", "/nonexistent")
        .env_remove("XDG_CONFIG_HOME")
        .stdin(Stdio::null());
    command
}

/// Returns the last line of standard output as JSON.
pub(super) fn last_json(output: &Output) -> Value {
    let text = String::from_utf8_lossy(&output.stdout);
    serde_json::from_str(text.lines().last().unwrap_or_default()).unwrap_or(Value::Null)
}

/// A network between client and server that a test can partition: it then keeps the connections
/// open, but passes nothing on.
pub(super) struct Network {
    pub(super) address: String,
    is_cut: Arc<AtomicBool>,
}

impl Network {
    pub(super) fn to(server: &str) -> Self {
        let listener = TcpListener::bind("127.0.0.1:0").expect("a port");
        let address = listener.local_addr().expect("an address").to_string();
        let server: SocketAddr = server.parse().expect("an address");
        let is_cut = Arc::new(AtomicBool::new(false));
        let cut = Arc::clone(&is_cut);
        std::thread::spawn(move || {
            for client in listener.incoming() {
                let client = client.expect("accepted");
                let server = TcpStream::connect(server).expect("connected");
                let back = (server.try_clone(), client.try_clone());
                pass_on(client, server, Arc::clone(&cut));
                pass_on(
                    back.0.expect("a copy"),
                    back.1.expect("a copy"),
                    Arc::clone(&cut),
                );
            }
        });
        Self { address, is_cut }
    }

    pub(super) fn cut(&self) {
        self.is_cut.store(true, Ordering::SeqCst);
    }
}

/// Passes bytes on in a thread, until an end closes or the network is cut.
fn pass_on(mut from: TcpStream, mut to: TcpStream, is_cut: Arc<AtomicBool>) {
    std::thread::spawn(move || {
        let mut bytes = [0; 4096];
        loop {
            let read = std::io::Read::read(&mut from, &mut bytes);
            while is_cut.load(Ordering::SeqCst) {
                std::thread::sleep(Duration::from_millis(10));
            }
            let Ok(count @ 1..) = read else { break };
            if to.write_all(&bytes[..count]).is_err() {
                break;
            }
        }
        // The other end may have closed already.
        let _ = to.shutdown(std::net::Shutdown::Write);
    });
}
