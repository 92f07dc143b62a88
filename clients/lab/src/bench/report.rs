//! Bench report: ratios within each repeat, medians over the repeats.

use atas_client::percentiles;
use atas_console::Output;
use atas_evaluation::median;
use serde_json::{Value, json};
use shm_schemas::{Percentiles, TickReport};

use super::counts::Counts;
use super::punctual::{Loaded, Measured, References, Repeat, fresh_share};
use super::tool::Notes;
use super::transport::Transports;
use super::{Plan, echo, machine, tables};

pub(super) struct Report {
    pub(super) idle: Vec<Repeat>,
    pub(super) loaded: Vec<Loaded>,
    pub(super) counts: Counts,
    pub(super) transports: Transports,
    pub(super) notes: Notes,
}

impl Report {
    /// Formats the figures as JSON; `null` if not measured.
    pub(super) fn json(&self, plan: &Plan<'_>) -> Value {
        let locked = || self.idle.iter().map(|repeat| &repeat.locked);
        let age = |measured: &Measured| percentiles::from_unsorted(measured.frame_age_ns.clone());
        let of_locked = |value: fn(&Measured) -> f64| median(locked().map(value).collect());
        let of_answer = |value: fn(&Repeat) -> f64| median(self.idle.iter().map(value).collect());
        let ticks = self.counts.ticks.as_ref();
        json!({
            "wake": {
                "p50_ratio": self.wake_ratio(P50),
                "p99_ratio": self.wake_ratio(P99),
                "p999_ratio": self.wake_ratio(P999),
                "cpu_percent": of_locked(|m| m.tick_cpu_percent),
                "idle": wake(&self.idle.iter().map(Compared::from).collect::<Vec<_>>()),
                "not_kept_awake_us": over(self.idle.iter().map(|r| r.not_kept_awake.wake)),
                "loaded": wake(&self.loaded.iter().map(Compared::from).collect::<Vec<_>>()),
            },
            "tick_us": ticks.map(|ticks| &ticks.body_us),
            "tick_stages_us": ticks.map(|ticks| &ticks.stages_us),
            "allocs_per_tick": ticks.map(|ticks| ticks.allocations_per_tick),
            "allocs_max": ticks.map(|ticks| ticks.allocations_max),
            "syscalls_per_tick": self.counts.syscalls_per_tick,
            "instructions_per_tick": self.counts.instructions_per_tick,
            "recording": {
                "body_ratio": ticks.map(|ticks| ticks.recording_ratio),
                "tick_ratio": ticks.map(|ticks| ticks.recording_tick_ratio),
                "after_body_us": ticks.map(|ticks| ticks.recording_us),
            },
            "frame_age_us": {
                "locked": over(locked().map(age)),
                "loaded": over(self.loaded.iter().map(|repeat| age(&repeat.locked))),
                "free": self.free_frame_age(),
                "fresh_share": {
                    "locked": fresh_share(locked()),
                    "free": fresh_share(self.free()),
                },
            },
            "sensor_to_command_ratio": of_answer(|repeat| repeat.answer.ratio()),
            "sensor_to_command_us": {
                "polling": of_answer(|repeat| us(repeat.answer.daemon.p50_ns)),
                "ping_pong": of_answer(|repeat| us(repeat.answer.ping_pong.p50_ns)),
                "tick_body": of_answer(|repeat| us(repeat.answer.body.p50_ns)),
                "locked": over(self.idle.iter().map(|r| r.locked.sensor_to_command)),
                "free": over(self.free().map(|m| m.sensor_to_command)),
            },
            "transports_us": {
                "iceoryx2": self.transports.iceoryx2,
                "unix_socket": self.transports.unix_socket,
                "zenoh": self.transports.zenoh,
                "zenoh_shared_memory": self.transports.zenoh_shared_memory,
                "payload_bytes": echo::PAYLOAD_BYTES,
            },
            "daemon": {
                "tick_us": over(locked().map(|m| m.body)),
                "stages_us": stages(locked().collect()),
                "cpu_percent": of_locked(|m| m.cpu_percent),
                "resident_mib": of_locked(|m| m.resident_mib),
                "first_tick_ms": median(locked().filter_map(|m| m.first_tick_ns).map(|ns| ns as f64 * 1e-6).collect()),
                "page_faults": locked().map(|m| m.page_faults).sum::<u64>(),
                "missed_ticks": locked().map(|m| m.missed_ticks).sum::<u64>(),
                "realtime": locked().all(|m| m.is_realtime),
            },
            "not_measured": self.notes.0,
            "repeats": plan.repeats,
            "seconds": plan.window.as_secs(),
            "core": plan.core,
            "machine": machine::name(),
            "kernel": machine::kernel(),
        })
    }

