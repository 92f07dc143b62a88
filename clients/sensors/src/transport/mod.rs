//! How bytes reach this process: serial terminals, datagrams, WebSocket messages, all behind one trait.
//!
//! A stream is cut anywhere; a datagram or a message arrives whole, one per read.

pub mod serial;
pub mod udp;
pub mod websocket;

use std::io;
use std::os::fd::AsFd;
use std::path::Path;
use std::time::Duration;

use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::io::Errno;

use crate::wire::Way;

/// Bytes that a read may bring at most: the largest datagram, and more than any message of a sensor server.
pub const READ_BYTES: usize = 1 << 16;

/// What a read brought.
#[derive(Debug)]
pub enum Input {
    /// So many bytes.
    Bytes(usize),
    /// Nothing within the time-out, or a signal came.
    Quiet,
    /// The end of a recording.
    End,
    /// The device is gone.
    Gone(io::Error),
}

/// An open connection to one device.
pub trait Transport: Send {
    /// Waits for bytes and reads them.
    fn read(&mut self, buffer: &mut [u8], timeout: Duration) -> Input;

    /// Sends bytes.
    ///
    /// # Errors
    /// When the device cannot be told anything, is gone, or does not take them in time.
    fn write(&mut self, bytes: &[u8]) -> io::Result<()>;

    /// Whether the device can be told anything.
    fn takes_messages(&self) -> bool {
        true
    }

    /// Whether this is a regular file, which has an end and no pace of its own.
    fn is_recording(&self) -> bool {
        false
    }
}

/// Opens a device by its path or address.
///
/// # Errors
/// A sentence that says what is wrong and what to do.
pub fn open(way: Way, device: &str) -> Result<Box<dyn Transport>, String> {
    Ok(match way {
        Way::Serial { baud } => Box::new(serial::Device::open(Path::new(device), baud)?),
        Way::Udp { port } => Box::new(udp::Udp::open(device, port)?),
        Way::WebSocket { port } => Box::new(websocket::Client::open(device, port)?),
    })
}

/// Waits until something can be read. False when the time is up.
fn wait_readable(source: &impl AsFd, timeout: Duration) -> Result<bool, Errno> {
    let timeout = Timespec {
        tv_sec: timeout.as_secs().cast_signed(),
        tv_nsec: timeout.subsec_nanos().into(),
    };
    let ready = poll(&mut [PollFd::new(source, PollFlags::IN)], Some(&timeout))?;
    Ok(ready > 0)
}

/// The address with the usual port where it names none.
fn with_port(address: &str, port: u16) -> String {
    let host = address.rsplit_once(']').map_or(address, |(_, tail)| tail);
    if host.contains(':') {
        address.to_owned()
    } else {
        format!("{address}:{port}")
    }
}
