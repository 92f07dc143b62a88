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
use crate::io::Order;
use crate::settings::{PARAMETERS, Settings};
use crate::wiring::{HandWiring, Wiring};
use robot_model::{HandModel, RobotModel, Side};
use shm_schemas::capacity::{ELEMENTS, JOINTS, SETTINGS};
use shm_schemas::layout::{FNV_OFFSET, fnv1a};
use shm_schemas::{HandWiringRecord, Layout, OrderKind, OrderRecord, RunHeader, SettingsRecord};

const _: () = assert!(PARAMETERS.len() <= SETTINGS);

/// Decoding error of a record.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Unreadable {
    /// Settings of another parameter table.
    OtherParameters,
    /// Setting out of range.
    SettingOutOfRange {
        /// Parameter name.
        name: &'static str,
    },
    /// Contradictory settings.
    Contradiction,
    /// Unknown request kind.
    UnknownOrder {
        /// Kind code.
        kind: u32,
    },
    /// Unknown hand or task of a goal.
    UnknownGoal,
    /// Invalid number of elements or fingertips of a hand.
    ImpossibleHand,
}

impl core::fmt::Display for Unreadable {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::OtherParameters => f.write_str(
                "could not read the settings because they were recorded with another table of parameters; \
                 replay with the version that recorded them",
            ),
            Self::SettingOutOfRange { name } => {
                write!(f, "could not read the settings because {name} is out of its range; is the recording damaged?")
            }
            Self::Contradiction => f.write_str(
                "could not read the settings because they contradict each other; is the recording damaged?",
            ),
            Self::UnknownOrder { kind } => write!(
                f,
                "could not read an order because its kind was {kind}, which this version does not know; \
                 replay with the version that recorded it"
            ),
            Self::UnknownGoal => f.write_str(
                "could not read a goal because its hand or its task has words that this version does not know; \
                 replay with the version that recorded it",
            ),
            Self::ImpossibleHand => f.write_str(
                "could not read the wiring because a hand has an impossible layout; is the recording damaged?",
            ),
        }
    }
}

impl core::error::Error for Unreadable {}

/// Converts all settings to a record.
#[must_use]
pub fn write_settings(settings: &Settings) -> SettingsRecord {
    let mut record = SettingsRecord {
        names_hash: names_hash(),
        count: PARAMETERS.len() as u32,
        ..SettingsRecord::default()
    };
    for (value, parameter) in record.value.iter_mut().zip(PARAMETERS) {
        *value = (parameter.get)(settings);
    }
    record
}

/// The settings of a record.
///
/// # Errors
/// [`Unreadable`] if the record follows another table, or a value is out of its range.
pub fn read_settings(record: &SettingsRecord) -> Result<Settings, Unreadable> {
    if record.names_hash != names_hash() || record.count as usize != PARAMETERS.len() {
        return Err(Unreadable::OtherParameters);
    }
    let mut settings = Settings::default();
    for (value, parameter) in record.value.iter().zip(PARAMETERS) {
        let name = parameter.name;
        let checked = parameter.check(*value);
        checked.map_err(|_| Unreadable::SettingOutOfRange { name })?;
        // No cross-checks here: intermediate states may be contradictory.
        (parameter.set)(&mut settings, *value);
    }
    settings.check().map_err(|_| Unreadable::Contradiction)?;
    Ok(settings)
}

/// FNV-1a 64 hash of all parameter names in order, each as `name_of` returns it.
fn names_hash() -> u64 {
    PARAMETERS.iter().fold(FNV_OFFSET, |hash, parameter| {
        fnv1a(fnv1a(hash, parameter.name.as_bytes()), b"\n")
    })
}

/// Converts a tick's request to a record.
#[must_use]
pub fn write_order(order: Option<&Order>) -> OrderRecord {
    let mut record = OrderRecord::default();
    let kind = match order {
        None => OrderKind::NONE,
        Some(Order::Start(goal)) => {
            record.goal = *goal.request();
            record.task = task::write(goal.task());
            record.value = goal.spare_m();
            OrderKind::START
        }
        Some(Order::Cancel { goal_id }) => {
            record.goal_id = *goal_id;
            OrderKind::CANCEL
        }
        Some(Order::ClientGone { goal_id }) => {
            record.goal_id = *goal_id;
            OrderKind::CLIENT_GONE
        }
        Some(Order::Stop(reason)) => {
            record.reason = *reason;
            OrderKind::STOP
        }
        Some(Order::Hold(reason)) => {
            record.reason = *reason;
            OrderKind::HOLD
        }
        Some(Order::Recover) => OrderKind::RECOVER,
        Some(Order::SetParameter { index, value }) => {
            (record.index, record.value) = (index_word(*index), *value);
            OrderKind::SET_PARAMETER
        }
        Some(Order::Configure(settings)) => {
            record.settings = write_settings(settings);
            OrderKind::CONFIGURE
        }
        Some(Order::Bias { hand }) => {
            record.index = index_word(*hand);
            OrderKind::BIAS
        }
    };
    record.kind = kind;
    record
}

/// An index that does not fit becomes an invalid one.
fn index_word(index: usize) -> u32 {
    u32::try_from(index).unwrap_or(u32::MAX)
}