    pub(super) fn print(&self, plan: &Plan<'_>, output: &mut Output) -> anyhow::Result<()> {
        tables::print(&self.json(plan), output)
    }

    fn wake_ratio(&self, which: Rank) -> Option<f64> {
        ratio(self.idle.iter().map(Compared::from), which, |c| {
            c.references.cyclictest
        })
    }

    fn free(&self) -> impl Iterator<Item = &Measured> {
        self.idle.iter().flat_map(|repeat| &repeat.free)
    }

    /// Returns the frame ages of all free-running daemons together, as each has a different phase.
    fn free_frame_age(&self) -> Value {
        let ages = self.free().flat_map(|measured| &measured.frame_age_ns);
        microseconds(&percentiles::from_unsorted(ages.copied().collect()))
    }
}

#[derive(Clone, Copy)]
struct Compared {
    daemon: Percentiles,
    references: References,
}

impl From<&Repeat> for Compared {
    fn from(repeat: &Repeat) -> Self {
        Self {
            daemon: repeat.locked.wake,
            references: repeat.references,
        }
    }
}

impl From<&Loaded> for Compared {
    fn from(repeat: &Loaded) -> Self {
        Self {
            daemon: repeat.locked.wake,
            references: repeat.references,
        }
    }
}

type Rank = fn(&Percentiles) -> u64;
const P50: Rank = |p| p.p50_ns;
const P99: Rank = |p| p.p99_ns;
const P999: Rank = |p| p.p999_ns;

/// Returns the median over the repeats of the daemon's latency divided by that of a reference in
/// the same repeat.
fn ratio(
    repeats: impl Iterator<Item = Compared>,
    which: Rank,
    other: impl Fn(&Compared) -> Option<Percentiles>,
) -> Option<f64> {
    let ratios = repeats.filter_map(|repeat| {
        let to_ns = which(&other(&repeat)?);
        (to_ns > 0).then(|| which(&repeat.daemon) as f64 / to_ns as f64)
    });
    median(ratios.collect())
}

fn wake(repeats: &[Compared]) -> Value {
    if repeats.is_empty() {
        return Value::Null;
    }
    let of = |other: fn(&References) -> Option<Percentiles>| {
        over(repeats.iter().filter_map(|r| other(&r.references)))
    };
    let to = |other: fn(&References) -> Option<Percentiles>| {
        let of = |rank| ratio(repeats.iter().copied(), rank, |c| other(&c.references));
        json!({"p50": of(P50), "p99": of(P99), "p999": of(P999)})
    };
    json!({
        "daemon_us": over(repeats.iter().map(|r| r.daemon)),
        "bare_loop_us": of(|b| b.bare),
        "bare_loop_awake_us": of(|b| b.bare_awake),
        "bare_loop_spinning_us": of(|b| b.bare_spinning),
        "cyclictest_us": of(|b| b.cyclictest),
        "to_cyclictest": to(|b| b.cyclictest),
        "to_bare_loop": to(|b| b.bare),
        "to_bare_loop_spinning": to(|b| b.bare_spinning),
    })
}

/// Returns medians over the repeats, µs; `null` without repeats.
fn over(repeats: impl Iterator<Item = Percentiles>) -> Value {
    let repeats: Vec<Percentiles> = repeats.collect();
    if repeats.is_empty() {
        return Value::Null;
    }
    let of = |rank: Rank| median(repeats.iter().map(|p| us(rank(p))).collect());
    json!({"p50": of(P50), "p99": of(P99), "p999": of(P999), "max": of(|p| p.max_ns)})
}

fn stages(repeats: Vec<&Measured>) -> Value {
    let named = TickReport::STAGE_NAMES
        .iter()
        .enumerate()
        .map(|(index, name)| {
            let figures = over(repeats.iter().map(|measured| measured.stages[index]));
            ((*name).to_owned(), figures)
        });
    Value::Object(named.collect())
}

fn microseconds(p: &Percentiles) -> Value {
    json!({"p50": us(p.p50_ns), "p99": us(p.p99_ns), "p999": us(p.p999_ns), "max": us(p.max_ns)})
}

fn us(ns: u64) -> f64 {
    ns as f64 * 1e-3
}
