//! First difference between two recordings: tick, field, and the ends of both.
//!
//! Times, writers, sequences and checksums are not compared: they differ between any two runs.

// Numbers of a file or a device reach this arithmetic.
#![warn(clippy::arithmetic_side_effects)]

use std::path::Path;

use shm_schemas::{HandFrame, JointCommand, JointState, OrderRecord, Status, TickInputs};
use zerocopy::{Immutable, IntoBytes};

use super::reader::{Entry, Reader, payload};

/// Fields of time and writer, which are not compared.
const NOT_COMPARED: [&str; 7] = [
    "stamp",
    "valid_until_ns",
    "crc32",
    "answers_sequence",
    "command_epoch",
    "command_sequence",
    "command_valid_until_ns",
];

/// Common part and first difference of two recordings.
pub struct Difference {
    /// Equal ticks before the first difference.
    pub equal_ticks: u64,
    /// First different tick and its difference, if any.
    pub first: Option<(u64, String)>,
    /// Last status of each recording.
    pub ends: [Option<Box<Status>>; 2],
}

/// Compares two recordings.
///
/// # Errors
/// A recording cannot be read.
pub fn diff(a: &Path, b: &Path) -> anyhow::Result<Difference> {
    let (mut first, mut second) = (Ticks::open(a)?, Ticks::open(b)?);
    let mut equal_ticks = 0_u64;
    let difference = loop {
        match (first.next()?, second.next()?) {
            (Some(a), Some(b)) => match part_difference(&a, &b) {
                Some(field) => break Some((a.tick, field)),
                None => equal_ticks = equal_ticks.saturating_add(u64::from(a.part == 0)),
            },
            (None, None) => break None,
            (Some(longer), None) => {
                break Some((longer.tick, "the second recording ends here".into()));
            }
            (None, Some(longer)) => {
                break Some((longer.tick, "the first recording ends here".into()));
            }
        }
    };
    Ok(Difference {
        equal_ticks,
        first: difference,
        ends: [first.end()?, second.end()?],
    })
}

/// Ticks of a file, and its last status.
struct Ticks {
    entries: Reader,
    last: Option<Box<Status>>,
}

impl Ticks {
    fn open(path: &Path) -> anyhow::Result<Self> {
        Ok(Self {
            entries: Reader::open(path)?,
            last: None,
        })
    }

    fn next(&mut self) -> anyhow::Result<Option<Box<TickInputs>>> {
        for entry in &mut self.entries {
            let Entry::Message(message) = entry? else {
                continue;
            };
            if let Some(part) = payload::<TickInputs>(&message)? {
                return Ok(Some(part));
            }
            self.last = payload::<Status>(&message)?.or(self.last.take());
        }
        Ok(None)
    }

    /// Returns the last status; reads to the end.
    fn end(mut self) -> anyhow::Result<Option<Box<Status>>> {
        while self.next()?.is_some() {}
        Ok(self.last)
    }
}

/// Compares inputs first: if they differ, commands may differ too.
fn part_difference(a: &TickInputs, b: &TickInputs) -> Option<String> {
    let under = |of: &str, field: Option<String>| field.map(|field| format!("{of}.{field}"));
    let counts = |part: &TickInputs| (part.tick, part.part, part.has_frame, part.has_joints);
    if counts(a) != counts(b) {
        return Some("which inputs arrived".into());
    }
    under(
        "frames[0]",
        difference(HandFrame::FIELDS, &a.frames[0], &b.frames[0]),
    )
    .or_else(|| {
        under(
            "frames[1]",
            difference(HandFrame::FIELDS, &a.frames[1], &b.frames[1]),
        )
    })
    .or_else(|| {
        under(
            "joints",
            difference(JointState::FIELDS, &a.joints, &b.joints),
        )
    })
    .or_else(|| under("order", request_difference(&a.order, &b.order)))
    .or_else(|| command_difference(&a.command, &b.command, &NOT_COMPARED))
}

fn request_difference(a: &OrderRecord, b: &OrderRecord) -> Option<String> {
    let (mut a, mut b) = (*a, *b);
    // The time of sending and the client's goal number are not part of the request.
    for order in [&mut a, &mut b] {
        order.goal_id = 0;
        (order.goal.stamp, order.goal.goal_id) = Default::default();
    }
    difference(OrderRecord::FIELDS, &a, &b)
}

/// Returns the first different field of two commands, except those listed, with both values if they
/// are readable.
#[must_use]
pub fn command_difference(a: &JointCommand, b: &JointCommand, except: &[&str]) -> Option<String> {
    let joints = |name: &str, a: &[f64], b: &[f64]| {
        let at = a
            .iter()
            .zip(b)
            .position(|(a, b)| a.to_bits() != b.to_bits())?;
        Some(format!(
            "command.{name}[{at}] is {:?} and {:?}",
            a[at], b[at]
        ))
    };
    joints("position", &a.position, &b.position)
        .or_else(|| joints("velocity", &a.velocity, &b.velocity))
        .or_else(|| {
            (a.mode != b.mode).then(|| format!("command.mode is {} and {}", a.mode, b.mode))
        })
        .or_else(|| field(JointCommand::FIELDS, a, b, except).map(|name| format!("command.{name}")))
}

fn difference<T: IntoBytes + Immutable>(
    fields: &'static [(&'static str, usize, usize)],
    a: &T,
    b: &T,
) -> Option<String> {
    field(fields, a, b, &NOT_COMPARED).map(str::to_owned)
}

/// Returns the name of the first different field of two payloads.
fn field<T: IntoBytes + Immutable>(
    fields: &'static [(&'static str, usize, usize)],
    a: &T,
    b: &T,
    except: &[&str],
) -> Option<&'static str> {
    let (a, b) = (a.as_bytes(), b.as_bytes());
    // Offsets and sizes of a layout that the compiler checked.
    let range = |offset: usize, size: usize| offset..offset.saturating_add(size);
    let differs = |offset: usize, size: usize| a[range(offset, size)] != b[range(offset, size)];
    let mut compared = fields.iter().filter(|(name, ..)| !except.contains(name));
    compared
        .find(|(_, offset, size)| differs(*offset, *size))
        .map(|(name, ..)| *name)
}
