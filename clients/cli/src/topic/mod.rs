//! `atas topic`: services of the bus.
//!
//! Only services published outside the control loop are readable. Those of the 1 kHz loop have a
//! fixed set of peers; `atas status` reports their rates.

mod stream;

use std::time::{Duration, Instant};

use atas_client::{POLL, Session};
use atas_console::arguments::Topic;
use atas_console::{Exit, ExitError, Interrupt, Output, number, table};
use serde_json::json;
use shm_bus::{BusName, STREAMS, Stream, now_ns};

use stream::{Received, open};

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
        } => echo(&bus.bus, find_stream(service)?, *count, interrupt, output),
        Topic::Hz {
            service,
            seconds,
            bus,
        } => hz(&bus.bus, find_stream(service)?, *seconds, interrupt, output),
    }
}

/// Finds a stream by its name or the end of its name.
fn find_stream(name: &str) -> anyhow::Result<&'static Stream> {
    let is_meant = |stream: &&Stream| {
        let end = stream.service.strip_suffix(name);
        end.is_some_and(|rest| rest.is_empty() || rest.ends_with('/'))
    };
    let mut meant = STREAMS.iter().filter(is_meant);
    match (meant.next(), meant.next()) {
        (Some(stream), None) => Ok(stream),
        _ => {
            let names: Vec<&str> = STREAMS
                .iter()
                .map(|stream| short_name(stream.service))
                .collect();
            let sentence = format!("unknown service {name:?}; use one of {}", names.join(", "));
            Err(ExitError::with_code(Exit::Usage, sentence))
        }
    }
}

/// Removes prefix and version from a service name.
fn short_name(service: &str) -> &str {
    service.splitn(3, '/').nth(2).unwrap_or(service)
}

fn list(bus: &BusName, output: &mut Output) -> anyhow::Result<()> {
    let session = Session::existing(bus)?;
    let mut rows = table(&[
        "service", "payload", "bytes", "writers", "readers", "read by",
    ]);
    for stream in &STREAMS {
        let traffic = session.bus().port_count(stream)?;
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
            short_name(stream.service).to_owned(),
            stream.payload.to_owned(),
            stream.payload_bytes.to_string(),
            traffic.writers.to_string(),
            traffic.readers.to_string(),
            if readable { "anyone" } else { "control loop" }.to_owned(),
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
    let mut received = open(&session, stream)?;
    let mut left = count.unwrap_or(u64::MAX);
    while left > 0 && !interrupt.is_set() {
        let mut reported = Vec::new();
        received.read_waiting(true, &mut reported)?;
        if reported.is_empty() {
            std::thread::sleep(POLL);
        }
        for Received { value, .. } in reported
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
    let mut received = open(&session, stream)?;
    let mut counted = PayloadCount::default();
    // Payloads from before the window do not count.
    received.read_waiting(false, &mut Vec::new())?;
    let begin = Instant::now();
    while begin.elapsed() < window && !interrupt.is_set() {
        std::thread::sleep(POLL);
        let mut reported = Vec::new();
        received.read_waiting(false, &mut reported)?;
        reported.iter().for_each(|reported| counted.add(reported));
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
    let age = age_ns.map_or("no payload".to_owned(), |ns| {
        format!("the newest is {} ms old", number(ns as f64 * 1e-6, 1))
    });
    output.line(format_args!(
        "{}: {} a second, {} lost, {age}",
        short_name(stream.service),
        number(rate_hz, 1),
        counted.lost
    ))
}

#[derive(Debug, Default)]
struct PayloadCount {
    payloads: u64,
    lost: u64,
    newest_ns: Option<u64>,
    next: Option<(u64, u64)>,
}

impl PayloadCount {
    fn add(&mut self, reported: &Received) {
        self.payloads += 1;
        let stamp = reported.stamp;
        if let Some((epoch, next)) = self.next
            && epoch == stamp.writer_epoch
        {
            self.lost = self
                .lost
                .saturating_add(stamp.sequence.saturating_sub(next));
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
    fn service_is_found_by_name_suffix() {
        let check = |name: &str, expected: Option<&str>| {
            let found = find_stream(name)
                .ok()
                .map(|stream| short_name(stream.service));
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
    fn sequence_gaps_count_as_lost() {
        let mut counted = PayloadCount::default();
        for (writer_epoch, sequence) in [(1, 5), (1, 6), (1, 9), (2, 0), (2, 1)] {
            let stamp = Stamp {
                sequence,
                writer_epoch,
                captured_ns: sequence,
            };
            counted.add(&Received {
                stamp,
                value: Value::Null,
            });
        }
        assert_eq!((counted.payloads, counted.lost), (5, 2));
    }
}
