//! Serial port that delivers whole reply packets only.
//!
//! Adapters and lines add bytes that are no reply: glitches when the direction of the line turns,
//! remains of a late reply, and the requests themselves if the adapter echoes them. Like the
//! vendors' clients, this port skips bytes before a header. It also removes echoes, even if an echo
//! arrives after the next request, as that of a request without reply can.
//!
//! ```text
//!  port ─▶ bytes ─▶ header found, packet complete, no echo ─▶ reader of the protocol
//! ```
//!
//! The reader of the protocol checks id and checksum.

// Numbers of a file or a device reach this arithmetic.
#![warn(clippy::arithmetic_side_effects)]

use std::collections::VecDeque;
use std::io::{self, Read, Write};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use serialport::{ClearBuffer, DataBits, FlowControl, Parity, Result, SerialPort, StopBits};

use super::protocol::Protocol;

/// Largest parameters of a packet of protocol 2.0, bytes: a bulk reply of 250 servos with four.
const LENGTH_MAX: usize = 1 << 10;
/// Requests whose echoes may still arrive. Design choice: the last one, and as many before it as
/// two cycles have.
const UNECHOED_MAX: usize = 4;
/// Reads after which a line that does not become quiet is used nevertheless. Design choice.
const READS_UNTIL_QUIET: usize = 16;

/// The port.
pub(super) struct PacketPort {
    port: Box<dyn SerialPort>,
    protocol: Protocol,
    /// The last request; if the adapter echoes, also those before it without echo so far.
    unechoed: VecDeque<Vec<u8>>,
    received: Vec<u8>,
    /// Rest of the packet that is being read.
    packet: io::Cursor<Vec<u8>>,
    echoes: Arc<AtomicBool>,
}

/// Result of a search for a packet.
#[derive(Debug, PartialEq, Eq)]
enum Search {
    /// More bytes are needed.
    Incomplete,
    /// The packet begins and ends here.
    Packet(usize, usize),
}

impl PacketPort {
    /// Wraps a port; `echoes` becomes true when an echo is received.
    pub(super) fn new(
        port: Box<dyn SerialPort>,
        protocol: Protocol,
        echoes: Arc<AtomicBool>,
    ) -> Self {
        Self {
            port,
            protocol,
            unechoed: VecDeque::new(),
            received: Vec::new(),
            packet: io::Cursor::default(),
            echoes,
        }
    }

    /// Discards bytes until none came for the timeout. The protocols have no sequence numbers: a
    /// late reply would be taken for that of the next request.
    pub(super) fn wait_until_quiet(&mut self) {
        let mut chunk = [0; 256];
        for _ in 0..READS_UNTIL_QUIET {
            // A failure of the port is reported by the next exchange.
            if !matches!(self.port.read(&mut chunk), Ok(1..)) {
                break;
            }
        }
    }

    /// Takes the next complete packet that is not the echo of a request.
    fn take_packet(&mut self) -> Option<Vec<u8>> {
        while let Search::Packet(begin, end) = find(self.protocol, &self.received) {
            let packet = self.received[begin..end].to_vec();
            self.received.drain(..end);
            let Some(echoed) = self.unechoed.iter().position(|sent| *sent == packet) else {
                return Some(packet);
            };
            self.echoes.store(true, Ordering::Relaxed);
            // Echoes come in order. A second equal packet is a reply.
            self.unechoed.drain(..=echoed);
        }
        None
    }
}

/// Finds the first packet.
fn find(protocol: Protocol, bytes: &[u8]) -> Search {
    for begin in 0..bytes.len() {
        let rest = &bytes[begin..];
        let length = match (protocol, rest) {
            // An id of 0xFF does not exist: the header begins later.
            (Protocol::One, [0xFF, 0xFF, id, length, ..]) if *id != 0xFF && *length >= 2 => {
                usize::from(*length).saturating_add(4)
            }
            (Protocol::Two, [0xFF, 0xFF, 0xFD, 0x00, _, low, high, ..]) => {
                match usize::from(u16::from_le_bytes([*low, *high])) {
                    length @ 3..=LENGTH_MAX => length.saturating_add(7),
                    _ => continue,
                }
            }
            // Too short to decide.
            _ if is_begin(protocol, rest) => return Search::Incomplete,
            _ => continue,
        };
        let end = begin.saturating_add(length);
        return match bytes.get(begin..end) {
            Some(_) => Search::Packet(begin, end),
            None => Search::Incomplete,
        };
    }
    Search::Incomplete
}

/// Returns true if these bytes can be the begin of a packet that has not arrived yet.
fn is_begin(protocol: Protocol, bytes: &[u8]) -> bool {
    match protocol {
        Protocol::One => bytes.len() < 4 && [0xFF, 0xFF].starts_with(&bytes[..bytes.len().min(2)]),
        Protocol::Two => {
            let header = [0xFF, 0xFF, 0xFD, 0x00];
            bytes.len() < 7 && header.starts_with(&bytes[..bytes.len().min(4)])
        }
    }
}

