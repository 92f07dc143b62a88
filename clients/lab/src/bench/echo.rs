//! Echo process of the transport benchmark: answers until it is terminated.

use std::io::{ErrorKind, Read, Write};
use std::os::unix::net::{UnixListener, UnixStream};
use std::path::Path;

use anyhow::Context;
use atas_console::Interrupt;
use atas_console::arguments::EchoTransport;
use shm_bus::{Bus, BusName, Realtime};
use shm_schemas::{HandFrame, JointCommand, JointState, service};

/// Payload size in each direction, bytes.
pub(super) const PAYLOAD_BYTES: usize = size_of::<HandFrame>();

/// `atas bench echo`: answers until SIGTERM.
pub(super) fn run(
    by: EchoTransport,
    bus: &BusName,
    socket: &Path,
    interrupt: &Interrupt,
) -> anyhow::Result<()> {
    match by {
        EchoTransport::Iceoryx2 => frames(bus, interrupt),
        EchoTransport::UnixSocket => bytes(socket, interrupt),
        EchoTransport::Words => words(bus, interrupt),
    }
}

fn frames(name: &BusName, interrupt: &Interrupt) -> anyhow::Result<()> {
    let bus = Bus::open(name, "echo", Realtime::Yes)?;
    let [there, back] = service::HAND_FRAME;
    let mut pings = bus.subscriber::<HandFrame>(there)?;
    let pongs = bus.publisher::<HandFrame>(back)?;
    let mut frame = HandFrame::default();
    while !interrupt.is_set() {
        if pings.newest(&mut frame)? {
            pongs.send(&frame)?;
        }
        std::hint::spin_loop();
    }
    Ok(())
}

fn words(name: &BusName, interrupt: &Interrupt) -> anyhow::Result<()> {
    let bus = Bus::open(name, "echo", Realtime::Yes)?;
    let [left, right] = service::HAND_FRAME;
    let mut frames = [
        bus.subscriber::<HandFrame>(left)?,
        bus.subscriber::<HandFrame>(right)?,
    ];
    let mut states = bus.subscriber::<JointState>(service::JOINT_STATE)?;
    let commands = bus.publisher::<JointCommand>(service::JOINT_COMMAND)?;
    let (mut frame, mut state) = (HandFrame::default(), JointState::default());
    let mut command = JointCommand::default();
    while !interrupt.is_set() {
        if states.newest(&mut state)? {
            for port in &mut frames {
                port.newest(&mut frame)?;
            }
            command.answers_sequence = state.stamp.sequence;
            commands.send(&command)?;
        }
        std::hint::spin_loop();
    }
    Ok(())
}

fn bytes(path: &Path, interrupt: &Interrupt) -> anyhow::Result<()> {
    let listener = UnixListener::bind(path);
    let listener = listener.with_context(|| format!("could not listen at {}", path.display()))?;
    let (mut stream, _) = listener.accept().context("could not accept")?;
    stream.set_nonblocking(true)?;
    let mut bytes = [0; PAYLOAD_BYTES];
    while !interrupt.is_set() && read_polling(&mut stream, &mut bytes, interrupt)? {
        stream.write_all(&bytes)?;
    }
    Ok(())
}

/// Reads a whole payload from a non-blocking stream by polling, as with shared memory. Returns
/// false on end of stream or a signal.
pub(super) fn read_polling(
    stream: &mut UnixStream,
    bytes: &mut [u8],
    interrupt: &Interrupt,
) -> anyhow::Result<bool> {
    let mut filled = 0;
    while filled < bytes.len() {
        match stream.read(&mut bytes[filled..]) {
            Ok(0) => return Ok(false),
            Ok(count) => filled += count,
            Err(error) if error.kind() == ErrorKind::WouldBlock => {
                if interrupt.is_set() {
                    return Ok(false);
                }
                std::hint::spin_loop();
            }
            Err(error) => return Err(error).context("could not read from the socket"),
        }
    }
    Ok(true)
}
