//! `atas remote check`: connects, shows the right of this client and measures round trips.

use std::time::{Duration, Instant};

use atas_console::Output;
use serde_json::json;

use super::config::Target;
use super::{CONNECT, connect_error, request, unexpected};
use crate::frame::Kind;
use crate::link::{Link, LinkError};
use crate::message::{Reply, Work};

/// Longest wait for an echo.
const ECHO: Duration = Duration::from_secs(5);

pub(super) fn check(target: &Target, count: u16, output: &mut Output) -> anyhow::Result<()> {
    let begin = Instant::now();
    let begun = request(target, Work::Check, begin + CONNECT);
    let (mut link, reply) = begun.map_err(|error| connect_error(target, &error))?;
    let connected = begin.elapsed();
    let Reply::Checked {
        version,
        client,
        right,
    } = reply
    else {
        return Err(unexpected(reply));
    };
    let trips = measure(&mut link, count).map_err(|error| connect_error(target, &error))?;
    link.close();
    let at = |share: f64| milliseconds(trips[((trips.len() - 1) as f64 * share) as usize]);
    let (p50, p99, max) = (at(0.5), at(0.99), at(1.0));
    let connect_ms = milliseconds(connected);
    if output.is_json() {
        return output.json(&json!({
            "version": version,
            "client": client,
            "right": right,
            "connect_ms": connect_ms,
            "count": count,
            "round_trip_ms": { "p50": p50, "p99": p99, "max": max },
        }));
    }
    output.line(format!(
        "{}: version {version}, client {client} with the right \"{right}\"",
        target.label
    ))?;
    output.line(format!(
        "connected in {connect_ms:.1} ms; {count} round trips: p50 {p50:.2} ms, p99 {p99:.2} ms, \
         max {max:.2} ms"
    ))
}

fn milliseconds(time: Duration) -> f64 {
    time.as_secs_f64() * 1e3
}

/// Returns the round-trip times, the shortest first.
fn measure(link: &mut Link, count: u16) -> Result<Vec<Duration>, LinkError> {
    let mut trips = Vec::with_capacity(count.into());
    for number in 0..count {
        let begin = Instant::now();
        link.send(Kind::Echo, &number.to_be_bytes())?;
        link.wait_frame(begin + ECHO)?;
        trips.push(begin.elapsed());
    }
    trips.sort();
    Ok(trips)
}
