//! `hz`: rate and age of joint states at a reader of the bus.

use std::sync::atomic::Ordering;
use std::time::Duration;

use serde_json::{Value, json};
use shm_bus::{Bus, BusName, Realtime, now_ns};
use shm_schemas::JointState;
use shm_schemas::service::JOINT_STATE;

use super::{print, stop_on_signal};
use crate::cli::Format;
use crate::failure::Failure;

/// Poll interval. Design choice: well below the buffer time of the bus at any robot's rate.
const PAUSE: Duration = Duration::from_millis(1);
const SECOND_NS: u64 = 1_000_000_000;

/// Prints rates once per second.
pub(super) fn run(bus: &BusName, seconds: Option<u64>, format: Format) -> Result<(), Failure> {
    let stop = stop_on_signal()?;
    let node = Bus::join(bus, "robot-listener", Realtime::No).map_err(Failure::Bus)?;
    let mut states = node
        .subscriber::<JointState>(JOINT_STATE)
        .map_err(Failure::Bus)?;
    let begun_ns = now_ns();
    let (mut second, mut printed) = (Second::default(), 0);
    while !stop.load(Ordering::Relaxed) && seconds.is_none_or(|end| printed < end) {
        states
            .drain(16, |state| second.take(state, now_ns()))
            .map_err(Failure::Bus)?;
        if now_ns() - begun_ns >= (printed + 1) * SECOND_NS {
            print(&second.line(format))?;
            second = Second {
                newest: second.newest,
                ..Second::default()
            };
            printed += 1;
        }
        std::thread::sleep(PAUSE);
    }
    Ok(())
}

/// Minimum, mean and maximum of times.
#[derive(Clone, Copy, Default)]
struct Times {
    min_ns: u64,
    max_ns: u64,
    sum_ns: u64,
    count: u64,
}

impl Times {
    fn take(&mut self, ns: u64) {
        self.min_ns = if self.count == 0 {
            ns
        } else {
            self.min_ns.min(ns)
        };
        self.max_ns = self.max_ns.max(ns);
        self.sum_ns = self.sum_ns.saturating_add(ns);
        self.count += 1;
    }

    /// Returns minimum, mean and maximum, ms.
    fn ms(&self) -> Option<[f64; 3]> {
        let ms = |ns: f64| (ns / 1e4).round() / 100.0;
        let mean_ns = (self.count > 0).then(|| self.sum_ns as f64 / self.count as f64)?;
        Some([ms(self.min_ns as f64), ms(mean_ns), ms(self.max_ns as f64)])
    }

    fn json(&self) -> Value {
        self.ms().map_or(
            Value::Null,
            |[min, mean, max]| json!({ "min": min, "mean": mean, "max": max }),
        )
    }
}

/// Joint states within one second.
#[derive(Clone, Copy, Default)]
struct Second {
    states: u64,
    lost: u64,
    period: Times,
    age: Times,
    /// Epoch, sequence and capture time of the newest state.
    newest: Option<(u64, u64, u64)>,
}

impl Second {
    fn take(&mut self, state: &JointState, now_ns: u64) {
        let stamp = state.stamp;
        self.states += 1;
        self.age.take(now_ns.saturating_sub(stamp.captured_ns));
        if let Some((epoch, sequence, captured_ns)) = self.newest
            && epoch == stamp.writer_epoch
        {
            self.period
                .take(stamp.captured_ns.saturating_sub(captured_ns));
            let gap = stamp.sequence.saturating_sub(sequence).saturating_sub(1);
            self.lost = self.lost.saturating_add(gap);
        }
        self.newest = Some((stamp.writer_epoch, stamp.sequence, stamp.captured_ns));
    }

    fn line(&self, format: Format) -> String {
        if format == Format::Json {
            return json!({
                "states": self.states,
                "lost": self.lost,
                "rate_hz": self.states,
                "period_ms": self.period.json(),
                "age_ms": self.age.json(),
            })
            .to_string();
        }
        let (Some([min, mean, max]), Some([_, age, oldest])) = (self.period.ms(), self.age.ms())
        else {
            return format!("{} Hz: no states to compare", self.states);
        };
        format!(
            "{} Hz, {} lost; period {mean:.2} ms ({min:.2} to {max:.2}); age {age:.2} ms (at most {oldest:.2})",
            self.states, self.lost
        )
    }
}
