//! Transports of a device: serial terminals, datagrams, WebSocket messages, behind one trait.
//!
//! Reads of a stream end at arbitrary bytes. A datagram or message arrives complete, one per read.

pub mod serial;
pub mod udp;
pub mod websocket;

use std::io;
use std::os::fd::AsFd;
use std::path::Path;
use std::time::Duration;

use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::io::Errno;

use crate::wire::Interface;

/// Largest number of bytes per read: the largest datagram, more than any message of a sensor
/// server.
pub const READ_BYTES: usize = 1 << 16;

/// Result of a read.
#[derive(Debug)]
pub enum Input {
    /// Number of bytes.
    Bytes(usize),
    /// No data within the timeout, or a signal.
    Silence,
    /// End of a recording.
    End,
    /// The device is gone.
    Gone(io::Error),
}

/// Open connection to one device.
pub trait Transport: Send {
    /// Waits for bytes and reads them.
    fn read(&mut self, buffer: &mut [u8], timeout: Duration) -> Input;

    /// Sends bytes.
    ///
    /// # Errors
    /// The device accepts no data, is gone, or does not accept them in time.
    fn write(&mut self, bytes: &[u8]) -> io::Result<()>;

    /// Returns true if the device accepts messages.
    fn accepts_messages(&self) -> bool {
        true
    }

    /// Returns true for a regular file, which has an end and no rate.
    fn is_recording(&self) -> bool {
        false
    }
}

/// Opens a device by its path or address.
///
/// # Errors
/// Cause and remedy as text.
pub fn open(way: Interface, device: &str) -> Result<Box<dyn Transport>, String> {
    Ok(match way {
        Interface::Serial { baud } => Box::new(serial::Device::open(Path::new(device), baud)?),
        Interface::Udp { port } => Box::new(udp::Udp::open(device, port)?),
        Interface::WebSocket { port } => Box::new(websocket::Client::open(device, port)?),
    })
}

/// Waits until data can be read. Returns false after the timeout.
fn wait_readable(source: &impl AsFd, timeout: Duration) -> Result<bool, Errno> {
    let timeout = Timespec {
        tv_sec: timeout.as_secs().cast_signed(),
        tv_nsec: timeout.subsec_nanos().into(),
    };
    let ready = poll(&mut [PollFd::new(source, PollFlags::IN)], Some(&timeout))?;
    Ok(ready > 0)
}

/// Returns the address, with the default port if it has none.
fn with_port(address: &str, port: u16) -> String {
    let host = address.rsplit_once(']').map_or(address, |(_, tail)| tail);
    if host.contains(':') {
        address.to_owned()
    } else {
        format!("{address}:{port}")
    }
}
