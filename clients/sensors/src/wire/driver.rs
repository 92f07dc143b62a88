//! What a sensor is to the rest of this process.

use clap::{ArgMatches, Command};

use crate::reading::{ByteCounts, Frame, Shape};

/// How a device is reached.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Way {
    /// A serial terminal: a byte stream without edges.
    Serial {
        /// Line speed, baud.
        baud: u32,
    },
    /// Datagrams of a peer `HOST[:PORT]`, one or more records each.
    Udp {
        /// The port where none is given.
        port: u16,
    },
    /// Messages of a server `ws://HOST:PORT`.
    WebSocket {
        /// The port where none is given.
        port: u16,
    },
}

/// How a sensor's zero is taken.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Zero {
    /// The device does it when it is told.
    Device,
    /// The device cannot: the mean of the first frames is subtracted here.
    Here,
}

/// What every sensor's subcommand takes and a driver may need.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Request {
    /// Frames per second that are asked for, or that the stream has.
    pub rate_hz: u32,
    /// Whether the present load shall become zero.
    pub zero: bool,
}

/// What is said to a device, and what it is expected to answer.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Dialogue {
    /// Sent once the device is connected; empty for a device that streams by itself.
    pub start: Vec<u8>,
    /// Sent once after the first `start`: takes the zero, where that is a message of its own.
    pub once: Vec<u8>,
    /// Whether `start` is acknowledged; frames before that follow old settings and are left out.
    pub acknowledged: bool,
    /// Sent for every frame, for a device that answers only when it is asked.
    pub poll: Vec<u8>,
    /// Whether `start` is sent again when nothing comes: a datagram may be lost, a device may restart.
    pub insist: bool,
    /// Sent before the end.
    pub stop: Vec<u8>,
}

/// What a driver reports while it takes bytes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Event<'a> {
    /// A valid frame of the expected shape.
    Frame(Frame<'a>),
    /// An acknowledgement: 0 for "accepted", otherwise the device's status.
    Acknowledged(u32),
    /// A valid frame of another kind than expected: what it is and which option selects it.
    Foreign(&'static str),
}

/// One device's driver: bytes in, frames out. No clock, no device, no allocation per frame where the format allows it.
pub trait Driver: Send {
    /// What every frame holds.
    fn shape(&self) -> Shape;

    /// Bits of the device's frame counter.
    fn counter_bits(&self) -> u32 {
        32
    }

    /// What to say to the device.
    fn dialogue(&self) -> Dialogue;

    /// Takes the next bytes of a stream, or one whole packet.
    fn receive(&mut self, bytes: &[u8], report: &mut dyn FnMut(Event<'_>));

    /// The stream ended: what is pending is settled. Packets leave nothing pending.
    fn finish(&mut self, _report: &mut dyn FnMut(Event<'_>)) {}

    /// What happened to the bytes so far.
    fn counts(&self) -> ByteCounts;
}

/// Makes a driver from the arguments of its subcommand, or says what is wrong.
pub type Make = fn(&ArgMatches, &Request) -> Result<Box<dyn Driver>, String>;

/// One line of the list of sensors: everything that the rest of the process knows about a kind of device.
#[derive(Clone, Copy, Debug)]
pub struct SensorType {
    /// Name of the subcommand.
    pub name: &'static str,
    /// What it is, for people.
    pub about: &'static str,
    /// Its wire, for people.
    pub wire: &'static str,
    /// How it is reached.
    pub way: Way,
    /// Taxels of one fingertip with default options.
    pub taxels: usize,
    /// Its usual rate, Hz.
    pub rate_hz: &'static str,
    /// Newtons per unit of x, y, z where the format itself says so; otherwise the unit's sheet has to.
    pub newtons_per_unit: Option<&'static str>,
    /// Which of its axes give normal and tangential forces, as it is usually mounted.
    pub axes: &'static str,
    /// How its zero is taken.
    pub zero: Zero,
    /// How a subcommand line ends, after `atas-sensor NAME`.
    pub example: &'static str,
    /// Further help.
    pub notes: &'static str,
    /// Adds the sensor's own options.
    pub options: fn(Command) -> Command,
    /// Makes a driver from them, or says what is wrong.
    pub driver: Make,
}
