//! Interface between a sensor driver and the rest of the process.

use clap::{ArgMatches, Command};

use crate::reading::{ByteCounts, Frame, Shape};

/// Transport of a device.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Interface {
    /// Serial terminal: a byte stream.
    Serial {
        /// Line speed, baud.
        baud: u32,
    },
    /// Datagrams of a peer `HOST[:PORT]`, one or more records each.
    Udp {
        /// Default port.
        port: u16,
    },
    /// Messages of a server `ws://HOST:PORT`.
    WebSocket {
        /// Default port.
        port: u16,
    },
}

/// Method of zeroing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Zero {
    /// The device zeroes on request.
    Device,
    /// This process subtracts the mean of the first frames.
    Host,
}

/// Options of every sensor subcommand that a driver may need.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Request {
    /// Requested frame rate, or rate of the stream, Hz.
    pub rate_hz: u32,
    /// True to make the present load zero.
    pub zero: bool,
}

/// Messages to a device, and its expected answers.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct DeviceMessages {
    /// Message after connecting; empty for a device that streams without a request.
    pub start: Vec<u8>,
    /// Message after the first `start` only: zeroes the device, if that is a separate message.
    pub once: Vec<u8>,
    /// True if the device acknowledges `start`. Earlier frames have old settings and are skipped.
    pub acknowledged: bool,
    /// Request for each frame, for a polled device.
    pub poll: Vec<u8>,
    /// True if `start` is repeated during silence: a datagram may be lost, a device may restart.
    pub repeat_start: bool,
    /// Message before the end.
    pub stop: Vec<u8>,
}

/// Event of a driver while it processes bytes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Event<'a> {
    /// Valid frame of the expected shape.
    Frame(Frame<'a>),
    /// Acknowledgement: 0 for "accepted", otherwise the device's status.
    Acknowledged(u32),
    /// Valid frame of another kind, with the option that selects it.
    OtherKind(&'static str),
}

/// Driver of one device: bytes in, frames out. No clock, no device, no allocation per frame where
/// the format allows it.
pub trait Driver: Send {
    /// Returns the shape of every frame.
    fn shape(&self) -> Shape;

    /// Returns the width of the device's frame counter, bits.
    fn counter_bits(&self) -> u32 {
        32
    }

    /// Returns the messages to the device.
    fn messages(&self) -> DeviceMessages;

    /// Processes the next bytes of a stream, or one complete packet.
    fn receive(&mut self, bytes: &[u8], report: &mut dyn FnMut(Event<'_>));

    /// Ends the stream and decides pending bytes. Packets leave none pending.
    fn finish(&mut self, _report: &mut dyn FnMut(Event<'_>)) {}

    /// Returns the byte counts so far.
    fn counts(&self) -> ByteCounts;
}

/// Creates a driver from the arguments of its subcommand, or returns an error text.
pub type Make = fn(&ArgMatches, &Request) -> Result<Box<dyn Driver>, String>;

/// Entry of the list of sensors: all properties of a kind of device.
#[derive(Clone, Copy, Debug)]
pub struct SensorType {
    /// Name of the subcommand.
    pub name: &'static str,
    /// Description.
    pub about: &'static str,
    /// Description of the interface.
    pub wire: &'static str,
    /// Transport.
    pub interface: Interface,
    /// Taxels of one fingertip with default options.
    pub taxels: usize,
    /// Typical rate, Hz.
    pub rate_hz: &'static str,
    /// Newtons per unit of x, y, z if the format defines it; otherwise the unit's data sheet does.
    pub newtons_per_unit: Option<&'static str>,
    /// Axes of the normal and tangential forces in the usual mounting.
    pub axes: &'static str,
    /// Method of zeroing.
    pub zero: Zero,
    /// End of an example command line, after `atas-sensor NAME`.
    pub example: &'static str,
    /// Further help.
    pub notes: &'static str,
    /// Adds the options of the sensor.
    pub options: fn(Command) -> Command,
    /// Creates a driver from the options.
    pub driver: Make,
}
