//! Wire formats of sensors.
//!
//! An input begins with options: variant of the device, size of the chunks, repaired checksums. A
//! mutation with a repaired checksum reaches the decoder behind it.

use std::sync::{LazyLock, OnceLock};

use atas_sensors::cli;
use atas_sensors::intake::Intake;
use atas_sensors::wire::{Event, Interface, Request, SensorType, named};
use clap::ArgMatches;

use crate::input::Input;
use crate::target::Target;

/// Longest stream: several of the longest frames.
const STREAM: usize = 8 << 10;

macro_rules! sensors {
    ($($function:ident = $name:literal, $vectors:literal;)*) => {
        /// Targets of this file.
        pub(crate) const TARGETS: [Target; 7] = [$(
            Target::new(concat!("sensor-", $name), $function::run, $function::seeds).length(STREAM)
        ),*];

        $(mod $function {
            pub(super) fn run(bytes: &[u8]) {
                super::decode($name, bytes);
            }

            pub(super) fn seeds() -> Vec<Vec<u8>> {
                let vectors = include_str!(concat!("../../../clients/sensors/tests/vectors/", $vectors));
                super::seeds($name, vectors)
            }
        })*
    };
}

sensors! {
    optoforce = "optoforce", "optoforce.toml";
    paxini = "paxini", "paxini.toml";
    paxini_hand = "paxini-hand", "paxini-hand.toml";
    anyskin = "anyskin", "anyskin.toml";
    netft = "netft", "netft.toml";
    uskin = "uskin", "uskin.toml";
    papillarray = "papillarray", "papillarray.toml";
}

/// Device variants by their options; the first is the default.
fn variants(sensor: &str) -> &'static [&'static [&'static str]] {
    match sensor {
        "optoforce" => &[&[], &["--channels", "4"], &["--channels", "six-axis"]],
        "paxini" => &[
            &[],
            &["--model", "s2015e"],
            &["--model", "s1610e", "--id", "3"],
        ],
        "paxini-hand" => &[
            &[],
            &["--modules", "31,52"],
            &["--modules", "25,31,9", "--fingertips", "2,0"],
        ],
        "anyskin" => &[&[], &["--magnetometers", "1"], &["--magnetometers", "16"]],
        "uskin" => &[
            &[],
            &["--taxels", "1", "--pads", "2"],
            &["--taxels", "4", "--calibrated"],
        ],
        "papillarray" => &[&[], &["--sensors", "2"]],
        _ => &[&[]],
    }
}

/// Streams of the test vectors, alone and together, with and without repaired checksums.
fn seeds(sensor: &str, vectors: &str) -> Vec<Vec<u8>> {
    let table: toml::Table = vectors.parse().expect("a table of test vectors");
    let mut seeds = Vec::new();
    let mut all = vec![16];
    for case in table["case"].as_array().into_iter().flatten() {
        let stream = match (case.get("hex"), case.get("text")) {
            (Some(hex), _) => hex
                .as_str()
                .unwrap_or_default()
                .split_whitespace()
                .filter_map(|byte| u8::from_str_radix(byte, 16).ok())
                .collect(),
            (_, Some(text)) => text.as_str().unwrap_or_default().as_bytes().to_vec(),
            _ => Vec::new(),
        };
        for options in 0..2 * variants(sensor).len() as u8 {
            seeds.push([&[options][..], &stream].concat());
        }
        all.extend(stream);
    }
    seeds.push(all);
    seeds
}

/// Parsed command lines of a sensor.
type Variants = OnceLock<Vec<ArgMatches>>;

