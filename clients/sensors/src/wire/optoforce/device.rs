//! Driver of OptoForce devices and the options of its subcommand.

use clap::{ArgMatches, Args, FromArgMatches, ValueEnum};

use super::{BAUD, Configuration, DataFrame, Decoder, DeviceStatus, Filter, Kind, MAX_VALUES};
use super::{Message, STOP, Speed};
use crate::reading::{ByteCounts, Condition, Frame, Quantity, Shape};
use crate::wire::{DeviceMessages, Driver, Event, Interface, Request, SensorType, Zero};

/// Entry in the list of sensors.
pub const TYPE: SensorType = SensorType {
    name: "optoforce",
    about: "OptoForce / OnRobot OMD three-axis domes and six-axis sensors on a serial port",
    wire: "serial, 1000000 baud 8N1, big-endian frames with a 16-bit sum",
    interface: Interface::Serial { baud: BAUD },
    taxels: 1,
    rate_hz: "1000",
    newtons_per_unit: None,
    axes: "-z,x,y",
    zero: Zero::Device,
    example: "--device /dev/ttyUSB0 --hand left --newtons-per-count 300/7925,300/8641,2000/6049",
    notes: "If frames come in bursts of 16: a USB bridge collects them. Write 1 to \
            /sys/bus/usb-serial/devices/ttyUSB0/latency_timer.",
    options: <Options as Args>::augment_args,
    driver: make,
};

/// Kind of frames of the device.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Channels {
    /// One three-axis dome.
    #[value(name = "1")]
    One,
    /// Four three-axis domes on one converter: dome i is finger i.
    #[value(name = "4")]
    Four,
    /// One six-axis sensor; the bus carries its force, the dry run also its torque.
    SixAxis,
}

#[derive(Debug, Args)]
struct Options {
    /// Kind of frames of the device
    #[arg(long, value_enum, default_value = "1")]
    channels: Channels,
    /// Low-pass of the device, Hz: 500, 150, 50, 15, 5, 1.5, or 0 for none.
    #[arg(long, default_value_t = 0.0)]
    filter_hz: f64,
}

fn make(matches: &ArgMatches, request: &Request) -> Result<Box<dyn Driver>, String> {
    let options = Options::from_arg_matches(matches).map_err(|error| error.to_string())?;
    let speed = Speed::from_hz(request.rate_hz)
        .map_err(|error| format!("could not use --rate-hz: {error}"))?;
    let filter = Filter::from_hz(options.filter_hz)
        .map_err(|error| format!("could not use --filter-hz: {error}"))?;
    let kind = match options.channels {
        Channels::One => Kind::OneChannel,
        Channels::Four => Kind::FourChannel,
        Channels::SixAxis => Kind::SixAxis,
    };
    let configuration = Configuration {
        speed,
        filter,
        zero: request.zero,
    };
    Ok(Box::new(OptoForce {
        kind,
        configuration,
        decoder: Decoder::default(),
    }))
}

/// Driver of one device.
struct OptoForce {
    kind: Kind,
    configuration: Configuration,
    decoder: Decoder,
}

impl Driver for OptoForce {
    fn shape(&self) -> Shape {
        Shape {
            quantity: match self.kind {
                Kind::SixAxis => Quantity::Wrench,
                Kind::OneChannel | Kind::FourChannel => Quantity::Force,
            },
            unit: "counts",
            fingers: self.kind.channel_count(),
            taxels: 1,
        }
    }

    fn counter_bits(&self) -> u32 {
        16
    }

    fn messages(&self) -> DeviceMessages {
        DeviceMessages {
            start: self.configuration.to_bytes().to_vec(),
            acknowledged: true,
            stop: STOP.to_vec(),
            ..DeviceMessages::default()
        }
    }

    fn receive(&mut self, bytes: &[u8], report: &mut dyn FnMut(Event<'_>)) {
        let kind = self.kind;
        self.decoder
            .push(bytes, |message| report_message(message, kind, report));
    }

    fn finish(&mut self, report: &mut dyn FnMut(Event<'_>)) {
        let kind = self.kind;
        self.decoder
            .finish(|message| report_message(message, kind, report));
    }

    fn counts(&self) -> ByteCounts {
        self.decoder.counts()
    }
}

fn report_message(message: Message, expected: Kind, report: &mut dyn FnMut(Event<'_>)) {
    match message {
        Message::Acknowledgement(answer) => report(Event::Acknowledged(answer.status.into())),
        Message::Data(frame) if frame.kind != expected => {
            report(Event::OtherKind(other_kind(frame.kind)));
        }
        Message::Data(frame) => report_frame(&frame, report),
    }
}

fn report_frame(frame: &DataFrame, report: &mut dyn FnMut(Event<'_>)) {
    let mut values = [0.0; MAX_VALUES];
    for (value, &counts) in values.iter_mut().zip(frame.values()) {
        *value = f64::from(counts);
    }
    report(Event::Frame(Frame {
        byte_offset: frame.byte_offset,
        count: Some(frame.count.into()),
        status: frame.status.0.into(),
        temperature_c: None,
        condition: condition(frame.status),
        values: &values[..frame.values().len()],
    }));
}

fn condition(status: DeviceStatus) -> Condition {
    if status.is_failed() {
        Condition::Failed
    } else if status.is_abnormal() {
        Condition::Degraded
    } else {
        Condition::Normal
    }
}

/// Returns the description of a frame kind, with the option that selects it.
fn other_kind(kind: Kind) -> &'static str {
    match kind {
        Kind::OneChannel => "one-channel frames; pass --channels 1",
        Kind::FourChannel => "four-channel frames; pass --channels 4",
        Kind::SixAxis => "six-axis frames; pass --channels six-axis",
    }
}
