//! Conversion of a task to a bus record and back.

use crate::modules::{IDS, Selection};
use crate::tasks::{
    BehaviourTable, MOTIONS, Name, Step, StepSequence, TRANSITIONS, Task, Transition, WAYPOINTS,
};
use shm_schemas::{StepRecord, TableRecord, TaskRecord, Text, TrackRecord};

/// Converts a task to a record.
pub(super) fn write(task: &Task) -> TaskRecord {
    TaskRecord {
        name: Text::new(&task.name),
        acting: write_track(Some(&task.acting)),
        helping: write_track(task.helping.as_ref()),
        table: task
            .table
            .map_or_else(TableRecord::default, |table| table.record()),
    }
}

/// Converts a record to a task; `None` if it contains an unknown code.
pub(super) fn read(record: &TaskRecord) -> Option<Task> {
    let helping = &record.helping;
    Some(Task {
        name: Name::new(record.name.as_str()),
        acting: read_track(&record.acting)?,
        helping: match helping.count {
            0 => None,
            _ => Some(read_track(helping)?),
        },
        table: BehaviourTable::from_record(&record.table).ok()?,
    })
}

fn write_track(track: Option<&StepSequence>) -> TrackRecord {
    let steps: &[Step] = track.map_or(&[], |track| track);
    let mut record = TrackRecord {
        count: super::index_to_u32(steps.len()),
        ..TrackRecord::default()
    };
    for (record, step) in record.steps.iter_mut().zip(steps) {
        *record = write_step(step);
    }
    record
}

fn read_track(record: &TrackRecord) -> Option<StepSequence> {
    let used = record.steps.get(..record.count as usize)?;
    let mut steps = [Step::NONE; shm_schemas::capacity::STEPS];
    for (step, record) in steps.iter_mut().zip(used) {
        *step = read_step(record)?;
    }
    StepSequence::validated(&steps[..used.len()])
}

fn write_step(step: &Step) -> StepRecord {
    let place = |place: Option<usize>| place.map_or(u32::MAX, super::index_to_u32);
    let motion = step.motion;
    StepRecord {
        name: Text::new(&step.name),
        motion: place(MOTIONS.iter().position(|m| m.name() == motion.name())),
        waypoint: place(motion.waypoint().map_or(Some(0), |waypoint| {
            WAYPOINTS.iter().position(|known| *known == waypoint)
        })),
        modules: bits(step.modules),
        transition: place(
            TRANSITIONS
                .iter()
                .position(|u| u.name() == step.transition.name()),
        ),
        point: match step.transition {
            Transition::Met(point) => u32::from(point),
            _ => 0,
        },
        pad: 0,
        timeout_s: step.timeout_s,
    }
}

fn read_step(record: &StepRecord) -> Option<Step> {
    let motion = MOTIONS.get(record.motion as usize)?;
    let waypoint = WAYPOINTS.get(record.waypoint as usize)?;
    let until = match TRANSITIONS.get(record.transition as usize)? {
        Transition::Met(_) => Transition::Met(u8::try_from(record.point).ok()?),
        until => *until,
    };
    let modules = IDS
        .into_iter()
        .filter(|id| record.modules >> id.0 & 1 == 1)
        .fold(Selection::NONE, |sum, id| {
            sum.union(Selection::from_modules(&[id]))
        });
    if bits(modules) != record.modules {
        return None;
    }
    let (name, motion) = (record.name.as_str(), motion.with_waypoint(*waypoint));
    Some(Step::new(name, motion, modules, until, record.timeout_s))
}

fn bits(modules: Selection) -> u32 {
    modules.ids().fold(0, |bits, id| bits | 1 << id.0)
}
