//! Round trip of one frame between two polling processes: shared memory of this project, Unix
//! socket, zenoh over TCP, zenoh with shared memory. Half of the round trip is reported.

use std::io::Write;
use std::os::unix::net::UnixStream;
use std::time::{Duration, Instant};

use anyhow::Context;
use atas_client::percentiles;
use atas_evaluation::median;
use shm_bus::{Bus, Realtime, now_ns};
use shm_schemas::{HandFrame, Percentiles, service};

use super::Plan;
use super::echo::{PAYLOAD_BYTES, read_polling};
use super::site::Site;
use super::tool::{self, Notes};
use atas_processes::child::{Child, sibling_program};

const ROUNDS: u64 = 5_000;
/// Round trips before the measurement, for caches and connections.
const WARM_UP: u64 = 500;
/// Longest time for a reply, and for the other process to start.
const REPLY_TIMEOUT: Duration = Duration::from_secs(5);
/// Interval of the first requests until the echo process replies.
const RETRY_INTERVAL: Duration = Duration::from_millis(20);
/// Benchmark program for zenoh, not part of the workspace.
const ZENOH: &str = "atas-bench-zenoh";
const ZENOH_HINT: &str = "to compare with zenoh: cargo install --locked --path tests/zenoh; without it \
    transports_us.zenoh is null";
const ZENOH_TIMEOUT: Duration = Duration::from_secs(60);

/// Half round-trip time, µs: median over the repeats of p50.
pub(super) struct Transports {
    pub(super) iceoryx2: Option<f64>,
    pub(super) unix_socket: Option<f64>,
    pub(super) zenoh: Option<f64>,
    pub(super) zenoh_shared_memory: Option<f64>,
}

impl Transports {
    pub(super) fn measure(plan: &Plan<'_>, notes: &mut Notes) -> anyhow::Result<Self> {
        let (mut shared, mut socket) = (Vec::new(), Vec::new());
        let (mut zenoh, mut zenoh_shared) = (Vec::new(), Vec::new());
        for _ in 0..plan.repeats {
            shared.push(half_us(&shared_memory(plan)?));
            socket.push(half_us(&unix_socket(plan)?));
            zenoh.extend(middleware("tcp", plan, notes)?);
            zenoh_shared.extend(middleware("shm", plan, notes)?);
        }
        Ok(Self {
            iceoryx2: median(shared),
            unix_socket: median(socket),
            zenoh: median(zenoh),
            zenoh_shared_memory: median(zenoh_shared),
        })
    }
}

fn half_us(round: &Percentiles) -> f64 {
    round.p50_ns as f64 * 0.5e-3
}

pub(super) fn start_echo(site: &Site, by: &str) -> anyhow::Result<Child> {
    let socket = site.folder().join("socket");
    let socket = socket.display().to_string();
    let bus = site.bus().as_str();
    let arguments = ["bench", "echo", by, "--bus", bus, "--socket", &socket];
    Child::start("atas-lab", &arguments, site.folder())
}

fn shared_memory(plan: &Plan<'_>) -> anyhow::Result<Percentiles> {
    let site = Site::new()?;
    let mut echo = start_echo(&site, "iceoryx2")?;
    let bus = Bus::open(site.bus(), "bench", Realtime::Yes)?;
    let [there, back] = service::HAND_FRAME;
    let mut pongs = bus.subscriber::<HandFrame>(back)?;
    let pings = bus.publisher::<HandFrame>(there)?;
    let (mut ping, mut pong) = (HandFrame::default(), HandFrame::default());
    rounds(plan, &mut echo, |sequence, limit| {
        ping.stamp.sequence = sequence;
        pings.send(&ping)?;
        poll(limit, || {
            Ok(pongs.newest(&mut pong)? && pong.stamp.sequence == sequence)
        })
    })
}

