//! Bus data as JSON: SI units, names instead of codes. Keys are an interface for scripts: new ones
//! may be added, none removed. Lists of fingertips have the length of the hand if the run is known
//! ([`crate::Run::fingertips`]), else the capacity of the payload ([`CAPACITY`]) with zeros.

mod streams;

pub use streams::{agents, arena, base, base_command, report, run, sensor, truth, view, wheels};

use serde_json::{Value, json};
use shm_schemas::capacity::{FINGERS, HANDS};
use shm_schemas::{
    EventKind, GraspFigures, Hand, HandStatus, ModuleEvent, ModuleId, Percentiles, ReasonRecord,
    Status, StatusFlags,
};

use crate::GoalProgress;

/// Number of fingertips per hand if unknown.
pub const CAPACITY: [usize; HANDS] = [FINGERS; HANDS];

/// Returns a reason, or `null`.
#[must_use]
pub fn reason(reason: &ReasonRecord) -> Value {
    if !reason.is_some() {
        return Value::Null;
    }
    json!({
        "cause": reason.cause.name(),
        "module": reason.module.name(),
        "value": reason.value,
        "limit": reason.limit,
        "index": reason.index,
        "sentence": reason.to_string(),
    })
}

fn figures(figures: &GraspFigures, fingers: usize) -> Value {
    json!({
        "normal_n": figures.normal_n[..fingers],
        "tangential_n": figures.tangential_n[..fingers],
        "f1_n": figures.f1_n,
        "f2_n": figures.f2_n,
        "stiffness_n_m": figures.stiffness_n_m,
        "stiffness_confidence": figures.stiffness_confidence,
        "friction": figures.friction,
        "lifted_m": figures.lifted_m,
    })
}

/// Returns the end of a goal of a hand with this number of fingertips.
#[must_use]
pub fn goal(progress: &GoalProgress, fingers: usize) -> Value {
    let last = progress.last();
    json!({
        "goal_id": last.goal_id,
        "state": last.state.name(),
        "step": progress.step(),
        "reason": reason(&last.reason),
        "figures": figures(progress.figures(), fingers),
    })
}

/// Returns one event with the fields of its kind.
#[must_use]
pub fn event(event: &ModuleEvent) -> Value {
    let mut value = json!({
        "sequence": event.stamp.sequence,
        "captured_ns": event.stamp.captured_ns,
        "tick": event.tick,
        "kind": event.kind.name(),
    });
    for field in fields_of(event.kind) {
        value[*field] = match *field {
            "module" => event.module.name().into(),
            "hand" => event.hand.name().into(),
            "finger" => event.finger.into(),
            "mode" => event.mode.name().into(),
            "value" => event.value.into(),
            "threshold" => event.threshold.into(),
            "reason" => reason(&event.reason),
            _ => event.text.as_str().into(),
        };
    }
    value
}

/// Returns the fields of an event kind; all fields for an unknown kind.
fn fields_of(kind: EventKind) -> &'static [&'static str] {
    match kind {
        EventKind::MODULE_ON | EventKind::MODULE_OFF => &["hand", "module"],
        EventKind::TOUCH_ON | EventKind::TOUCH_OFF => &["hand", "finger", "value", "threshold"],
        EventKind::STEP => &["hand", "text"],
        EventKind::STIFFNESS => &["hand", "value", "threshold"],
        EventKind::GOAL => &["hand", "text", "reason"],
        EventKind::MODE => &["mode", "reason"],
        EventKind::WARNING => &["hand", "module", "value", "threshold", "reason"],
        _ => &[
            "hand",
            "module",
            "finger",
            "mode",
            "value",
            "threshold",
            "reason",
            "text",
        ],
    }
}

/// Returns the conditions of the daemon's loop, for a list of events.
#[must_use]
pub fn conditions(status: &Status) -> Value {
    let has = |flag| status.flags & flag != 0;
    json!({
        "captured_ns": status.stamp.captured_ns,
        "kind": "conditions",
        "phase_locked": has(StatusFlags::PHASE_LOCKED),
        "realtime": has(StatusFlags::REALTIME),
        "degraded": has(StatusFlags::DEGRADED),
    })
}

