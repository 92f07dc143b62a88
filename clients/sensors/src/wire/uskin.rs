//! XELA uSkin pads: the vendor's server sends JSON over a WebSocket, port 5000.
//!
//! One object per update, sensors under numeric keys:
//! `{"message":5548,"1":{"model":"uSPa44","taxels":16,"data":"C0B3,4465,…","calibrated":[…]}}`.
//! `message` counts updates; the first message has `"message":"Welcome"` and no reading. `data`
//! holds 3 × taxels hexadecimal `u16`, x y z per taxel. `calibrated` has the same in newtons if the
//! server has a model of the pad; `--calibrated` selects it. Sensor key i is finger i − 1 of the
//! device.
//!
//! An update is valid if it has every expected sensor with exactly the expected number of values;
//! anything else is junk. Source: the vendor's ROS package and recorded messages.

use clap::{ArgMatches, Args, FromArgMatches};
use serde::Deserialize;
use serde_json::{Map, Value};

use crate::reading::{ByteCounts, Condition, Frame, Quantity, Shape};
use crate::wire::{DeviceMessages, Driver, Event, Interface, Request, SensorType, Zero};

/// Entry in the list of sensors.
pub const TYPE: SensorType = SensorType {
    name: "uskin",
    about: "XELA uSkin pads behind the vendor's server",
    wire: "WebSocket port 5000, JSON",
    interface: Interface::WebSocket { port: 5000 },
    taxels: 16,
    rate_hz: "100",
    newtons_per_unit: None,
    axes: "z,x,y",
    zero: Zero::Host,
    example: "--device ws://127.0.0.1:5000 --hand left --calibrated --newtons-per-count 1,1,1",
    notes: "With --calibrated the values are in newtons: use --newtons-per-count 1,1,1.",
    options: <Options as Args>::augment_args,
    driver: make,
};

#[derive(Debug, Args)]
struct Options {
    /// Taxels of one pad: 16 of a uSPa44, 24 of a uSPa46, 4 of a uSPa22.
    #[arg(long, default_value_t = 16, value_parser = clap::value_parser!(u64).range(1..=64))]
    taxels: u64,
    /// Pads behind the server: keys 1 to this number.
    #[arg(long, default_value_t = 1, value_parser = clap::value_parser!(u64).range(1..=4))]
    pads: u64,
    /// Read the forces that the server calibrated, not the counts.
    #[arg(long)]
    calibrated: bool,
}

fn make(matches: &ArgMatches, _request: &Request) -> Result<Box<dyn Driver>, String> {
    let options = Options::from_arg_matches(matches).map_err(|error| error.to_string())?;
    let (pads, taxels) = (options.pads as usize, options.taxels as usize);
    Ok(Box::new(USkin {
        pads,
        taxels,
        calibrated: options.calibrated,
        counts: ByteCounts::default(),
        values: Vec::with_capacity(3 * pads * taxels),
    }))
}

/// Pad of an update.
#[derive(Deserialize)]
struct Pad {
    #[serde(default)]
    data: String,
    calibrated: Option<Vec<f64>>,
}

/// Driver of one server.
struct USkin {
    pads: usize,
    taxels: usize,
    calibrated: bool,
    counts: ByteCounts,
    /// Values of the current update.
    values: Vec<f64>,
}

/// Content of a text message.
enum Update {
    Count(u32),
    Welcome,
    Junk,
}

impl USkin {
    fn read(&mut self, text: &[u8]) -> Update {
        self.values.clear();
        let Ok(mut object) = serde_json::from_slice::<Map<String, Value>>(text) else {
            return Update::Junk;
        };
        let count = match object.get("message") {
            Some(Value::Number(number)) => number.as_u64().map(|count| count as u32),
            Some(Value::String(_)) => return Update::Welcome,
            _ => None,
        };
        let complete = (1..=self.pads).all(|key| {
            object
                .remove(&key.to_string())
                .is_some_and(|pad| self.read_pad(pad))
        });
        match count {
            Some(count) if complete => Update::Count(count),
            _ => Update::Junk,
        }
    }

    /// Adds a pad's values. Returns false for unexpected values.
    fn read_pad(&mut self, pad: Value) -> bool {
        let before = self.values.len();
        let Ok(pad) = serde_json::from_value::<Pad>(pad) else {
            return false;
        };
        if self.calibrated {
            self.values.extend(pad.calibrated.unwrap_or_default());
        } else {
            let words = pad.data.split(',').map(hexadecimal);
            self.values.extend(words.map_while(|word| word));
        }
        let added = &self.values[before..];
        added.len() == 3 * self.taxels && added.iter().all(|value| value.is_finite())
    }
}

/// Parses a hexadecimal `u16`. An invalid word ends the list, which is then too short.
fn hexadecimal(word: &str) -> Option<f64> {
    u16::from_str_radix(word.trim(), 16).ok().map(f64::from)
}

impl Driver for USkin {
    fn shape(&self) -> Shape {
        Shape {
            quantity: Quantity::Force,
            unit: if self.calibrated { "n" } else { "counts" },
            fingers: self.pads,
            taxels: self.taxels,
        }
    }

    fn messages(&self) -> DeviceMessages {
        DeviceMessages::default()
    }

    fn receive(&mut self, bytes: &[u8], report: &mut dyn FnMut(Event<'_>)) {
        let byte_offset = self.counts.received;
        let length = bytes.len() as u64;
        self.counts.received += length;
        match self.read(bytes) {
            Update::Junk => {
                self.counts.junk += length;
                self.counts.checksum_failures += 1;
            }
            Update::Welcome => {
                self.counts.acknowledgement += length;
                self.counts.acknowledgements += 1;
            }
            Update::Count(count) => {
                self.counts.data += length;
                self.counts.frames += 1;
                report(Event::Frame(Frame {
                    byte_offset,
                    count: Some(count),
                    status: 0,
                    temperature_c: None,
                    condition: Condition::Normal,
                    values: &self.values,
                }));
            }
        }
    }

    fn counts(&self) -> ByteCounts {
        self.counts
    }
}
