//! Every sensor's decoder at full speed: frames of its emulated peer, one percent of them damaged, on one core.
//!
//! `cargo bench -p atas-sensors --bench throughput -- [counts] [FRAMES [SENSOR]]`, 1,000,000 frames by default. Fails when a valid
//! frame is lost or read wrongly, a damaged one passes or is not accounted for, or the speed is below 50 times the
//! sensor's real rate; with `counts` the speed, which belongs to the machine, fails nothing. Making the frames is not timed.
#![expect(clippy::print_stdout, reason = "a bench prints")]

#[path = "../tests/common/peers.rs"]
mod peers;

use std::time::{Duration, Instant};

use atas_sensors::cli;
use atas_sensors::wire::{Driver, Event, Request, SENSORS, SensorType, Way};

/// Different frames; more would be made anew for each pass for nothing.
const VARIETY: u32 = 10_000;
/// Of so many frames one is damaged.
const DAMAGED: u32 = 100;
/// Bytes of one read.
const READ: usize = 4096;
/// Least speed, in multiples of the sensor's real rate.
const LEAST: f64 = 50.0;
/// The word after which nothing but counts is judged.
const COUNTS: &str = "counts";

fn main() {
    // Cargo passes its own options, beginning with dashes.
    let mut words = std::env::args()
        .skip(1)
        .filter(|word| !word.starts_with('-'))
        .peekable();
    let least = words.next_if_eq(COUNTS).map_or(LEAST, |_| 0.0);
    let frames: u32 = words
        .next()
        .map_or(1_000_000, |word| word.parse().expect("a number"));
    let only = words.next();
    println!(
        "{:<12} {:>10} {:>8} {:>9} {:>10} {:>12} {:>8}",
        "sensor", "frames", "damaged", "lost", "junk B", "frames/s", "x real"
    );
    let mut failed = false;
    for sensor in SENSORS
        .iter()
        .filter(|s| only.as_ref().is_none_or(|name| name == s.name))
    {
        failed |= !measure(sensor, frames, least);
    }
    if failed {
        std::process::exit(1);
    }
}

fn driver(sensor: &SensorType) -> Box<dyn Driver> {
    let line = ["atas-sensor", sensor.name, "--device", "-", "--dry-run"];
    let matches = cli::command().try_get_matches_from(line).expect("sound");
    let request = Request {
        rate_hz: sensor.rate_hz.parse().expect("a number"),
        zero: false,
    };
    (sensor.driver)(matches.subcommand().expect("a sensor").1, &request).expect("a driver")
}

/// Frames as they come, every hundredth of them damaged in one of four ways, and which those are.
struct Traffic {
    pieces: Vec<Vec<u8>>,
    /// Valid frames.
    valid: u64,
    damaged: u64,
}

fn traffic(sensor: &SensorType) -> Traffic {
    let (mut pieces, mut valid, mut damaged) = (Vec::new(), 0, 0);
    for n in 0..VARIETY {
        let frame = peers::frame(sensor.name, n);
        if n % DAMAGED != DAMAGED / 2 {
            valid += 1;
            pieces.push(frame);
            continue;
        }
        damaged += 1;
        pieces.push(damage(frame, n / DAMAGED));
    }
    Traffic {
        pieces,
        valid,
        damaged,
    }
}

/// A frame that is no longer valid for certain: cut in the middle, begun in the middle, or with a bad byte at its end.
fn damage(mut frame: Vec<u8>, way: u32) -> Vec<u8> {
    let middle = frame.len() / 2;
    match way % 3 {
        0 => frame.truncate(middle),
        1 => drop(frame.drain(..middle + 1)),
        _ => {
            frame.truncate(frame.len() - 1);
            frame.extend(b"junk");
        }
    }
    frame
}

/// Whether the sensor keeps what it promises, at `least` times its real rate.
fn measure(sensor: &SensorType, frames: u32, least: f64) -> bool {
    let traffic = traffic(sensor);
    let mut driver = driver(sensor);
    let stream = traffic.pieces.concat();
    let passes = frames.div_ceil(VARIETY);
    let (mut found, mut checksum) = (0_u64, 0.0_f64);
    let mut expected = 0.0_f64;
    let mut spent = Duration::ZERO;
    for pass in 0..passes {
        let mut note = |event: Event<'_>| {
            if let Event::Frame(frame) = event {
                found += 1;
                checksum += frame.values[0];
            }
        };
        let begun = Instant::now();
        match sensor.way {
            Way::Serial { .. } => stream
                .chunks(READ)
                .for_each(|bytes| driver.receive(bytes, &mut note)),
            _ => traffic
                .pieces
                .iter()
                .for_each(|bytes| driver.receive(bytes, &mut note)),
        }
        if pass + 1 == passes {
            driver.finish(&mut note);
        }
        spent += begun.elapsed();
        expected += first_values(sensor);
    }
    let counts = driver.counts();
    let sent = traffic.valid * u64::from(passes);
    let damaged = traffic.damaged * u64::from(passes);
    let rate: f64 = sensor.rate_hz.parse().expect("a number");
    let per_second = found as f64 / spent.as_secs_f64();
    let lost = sent.abs_diff(found);
    println!(
        "{:<12} {:>10} {:>8} {:>9} {:>10} {:>12.0} {:>8.0}",
        sensor.name,
        found,
        damaged,
        lost,
        counts.junk,
        per_second,
        per_second / rate
    );
    let balanced = counts.received == counts.data + counts.acknowledgement + counts.junk;
    let damage_bytes: u64 = damage_bytes(&traffic) * u64::from(passes);
    lost == 0
        && checksum == expected
        && counts.junk == damage_bytes
        && balanced
        && per_second >= least * rate
}

/// Bytes of the damaged frames of one pass.
fn damage_bytes(traffic: &Traffic) -> u64 {
    let damaged = traffic.pieces.iter().enumerate();
    damaged
        .filter(|(n, _)| *n as u32 % DAMAGED == DAMAGED / 2)
        .map(|(_, piece)| piece.len() as u64)
        .sum()
}

/// Sum of the first values of the valid frames of one pass, from the peers' own rule.
fn first_values(sensor: &SensorType) -> f64 {
    let first = |n: u32| match sensor.name {
        "paxini" | "paxini-hand" => f64::from(peers::magnitude(n, 0)),
        "papillarray" => f64::from(peers::value(n, 0)) / 8.0,
        "netft" => f64::from(peers::value(n, 0) * 1000),
        "uskin" => f64::from(0x8000 + peers::value(n, 0)),
        _ => f64::from(peers::value(n, 0)),
    };
    (0..VARIETY)
        .filter(|n| n % DAMAGED != DAMAGED / 2)
        .map(first)
        .sum()
}
