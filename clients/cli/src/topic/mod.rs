//! `atas topic`: the bus itself. Only services that the non-real-time side publishes are read; those of the 1 kHz loop have
//! a closed set of peers, and what is known of them the daemon's status tells.

mod stream;

use std::time::{Duration, Instant};

use atas_client::{POLL, Session};
use atas_console::arguments::Topic;
use atas_console::{Ended, Exit, Interrupt, Output, number, table};
use serde_json::json;
use shm_bus::{BusName, STREAMS, Stream, now_ns};

use stream::{Told, open};

/// `atas topic`.
pub(crate) fn topic(
    action: &Topic,
    interrupt: &Interrupt,
    output: &mut Output,
) -> anyhow::Result<()> {
    match action {
        Topic::List(bus) => list(&bus.bus, output),
        Topic::Echo {
            service,
            count,
            bus,
        } => echo(&bus.bus, named(service)?, *count, interrupt, output),
        Topic::Hz {
            service,
            seconds,
            bus,
        } => hz(&bus.bus, named(service)?, *seconds, interrupt, output),
    }
}

/// The stream of this name, or of this end of a name.
fn named(name: &str) -> anyhow::Result<&'static Stream> {
    let is_meant = |stream: &&Stream| {
        let end = stream.service.strip_suffix(name);
        end.is_some_and(|rest| rest.is_empty() || rest.ends_with('/'))
    };
    let mut meant = STREAMS.iter().filter(is_meant);
    match (meant.next(), meant.next()) {
        (Some(stream), None) => Ok(stream),
        _ => {
            let names: Vec<&str> = STREAMS.iter().map(|stream| short(stream.service)).collect();
            let sentence = format!(
                "no service is named {name:?}; there are {}",
                names.join(", ")
            );
            Err(Ended::with(Exit::Usage, sentence))
        }
    }
}

/// A service's name without the common beginning and its version.
fn short(service: &str) -> &str {
    service.splitn(3, '/').nth(2).unwrap_or(service)
}

fn list(bus: &BusName, output: &mut Output) -> anyhow::Result<()> {
    let session = Session::existing(bus)?;
    let mut rows = table(&[
        "service", "payload", "bytes", "writers", "readers", "read by",
    ]);
    for stream in &STREAMS {
        let traffic = session.bus().traffic(stream)?;
        let readable = stream::is_readable(stream);
        if output.is_json() {
            output.json(&json!({
                "service": stream.service,
                "payload": stream.payload,
                "bytes": stream.payload_bytes,
                "writers": traffic.writers,
                "readers": traffic.readers,
                "readable": readable,
            }))?;
        }
        rows.add_row([
            short(stream.service).to_owned(),
            stream.payload.to_owned(),
            stream.payload_bytes.to_string(),
            traffic.writers.to_string(),
            traffic.readers.to_string(),
            if readable { "anyone" } else { "the loop" }.to_owned(),
        ]);
    }
    if output.is_json() {
        Ok(())
    } else {
        output.table(rows)
    }
}

fn echo(
    bus: &BusName,
    stream: &'static Stream,
    count: Option<u64>,
    interrupt: &Interrupt,
    output: &mut Output,
) -> anyhow::Result<()> {
    let session = Session::existing(bus)?;
    let mut heard = open(&session, stream)?;
    let mut left = count.unwrap_or(u64::MAX);
    while left > 0 && !interrupt.is_set() {
        let mut told = Vec::new();
        heard.listen(true, &mut told)?;
        if told.is_empty() {
            std::thread::sleep(POLL);
        }
        for Told { value, .. } in told
            .into_iter()
            .take(usize::try_from(left).unwrap_or(usize::MAX))
        {
            left -= 1;
            if output.is_json() {
                output.json(&value)?;
            } else {
                output.line(format_args!("{value:#}\n---"))?;
            }
        }
    }
    Ok(())
}

fn hz(
    bus: &BusName,
    stream: &'static Stream,
    window: Duration,
    interrupt: &Interrupt,
    output: &mut Output,
) -> anyhow::Result<()> {
    let session = Session::existing(bus)?;
    let mut heard = open(&session, stream)?;
    let mut counted = Counted::default();
    // What waited before the window does not count.
    heard.listen(false, &mut Vec::new())?;
    let begin = Instant::now();
    while begin.elapsed() < window && !interrupt.is_set() {
        std::thread::sleep(POLL);
        let mut told = Vec::new();
        heard.listen(false, &mut told)?;
        told.iter().for_each(|told| counted.add(told));
    }
    let rate_hz = counted.payloads as f64 / begin.elapsed().as_secs_f64();
    let age_ns = counted
        .newest_ns
        .map(|newest_ns| now_ns().saturating_sub(newest_ns));
    if output.is_json() {
        return output.json(&json!({
            "service": stream.service,
            "payloads": counted.payloads,
            "lost": counted.lost,
            "rate_hz": rate_hz,
            "newest_age_ns": age_ns,
        }));
    }
    let age = age_ns.map_or("nothing came".to_owned(), |ns| {
        format!("the newest is {} ms old", number(ns as f64 * 1e-6, 1))
    });
    output.line(format_args!(
        "{}: {} a second, {} lost, {age}",
        short(stream.service),
        number(rate_hz, 1),
        counted.lost
    ))
}

/// What came in a window.
#[derive(Debug, Default)]
struct Counted {
    payloads: u64,
    lost: u64,
    newest_ns: Option<u64>,
    next: Option<(u64, u64)>,
}

impl Counted {
    fn add(&mut self, told: &Told) {
        self.payloads += 1;
        let stamp = told.stamp;
        if let Some((epoch, next)) = self.next
            && epoch == stamp.writer_epoch
        {
            self.lost += stamp.sequence.saturating_sub(next);
        }
        self.next = Some((stamp.writer_epoch, stamp.sequence.saturating_add(1)));
        self.newest_ns = Some(stamp.captured_ns);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::Value;
    use shm_schemas::Stamp;

    #[test]
    fn a_service_is_named_by_the_end_of_its_name() {
        let check = |name: &str, expected: Option<&str>| {
            let found = named(name).ok().map(|stream| short(stream.service));
            assert_eq!(found, expected, "{name}");
        };
        check("status", Some("status"));
        check("sensor-status", Some("sensor-status"));
        check("atas/v2/view", Some("view"));
        check("hand-frame/left", Some("hand-frame/left"));
        check("left", Some("hand-frame/left"));
        check("tatus", None);
        check("", None);
    }

    #[test]
    fn gaps_in_a_writers_sequence_are_losses() {
        let mut counted = Counted::default();
        for (writer_epoch, sequence) in [(1, 5), (1, 6), (1, 9), (2, 0), (2, 1)] {
            let stamp = Stamp {
                sequence,
                writer_epoch,
                captured_ns: sequence,
            };
            counted.add(&Told {
                stamp,
                value: Value::Null,
            });
        }
        assert_eq!((counted.payloads, counted.lost), (5, 2));
    }
}
