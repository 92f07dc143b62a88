//! State, diagnostics and events of the daemon.

use std::time::{Duration, Instant};

use atas_client::{Observer, rejections, text};
use shm_schemas::capacity::HANDS;
use shm_schemas::{EventKind, GoalState, Hand, Mode, ModuleEvent, Status, StatusFlags};

use super::pace::Pace;
use crate::clock::{Clock, present};
use crate::middleware::{Node, Publish, Quality};
use crate::wire::Byte;
use crate::wire::atas::DaemonState;
use crate::wire::standard::{DiagnosticArray, DiagnosticStatus, Header, KeyValue, Log};

/// Rate of the state without a change, Hz. Design choice.
const STATE_HZ: f64 = 10.0;
/// Rate of diagnostics, Hz: as diagnostic_updater.
const DIAGNOSTICS_HZ: f64 = 1.0;
/// Pause between two states of a missing daemon.
const ABSENCE: Duration = Duration::from_secs(1);

/// Severities of `rcl_interfaces/msg/Log`.
const INFO: u8 = 20;
const WARNING: u8 = 30;
const ERROR: u8 = 40;
/// Levels of `diagnostic_msgs/msg/DiagnosticStatus`.
const OK: u8 = 0;
const WARN: u8 = 1;
const BAD: u8 = 2;
const STALE: u8 = 3;

/// Topics of the daemon.
pub(super) struct DaemonTopics {
    state: Box<dyn Publish<DaemonState>>,
    events: Box<dyn Publish<Log>>,
    diagnostics: Box<dyn Publish<DiagnosticArray>>,
    state_pace: Pace,
    diagnostics_pace: Pace,
    last: DaemonState,
    absent: Option<Instant>,
}

impl DaemonTopics {
    pub(super) fn open(node: &mut Node, namespace: &str) -> anyhow::Result<Self> {
        Ok(Self {
            state: node.publisher(&format!("{namespace}/state"), Quality::LATCHED)?,
            events: node.publisher(&format!("{namespace}/events"), Quality::EVENTS)?,
            diagnostics: node.publisher("/diagnostics", Quality::STREAM)?,
            state_pace: Pace::new(STATE_HZ),
            diagnostics_pace: Pace::new(DIAGNOSTICS_HZ),
            last: DaemonState::default(),
            absent: None,
        })
    }

    pub(super) fn publish(
        &mut self,
        observer: &Observer,
        clock: &Clock,
        events: &[ModuleEvent],
    ) -> anyhow::Result<()> {
        for event in events {
            self.events.publish(log(event, clock))?;
        }
        if observer.status.pid == 0 {
            return self.absent();
        }
        self.absent = None;
        let state = state(&observer.status, observer.is_alive(), clock);
        let is_due = self.state_pace.is_due();
        if is_due || is_changed(&self.last, &state) {
            self.last = state.clone();
            self.state.publish(state)?;
        }
        if self.diagnostics_pace.is_due() {
            let statuses = diagnostics(&observer.status, observer.is_alive());
            self.diagnose(statuses)?;
        }
        Ok(())
    }

    /// Publishes that there is no daemon, once a second.
    pub(super) fn absent(&mut self) -> anyhow::Result<()> {
        if self.absent.is_some_and(|since| since.elapsed() < ABSENCE) {
            return Ok(());
        }
        self.absent = Some(Instant::now());
        self.last = DaemonState {
            header: now(),
            reason: "no daemon reports on the bus; start `atasd`".to_owned(),
            ..DaemonState::default()
        };
        self.state.publish(self.last.clone())?;
        self.diagnose(vec![status_of(STALE, "daemon", &self.last.reason, &[])])
    }

    fn diagnose(&self, status: Vec<DiagnosticStatus>) -> anyhow::Result<()> {
        self.diagnostics.publish(DiagnosticArray {
            header: now(),
            status,
        })
    }
}

fn now() -> Header {
    Header {
        stamp: present(),
        frame_id: String::new(),
    }
}

fn state(status: &Status, alive: bool, clock: &Clock) -> DaemonState {
    let has_goal = status.goal_id != 0;
    let name = match status.task.as_str() {
        "" if has_goal => status.goal_kind.to_string(),
        own => own.to_owned(),
    };
    let reason = |reason: &shm_schemas::ReasonRecord| match reason.is_some() {
        true => reason.to_string(),
        false => String::new(),
    };
    DaemonState {
        header: clock.header(status.stamp.captured_ns, ""),
        version: status.version.to_string(),
        mode: status.mode.to_string(),
        reason: reason(&status.reason),
        alive,
        task: name,
        goal_state: if has_goal {
            status.goal_state.to_string()
        } else {
            String::new()
        },
        step: status.step.to_string(),
        goal_reason: reason(&status.goal_reason),
        ticks: status.ticks,
        missed_ticks: status.missed_ticks,
    }
}