/// Returns the daemon's status for hands with these numbers of fingertips.
#[must_use]
pub fn status(status: &Status, fingers: [usize; HANDS]) -> Value {
    let hands = Hand::BOTH.iter().zip(&status.hands).zip(fingers).map(hand);
    json!({
        "captured_ns": status.stamp.captured_ns,
        "version": status.version.as_str(),
        "pid": status.pid,
        "config_hash": format!("{:016x}", status.config_hash),
        "started_ns": status.started_ns,
        "rate_hz": status.rate_hz,
        "mode": status.mode.name(),
        "reason": reason(&status.reason),
        "degraded": status.flags & StatusFlags::DEGRADED != 0,
        "lockstep": status.flags & StatusFlags::LOCKSTEP != 0,
        "realtime": status.flags & StatusFlags::REALTIME != 0,
        "phase_locked": status.flags & StatusFlags::PHASE_LOCKED != 0,
        "memory_locked": status.flags & StatusFlags::MEMORY_LOCKED != 0,
        "kept_awake": status.flags & StatusFlags::KEPT_AWAKE != 0,
        "sense_only": status.flags & StatusFlags::SENSE_ONLY != 0,
        "ticks": status.ticks,
        "missed_ticks": status.missed_ticks,
        "late_ticks": status.late_ticks,
        "dropped_records": status.dropped_records,
        "goal": {
            "goal_id": status.goal_id,
            "kind": status.goal_kind.name(),
            "state": status.goal_state.name(),
            "step": status.step.as_str(),
            "task": status.task.as_str(),
            "reason": reason(&status.goal_reason),
        },
        "hands": hands.collect::<Vec<Value>>(),
        "joints": {
            "states": status.joints.states,
            "lost": status.joints.lost,
            "rejected": status.joints.rejected,
            "age_ns": age_ns(status.joints.age_ns),
        },
        "wake": percentiles(&status.wake),
        "frame_age": percentiles(&status.frame_age),
        "tick": percentiles(&status.tick),
        "sensor_to_command": percentiles(&status.sensor_to_command),
    })
}

fn hand(((hand, sensor), fingers): ((&Hand, &HandStatus), usize)) -> Value {
    json!({
        "hand": hand.name(),
        "required": sensor.required != 0,
        "frames": sensor.frames,
        "lost": sensor.lost,
        "duplicates": sensor.duplicates,
        "reordered": sensor.reordered,
        "corrupt": sensor.corrupt,
        "mistimed": sensor.mistimed,
        "foreign": sensor.foreign,
        "masked_elements": sensor.masked_elements,
        "restarts": sensor.restarts,
        "touches": sensor.touches[..fingers],
        "age_ns": age_ns(sensor.age_ns),
        "layout_hash": format!("{:016x}", sensor.layout_hash),
        "normal_n": sensor.normal_n[..fingers],
        "tangential_n": sensor.tangential_n[..fingers],
        "modules": names(sensor.modules_active),
    })
}

/// Returns a distribution.
#[must_use]
pub fn percentiles(figures: &Percentiles) -> Value {
    json!({
        "p50_ns": figures.p50_ns,
        "p99_ns": figures.p99_ns,
        "p999_ns": figures.p999_ns,
        "max_ns": figures.max_ns,
        "count": figures.count,
    })
}

/// Returns the modules of a bit set.
fn names(active: u32) -> Vec<&'static str> {
    let is_active = |id: &&ModuleId| id.0 < u32::BITS && active >> id.0 & 1 == 1;
    let active = ModuleId::ALL.iter().filter(is_active);
    active.map(|id| id.name()).collect()
}

/// Returns `null` if nothing has arrived.
fn age_ns(age_ns: u64) -> Value {
    if age_ns == u64::MAX {
        Value::Null
    } else {
        age_ns.into()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn event_has_the_fields_of_its_kind() {
        let check = |kind, expected: &[&str]| {
            let value = event(&ModuleEvent {
                kind,
                ..ModuleEvent::default()
            });
            let keys = value
                .as_object()
                .map(|fields| fields.keys().collect::<Vec<_>>());
            let mut expected = [&["sequence", "captured_ns", "tick", "kind"], expected].concat();
            expected.sort_unstable();
            let mut keys = keys.unwrap_or_default();
            keys.sort_unstable();
            assert_eq!(keys, expected, "{kind}");
        };
        check(EventKind::STEP, &["hand", "text"]);
        check(EventKind::MODE, &["mode", "reason"]);
        check(EventKind::MODULE_ON, &["hand", "module"]);
    }
    #[test]
    fn lists_of_fingertips_have_the_length_of_the_hand() {
        let lists = |value: &Value| {
            let keys = ["touches", "normal_n", "tangential_n"];
            let lists = keys.into_iter().filter_map(|key| value[key].as_array());
            lists.map(Vec::len).collect::<Vec<_>>()
        };
        for (fingers, expected) in [([2, 3], [[2; 3], [3; 3]]), (CAPACITY, [[4; 3]; 2])] {
            let value = status(&Status::default(), fingers);
            for (hand, expected) in expected.iter().enumerate() {
                assert_eq!(lists(&value["hands"][hand]), expected);
            }
        }
        let ended = goal(&GoalProgress::default(), 3);
        assert_eq!(lists(&ended["figures"]), [3, 3]);
    }
}
