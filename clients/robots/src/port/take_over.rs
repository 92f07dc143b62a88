//! Take-over of the servos of a port without motion: before the first cycle and after every
//! failure.
//!
//! All servos are checked before any is changed. A servo with torque keeps its goal, so that a grip
//! survives a restart. A servo without torque gets its settings, its current position as goal, and
//! then torque.

use core::f64::consts::TAU;

use super::PortMap;
use crate::drivers::State;
use crate::drivers::wire::{Wire, WireError};
use crate::map::MappedServo;

/// Tolerance of the joint limits, rad or m, as in the daemon.
const MARGIN_RAD: f64 = 0.05;
/// Largest difference of a position and the goal that holds it, rad: more than half an encoder
/// step.
const GOAL_ERROR_MAX_RAD: f64 = 0.001;
/// Required distance below the temperature limit, K. Design choice.
const COOLDOWN_K: f64 = 5.0;

/// The open port and the held position of each joint, rad or m.
pub(super) type Taken = (Wire, Vec<(usize, f64)>);

/// Opens the port and takes over its servos; returns an error text on failure.
pub(super) fn take_over(map: &PortMap) -> Result<Taken, String> {
    let protocol = map.driver.protocol();
    let mut wire = Wire::open(&map.device, map.baud, protocol, map.answer_within)?;
    let states: Vec<State> = map
        .servos
        .iter()
        .map(|mapped| check_servo(map, &mut wire, mapped))
        .collect::<Result<_, _>>()?;
    let held = map.servos.iter().zip(states).map(|(mapped, state)| {
        let shaft_rad = hold(map, &mut wire, mapped, state).map_err(|e| error_text(map, &e))?;
        Ok((mapped.joint, mapped.joint_rad(shaft_rad)))
    });
    let held = held.collect::<Result<Vec<_>, String>>()?;
    let servos: Vec<_> = map.servos.iter().map(|mapped| mapped.servo).collect();
    map.driver
        .choose_reading(&mut wire, &servos)
        .map_err(|error| error_text(map, &error))?;
    if wire.echoes() {
        tracing::warn!(
            device = map.device,
            "the adapter echoes requests; the echo is ignored"
        );
    }
    Ok((wire, held))
}

/// Returns the error text with the joint and advice.
pub(super) fn error_text(map: &PortMap, error: &WireError) -> String {
    let device = &map.device;
    let (WireError::NoReply(id)
    | WireError::Damaged(id)
    | WireError::Rejected { id, .. }
    | WireError::WrongMode { id, .. }) = error
    else {
        return format!("{device}: {error}");
    };
    let mapped = map.servos.iter().find(|mapped| mapped.servo.id == *id);
    let joint = mapped.map_or("no joint", |mapped| mapped.name.as_str());
    let advice = match error {
        WireError::NoReply(_) => "; check its power, cable and id (atas-robot probe)",
        WireError::Damaged(_) => "; check the cable, and that no two servos have this id",
        _ => "",
    };
    format!("{device}: {error} ({joint}){advice}")
}

/// Checks model, health and position of a servo; returns its torque state.
fn check_servo(map: &PortMap, wire: &mut Wire, mapped: &MappedServo) -> Result<State, String> {
    let (driver, servo, called) = (map.driver, &mapped.servo, mapped.label());
    let known = |error: WireError| error_text(map, &error);
    let number = driver.model_number(wire, servo.id).map_err(known)?;
    if number != servo.model.number {
        let found = driver.models().iter().find(|model| model.number == number);
        let found = found.map_or(format!("model {number}"), |model| model.name.to_owned());
        let (device, needed) = (&map.device, servo.model.name);
        return Err(format!(
            "{device}: {called} is {found}, the map requires {needed}; check ids and models \
             (atas-robot probe)"
        ));
    }
    let health = driver.health(wire, servo.id).map_err(known)?;
    if let [complaint, ..] = health.errors[..] {
        return Err(format!(
            "{called} reports an error: {complaint}; remove its load, then switch its power off \
             and on"
        ));
    }
    let cool_c = mapped.temperature_limit_c - COOLDOWN_K;
    if health.temperature_c > cool_c {
        let now_c = health.temperature_c;
        return Err(format!(
            "{called} is at {now_c} °C; the robot continues below {cool_c} °C"
        ));
    }
    let state = driver.state(wire, servo).map_err(known)?;
    check_position(map, wire, mapped, state)?;
    Ok(state)
}

/// Rejects a joint outside its limits: its zero or direction is wrong, or it was moved by hand.
/// Also rejects a shaft below the zero of its encoder, which no goal can hold.
fn check_position(
    map: &PortMap,
    wire: &mut Wire,
    mapped: &MappedServo,
    state: State,
) -> Result<(), String> {
    let shaft_rad = map
        .driver
        .position(wire, &mapped.servo)
        .map_err(|error| error_text(map, &error))?;
    let joint_rad = mapped.joint_rad(shaft_rad);
    let (lower, upper) = mapped.limits_rad;
    let within =
        |joint_rad: f64| joint_rad >= lower - MARGIN_RAD && joint_rad <= upper + MARGIN_RAD;
    let goal_error_rad = (map.driver.rounded(shaft_rad) - shaft_rad).abs();
    let no_goal = state == State::TorqueOff && goal_error_rad > GOAL_ERROR_MAX_RAD;
    // An absolute encoder reads almost a whole turn just below its zero.
    let is_wrapped = !within(joint_rad) && within(mapped.joint_rad(shaft_rad - TAU));
    if is_wrapped || within(joint_rad) && no_goal {
        return Err(format!(
            "{} is below the zero of its encoder, where it cannot hold (it reads {shaft_rad:.3} \
             rad); turn the joint by hand, or mount the servo so that its whole travel is above \
             zero",
            mapped.label()
        ));
    }
    if within(joint_rad) {
        return Ok(());
    }
    Err(format!(
        "{} is at {joint_rad:.3} rad, its limits are {lower:.3} to {upper:.3}; move it \
         there by hand, or correct its zero and direction (atas-robot calibrate)",
        mapped.label()
    ))
}

/// Makes a servo hold; returns the held shaft angle, rad.
fn hold(
    map: &PortMap,
    wire: &mut Wire,
    mapped: &MappedServo,
    state: State,
) -> Result<f64, WireError> {
    let (driver, servo) = (map.driver, &mapped.servo);
    match state {
        State::Holding(goal_rad) => {
            driver.limit(wire, servo)?;
            Ok(goal_rad)
        }
        State::TorqueOff => {
            driver.configure(wire, servo)?;
            let here_rad = driver.rounded(driver.position(wire, servo)?);
            driver.write_goals(wire, &[*servo], &[here_rad])?;
            driver.set_torque(wire, servo.id, true)?;
            Ok(here_rad)
        }
    }
}