/// Parsed command lines of all variants: parsing takes longer than decoding.
fn arguments(sensor: &'static SensorType, variant: usize) -> &'static ArgMatches {
    static PARSED: LazyLock<Vec<(&str, Variants)>> = LazyLock::new(|| {
        let all = atas_sensors::wire::SENSORS.iter();
        all.map(|sensor| (sensor.name, OnceLock::new())).collect()
    });
    let (_, parsed) = PARSED
        .iter()
        .find(|(name, _)| *name == sensor.name)
        .expect("a listed sensor");
    let parsed = parsed.get_or_init(|| {
        let parse = |options: &&[&'static str]| {
            let line = ["atas-sensor", sensor.name, "--device", "-", "--dry-run"];
            let line = line.into_iter().chain(options.iter().copied());
            let matches = cli::command()
                .try_get_matches_from(line)
                .expect("valid options");
            matches.subcommand().expect("a sensor").1.clone()
        };
        variants(sensor.name).iter().map(parse).collect()
    });
    &parsed[variant % parsed.len()]
}

fn decode(name: &str, bytes: &[u8]) {
    let sensor = named(name).expect("a listed sensor");
    let mut input = Input::new(bytes);
    let options = usize::from(input.byte());
    let variants = variants(name).len();
    let chunk = [usize::MAX, 1, 7, 64][options / (2 * variants) % 4];
    let mut stream = input.rest().to_vec();
    if options / variants % 2 == 1 {
        repair(name, &mut stream);
    }
    let request = Request {
        rate_hz: sensor.rate_hz.parse().unwrap_or(100),
        zero: false,
    };
    let make = || {
        let driver = (sensor.driver)(arguments(sensor, options % variants), &request);
        driver.expect("valid options")
    };
    let mut driver = make();
    let (mut frames, shape) = (0, driver.shape());
    let mut note = |event: Event<'_>| {
        if let Event::Frame(frame) = event {
            frames += 1;
            assert!(frame.values.len() <= 6 * shape.fingers * shape.taxels);
        }
    };
    for piece in stream.chunks(chunk.min(stream.len().max(1))) {
        driver.receive(piece, &mut note);
    }
    driver.finish(&mut note);
    let counts = driver.counts();
    assert_eq!(counts.received, stream.len() as u64);
    assert_eq!(
        counts.received,
        counts.data + counts.acknowledgement + counts.junk
    );
    assert_eq!(counts.pending, 0);
    let is_stream = matches!(sensor.interface, Interface::Serial { .. });
    if is_stream && chunk != usize::MAX {
        // The result does not depend on the chunk boundaries.
        let mut whole = make();
        let (mut expected, mut ignore) = (0, 0);
        whole.receive(&stream, &mut |event| match event {
            Event::Frame(_) => expected += 1,
            _ => ignore += 1,
        });
        whole.finish(&mut |event| expected += u64::from(matches!(event, Event::Frame(_))));
        assert_eq!(
            (frames, counts),
            (expected, whole.counts()),
            "{ignore} other events"
        );
    } else {
        // Numbers and times of the frames.
        let mut intake = Intake::new(make(), options & 1 == 0);
        intake.begin_stream(false);
        intake.push(&stream);
        intake.finish();
        let _health = intake.health();
    }
}

/// Repairs the checksums of all frames that begin with a header of this sensor.
fn repair(name: &str, stream: &mut [u8]) {
    match name {
        "optoforce" => each_header(stream, &[0xAA], |frame| {
            let length = match frame.get(..4) {
                Some([0xAA, 7, 8, kind]) => usize::from(*kind) + 6,
                Some([0xAA, 0, 0x50, 1]) => 7,
                _ => return,
            };
            if let Some(frame) = frame.get_mut(..length) {
                let (covered, sum) = frame.split_at_mut(length - 2);
                sum.copy_from_slice(&wrapping_sum(covered).to_be_bytes());
            }
        }),
        "paxini" => each_header(stream, &[0xAA, 0x55], |frame| {
            let length = frame
                .get(2..4)
                .map(|low| usize::from(low[0]) + 256 * usize::from(low[1]));
            lrc(frame, length.map(|length| length + 5));
        }),
        "paxini-hand" => {
            each_header(stream, &[0xAA, 0x56], |frame| {
                let length = frame
                    .get(3..5)
                    .map(|low| usize::from(low[0]) + 256 * usize::from(low[1]));
                lrc(frame, length.map(|length| length + 6));
            });
            each_header(stream, &[0xAA, 0x55], |frame| lrc(frame, Some(10)));
        }
        "papillarray" => each_header(stream, &[0x55, 0x66, 0x77, 0x88], |packet| {
            let body = &mut packet[4..];
            let end = body
                .windows(4)
                .position(|mark| mark == [0xAA, 0xBB, 0xCC, 0xDD]);
            if let Some(covered) = end.and_then(|end| end.checked_sub(2)) {
                let sum = wrapping_sum(&body[..covered]).to_le_bytes();
                body[covered..covered + 2].copy_from_slice(&sum);
            }
        }),
        _ => {}
    }
}

fn each_header(stream: &mut [u8], header: &[u8], mut repair: impl FnMut(&mut [u8])) {
    for begin in 0..stream.len() {
        if stream[begin..].starts_with(header) {
            repair(&mut stream[begin..]);
        }
    }
}

fn wrapping_sum(bytes: &[u8]) -> u16 {
    bytes
        .iter()
        .fold(0, |sum, &byte| sum.wrapping_add(byte.into()))
}

/// Makes the sum of a frame zero.
fn lrc(frame: &mut [u8], length: Option<usize>) {
    if let Some([covered @ .., last]) = length.and_then(|length| frame.get_mut(..length)) {
        let sum = covered
            .iter()
            .fold(0_u8, |sum, &byte| sum.wrapping_add(byte));
        *last = sum.wrapping_neg();
    }
}
