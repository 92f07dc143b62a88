//! Tests of an OptoForce byte stream with the daemon: generated and, if available, recorded data,
//! in partial reads at the device's rate through a pseudo-terminal.

use rustix::fd::OwnedFd;
use rustix::pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt};
use shm_bus::{Bus, FreshBus, Realtime};
use shm_schemas::{SensorStatus, Status, service};
use std::time::{Duration, Instant};
use system_tests::{Process, lock_exclusive, shared_path, wait_for};

/// Daemon configuration for this sensor; thresholds from the recording's description.
const CONFIG: &str = "
[robot]
joints_required = false
[hands.left]
layout = \"dome-1\"
fingers = 1
[hands.right]
required = false
[intake]
element_force_n = 2000.0
reject_age_s = 5.0
[perception]
touch_on_n = 19.8
touch_off_n = 9.9
";
/// Touches in either stream.
const TOUCHES: u64 = 5;
/// The device sends 1000 frames of 16 bytes per second.
const BYTES_PER_S: f64 = 16_000.0;

fn pseudo_terminal() -> (OwnedFd, String) {
    let master = openpt(OpenptFlags::RDWR | OpenptFlags::NOCTTY).expect("a pseudo-terminal");
    grantpt(&master).expect("granted");
    unlockpt(&master).expect("unlocked");
    let name = ptsname(&master, Vec::new())
        .expect("a name")
        .into_string()
        .expect("UTF-8");
    let mut raw = rustix::termios::tcgetattr(&master).expect("a terminal");
    raw.make_raw();
    rustix::termios::tcsetattr(&master, rustix::termios::OptionalActions::Now, &raw).expect("raw");
    (master, name)
}

/// Writes all bytes at the device's rate, in pieces of 1 to 37 bytes that ignore frame boundaries.
fn feed(master: &OwnedFd, bytes: &[u8]) {
    let begin = Instant::now();
    let mut sent = 0;
    while sent < bytes.len() {
        let due = (begin.elapsed().as_secs_f64() * BYTES_PER_S) as usize;
        if due <= sent {
            std::thread::sleep(Duration::from_micros(500));
            continue;
        }
        let piece = (1 + (sent * 7) % 37).min(bytes.len() - sent);
        sent += rustix::io::write(master, &bytes[sent..sent + piece]).expect("writable");
    }
}

/// Generates frames of a fingertip that is pressed five times for half a second, with noise and
/// with junk after every hundredth frame.
fn generated() -> (Vec<u8>, u64) {
    const FRAMES: u16 = 5_500;
    let mut stream = Vec::new();
    let mut noise = 1_u32;
    let mut jitter = move || {
        noise = noise.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (noise >> 30) as i16 - 1
    };
    for n in 0..FRAMES {
        // A press in the first half of every second, after half a second of rest.
        let phase = f64::from((n + 500) % 1000) / 500.0;
        let press = if n >= 500 && phase < 1.0 {
            (200.0 * (phase * std::f64::consts::PI).sin()) as i16
        } else {
            0
        };
        stream.extend(frame(n, [jitter(), jitter(), jitter() - press]));
        if n % 100 == 99 {
            stream.extend([0xAA, 0x07, 0x08, 0x0A, 0x55]);
        }
    }
    (stream, FRAMES.into())
}

/// Returns a data frame of one fingertip.
fn frame(count: u16, forces: [i16; 3]) -> Vec<u8> {
    let mut bytes = vec![0xAA, 0x07, 0x08, 0x0A];
    let words = [count, 0].into_iter().chain(forces.map(i16::cast_unsigned));
    bytes.extend(words.flat_map(u16::to_be_bytes));
    let sum: u16 = bytes.iter().map(|&byte| u16::from(byte)).sum();
    bytes.extend(sum.to_be_bytes());
    bytes
}

#[test]
fn stream_with_junk_is_received_without_loss() {
    let (stream, frames) = generated();
    check(&stream, frames);
}

#[test]
fn recorded_stream_is_received_without_loss() {
    if let Some(path) = shared_path("data/optoforce_wire/capture.bin") {
        check(&std::fs::read(path).expect("readable"), 34_374);
    }
}

/// Feeds the stream; checks the frames and touches that the daemon counted.
fn check(stream: &[u8], frames: u64) {
    let _alone = lock_exclusive();
    let bus = FreshBus::new("opto");
    let folder = tempfile::TempDir::new().expect("a folder");
    let config = folder.path().join("atas.toml");
    std::fs::write(&config, CONFIG).expect("writable");
    let (master, tty) = pseudo_terminal();
    let daemon = [
        "--bus",
        bus.as_str(),
        "--config",
        config.to_str().expect("UTF-8"),
    ];
    let _daemon = Process::start("atasd", &daemon);
    let observer = Bus::open(&bus, "observer", Realtime::No).expect("a bus");
    let mut statuses = observer
        .subscriber::<Status>(service::STATUS)
        .expect("a subscriber");
    let mut sensors = observer
        .subscriber::<SensorStatus>(service::SENSOR_STATUS)
        .expect("a subscriber");
    let mut status = Status::default();
    wait_for("the daemon", || {
        statuses
            .newest(&mut status)
            .expect("readable")
            .then_some(())
    });
    let sensor = [
        "optoforce",
        "--device",
        &tty,
        "--hand",
        "left",
        "--bus",
        bus.as_str(),
        "--no-configure",
        "--newtons-per-count",
        "300/7925,300/8641,2000/6049",
    ];
    let sensor = Process::start("atas-sensor", &sensor);
    let mut report = SensorStatus::default();
    wait_for("the sensor", || {
        sensors.newest(&mut report).expect("readable").then_some(())
    });
    feed(&master, stream);
    wait_for("every frame", || {
        statuses.newest(&mut status).expect("readable");
        let hand = status.hands[0];
        let refused = hand.corrupt + hand.foreign + hand.mistimed;
        (hand.frames + hand.lost + refused >= frames).then_some(())
    });
    let hand = status.hands[0];
    assert_eq!(
        (hand.frames, hand.lost, hand.touches[0]),
        (frames, 0, TOUCHES),
        "{}",
        sensor.log()
    );
    assert_eq!((hand.corrupt, hand.foreign, hand.mistimed), (0, 0, 0));
}
