//! Recording and replay: conversion of controller set-up and inputs to bus records and back.
//!
//! [`Replay`] runs the controller on recorded ticks and compares every command bit for bit.
//!
//! * **Invariants:** a round trip changes no bit; an unknown record is an error.
//! * **Out of scope:** files, and the ticks after a panic, which the daemon holds without the
//!   controller.

mod replay;
mod task;

pub use replay::{Replay, ReplayError, Replayed};

use crate::controller::Controller;
use crate::goal::Goal;
use crate::io::OperatorRequest;
use crate::sensor_setup::{HandSensorSetup, SensorSetup};
use crate::settings::{PARAMETERS, Settings, former_name};
use robot_model::{HandModel, HandSide, RobotModel};
use shm_schemas::capacity::{ELEMENTS, JOINTS, SETTINGS};
use shm_schemas::layout::{FNV_OFFSET, fnv1a};
use shm_schemas::{HandWiringRecord, Layout, OrderKind, OrderRecord, RunHeader, SettingsRecord};

const _: () = assert!(PARAMETERS.len() <= SETTINGS);

/// Decoding error of a record.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RecordError {
    /// Settings of another parameter table.
    ParameterTableMismatch,
    /// Setting out of range.
    SettingOutOfRange {
        /// Parameter name.
        name: &'static str,
    },
    /// Contradictory settings.
    Contradiction,
    /// Unknown request kind.
    UnknownRequest {
        /// Kind code.
        kind: u32,
    },
    /// Unknown hand or task of a goal.
    UnknownGoal,
    /// Invalid number of elements or fingertips of a hand.
    InvalidHand,
}

impl core::fmt::Display for RecordError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::ParameterTableMismatch => f.write_str(
                "settings not readable: recorded with another parameter table; replay with the \
                 version that recorded them",
            ),
            Self::SettingOutOfRange { name } => {
                write!(
                    f,
                    "settings not readable: {name} is out of range; check whether the \
                    recording is damaged"
                )
            }
            Self::Contradiction => f.write_str(
                "settings not readable: values contradict each other; check whether the recording \
                 is damaged",
            ),
            Self::UnknownRequest { kind } => write!(
                f,
                "request not readable: kind {kind} is unknown to this version; replay with the \
                 version that recorded it"
            ),
            Self::UnknownGoal => f.write_str(
                "goal not readable: its hand or task is unknown to this version; replay with the \
                 version that recorded it",
            ),
            Self::InvalidHand => f.write_str(
                "sensor set-up not readable: a hand has an invalid layout; check whether the \
                 recording is damaged",
            ),
        }
    }
}

impl core::error::Error for RecordError {}

/// Converts all settings to a record.
#[must_use]
pub fn write_settings(settings: &Settings) -> SettingsRecord {
    let mut record = SettingsRecord {
        names_hash: names_hash(|name| name),
        count: PARAMETERS.len() as u32,
        ..SettingsRecord::default()
    };
    for (value, parameter) in record.value.iter_mut().zip(PARAMETERS) {
        *value = (parameter.get)(settings);
    }
    record
}

/// Converts a record to settings.
///
/// # Errors
/// [`RecordError`] for another parameter table or a value out of range.
pub fn read_settings(record: &SettingsRecord) -> Result<Settings, RecordError> {
    let known = [names_hash(|name| name), names_hash(former_name)];
    if !known.contains(&record.names_hash) || record.count as usize != PARAMETERS.len() {
        return Err(RecordError::ParameterTableMismatch);
    }
    let mut settings = Settings::default();
    for (value, parameter) in record.value.iter().zip(PARAMETERS) {
        let name = parameter.name;
        let checked = parameter.check(*value);
        checked.map_err(|_| RecordError::SettingOutOfRange { name })?;
        // No cross-checks here: intermediate states may be contradictory.
        (parameter.set)(&mut settings, *value);
    }
    settings.check().map_err(|_| RecordError::Contradiction)?;
    Ok(settings)
}

