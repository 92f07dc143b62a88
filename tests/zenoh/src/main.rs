//! Round trip of one payload between two local processes through zenoh: over TCP, or in shared
//! memory with TCP notifications.
//!
//! ```text
//! atas-bench-zenoh echo tcp|shm FILE          listens, writes its address into FILE, replies
//! atas-bench-zenoh ping tcp|shm FILE BYTES    prints the median of half a round trip, µs
//! ```
//!
//! Both ends poll, send each message at once (`express`) and do not scout the network. All waits
//! have a timeout.

use std::net::TcpListener;
use std::path::Path;
use std::time::{Duration, Instant};

use zenoh::bytes::ZBytes;
use zenoh::handlers::FifoChannelHandler;
use zenoh::pubsub::{Publisher, Subscriber};
use zenoh::qos::CongestionControl;
use zenoh::sample::Sample;
use zenoh::shm::{BlockOn, GarbageCollect, ShmProviderBuilder};
use zenoh::{Config, Session, Wait};

type Failure = Box<dyn std::error::Error + Send + Sync>;

const REQUEST_KEY: &str = "atas/bench/there";
const REPLY_KEY: &str = "atas/bench/back";
/// Measured rounds, and rounds before the measurement.
const ROUNDS: usize = 5_000;
const WARM_UP: usize = 500;
/// Timeout of the other end's start and of its replies.
const TIMEOUT: Duration = Duration::from_secs(10);
/// Interval of resending the first message, which the echo may have missed.
const RESEND_INTERVAL: Duration = Duration::from_millis(50);
/// Maximum lifetime of an echo.
const LIFETIME: Duration = Duration::from_secs(120);
/// Shared memory of one end: three hundred payloads, so that no end waits for a free buffer.
const SHARED_BYTES: usize = 1 << 20;
const USAGE: &str =
    "could not parse the arguments: needs `echo tcp|shm FILE` or `ping tcp|shm FILE BYTES`";

fn main() -> Result<(), Failure> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let words: Vec<&str> = arguments.iter().map(String::as_str).collect();
    match words[..] {
        ["echo", by, place] => echo(by.parse()?, Path::new(place)),
        ["ping", by, place, bytes] => ping(by.parse()?, Path::new(place), bytes.parse()?),
        _ => Err(USAGE.into()),
    }
}

/// Transport of the payload.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Transport {
    Tcp,
    SharedMemory,
}

impl std::str::FromStr for Transport {
    type Err = Failure;

    fn from_str(word: &str) -> Result<Self, Failure> {
        match word {
            "tcp" => Ok(Self::Tcp),
            "shm" => Ok(Self::SharedMemory),
            _ => Err(USAGE.into()),
        }
    }
}

/// Creates a payload with one copy of the bytes, as a sensor process writes its frame.
type Copied = Box<dyn Fn(&[u8]) -> Result<ZBytes, Failure>>;

fn payload_factory(by: Transport) -> Result<Copied, Failure> {
    if by == Transport::Tcp {
        return Ok(Box::new(|bytes| Ok(bytes.into())));
    }
    let memory = ShmProviderBuilder::default_backend(SHARED_BYTES).wait()?;
    Ok(Box::new(move |bytes| {
        let place = memory.alloc(bytes.len());
        let mut place = place.with_policy::<BlockOn<GarbageCollect>>().wait()?;
        place.copy_from_slice(bytes);
        Ok(place.into())
    }))
}

fn open(by: Transport, key: &str, place: &str) -> Result<Session, Failure> {
    let mut config = Config::default();
    config.insert_json5("mode", "\"peer\"")?;
    config.insert_json5(key, &format!("[\"{place}\"]"))?;
    let is_shared = (by == Transport::SharedMemory).to_string();
    config.insert_json5("transport/shared_memory/enabled", &is_shared)?;
    config.insert_json5("scouting/multicast/enabled", "false")?;
    config.insert_json5("scouting/gossip/enabled", "false")?;
    zenoh::open(config).wait()
}