/// Returns true if anything but time and counters changed.
fn is_changed(last: &DaemonState, new: &DaemonState) -> bool {
    let lasting = |of: &DaemonState| DaemonState {
        header: Header::default(),
        ticks: 0,
        ..of.clone()
    };
    lasting(last) != lasting(new)
}

fn diagnostics(status: &Status, alive: bool) -> Vec<DiagnosticStatus> {
    let level = match (alive, status.mode) {
        (false, _) => STALE,
        (true, Mode::HOLD | Mode::SAFE_STOP | Mode::FAULT) => BAD,
        (true, _) if status.flags & StatusFlags::DEGRADED != 0 => WARN,
        (true, _) => OK,
    };
    let reason = match (alive, status.reason.is_some()) {
        (false, _) => "the daemon does not report; it has ended or hangs".to_owned(),
        (true, true) => format!("mode {}: {}", status.mode, status.reason),
        (true, false) => format!("mode {}", status.mode),
    };
    let us = |ns: u64| format!("{:.1}", ns as f64 * 1e-3);
    let values = [
        ("ticks", status.ticks.to_string()),
        ("missed ticks", status.missed_ticks.to_string()),
        ("late ticks", status.late_ticks.to_string()),
        ("tick p99 (µs)", us(status.tick.p99_ns)),
        ("wake-up delay p99 (µs)", us(status.wake.p99_ns)),
        ("dropped records", status.dropped_records.to_string()),
    ];
    let mut all = vec![status_of(level, "daemon", &reason, &values)];
    all.extend((0..HANDS).filter_map(|index| sensor(status, index)));
    all
}

/// Returns the condition of one hand's sensor; `None` for a hand without one.
fn sensor(status: &Status, index: usize) -> Option<DiagnosticStatus> {
    let sensor = &status.hands[index];
    if sensor.required == 0 && sensor.frames == 0 {
        return None;
    }
    let rejected = rejections::rejected_frames(sensor);
    let (level, sentence) = match (sensor.frames, rejected) {
        (0, 0) => (BAD, "no tactile frame yet".to_owned()),
        (0, _) => (BAD, format!("{rejected} tactile frames, all rejected")),
        (_, 0) => (OK, "tactile frames arrive".to_owned()),
        (_, _) => (WARN, format!("{rejected} tactile frames were rejected")),
    };
    let values = [
        ("accepted frames", sensor.frames.to_string()),
        ("lost frames", sensor.lost.to_string()),
        ("masked elements", sensor.masked_elements.to_string()),
        ("sensor restarts", sensor.restarts.to_string()),
    ];
    let name = format!("{} hand", Hand::BOTH[index]);
    Some(status_of(level, &name, &sentence, &values))
}

fn status_of(level: u8, name: &str, message: &str, values: &[(&str, String)]) -> DiagnosticStatus {
    let values = values.iter().map(|(key, value)| KeyValue {
        key: (*key).to_owned(),
        value: value.clone(),
    });
    DiagnosticStatus {
        level: Byte(level),
        name: format!("atas: {name}"),
        message: message.to_owned(),
        hardware_id: "atas".to_owned(),
        values: values.collect(),
    }
}

fn log(event: &ModuleEvent, clock: &Clock) -> Log {
    let is_stop = matches!(event.mode, Mode::HOLD | Mode::SAFE_STOP | Mode::FAULT);
    let level = match event.kind {
        EventKind::WARNING => WARNING,
        EventKind::MODE if is_stop => ERROR,
        EventKind::GOAL if event.text.as_str() == GoalState::FAILED.name() => ERROR,
        _ => INFO,
    };
    Log {
        stamp: clock.time(event.stamp.captured_ns),
        level,
        name: format!("atas.{}", event.kind.name()),
        msg: text::event(event).trim().to_owned(),
        ..Log::default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use shm_schemas::Reason;

    #[test]
    fn stopped_robot_is_an_error_with_its_reason() {
        let mut status = Status {
            pid: 7,
            mode: Mode::SAFE_STOP,
            reason: Reason::Estop.into(),
            ..Status::default()
        };
        (status.hands[1].required, status.hands[1].frames) = (1, 9);
        let all = diagnostics(&status, true);
        assert_eq!(all.len(), 2, "the left hand has no sensor");
        assert_eq!(all[0].level, Byte(BAD));
        assert!(all[0].message.contains("stopped by"), "{}", all[0].message);
        assert_eq!(
            (all[1].level, all[1].name.as_str()),
            (Byte(OK), "atas: right hand")
        );
        assert_eq!(diagnostics(&status, false)[0].level, Byte(STALE));
    }
}
