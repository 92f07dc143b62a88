//! Bus data as text for people.

use shm_schemas::capacity::FINGERS;
use shm_schemas::{EventKind, FingerReport, HandReport, ModuleEvent, ModuleId, Status};

/// Returns the active or last goal, with the reason of an end without success.
#[must_use]
pub fn goal(status: &Status) -> String {
    if status.goal_id == 0 {
        return "no goal yet".into();
    }
    let name = match status.task.as_str() {
        "" => status.goal_kind.to_string(),
        own => own.to_owned(),
    };
    let mut text = format!("goal {name} {}", status.goal_state);
    if !status.step.as_str().is_empty() {
        text += &format!(", step {}", status.step);
    }
    if status.goal_reason.is_some() {
        text += &format!(": {}", status.goal_reason);
    }
    text
}

/// Returns the text of an event, without its time.
#[must_use]
pub fn event(event: &ModuleEvent) -> String {
    let (hand, module) = (event.hand, event.module);
    let (value, threshold) = (event.value, event.threshold);
    match event.kind {
        EventKind::MODULE_ON => format!("{hand:5}  {module} on"),
        EventKind::MODULE_OFF => format!("{hand:5}  {module} off"),
        EventKind::TOUCH_ON | EventKind::TOUCH_OFF => {
            let word = if event.kind == EventKind::TOUCH_ON {
                "touches"
            } else {
                "lets go"
            };
            format!(
                "{hand:5}  finger {} {word} at {value:.3} N (threshold {threshold:.3} N)",
                event.finger + 1
            )
        }
        EventKind::STEP => format!("{hand:5}  step {}", event.text),
        EventKind::STIFFNESS => {
            format!("{hand:5}  stiffness {value:.0} N/m, F_2 is {threshold:.2} N")
        }
        EventKind::GOAL => format!("{hand:5}  goal {}{}", event.text, reason_suffix(event)),
        EventKind::MODE => format!("       mode {}{}", event.mode, reason_suffix(event)),
        EventKind::WARNING => format!("{hand:5}  warning{}", reason_suffix(event)),
        kind => format!(
            "{hand:5}  {kind}, value {value}, threshold {threshold}{}",
            module_suffix(module)
        ),
    }
}

fn reason_suffix(event: &ModuleEvent) -> String {
    if event.reason.is_some() {
        format!(": {}", event.reason)
    } else {
        String::new()
    }
}

fn module_suffix(module: ModuleId) -> String {
    if module == ModuleId::NONE {
        String::new()
    } else {
        format!(" ({module})")
    }
}

/// Returns the readings of the tick in which a module changed, for a hand with this number of
/// fingertips.
#[must_use]
pub fn evidence(module: ModuleId, hand: &HandReport, fingers: usize) -> String {
    let fingers = &hand.fingers[..fingers.clamp(1, FINGERS)];
    let largest = |value: fn(&FingerReport) -> f32| {
        fingers.iter().map(value).fold(f32::NEG_INFINITY, f32::max)
    };
    let n = |value: f32| number(value, 2);
    let each = |value: fn(&FingerReport) -> f32| {
        let values: Vec<f32> = fingers.iter().map(value).collect();
        newtons(&values)
    };
    let pressed = || each(|f| f.normal_n);
    let sheared = || each(|f| f.tangential_n);
    match module {
        ModuleId::FIRST_TOUCH => format!("F_n {} N, F_1 {} N", pressed(), n(hand.f1_n)),
        ModuleId::FORCE_LIMIT => format!("F_n {} N, F_2 {} N", pressed(), n(hand.f2_n)),
        ModuleId::SLIP | ModuleId::SLIP_REACTION | ModuleId::RELAX => format!(
            "S {}, dF_t {} N, F_n {} N",
            n(largest(|f| f.utilisation)),
            number(largest(|f| f.tangential_increment_n), 3),
            pressed()
        ),
        ModuleId::PROBE => format!(
            "F_n {} N, stiffness {} N/m, F_2 {} N",
            pressed(),
            number(hand.stiffness_n_m, 0),
            n(hand.f2_n)
        ),
        ModuleId::TERMINATE_SCREW | ModuleId::RELEASE_PLACED | ModuleId::LIFT_VERIFICATION => {
            format!(
                "F_t {} N, dF_t {} N",
                sheared(),
                number(largest(|f| f.tangential_increment_n), 3)
            )
        }
        _ => format!("F_n {} N, F_t {} N", pressed(), sheared()),
    }
}

