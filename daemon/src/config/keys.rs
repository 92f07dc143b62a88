//! All configuration keys and their permitted values.
//!
//! Tunable numbers come from the controller's table [`PARAMETERS`]; the other keys are listed here.

use atas_core::limits::TICK_RATE_HZ;
use atas_core::settings::{ORDERED_PAIRS, PARAMETERS, Parameter, find, present_name};

use super::{Config, Cpu, HandSensor};

/// Key that cannot change at run time.
struct FixedKey {
    name: &'static str,
    needs: &'static str,
    is_valid: fn(&Config) -> bool,
}

const LAYOUT: &str = "\"robot\", \"dome-41\", \"dome-1\", \"pad-N\", \"flat-RxC-P\", \"cylinder-RxC-P-Q\" or \
                      { normals = [[x, y, z], …], radius_m = … or positions_m = [[x, y, z], …], element_area_m2 = … } \
    with 1 to 64 unit vectors that do not point along x";
/// Section whose keys are the names of user tasks.
const TASKS: &str = "tasks";
const YES_NO: &str = "true or false";
/// Right of the service's group; the gate reads it at each use.
const ACCESS_GROUP: &str = "access.group";

/// `SCHED_FIFO` has priorities 1 to 99; 99 is used by kernel threads.
const PRIORITY_MAX: u32 = 98;
/// Maximum spin: beyond it spinning takes more than a tenth of a core (measured: 9 % at 100 µs and
/// 1 kHz).
const SPIN_MAX_US: u32 = 100;

/// Maximum spin, periods. The tick and the sleep need the rest; without sleep a real-time thread
/// blocks the machine. Design choice.
const SPIN_MAX_PERIODS: f64 = 0.5;

/// Minimum validity of a command, periods. Below it a command expires before a slightly late one
/// replaces it. Design choice.
const VALID_MIN_PERIODS: f64 = 1.5;

/// Maximum phase offset: the age of a frame at which the robot holds (`intake.hold_age_s` by
/// default).
const PHASE_OFFSET_MAX_US: u32 = 5_000;

/// Limits of the wait for frames: less is within the jitter of arrivals, more takes over half of a
/// 1 kHz period.
const ARRIVAL_WAIT_US: std::ops::RangeInclusive<u32> = 10..=500;

