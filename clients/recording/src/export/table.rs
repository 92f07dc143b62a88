//! Table row of a tick: named columns with units in the names, common to CSV and Parquet.

use std::borrow::Cow;

use robot_model::JointKind;
use shm_schemas::{FingerReport, Hand, HandReport, JointState, ModuleId, TickReport};

use super::subject::Subject;
use crate::rows::Row;

/// Value of a cell; empty if not recorded.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Cell {
    Empty,
    Whole(i64),
    Number(f64),
    /// Number with the digits of a 32-bit float.
    Short(f32),
    Text(Cow<'static, str>),
}

/// Type of a column.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Form {
    Whole,
    Number,
    Short,
    Text,
}

/// Column.
pub(super) struct Column {
    pub(super) name: String,
    pub(super) form: Form,
    value: Box<dyn Fn(&Row) -> Cell>,
}

impl Column {
    pub(super) fn cell(&self, row: &Row) -> Cell {
        (self.value)(row)
    }
}

type Of<T> = (&'static str, fn(&T) -> f32);

const OF_HAND: [Of<HandReport>; 3] = [
    ("f1_n", |hand| hand.f1_n),
    ("f2_n", |hand| hand.f2_n),
    ("stiffness_n_m", |hand| hand.stiffness_n_m),
];
const OF_FINGER: [Of<FingerReport>; 7] = [
    ("normal_n", |finger| finger.normal_n),
    ("tangential_n", |finger| finger.tangential_n),
    ("tangential_increment_n", |finger| {
        finger.tangential_increment_n
    }),
    ("utilisation", |finger| finger.utilisation),
    ("friction", |finger| finger.friction),
    ("closing_m_s", |finger| finger.closing_m_s),
    ("in_contact", |finger| finger.in_contact as f32),
];
/// Components of an element's force: normal, and along both tangents.
const COMPONENTS: [&str; 3] = ["fn", "ft1", "ft2"];

/// Returns all columns in the order of the file.
pub(super) fn columns(subject: &Subject, elements: bool) -> Vec<Column> {
    let clock = subject.clock;
    let mut columns = vec![
        column("tick", Form::Whole, |row| Cell::Whole(row.tick as i64)),
        column("unix_ns", Form::Whole, move |row| {
            Cell::Whole(clock.unix_ns(row.captured_ns) as i64)
        }),
        column("sensor_ns", Form::Whole, |row| {
            Cell::Whole(row.captured_ns as i64)
        }),
        report_column("mode", Form::Text, |report| {
            Cell::Text(report.mode.name().into())
        }),
        report_column("goal_id", Form::Whole, |report| {
            Cell::Whole(report.goal_id as i64)
        }),
        report_column("wake_late_ns", Form::Whole, |report| {
            Cell::Whole(report.wake_late_ns.into())
        }),
        report_column("sensor_to_command_ns", Form::Whole, |report| {
            Cell::Whole(report.sensor_to_command_ns.into())
        }),
    ];
    let hands = subject.fingers.iter().copied().enumerate();
    let hands: Vec<_> = hands.filter(|(_, fingers)| *fingers > 0).collect();
    for (hand, fingers) in &hands {
        columns.extend(hand_columns(*hand, *fingers));
    }
    columns.extend(joint_columns(subject));
    if elements {
        for (hand, fingers) in &hands {
            let count = subject.layouts[*hand].count;
            columns.extend(element_columns(*hand, *fingers, count));
        }
    }
    columns
}

fn column(name: impl Into<String>, form: Form, value: impl Fn(&Row) -> Cell + 'static) -> Column {
    Column {
        name: name.into(),
        form,
        value: Box::new(value),
    }
}

fn report_column(
    name: impl Into<String>,
    form: Form,
    value: impl Fn(&TickReport) -> Cell + 'static,
) -> Column {
    column(name, form, move |row| {
        row.report.as_deref().map_or(Cell::Empty, &value)
    })
}

fn hand_columns(hand: usize, fingers: usize) -> Vec<Column> {
    let name = |what: &str| format!("{}_{what}", Hand::BOTH[hand]);
    let mut columns = vec![
        column(name("step"), Form::Text, move |row| {
            let step = row.steps[hand].as_str();
            match row.report {
                Some(_) if !step.is_empty() => Cell::Text(step.to_owned().into()),
                _ => Cell::Empty,
            }
        }),
        report_column(name("step_index"), Form::Whole, move |report| {
            Cell::Whole(report.hands[hand].step.into())
        }),
        report_column(name("frame_age_ns"), Form::Whole, move |report| {
            let age_ns = i64::try_from(report.hands[hand].frame_age_ns);
            age_ns.map_or(Cell::Empty, Cell::Whole)
        }),
    ];
    for (what, value) in OF_HAND {
        columns.push(report_column(name(what), Form::Short, move |report| {
            Cell::Short(value(&report.hands[hand]))
        }));
    }
    for id in ModuleId::ALL.iter().filter(|id| **id != ModuleId::NONE) {
        let what = format!("module_{}", super::messages::word(*id));
        columns.push(report_column(name(&what), Form::Whole, move |report| {
            Cell::Whole((report.hands[hand].modules_active >> id.0 & 1).into())
        }));
    }
    for finger in 0..fingers {
        for (what, value) in OF_FINGER {
            let what = format!("finger{}_{what}", finger + 1);
            columns.push(report_column(name(&what), Form::Short, move |report| {
                Cell::Short(value(&report.hands[hand].fingers[finger]))
            }));
        }
    }
    columns
}

/// Returns the unit suffixes of a joint's position, velocity and effort.
fn units(kind: JointKind) -> [&'static str; 3] {
    match kind {
        JointKind::Revolute => ["rad", "rad_s", "n_m"],
        JointKind::Prismatic => ["m", "m_s", "n"],
    }
}

fn joint_columns(subject: &Subject) -> Vec<Column> {
    type OfJoint = (&'static str, fn(&JointState) -> &[f64]);
    let measured: [OfJoint; 3] = [
        ("position", |joints| &joints.position),
        ("velocity", |joints| &joints.velocity),
        ("effort", |joints| &joints.effort),
    ];
    let mut columns = Vec::new();
    for (index, (joint, kind)) in subject.joints().enumerate() {
        let units = units(kind);
        for ((what, values), unit) in measured.into_iter().zip(units) {
            columns.push(column(
                format!("{joint}_{what}_{unit}"),
                Form::Number,
                move |row| {
                    let inputs = row.inputs.as_deref();
                    let joints = inputs.and_then(|inputs| inputs.joints.as_ref());
                    let known = joints.filter(|joints| index < joints.joint_count as usize);
                    known.map_or(Cell::Empty, |joints| Cell::Number(values(joints)[index]))
                },
            ));
        }
        let name = format!("{joint}_commanded_{}", units[0]);
        columns.push(column(name, Form::Number, move |row| {
            let command = row.inputs.as_deref().map(|inputs| &inputs.command);
            let known = command.filter(|command| index < command.joint_count as usize);
            known.map_or(Cell::Empty, |command| Cell::Number(command.position[index]))
        }));
    }
    columns
}

fn element_columns(hand: usize, fingers: usize, count: usize) -> Vec<Column> {
    let mut columns = Vec::new();
    for finger in 0..fingers {
        for element in 0..count {
            for (axis, component) in COMPONENTS.iter().enumerate() {
                let name = format!(
                    "{}_finger{}_element{element}_{component}_n",
                    Hand::BOTH[hand],
                    finger + 1
                );
                columns.push(column(name, Form::Short, move |row| {
                    let inputs = row.inputs.as_deref();
                    let frame = inputs.and_then(|inputs| inputs.frames[hand].as_ref());
                    let is_valid = |mask: u64| mask >> element & 1 == 1;
                    let valid = frame.filter(|frame| is_valid(frame.valid_mask[finger]));
                    valid.map_or(Cell::Empty, |frame| {
                        Cell::Short(frame.force_n[finger][element][axis])
                    })
                }));
            }
        }
    }
    columns
}