/// Returns forces in newtons as a list, for example `0.30, 0.12 and 0.50`.
///
/// ```
/// assert_eq!(atas_client::text::newtons(&[0.3, 0.12, 0.5]), "0.30, 0.12 and 0.50");
/// ```
#[must_use]
pub fn newtons(forces_n: &[f32]) -> String {
    let words: Vec<String> = forces_n.iter().map(|n| number(*n, 2)).collect();
    listed(&words)
}

/// Returns words as a list.
fn listed(words: &[String]) -> String {
    match words {
        [] => String::new(),
        [only] => only.clone(),
        [first @ .., last] => format!("{} and {last}", first.join(", ")),
    }
}

/// Returns a number with this many digits, without a minus before zero.
fn number(value: f32, digits: usize) -> String {
    let least = 0.5 * 10_f32.powi(-(digits as i32));
    let value = if value.abs() < least { 0.0 } else { value };
    format!("{value:.digits$}")
}

#[cfg(test)]
mod tests {
    use super::*;
    use shm_schemas::{Hand, Mode, Reason, Text};

    fn right(kind: EventKind) -> ModuleEvent {
        ModuleEvent {
            kind,
            hand: Hand::RIGHT,
            ..ModuleEvent::default()
        }
    }

    #[test]
    fn events_have_readable_texts() {
        let check = |shown: ModuleEvent, expected| assert_eq!(event(&shown), expected);
        check(
            ModuleEvent {
                module: ModuleId::SLIP,
                ..right(EventKind::MODULE_ON)
            },
            "right  module 2, slip on",
        );
        check(
            ModuleEvent {
                finger: 1,
                value: 0.0712,
                threshold: 0.06,
                ..right(EventKind::TOUCH_ON)
            },
            "right  finger 2 touches at 0.071 N (threshold 0.060 N)",
        );
        check(
            ModuleEvent {
                text: Text::new("lift"),
                ..right(EventKind::STEP)
            },
            "right  step lift",
        );
        check(
            ModuleEvent {
                value: 1512.3,
                threshold: 0.756,
                ..right(EventKind::STIFFNESS)
            },
            "right  stiffness 1512 N/m, F_2 is 0.76 N",
        );
        check(
            ModuleEvent {
                mode: Mode::SAFE_STOP,
                reason: Reason::Estop.into(),
                ..right(EventKind::MODE)
            },
            "       mode safe-stop: stopped by `atas estop`; `atas recover` re-arms",
        );
        check(
            right(EventKind(99)),
            "right  unknown(99), value 0, threshold 0",
        );
    }

    #[test]
    fn module_evidence_lists_its_readings() {
        let mut hand = HandReport {
            f1_n: 0.12,
            f2_n: 8.0,
            stiffness_n_m: 1512.3,
            ..HandReport::default()
        };
        hand.fingers[0].normal_n = 0.3;
        hand.fingers[1].utilisation = 1.02;
        hand.fingers[1].tangential_increment_n = 0.0712;
        let check = |module, expected| assert_eq!(evidence(module, &hand, 2), expected);
        check(ModuleId::FIRST_TOUCH, "F_n 0.30 and 0.00 N, F_1 0.12 N");
        check(ModuleId::FORCE_LIMIT, "F_n 0.30 and 0.00 N, F_2 8.00 N");
        check(ModuleId::SLIP, "S 1.02, dF_t 0.071 N, F_n 0.30 and 0.00 N");
        check(
            ModuleId::PROBE,
            "F_n 0.30 and 0.00 N, stiffness 1512 N/m, F_2 8.00 N",
        );
        check(ModuleId::CARRY, "F_n 0.30 and 0.00 N, F_t 0.00 and 0.00 N");
        hand.fingers[2].normal_n = 0.5;
        let of_three = evidence(ModuleId::FORCE_LIMIT, &hand, 3);
        assert_eq!(of_three, "F_n 0.30, 0.00 and 0.50 N, F_2 8.00 N");
        let of_one = evidence(ModuleId::FORCE_LIMIT, &hand, 1);
        assert_eq!(of_one, "F_n 0.30 N, F_2 8.00 N");
    }
}