/// FNV-1a 64 hash of all parameter names in order, each as `name_of` returns it.
fn names_hash(name_of: fn(&'static str) -> &'static str) -> u64 {
    PARAMETERS.iter().fold(FNV_OFFSET, |hash, parameter| {
        fnv1a(fnv1a(hash, name_of(parameter.name).as_bytes()), b"\n")
    })
}

/// Converts a tick's request to a record.
#[must_use]
pub fn write_request(order: Option<&OperatorRequest>) -> OrderRecord {
    let mut record = OrderRecord::default();
    let kind = match order {
        None => OrderKind::NONE,
        Some(OperatorRequest::Start(goal)) => {
            record.goal = *goal.request();
            record.task = task::write(goal.task());
            record.value = goal.clearance_margin_m();
            OrderKind::START
        }
        Some(OperatorRequest::Cancel { goal_id }) => {
            record.goal_id = *goal_id;
            OrderKind::CANCEL
        }
        Some(OperatorRequest::ClientDisconnected { goal_id }) => {
            record.goal_id = *goal_id;
            OrderKind::CLIENT_GONE
        }
        Some(OperatorRequest::Stop(reason)) => {
            record.reason = (*reason).into();
            OrderKind::STOP
        }
        Some(OperatorRequest::Hold(reason)) => {
            record.reason = (*reason).into();
            OrderKind::HOLD
        }
        Some(OperatorRequest::Recover) => OrderKind::RECOVER,
        Some(OperatorRequest::SetParameter { index, value }) => {
            (record.index, record.value) = (index_to_u32(*index), *value);
            OrderKind::SET_PARAMETER
        }
        Some(OperatorRequest::Configure(settings)) => {
            record.settings = write_settings(settings);
            OrderKind::CONFIGURE
        }
        Some(OperatorRequest::Bias { hand }) => {
            record.index = index_to_u32(*hand);
            OrderKind::BIAS
        }
    };
    record.kind = kind;
    record
}

/// An index that does not fit becomes an invalid one.
fn index_to_u32(index: usize) -> u32 {
    u32::try_from(index).unwrap_or(u32::MAX)
}

/// Converts a record to a tick's request.
///
/// # Errors
/// [`RecordError`] for unknown or invalid content.
pub fn read_request(record: &OrderRecord) -> Result<Option<OperatorRequest>, RecordError> {
    let (goal_id, index) = (record.goal_id, record.index as usize);
    Ok(Some(match record.kind {
        OrderKind::NONE => return Ok(None),
        OrderKind::START => OperatorRequest::Start(read_goal(record)?),
        OrderKind::CANCEL => OperatorRequest::Cancel { goal_id },
        OrderKind::CLIENT_GONE => OperatorRequest::ClientDisconnected { goal_id },
        OrderKind::STOP => OperatorRequest::Stop(record.reason.into()),
        OrderKind::HOLD => OperatorRequest::Hold(record.reason.into()),
        OrderKind::RECOVER => OperatorRequest::Recover,
        OrderKind::SET_PARAMETER => OperatorRequest::SetParameter {
            index,
            value: record.value,
        },
        OrderKind::CONFIGURE => OperatorRequest::Configure(read_settings(&record.settings)?),
        OrderKind::BIAS => OperatorRequest::Bias { hand: index },
        unknown => return Err(RecordError::UnknownRequest { kind: unknown.0 }),
    }))
}

fn read_goal(record: &OrderRecord) -> Result<Goal, RecordError> {
    let hand = record.goal.hand.index().ok_or(RecordError::UnknownGoal)?;
    let task = task::read(&record.task).ok_or(RecordError::UnknownGoal)?;
    Ok(Goal::new(record.goal, HandSide::BOTH[hand], task).with_clearance_margin(record.value))
}

/// Writes the controller's set-up into a run header; the daemon sets the other fields.
pub fn write_origin(
    header: &mut RunHeader,
    robot: &RobotModel,
    wiring: &SensorSetup,
    settings: &Settings,
) {
    header.stamp.writer_epoch = wiring.writer_epoch;
    header.tick_s = wiring.tick_s;
    header.joints_required = u32::from(wiring.joints_required);
    let stiffness = first_hand(robot).stiffness();
    header.stiffness = [0.0; JOINTS];
    header.stiffness[..stiffness.len()].copy_from_slice(&stiffness);
    header.hands = wiring.hands.each_ref().map(write_hand);
    header.settings = write_settings(settings);
}

/// Creates a controller in the recorded initial state, for the robot named in the header.
///
/// # Errors
/// [`RecordError`] for a damaged header or another version.
pub fn read_origin(header: &RunHeader, robot: &RobotModel) -> Result<Controller, RecordError> {
    let [left, right] = &header.hands;
    let wiring = SensorSetup {
        hands: [read_hand(left)?, read_hand(right)?],
        joints_required: header.joints_required != 0,
        tick_s: header.tick_s,
        writer_epoch: header.stamp.writer_epoch,
    };
    let settings = read_settings(&header.settings)?;
    Ok(Controller::new(robot, wiring, settings))
}

fn first_hand(robot: &RobotModel) -> &HandModel {
    robot.hand(robot.sides().next().unwrap_or(HandSide::Left))
}

fn write_hand(hand: &HandSensorSetup) -> HandWiringRecord {
    let layout = &hand.layout;
    HandWiringRecord {
        fingers: index_to_u32(hand.fingers),
        required: u32::from(hand.required),
        rate_hz: hand.rate_hz,
        element_count: index_to_u32(layout.count),
        pad: 0,
        normal: layout.normal,
        tangent1: layout.tangent1,
        tangent2: layout.tangent2,
        position_m: layout.position_m,
        element_area_m2: layout.element_area_m2,
    }
}

fn read_hand(record: &HandWiringRecord) -> Result<HandSensorSetup, RecordError> {
    let (count, fingers) = (record.element_count as usize, record.fingers as usize);
    let possible = (1..=ELEMENTS).contains(&count)
        && (1..=shm_schemas::capacity::FINGERS).contains(&fingers)
        && record.rate_hz > 0.0;
    if !possible {
        return Err(RecordError::InvalidHand);
    }
    Ok(HandSensorSetup {
        layout: Layout {
            count,
            normal: record.normal,
            tangent1: record.tangent1,
            tangent2: record.tangent2,
            position_m: record.position_m,
            element_area_m2: record.element_area_m2,
        },
        fingers,
        required: record.required != 0,
        rate_hz: record.rate_hz,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use shm_schemas::{GoalKind, GoalRequest, Hand, Reason};

    #[test]
    fn every_request_survives_a_round_trip() {
        let mut settings = Settings::default();
        settings.set("grasp.dr_n", 0.1 + 0.2).expect("in range");
        let goal = |kind| {
            let request = GoalRequest {
                goal_id: 3,
                kind,
                width_m: 1.0 / 3.0,
                ..GoalRequest::default()
            };
            Goal::resolve(&request, &[]).expect("built in")
        };
        for order in [
            None,
            Some(OperatorRequest::Start(goal(GoalKind::GRASP))),
            Some(OperatorRequest::Start(goal(GoalKind::ASSEMBLE))),
            Some(OperatorRequest::Cancel { goal_id: 5 }),
            Some(OperatorRequest::ClientDisconnected { goal_id: 6 }),
            Some(OperatorRequest::Stop(Reason::Estop)),
            Some(OperatorRequest::Hold(Reason::SupervisorSilent {
                silent_s: 1.0,
                limit_s: 2.0,
            })),
            Some(OperatorRequest::Recover),
            Some(OperatorRequest::SetParameter {
                index: 7,
                value: 0.1,
            }),
            Some(OperatorRequest::Configure(settings)),
            Some(OperatorRequest::Bias { hand: 1 }),
        ] {
            assert_eq!(read_request(&write_request(order.as_ref())), Ok(order));
        }
    }

    #[test]
    fn invalid_records_are_rejected() {
        let mut record = write_request(Some(&OperatorRequest::Configure(Settings::default())));
        record.settings.value[0] = f64::NAN;
        let name = PARAMETERS[0].name;
        let out_of_range = RecordError::SettingOutOfRange { name };
        assert_eq!(read_request(&record), Err(out_of_range));
        let mut apart = Settings::default();
        apart.set("intake.reject_age_s", 5.0).expect("in range");
        apart.set("intake.hold_age_s", 0.3).expect("in range");
        let order = Some(OperatorRequest::Configure(apart));
        assert_eq!(read_request(&write_request(order.as_ref())), Ok(order));
        apart.intake.reject_age_s = 0.1;
        let contradicting = write_request(Some(&OperatorRequest::Configure(apart)));
        assert_eq!(
            read_request(&contradicting),
            Err(RecordError::Contradiction)
        );
        record.settings.names_hash ^= 1;
        assert_eq!(
            read_request(&record),
            Err(RecordError::ParameterTableMismatch)
        );
        let mut start = write_request(None);
        start.kind = OrderKind::START;
        assert_eq!(
            read_request(&start),
            Err(RecordError::UnknownGoal),
            "no task"
        );
        start.goal.hand = Hand(2);
        assert_eq!(
            read_request(&start),
            Err(RecordError::UnknownGoal),
            "no hand"
        );
        record.kind = OrderKind(99);
        assert_eq!(
            read_request(&record),
            Err(RecordError::UnknownRequest { kind: 99 })
        );
    }
}