const FIXED: &[FixedKey] = &[
    FixedKey {
        name: "realtime.mode",
        needs: "\"require\", \"try\" or \"off\"",
        is_valid: |_| true,
    },
    FixedKey {
        name: "realtime.priority",
        needs: "a whole number from 1 to 98",
        is_valid: |c| (1..=PRIORITY_MAX).contains(&c.realtime.priority),
    },
    FixedKey {
        name: "realtime.cpu",
        needs: "\"any\" or the number of a core, 0 to 1023",
        is_valid: |c| !matches!(c.realtime.cpu, Cpu::Core(1024..)),
    },
    FixedKey {
        name: "realtime.rate_hz",
        needs: "a whole number from 100 to 10000",
        is_valid: |c| (TICK_RATE_HZ.0..=TICK_RATE_HZ.1).contains(&c.realtime.rate_hz),
    },
    FixedKey {
        name: "realtime.spin_us",
        needs: "a whole number from 0 to 100",
        is_valid: |c| c.realtime.spin_us <= SPIN_MAX_US,
    },
    FixedKey {
        name: "realtime.keep_awake",
        needs: YES_NO,
        is_valid: |_| true,
    },
    FixedKey {
        name: "realtime.phase_lock",
        needs: YES_NO,
        is_valid: |_| true,
    },
    FixedKey {
        name: "realtime.phase_offset_us",
        needs: "a whole number from 0 to 5000",
        is_valid: |c| c.realtime.phase_offset_us <= PHASE_OFFSET_MAX_US,
    },
    FixedKey {
        name: "realtime.arrival_wait_us",
        needs: "a whole number from 10 to 500",
        is_valid: |c| ARRIVAL_WAIT_US.contains(&c.realtime.arrival_wait_us),
    },
    FixedKey {
        name: "robot.model",
        needs: "the name of a shipped robot (`atas robot list`) or the path of a robot file",
        is_valid: |c| !c.robot.model.is_empty(),
    },
    FixedKey {
        name: "robot.joints_required",
        needs: YES_NO,
        is_valid: |_| true,
    },
    FixedKey {
        name: "hands.left.layout",
        needs: LAYOUT,
        is_valid: |c| has_layout(&c.hands.left),
    },
    FixedKey {
        name: "hands.left.fingers",
        needs: FINGERS,
        is_valid: |c| has_fingers(&c.hands.left),
    },
    FixedKey {
        name: "hands.left.rate_hz",
        needs: RATE,
        is_valid: |c| has_rate(&c.hands.left),
    },
    FixedKey {
        name: "hands.left.required",
        needs: YES_NO,
        is_valid: |_| true,
    },
    FixedKey {
        name: "hands.right.layout",
        needs: LAYOUT,
        is_valid: |c| has_layout(&c.hands.right),
    },
    FixedKey {
        name: "hands.right.fingers",
        needs: FINGERS,
        is_valid: |c| has_fingers(&c.hands.right),
    },
    FixedKey {
        name: "hands.right.rate_hz",
        needs: RATE,
        is_valid: |c| has_rate(&c.hands.right),
    },
    FixedKey {
        name: "hands.right.required",
        needs: YES_NO,
        is_valid: |_| true,
    },
    FixedKey {
        name: "recording.stream",
        needs: YES_NO,
        is_valid: |_| true,
    },
    FixedKey {
        name: "recording.flight_folder",
        needs: "the path of a folder, or \"\"",
        is_valid: |_| true,
    },
    FixedKey {
        name: ACCESS_GROUP,
        needs: "\"none\", \"observe\" or \"command\"",
        is_valid: |_| true,
    },
];

/// Minimum Jaro-Winkler similarity of a suggestion. Chosen by trying misspellings.
pub(super) const SIMILARITY_MIN: f64 = 0.8;
const FINGERS: &str = "a whole number from 1 to 4, or 0 for the number in the robot file";
const RATE: &str = "a number from 1 to 10000";

fn has_layout(hand: &HandSensor) -> bool {
    hand.layout.is_valid()
}

fn has_fingers(hand: &HandSensor) -> bool {
    hand.fingers <= shm_schemas::capacity::FINGERS
}

fn has_rate(hand: &HandSensor) -> bool {
    (1.0..=10_000.0).contains(&hand.rate_hz)
}

/// All keys, `section.key`, in the order of the configuration file.
pub fn known_keys() -> impl Iterator<Item = &'static str> {
    FIXED
        .iter()
        .map(|key| key.name)
        .chain(PARAMETERS.iter().map(|p| p.name))
}

/// Returns true if a key is fixed at run time. Access rights are read by the gate and may change.
pub(super) fn is_fixed(name: &str) -> bool {
    name != ACCESS_GROUP && FIXED.iter().any(|key| key.name == name)
}

/// Task name in a key of section `tasks`.
pub(super) fn task_name(key: &str) -> Option<&str> {
    key.strip_prefix(TASKS)?.strip_prefix('.')
}

/// Returns true if this is the name of a section.
pub(super) fn is_section(name: &str) -> bool {
    name == TASKS
        || known_keys().any(|key| {
            key.strip_prefix(name)
                .is_some_and(|rest| rest.starts_with('.'))
        })
}

/// Permitted values of a key; `None` for an unknown key.
pub(super) fn permitted_values(name: &str) -> Option<String> {
    let range = |p: &Parameter| format!("a number from {} to {}", p.lower, p.upper);
    let fixed = FIXED.iter().find(|key| key.name == name);
    fixed
        .map(|key| key.needs.to_owned())
        .or_else(|| find(name).map(range))
}

