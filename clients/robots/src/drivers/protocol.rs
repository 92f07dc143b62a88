//! Protocols of the servo families.

/// Protocol of a port.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Protocol {
    /// Dynamixel protocol 1.0, Feetech variant: the status of a reply is a set of alarms.
    One,
    /// Dynamixel protocol 2.0: the status of a reply is an error number and an alert bit.
    Two,
}