/// Converts a record to a tick's request.
///
/// # Errors
/// [`Unreadable`] for unknown or invalid content.
pub fn read_order(record: &OrderRecord) -> Result<Option<Order>, Unreadable> {
    let (goal_id, index) = (record.goal_id, record.index as usize);
    Ok(Some(match record.kind {
        OrderKind::NONE => return Ok(None),
        OrderKind::START => Order::Start(read_goal(record)?),
        OrderKind::CANCEL => Order::Cancel { goal_id },
        OrderKind::CLIENT_GONE => Order::ClientGone { goal_id },
        OrderKind::STOP => Order::Stop(record.reason),
        OrderKind::HOLD => Order::Hold(record.reason),
        OrderKind::RECOVER => Order::Recover,
        OrderKind::SET_PARAMETER => Order::SetParameter {
            index,
            value: record.value,
        },
        OrderKind::CONFIGURE => Order::Configure(read_settings(&record.settings)?),
        OrderKind::BIAS => Order::Bias { hand: index },
        unknown => return Err(Unreadable::UnknownOrder { kind: unknown.0 }),
    }))
}

fn read_goal(record: &OrderRecord) -> Result<Goal, Unreadable> {
    let hand = record.goal.hand.index().ok_or(Unreadable::UnknownGoal)?;
    let task = task::read(&record.task).ok_or(Unreadable::UnknownGoal)?;
    Ok(Goal::of(record.goal, Side::BOTH[hand], task).with_spare(record.value))
}

/// Writes the controller's set-up into a run header; the daemon sets the other fields.
pub fn write_origin(
    header: &mut RunHeader,
    robot: &RobotModel,
    wiring: &Wiring,
    settings: &Settings,
) {
    header.stamp.writer_epoch = wiring.writer_epoch;
    header.tick_s = wiring.tick_s;
    header.joints_required = u32::from(wiring.joints_required);
    let stiffness_n_m_rad = hand_of(robot).stiffness_n_m_rad();
    header.stiffness_n_m_rad = [0.0; JOINTS];
    header.stiffness_n_m_rad[..stiffness_n_m_rad.len()].copy_from_slice(&stiffness_n_m_rad);
    header.hands = wiring.hands.each_ref().map(write_hand);
    header.settings = write_settings(settings);
}

/// Creates a controller in the recorded initial state, for the robot named in the header.
///
/// # Errors
/// [`Unreadable`] for a damaged header or another version.
pub fn read_origin(header: &RunHeader, robot: &RobotModel) -> Result<Controller, Unreadable> {
    let [left, right] = &header.hands;
    let wiring = Wiring {
        hands: [read_hand(left)?, read_hand(right)?],
        joints_required: header.joints_required != 0,
        tick_s: header.tick_s,
        writer_epoch: header.stamp.writer_epoch,
    };
    let settings = read_settings(&header.settings)?;
    Ok(Controller::new(robot, wiring, settings))
}

fn hand_of(robot: &RobotModel) -> &HandModel {
    robot.hand(robot.sides().next().unwrap_or(Side::Left))
}

fn write_hand(hand: &HandWiring) -> HandWiringRecord {
    let layout = &hand.layout;
    HandWiringRecord {
        fingers: index_word(hand.fingers),
        required: u32::from(hand.required),
        rate_hz: hand.rate_hz,
        element_count: index_word(layout.count),
        pad: 0,
        normal: layout.normal,
        tangent1: layout.tangent1,
        tangent2: layout.tangent2,
        position_m: layout.position_m,
        element_area_m2: layout.element_area_m2,
    }
}

fn read_hand(record: &HandWiringRecord) -> Result<HandWiring, Unreadable> {
    let (count, fingers) = (record.element_count as usize, record.fingers as usize);
    let possible = (1..=ELEMENTS).contains(&count)
        && (1..=shm_schemas::capacity::FINGERS).contains(&fingers)
        && record.rate_hz > 0.0;
    if !possible {
        return Err(Unreadable::ImpossibleHand);
    }
    Ok(HandWiring {
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
    use shm_schemas::{Cause, GoalKind, GoalRequest, Hand, Reason};

    #[test]
    fn every_order_reads_back_as_written() {
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
            Some(Order::Start(goal(GoalKind::GRASP))),
            Some(Order::Start(goal(GoalKind::ASSEMBLE))),
            Some(Order::Cancel { goal_id: 5 }),
            Some(Order::ClientGone { goal_id: 6 }),
            Some(Order::Stop(Reason::limit(Cause::ESTOP, 1.0, 2.0))),
            Some(Order::Recover),
            Some(Order::SetParameter {
                index: 7,
                value: 0.1,
            }),
            Some(Order::Configure(settings)),
            Some(Order::Bias { hand: 1 }),
        ] {
            assert_eq!(read_order(&write_order(order.as_ref())), Ok(order));
        }
    }

    #[test]
    fn what_means_something_else_is_refused() {
        let mut record = write_order(Some(&Order::Configure(Settings::default())));
        record.settings.value[0] = f64::NAN;
        let name = PARAMETERS[0].name;
        let out_of_range = Unreadable::SettingOutOfRange { name };
        assert_eq!(read_order(&record), Err(out_of_range));
        let mut apart = Settings::default();
        apart.set("intake.reject_age_s", 5.0).expect("in range");
        apart.set("intake.hold_age_s", 0.3).expect("in range");
        let order = Some(Order::Configure(apart));
        assert_eq!(read_order(&write_order(order.as_ref())), Ok(order));
        apart.intake.reject_age_s = 0.1;
        let contradicting = write_order(Some(&Order::Configure(apart)));
        assert_eq!(read_order(&contradicting), Err(Unreadable::Contradiction));
        record.settings.names_hash ^= 1;
        assert_eq!(read_order(&record), Err(Unreadable::OtherParameters));
        let mut start = write_order(None);
        start.kind = OrderKind::START;
        assert_eq!(read_order(&start), Err(Unreadable::UnknownGoal), "no task");
        start.goal.hand = Hand(2);
        assert_eq!(read_order(&start), Err(Unreadable::UnknownGoal), "no hand");
        record.kind = OrderKind(99);
        assert_eq!(
            read_order(&record),
            Err(Unreadable::UnknownOrder { kind: 99 })
        );
    }
}