/// Returns true if the value of a key is permitted.
pub(super) fn is_valid(name: &str, config: &Config) -> bool {
    match (FIXED.iter().find(|key| key.name == name), find(name)) {
        (Some(key), _) => (key.is_valid)(config),
        (None, Some(parameter)) => parameter.check((parameter.get)(&config.settings())).is_ok(),
        (None, None) => false,
    }
}

/// Values in conflict with another one: `(key, value, permitted values)`.
pub(super) fn conflicts(config: &Config) -> impl Iterator<Item = (&'static str, f64, String)> {
    let settings = config.settings();
    let ordered = ORDERED_PAIRS.iter().filter_map(move |&(lower, upper)| {
        let value = |name| find(name).map_or(f64::NAN, |p| (p.get)(&settings));
        let (below, above) = (value(lower), value(upper));
        (below > above).then(|| (lower, below, format!("at most {upper}, which is {above}")))
    });
    ordered.chain(timing_conflicts(config))
}

fn timing_conflicts(config: &Config) -> impl Iterator<Item = (&'static str, f64, String)> {
    let rate_hz = f64::from(config.realtime.rate_hz);
    let (spin_us, valid_s) = (f64::from(config.realtime.spin_us), config.safety.valid_s);
    let spin_max_us = SPIN_MAX_PERIODS * 1e6 / rate_hz;
    let valid_min_s = VALID_MIN_PERIODS / rate_hz;
    let at = format!("of a period at realtime.rate_hz = {rate_hz}");
    let spins = (spin_us > spin_max_us).then(|| {
        let needs = format!("at most {spin_max_us}, {SPIN_MAX_PERIODS} {at}");
        ("realtime.spin_us", spin_us, needs)
    });
    let expires = (valid_s < valid_min_s).then(|| {
        let needs = format!("at least {valid_min_s}, {VALID_MIN_PERIODS} {at}");
        ("safety.valid_s", valid_s, needs)
    });
    spins.into_iter().chain(expires)
}

/// Suggestion for an unknown name: the same key in another section, else the most similar key or
/// section.
pub(super) fn suggestion(name: &str) -> Option<&'static str> {
    if let Some(now) = present_name(name) {
        return Some(now);
    }
    let last = |key: &'static str| key.rsplit_once('.').map_or(key, |(_, last)| last);
    let wanted = name.rsplit_once('.').map_or(name, |(_, last)| last);
    if let Some(moved) = known_keys().find(|known| last(known) == wanted) {
        return Some(moved);
    }
    let sections =
        known_keys().filter_map(|known| known.rsplit_once('.').map(|(section, _)| section));
    known_keys()
        .chain(sections)
        .map(|known| (strsim::jaro_winkler(known, name), known))
        .filter(|(likeness, _)| *likeness > SIMILARITY_MIN)
        .max_by(|a, b| a.0.total_cmp(&b.0))
        .map(|(_, known)| known)
}

/// Parameter suggested for an unknown name.
#[must_use]
pub fn suggested_parameter(name: &str) -> Option<&'static str> {
    suggestion(name).filter(|name| find(name).is_some())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ordered_pairs_are_valid_by_default() {
        for (lower, upper) in ORDERED_PAIRS {
            assert!(
                find(lower).is_some() && find(upper).is_some(),
                "{lower}, {upper}"
            );
        }
        assert_eq!(conflicts(&Config::default()).count(), 0);
    }

    #[test]
    fn every_default_is_valid() {
        for key in known_keys() {
            assert!(is_valid(key, &Config::default()), "{key}");
        }
    }

    #[test]
    fn misspelt_key_gets_a_suggestion() {
        let check = |name, meant| assert_eq!(suggestion(name), meant, "{name}");
        check("grasp.drn", Some("grasp.dr_n"));
        check("grsp.dr_n", Some("grasp.dr_n"));
        check("grasp.touch_on_n", Some("perception.touch_on_n"));
        check("priority", Some("realtime.priority"));
        check("grsp", Some("grasp"));
        check("grasp.keep_n", Some("grasp.carry_min_n"));
        check("follow", Some("teleop"));
        check("zzz", None);
    }
}
