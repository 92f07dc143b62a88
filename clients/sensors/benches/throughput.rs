//! Throughput of every sensor's decoder on one core, with one percent damaged frames from its
//! emulated peer.
//!
//! Run: `cargo bench -p atas-sensors --bench throughput -- [counts] [FRAMES [SENSOR]]`, 1,000,000
//! frames by default. Fails if a valid frame is lost or wrong, a damaged one is accepted or not
//! counted, or the speed is below 50 times the real rate. `counts` disables the speed check, which
//! depends on the computer. Frame generation is not timed.
#![expect(clippy::print_stdout, reason = "a bench prints")]

#[path = "../tests/common/peers.rs"]
mod peers;

use std::time::{Duration, Instant};

use atas_sensors::cli;
use atas_sensors::wire::{Driver, Event, Interface, Request, SENSORS, SensorType};

/// Distinct frames, repeated by every pass.
const DISTINCT_FRAMES: u32 = 10_000;
/// One frame in this many is damaged.
const DAMAGE_INTERVAL: u32 = 100;
/// Bytes of one read.
const READ_BYTES: usize = 4096;
/// Required speed, in multiples of the sensor's real rate.
const SPEED_FACTOR_MIN: f64 = 50.0;
/// Argument that disables the speed check.
const COUNTS_ONLY: &str = "counts";

fn main() {
    // Cargo passes its own options, beginning with dashes.
    let mut words = std::env::args()
        .skip(1)
        .filter(|word| !word.starts_with('-'))
        .peekable();
    let least = words
        .next_if_eq(COUNTS_ONLY)
        .map_or(SPEED_FACTOR_MIN, |_| 0.0);
    let frames: u32 = words.next().map_or(1_000_000, |word| {
        word.parse().expect("an integer number of frames")
    });
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
    let matches = cli::command()
        .try_get_matches_from(line)
        .expect("a valid command line");
    let request = Request {
        rate_hz: sensor.rate_hz.parse().expect("an integer rate"),
        zero: false,
    };
    (sensor.driver)(matches.subcommand().expect("a sensor").1, &request).expect("a driver")
}

/// Frames of one pass; every hundredth is damaged in one of three ways.
struct Traffic {
    pieces: Vec<Vec<u8>>,
    valid: u64,
    damaged: u64,
}

fn traffic(sensor: &SensorType) -> Traffic {
    let (mut pieces, mut valid, mut damaged) = (Vec::new(), 0, 0);
    for n in 0..DISTINCT_FRAMES {
        let frame = peers::frame(sensor.name, n);
        if n % DAMAGE_INTERVAL != DAMAGE_INTERVAL / 2 {
            valid += 1;
            pieces.push(frame);
            continue;
        }
        damaged += 1;
        pieces.push(damage(frame, n / DAMAGE_INTERVAL));
    }
    Traffic {
        pieces,
        valid,
        damaged,
    }
}

/// Removes the second half or the first half of a frame, or overwrites its end with junk.
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

/// Measures one sensor; returns whether all checks pass at `least` times the real rate.
fn measure(sensor: &SensorType, frames: u32, least: f64) -> bool {
    let traffic = traffic(sensor);
    let mut driver = driver(sensor);
    let stream = traffic.pieces.concat();
    let passes = frames.div_ceil(DISTINCT_FRAMES);
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
        match sensor.interface {
            Interface::Serial { .. } => stream
                .chunks(READ_BYTES)
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
    let rate: f64 = sensor.rate_hz.parse().expect("an integer rate");
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

/// Returns the damaged bytes of one pass.
fn damage_bytes(traffic: &Traffic) -> u64 {
    let damaged = traffic.pieces.iter().enumerate();
    damaged
        .filter(|(n, _)| *n as u32 % DAMAGE_INTERVAL == DAMAGE_INTERVAL / 2)
        .map(|(_, piece)| piece.len() as u64)
        .sum()
}

/// Returns the sum of the valid frames' first values of one pass, from the peers' formula.
fn first_values(sensor: &SensorType) -> f64 {
    let first = |n: u32| match sensor.name {
        "paxini" | "paxini-hand" => f64::from(peers::magnitude(n, 0)),
        "papillarray" => f64::from(peers::value(n, 0)) / 8.0,
        "netft" => f64::from(peers::value(n, 0) * 1000),
        "uskin" => f64::from(0x8000 + peers::value(n, 0)),
        _ => f64::from(peers::value(n, 0)),
    };
    (0..DISTINCT_FRAMES)
        .filter(|n| n % DAMAGE_INTERVAL != DAMAGE_INTERVAL / 2)
        .map(first)
        .sum()
}
