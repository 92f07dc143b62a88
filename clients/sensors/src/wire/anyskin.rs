//! AnySkin, ReSkin and eFlesh: magnetometers under a magnetic skin, over USB CDC (115,200 baud,
//! little-endian).
//!
//! | message | bytes | layout |
//! |---|---|---|
//! | data | 16 n + 2 | n × (temperature °C, Bx, By, Bz in µT, each `f32`), then `0D 0A` |
//!
//! The format has neither header, counter nor checksum, and `0D 0A` occurs inside floats as well. A
//! frame has the end mark at its full length and only plausible numbers before it: every
//! temperature between −40 and 125 °C (the range of the MLX90393), every flux finite and below 100
//! mT (twice the range of that chip). Numbers read at a wrong offset are almost never all
//! plausible, so a stream resynchronises at its next complete frame. Start-up text of the board is
//! junk. A frame with damaged but plausible numbers passes; no decoder can detect it.
//!
//! The values are flux, not force. `--newtons-per-count` sets a linear scale in N per µT. `--zero`
//! makes the initial load zero; without it the field of the magnets reads as a force. Sources: the
//! boards' public firmware and reader.

use clap::{ArgMatches, Args, FromArgMatches};

use crate::reading::{ByteCounts, Condition, Frame, Quantity, Shape};
use crate::resync::{Candidate, Resync, Wire};
use crate::wire::{DeviceMessages, Driver, Event, Interface, Request, SensorType, Zero};

/// Entry in the list of sensors.
pub const TYPE: SensorType = SensorType {
    name: "anyskin",
    about: "AnySkin, ReSkin or eFlesh magnetic skin: five magnetometers on a USB serial port",
    wire: "serial, 115200 baud 8N1, f32 little-endian, no checksum, CR LF",
    interface: Interface::Serial { baud: 115_200 },
    taxels: 5,
    rate_hz: "100",
    newtons_per_unit: None,
    axes: "z,x,y",
    zero: Zero::Host,
    example: "--device /dev/ttyACM0 --hand left --zero --newtons-per-count 0.002,0.002,0.01",
    notes: "The skin measures flux in microtesla; --newtons-per-count is newtons per microtesla of \
        this skin.",
    options: <Options as Args>::augment_args,
    driver: make,
};

/// Most magnetometers of one board.
const MAX_TAXELS: usize = 16;
/// Bytes of one magnetometer.
const TAXEL_BYTES: usize = 16;
/// Range of plausible temperatures, °C (data sheet of the MLX90393: −40 to 85, and a margin for its
/// offset).
const TEMPERATURE_C: core::ops::RangeInclusive<f32> = -40.0..=125.0;
/// Largest plausible flux density, µT (twice the 50 mT of the MLX90393's data sheet).
const FLUX_MAX_UT: f32 = 100_000.0;

#[derive(Debug, Args)]
struct Options {
    /// Magnetometers on the board.
    #[arg(long, default_value_t = 5, value_parser = clap::value_parser!(u64).range(1..=MAX_TAXELS as u64))]
    magnetometers: u64,
}

fn make(matches: &ArgMatches, _request: &Request) -> Result<Box<dyn Driver>, String> {
    let options = Options::from_arg_matches(matches).map_err(|error| error.to_string())?;
    let taxels = options.magnetometers as usize;
    Ok(Box::new(AnySkin {
        decoder: Resync::new(Format { taxels }),
    }))
}

/// Frame format of one board.
#[derive(Clone, Copy, Debug)]
pub struct Format {
    /// Number of magnetometers.
    pub taxels: usize,
}

/// Frame: offset, mean temperature, °C, and flux per magnetometer, µT.
#[derive(Clone, Copy, Debug)]
pub struct Flux {
    byte_offset: u64,
    temperature_c: f64,
    values: [f64; 3 * MAX_TAXELS],
}

impl Wire for Format {
    type Message = Flux;
    const LENGTH_MAX: usize = TAXEL_BYTES * MAX_TAXELS + 2;
    const NESTED: bool = false;

    fn examine(&self, bytes: &[u8], byte_offset: u64) -> Candidate<Flux> {
        let length = TAXEL_BYTES * self.taxels + 2;
        // An implausible first temperature decides at once.
        let may_begin = |first: &[u8; 4]| TEMPERATURE_C.contains(&f32::from_le_bytes(*first));
        if bytes.first_chunk().is_some_and(|first| !may_begin(first)) {
            return Candidate::None;
        }
        let Some(frame) = bytes.get(..length) else {
            return Candidate::Undecided;
        };
        let Some(numbers) = frame.strip_suffix(b"\r\n") else {
            return Candidate::None;
        };
        let mut values = [0.0; 3 * MAX_TAXELS];
        let mut warmth_c = 0.0;
        for (value, taxel) in values
            .chunks_exact_mut(3)
            .zip(numbers.chunks_exact(TAXEL_BYTES))
        {
            let Some((temperature_c, flux)) = plausible(taxel) else {
                return Candidate::Corrupt;
            };
            warmth_c += f64::from(temperature_c);
            value.copy_from_slice(&flux.map(f64::from));
        }
        let flux = Flux {
            byte_offset,
            temperature_c: warmth_c / self.taxels as f64,
            values,
        };
        Candidate::Valid(flux, length)
    }

    fn is_data(_message: &Flux) -> bool {
        true
    }
}

/// Returns temperature and flux of one magnetometer if all its numbers are plausible.
fn plausible(taxel: &[u8]) -> Option<(f32, [f32; 3])> {
    let (words, _) = taxel.as_chunks::<4>();
    let [temperature, x, y, z] = <[[u8; 4]; 4]>::try_from(words)
        .ok()?
        .map(f32::from_le_bytes);
    let flux = [x, y, z];
    // False for NaN.
    let believed = |value: &f32| value.abs() <= FLUX_MAX_UT;
    let is_plausible = TEMPERATURE_C.contains(&temperature) && flux.iter().all(believed);
    is_plausible.then_some((temperature, flux))
}

/// Driver of one board.
struct AnySkin {
    decoder: Resync<Format>,
}

impl Driver for AnySkin {
    fn shape(&self) -> Shape {
        Shape {
            quantity: Quantity::Flux,
            unit: "ut",
            fingers: 1,
            taxels: self.decoder.wire().taxels,
        }
    }

    fn messages(&self) -> DeviceMessages {
        DeviceMessages::default()
    }

    fn receive(&mut self, bytes: &[u8], report: &mut dyn FnMut(Event<'_>)) {
        let taxels = self.decoder.wire().taxels;
        self.decoder
            .push(bytes, |flux| report_flux(&flux, taxels, report));
    }

    fn finish(&mut self, report: &mut dyn FnMut(Event<'_>)) {
        let taxels = self.decoder.wire().taxels;
        self.decoder
            .finish(|flux| report_flux(&flux, taxels, report));
    }

    fn counts(&self) -> ByteCounts {
        self.decoder.counts()
    }
}

fn report_flux(flux: &Flux, taxels: usize, report: &mut dyn FnMut(Event<'_>)) {
    report(Event::Frame(Frame {
        byte_offset: flux.byte_offset,
        count: None,
        status: 0,
        temperature_c: Some(flux.temperature_c),
        condition: Condition::Normal,
        values: &flux.values[..3 * taxels],
    }));
}