struct Ports<'a> {
    out: Publisher<'a>,
    back: Subscriber<FifoChannelHandler<Sample>>,
}

impl<'a> Ports<'a> {
    fn open(session: &'a Session, out: &'static str, back: &'static str) -> Result<Self, Failure> {
        let out = session
            .declare_publisher(out)
            .express(true)
            .congestion_control(CongestionControl::Block);
        Ok(Self {
            out: out.wait()?,
            back: session.declare_subscriber(back).wait()?,
        })
    }

    /// Polls for a message until the timeout.
    fn poll(&self, limit: Duration) -> Result<Option<Sample>, Failure> {
        let begin = Instant::now();
        loop {
            if let Some(sample) = self.back.try_recv()? {
                return Ok(Some(sample));
            }
            if begin.elapsed() > limit {
                return Ok(None);
            }
            std::hint::spin_loop();
        }
    }
}

fn echo(by: Transport, file: &Path) -> Result<(), Failure> {
    let port = TcpListener::bind("127.0.0.1:0")?.local_addr()?.port();
    let place = format!("tcp/127.0.0.1:{port}");
    let session = open(by, "listen/endpoints", &place)?;
    let (ports, payload_factory) = (
        Ports::open(&session, REPLY_KEY, REQUEST_KEY)?,
        payload_factory(by)?,
    );
    let draft = file.with_extension("draft");
    std::fs::write(&draft, place)?;
    std::fs::rename(draft, file)?;
    let begin = Instant::now();
    while begin.elapsed() < LIFETIME {
        if let Some(sample) = ports.poll(RESEND_INTERVAL)? {
            // The measured transport must be the requested one.
            if sample.payload().as_shm().is_some() != (by == Transport::SharedMemory) {
                return Err("the payload did not use the requested transport".into());
            }
            ports
                .out
                .put(payload_factory(&sample.payload().to_bytes())?)
                .wait()?;
        }
    }
    Ok(())
}

fn ping(by: Transport, file: &Path, bytes: usize) -> Result<(), Failure> {
    let begin = Instant::now();
    while !file.exists() {
        if begin.elapsed() > TIMEOUT {
            return Err("timed out waiting for the address of the echo".into());
        }
        std::thread::sleep(RESEND_INTERVAL);
    }
    let session = open(by, "connect/endpoints", &std::fs::read_to_string(file)?)?;
    let (ports, payload_factory) = (
        Ports::open(&session, REQUEST_KEY, REPLY_KEY)?,
        payload_factory(by)?,
    );
    let payload = vec![7_u8; bytes];
    let round = |limit| round(&ports, || payload_factory(&payload), limit);
    while round(RESEND_INTERVAL)?.is_none() {
        if begin.elapsed() > TIMEOUT {
            return Err("timed out waiting for a reply of the echo".into());
        }
    }
    // Discards replies to repeated messages.
    while ports.poll(RESEND_INTERVAL)?.is_some() {}
    let mut halves_ns = Vec::with_capacity(ROUNDS);
    for index in 0..WARM_UP + ROUNDS {
        let took = round(TIMEOUT)?.ok_or("the echo stopped replying")?;
        if index >= WARM_UP {
            halves_ns.push(took.as_nanos() / 2);
        }
    }
    halves_ns.sort_unstable();
    println!("{:.3}", halves_ns[ROUNDS / 2] as f64 * 1e-3);
    Ok(())
}

/// Returns the duration of one round trip; `None` on timeout.
fn round(
    ports: &Ports<'_>,
    payload: impl FnOnce() -> Result<ZBytes, Failure>,
    limit: Duration,
) -> Result<Option<Duration>, Failure> {
    let begin = Instant::now();
    ports.out.put(payload()?).wait()?;
    let answer = ports.poll(limit)?;
    Ok(answer.map(|_| begin.elapsed()))
}
