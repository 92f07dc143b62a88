//! Datagrams of one peer.
//!
//! A missing or restarting peer answers "connection refused". This counts as silence, not as an
//! end: the driver repeats its request, and the health report shows missing data.

use std::io;
use std::net::{Ipv4Addr, Ipv6Addr, SocketAddr, ToSocketAddrs, UdpSocket};
use std::time::Duration;

use rustix::io::Errno;

use super::{Input, Transport, wait_readable, with_port};

/// Socket that receives from one peer only.
#[derive(Debug)]
pub struct Udp(UdpSocket);

impl Udp {
    /// Opens a socket to `HOST[:PORT]`.
    ///
    /// # Errors
    /// Cause and remedy as text.
    pub fn open(address: &str, port: u16) -> Result<Self, String> {
        let advise = |error: io::Error| format!("{error}; give the peer as HOST or HOST:PORT");
        let peer = with_port(address, port)
            .to_socket_addrs()
            .map_err(advise)?
            .next()
            .ok_or("no address found; give the peer as HOST or HOST:PORT")?;
        let any: SocketAddr = if peer.is_ipv4() {
            (Ipv4Addr::UNSPECIFIED, 0).into()
        } else {
            (Ipv6Addr::UNSPECIFIED, 0).into()
        };
        let socket = UdpSocket::bind(any).map_err(advise)?;
        socket.connect(peer).map_err(advise)?;
        socket.set_nonblocking(true).map_err(advise)?;
        Ok(Self(socket))
    }
}

impl Transport for Udp {
    fn read(&mut self, buffer: &mut [u8], timeout: Duration) -> Input {
        match wait_readable(&self.0, timeout) {
            Ok(false) | Err(Errno::INTR) => return Input::Silence,
            Ok(true) => {}
            Err(error) => return Input::Gone(error.into()),
        }
        match self.0.recv(buffer) {
            Ok(length) => Input::Bytes(length),
            Err(error) if is_silence(&error) => Input::Silence,
            Err(error) => Input::Gone(error),
        }
    }

    fn write(&mut self, bytes: &[u8]) -> io::Result<()> {
        match self.0.send(bytes) {
            Err(error) if !is_silence(&error) => Err(error),
            _ => Ok(()),
        }
    }
}

fn is_silence(error: &io::Error) -> bool {
    use io::ErrorKind::{ConnectionRefused, Interrupted, WouldBlock};
    matches!(error.kind(), ConnectionRefused | Interrupted | WouldBlock)
}