fn unix_socket(plan: &Plan<'_>) -> anyhow::Result<Percentiles> {
    let site = Site::new()?;
    let mut echo = start_echo(&site, "unix-socket")?;
    let path = site.folder().join("socket");
    let begin = Instant::now();
    let mut stream = loop {
        echo.check()?;
        match UnixStream::connect(&path) {
            Ok(stream) => break stream,
            Err(error) if begin.elapsed() > REPLY_TIMEOUT => {
                return Err(error).with_context(|| format!("could not reach {}", path.display()));
            }
            Err(_) => std::thread::sleep(Duration::from_millis(2)),
        }
    };
    stream.set_nonblocking(true)?;
    let mut bytes = [0; PAYLOAD_BYTES];
    rounds(plan, &mut echo, |_, _| {
        stream.write_all(&bytes)?;
        read_polling(&mut stream, &mut bytes, plan.interrupt)
    })
}

/// Measures zenoh over loopback TCP or with shared memory. Both ends are processes of its program,
/// which prints half of the round trip, p50, µs.
fn middleware(by: &str, plan: &Plan<'_>, notes: &mut Notes) -> anyhow::Result<Option<f64>> {
    let site = Site::new()?;
    let program = sibling_program(ZENOH).unwrap_or_else(|_| ZENOH.into());
    let place = site.folder().join("place").display().to_string();
    let arguments = ["echo", by, &place];
    let echo = tool::start(
        &program,
        ZENOH,
        ZENOH_HINT,
        &arguments,
        site.folder(),
        notes,
    )?;
    let Some(_echo) = echo else {
        return Ok(None);
    };
    let size = PAYLOAD_BYTES.to_string();
    let other = Site::new()?;
    let mut ping = Child::start_program(
        &program,
        ZENOH,
        &["ping", by, &place, &size],
        other.folder(),
    )?;
    let ended = tool::wait(&mut ping, ZENOH_TIMEOUT, plan.interrupt);
    plan.interrupt.check("the bench was measuring zenoh")?;
    let half = ping.results().first().and_then(|line| line.parse().ok());
    if !ended.is_ok_and(|status| status.success()) || half.is_none() {
        notes.add(format!(
            "zenoh by {by} was not measured ({})",
            ping.tail().trim()
        ));
    }
    Ok(half)
}

/// Measures round trips after repeating the first request until the echo process replies.
pub(super) fn rounds(
    plan: &Plan<'_>,
    echo: &mut Child,
    mut round: impl FnMut(u64, Duration) -> anyhow::Result<bool>,
) -> anyhow::Result<Percentiles> {
    let begin = Instant::now();
    let mut sequence = 0;
    while !round(sequence, RETRY_INTERVAL)? {
        plan.interrupt
            .check("the bench was waiting for the echo process")?;
        echo.check()?;
        anyhow::ensure!(
            begin.elapsed() < REPLY_TIMEOUT,
            "the echo process did not start within \
            {REPLY_TIMEOUT:?}"
        );
        sequence += 1;
    }
    let mut durations_ns = Vec::new();
    for index in 0..WARM_UP + ROUNDS {
        sequence += 1;
        let begin_ns = now_ns();
        let answered = round(sequence, REPLY_TIMEOUT)?;
        let duration_ns = now_ns() - begin_ns;
        plan.interrupt
            .check("the bench was measuring a transport")?;
        anyhow::ensure!(
            answered,
            "the echo process did not reply within {REPLY_TIMEOUT:?}"
        );
        if index >= WARM_UP {
            durations_ns.push(duration_ns);
        }
    }
    Ok(percentiles::from_unsorted(durations_ns))
}

pub(super) fn poll(
    limit: Duration,
    mut answered: impl FnMut() -> anyhow::Result<bool>,
) -> anyhow::Result<bool> {
    let begin_ns = now_ns();
    while !answered()? {
        if u128::from(now_ns() - begin_ns) > limit.as_nanos() {
            return Ok(false);
        }
        std::hint::spin_loop();
    }
    Ok(true)
}
