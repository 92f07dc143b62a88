//! Taking the servos of a port over so that nothing moves: before the first cycle, and after every trouble.
//!
//! All are looked at before any is touched. A servo that holds goes on holding what it holds: a grip outlives this process. A loose
//! one gets its settings, then the place where it stands as its goal, and only then torque.

use super::PortMap;
use crate::drivers::State;
use crate::drivers::wire::{Wire, WireError};
use crate::map::MappedServo;

/// How far outside its limits a joint may stand, rad: what the daemon believes of one.
const MARGIN_RAD: f64 = 0.05;
/// How much cooler than its limit a servo must be before the robot goes on, K. Ours.
const COOLER_K: f64 = 5.0;

/// The open port, and where each joint is held, rad.
pub(super) type Taken = (Wire, Vec<(usize, f64)>);

/// Opens the port and takes its servos over, or says in words why not.
pub(super) fn take_over(map: &PortMap) -> Result<Taken, String> {
    let protocol = map.driver.protocol();
    let mut wire = Wire::open(&map.device, map.baud, protocol, map.answer_within)?;
    let states: Vec<State> = map
        .servos
        .iter()
        .map(|mapped| look(map, &mut wire, mapped))
        .collect::<Result<_, _>>()?;
    let held = map.servos.iter().zip(states).map(|(mapped, state)| {
        let shaft_rad = hold(map, &mut wire, mapped, state).map_err(|e| explained(map, &e))?;
        Ok((mapped.joint, mapped.joint_rad(shaft_rad)))
    });
    let held = held.collect::<Result<Vec<_>, String>>()?;
    let servos: Vec<_> = map.servos.iter().map(|mapped| mapped.servo).collect();
    map.driver
        .choose_reading(&mut wire, &servos)
        .map_err(|error| explained(map, &error))?;
    Ok((wire, held))
}

/// An error with the joint that it concerns, and what to do.
pub(super) fn explained(map: &PortMap, error: &WireError) -> String {
    let device = &map.device;
    let (WireError::Silent(id)
    | WireError::Damaged(id)
    | WireError::Refused { id, .. }
    | WireError::OtherMode { id, .. }) = error
    else {
        return format!("{device}: {error}");
    };
    let mapped = map.servos.iter().find(|mapped| mapped.servo.id == *id);
    let joint = mapped.map_or("no joint", |mapped| mapped.name.as_str());
    let advice = match error {
        WireError::Silent(_) => "; check its power, cable and id (atas-robot probe)",
        WireError::Damaged(_) => "; check the cable, and that no two servos have this id",
        _ => "",
    };
    format!("{device}: {error} ({joint}){advice}")
}

/// Whether a servo is what the map says, is well, and holds.
fn look(map: &PortMap, wire: &mut Wire, mapped: &MappedServo) -> Result<State, String> {
    let (driver, servo, called) = (map.driver, &mapped.servo, mapped.called());
    let known = |error: WireError| explained(map, &error);
    let number = driver.model_number(wire, servo.id).map_err(known)?;
    if number != servo.model.number {
        let found = driver.models().iter().find(|model| model.number == number);
        let found = found.map_or(format!("model {number}"), |model| model.name.to_owned());
        let (device, needed) = (&map.device, servo.model.name);
        return Err(format!(
            "{device}: {called} is {found}, the map says {needed}; check ids and models (atas-robot probe)"
        ));
    }
    let health = driver.health(wire, servo.id).map_err(known)?;
    if let [complaint, ..] = health.complaints[..] {
        return Err(format!(
            "{called} says that {complaint}; take its load away, then its power, and give it back"
        ));
    }
    let cool_c = mapped.temperature_limit_c - COOLER_K;
    if health.temperature_c > cool_c {
        let now_c = health.temperature_c;
        return Err(format!(
            "{called} is at {now_c} °C; the robot goes on below {cool_c}"
        ));
    }
    let state = driver.state(wire, servo).map_err(known)?;
    stands_within(map, wire, mapped)?;
    Ok(state)
}

/// A joint outside its limits would be believed by nobody: its zero or its direction is wrong, or somebody pushed it there.
fn stands_within(map: &PortMap, wire: &mut Wire, mapped: &MappedServo) -> Result<(), String> {
    let shaft_rad = position_rad(map, wire, mapped).map_err(|error| explained(map, &error))?;
    let joint_rad = mapped.joint_rad(shaft_rad);
    let (lower_rad, upper_rad) = mapped.limits_rad;
    if joint_rad >= lower_rad - MARGIN_RAD && joint_rad <= upper_rad + MARGIN_RAD {
        return Ok(());
    }
    Err(format!(
        "{} stands at {joint_rad:.3} rad, allowed are {lower_rad:.3} to {upper_rad:.3}; move it there by hand, or correct its zero and \
         direction (atas-robot calibrate)",
        mapped.called()
    ))
}

fn position_rad(map: &PortMap, wire: &mut Wire, mapped: &MappedServo) -> Result<f64, WireError> {
    let mut reading = Vec::new();
    map.driver.read(wire, &[mapped.servo], &mut reading)?;
    reading
        .first()
        .map(|reading| reading.position_rad)
        .ok_or(WireError::Silent(mapped.servo.id))
}

/// Makes a servo hold, and says where, rad of its shaft.
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
        State::Loose => {
            driver.configure(wire, servo)?;
            let here_rad = driver.rounded(position_rad(map, wire, mapped)?);
            driver.write_goals(wire, &[*servo], &[here_rad])?;
            driver.set_torque(wire, servo.id, true)?;
            Ok(here_rad)
        }
    }
}
