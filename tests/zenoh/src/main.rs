//! One payload there and back between two processes through zenoh on this machine: over TCP, or in shared memory that
//! zenoh's messages over TCP only point into.
//!
//! ```text
//! atas-bench-zenoh echo tcp|shm FILE          listens, writes where into FILE, answers until it is ended
//! atas-bench-zenoh ping tcp|shm FILE BYTES    prints the median of half a round, µs
//! ```
//!
//! Both ends poll, send each message at once (`express`) and look for no one else on the network. Every wait has its limit.

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

const THERE: &str = "atas/bench/there";
const BACK: &str = "atas/bench/back";
/// Rounds that are measured, and rounds before.
const ROUNDS: usize = 5_000;
const WARM_UP: usize = 500;
/// How long the other end may take to be there, and to answer.
const PATIENCE: Duration = Duration::from_secs(10);
/// The first message is sent again after this: the echo may not have heard it.
const ASK_AGAIN: Duration = Duration::from_millis(50);
/// How long an echo lives, whatever becomes of its other end.
const LIFE: Duration = Duration::from_secs(120);
/// Shared memory of one end: three hundred payloads, so that nobody waits for the other to let go of one.
const SHARED_BYTES: usize = 1 << 20;
const USAGE: &str =
    "could not understand the arguments; needs `echo tcp|shm FILE` or `ping tcp|shm FILE BYTES`";

fn main() -> Result<(), Failure> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let words: Vec<&str> = arguments.iter().map(String::as_str).collect();
    match words[..] {
        ["echo", by, place] => echo(by.parse()?, Path::new(place)),
        ["ping", by, place, bytes] => ping(by.parse()?, Path::new(place), bytes.parse()?),
        _ => Err(USAGE.into()),
    }
}

/// Where payloads lie on their way.
#[derive(Clone, Copy, PartialEq, Eq)]
enum By {
    Tcp,
    SharedMemory,
}

impl std::str::FromStr for By {
    type Err = Failure;

    fn from_str(word: &str) -> Result<Self, Failure> {
        match word {
            "tcp" => Ok(Self::Tcp),
            "shm" => Ok(Self::SharedMemory),
            _ => Err(USAGE.into()),
        }
    }
}

/// Makes a payload: copies the bytes once, as a sensor process writes its frame once.
type Copied = Box<dyn Fn(&[u8]) -> Result<ZBytes, Failure>>;

fn copied(by: By) -> Result<Copied, Failure> {
    if by == By::Tcp {
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

fn open(by: By, key: &str, place: &str) -> Result<Session, Failure> {
    let mut config = Config::default();
    config.insert_json5("mode", "\"peer\"")?;
    config.insert_json5(key, &format!("[\"{place}\"]"))?;
    let is_shared = (by == By::SharedMemory).to_string();
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

    /// Polls for a message.
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

fn echo(by: By, file: &Path) -> Result<(), Failure> {
    let port = TcpListener::bind("127.0.0.1:0")?.local_addr()?.port();
    let place = format!("tcp/127.0.0.1:{port}");
    let session = open(by, "listen/endpoints", &place)?;
    let (ports, copied) = (Ports::open(&session, BACK, THERE)?, copied(by)?);
    let draft = file.with_extension("draft");
    std::fs::write(&draft, place)?;
    std::fs::rename(draft, file)?;
    let begin = Instant::now();
    while begin.elapsed() < LIFE {
        if let Some(sample) = ports.poll(ASK_AGAIN)? {
            // What is compared must be what its name says.
            if sample.payload().as_shm().is_some() != (by == By::SharedMemory) {
                return Err("the payload came another way than it was asked to".into());
            }
            ports.out.put(copied(&sample.payload().to_bytes())?).wait()?;
        }
    }
    Ok(())
}

fn ping(by: By, file: &Path, bytes: usize) -> Result<(), Failure> {
    let begin = Instant::now();
    while !file.exists() {
        if begin.elapsed() > PATIENCE {
            return Err("the echo did not say where it is".into());
        }
        std::thread::sleep(ASK_AGAIN);
    }
    let session = open(by, "connect/endpoints", &std::fs::read_to_string(file)?)?;
    let (ports, copied) = (Ports::open(&session, THERE, BACK)?, copied(by)?);
    let payload = vec![7_u8; bytes];
    let round = |limit| round(&ports, || copied(&payload), limit);
    while round(ASK_AGAIN)?.is_none() {
        if begin.elapsed() > PATIENCE {
            return Err("the echo does not answer".into());
        }
    }
    // Answers to what was asked more than once.
    while ports.poll(ASK_AGAIN)?.is_some() {}
    let mut halves_ns = Vec::with_capacity(ROUNDS);
    for index in 0..WARM_UP + ROUNDS {
        let took = round(PATIENCE)?.ok_or("the echo stopped answering")?;
        if index >= WARM_UP {
            halves_ns.push(took.as_nanos() / 2);
        }
    }
    halves_ns.sort_unstable();
    println!("{:.3}", halves_ns[ROUNDS / 2] as f64 * 1e-3);
    Ok(())
}

/// How long a payload took there and back.
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