impl Read for PacketPort {
    /// Fails with `TimedOut` without any reply, with `InvalidData` if only parts of one came.
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        loop {
            let count = self.packet.read(buffer)?;
            if count > 0 || buffer.is_empty() {
                return Ok(count);
            }
            if let Some(packet) = self.take_packet() {
                self.packet = io::Cursor::new(packet);
                continue;
            }
            let mut chunk = [0; 256];
            match self.port.read(&mut chunk) {
                Ok(0) => return Ok(0),
                Ok(count) => self.received.extend_from_slice(&chunk[..count]),
                Err(error) if error.kind() == io::ErrorKind::TimedOut => {
                    return Err(match self.received.is_empty() {
                        true => error,
                        false => io::ErrorKind::InvalidData.into(),
                    });
                }
                Err(error) => return Err(error),
            }
        }
    }
}

impl Write for PacketPort {
    /// Writes a request; discards what came before it.
    fn write(&mut self, request: &[u8]) -> io::Result<usize> {
        self.port.clear(ClearBuffer::Input)?;
        self.received.clear();
        self.packet = io::Cursor::default();
        if !self.echoes.load(Ordering::Relaxed) {
            self.unechoed.clear();
        }
        if self.unechoed.len() == UNECHOED_MAX {
            self.unechoed.pop_front();
        }
        self.unechoed.push_back(request.to_vec());
        self.port.write_all(request)?;
        Ok(request.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        self.port.flush()
    }
}

/// Passes settings of the line on to the wrapped port.
macro_rules! pass_on {
    (get $($get:ident: $value:ty),*; set $($set:ident: $new:ty),*; read $($read:ident),*) => {
        $(fn $get(&self) -> Result<$value> {
            self.port.$get()
        })*
        $(fn $set(&mut self, value: $new) -> Result<()> {
            self.port.$set(value)
        })*
        $(fn $read(&mut self) -> Result<bool> {
            self.port.$read()
        })*
    };
}

impl SerialPort for PacketPort {
    /// Returns 0: what came before a request is discarded when it is written.
    fn bytes_to_read(&self) -> Result<u32> {
        Ok(0)
    }

    fn name(&self) -> Option<String> {
        self.port.name()
    }

    fn timeout(&self) -> Duration {
        self.port.timeout()
    }

    fn clear(&self, buffer: ClearBuffer) -> Result<()> {
        self.port.clear(buffer)
    }

    fn try_clone(&self) -> Result<Box<dyn SerialPort>> {
        Ok(Box::new(Self::new(
            self.port.try_clone()?,
            self.protocol,
            Arc::clone(&self.echoes),
        )))
    }

    pass_on! {
        get baud_rate: u32, data_bits: DataBits, flow_control: FlowControl, parity: Parity,
            stop_bits: StopBits, bytes_to_write: u32, set_break: (), clear_break: ();
        set set_baud_rate: u32, set_data_bits: DataBits, set_flow_control: FlowControl,
            set_parity: Parity, set_stop_bits: StopBits, set_timeout: Duration,
            write_request_to_send: bool, write_data_terminal_ready: bool;
        read read_clear_to_send, read_data_set_ready, read_ring_indicator, read_carrier_detect
    }
}

#[cfg(test)]
#[allow(clippy::arithmetic_side_effects, reason = "numbers of the tests only")]
mod tests {
    use super::*;

    #[test]
    fn packets_are_found_behind_other_bytes() {
        let check = |protocol, bytes: &[u8], expected| {
            assert_eq!(find(protocol, bytes), expected, "{bytes:x?}");
        };
        let one = [0xFF, 0xFF, 1, 3, 0, 7, 0xF4];
        let two = [0xFF, 0xFF, 0xFD, 0, 1, 4, 0, 0x55, 0, 0xA1, 0x0C];
        for junk in [
            &[][..],
            &[0xFF],
            &[0, 0xFF],
            &[0x3C, 0xFF, 0xFF, 0xFF],
            &[7; 9],
        ] {
            for (protocol, packet) in [(Protocol::One, &one[..]), (Protocol::Two, &two[..])] {
                let bytes = [junk, packet, &[0xFF, 0xFF]].concat();
                let found = Search::Packet(junk.len(), junk.len() + packet.len());
                check(protocol, &bytes, found);
                for end in 0..junk.len() + packet.len() {
                    check(protocol, &bytes[..end], Search::Incomplete);
                }
            }
        }
        // A length that no packet has is no header.
        check(Protocol::One, &[0xFF, 0xFF, 1, 0, 0, 0], Search::Incomplete);
        let long = [&[0xFF, 0xFF, 0xFD, 0, 1, 0xFF, 0xFF][..], &two].concat();
        check(Protocol::Two, &long, Search::Packet(7, 18));
    }
}
