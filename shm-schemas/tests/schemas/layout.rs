//! Golden layout: size, alignment and fields of every payload.

use shm_schemas::Payload;
use shm_schemas::*;
use std::collections::HashSet;
use std::fmt::Write;

type Fields = &'static [(&'static str, usize, usize)];

/// Returns name, versioned type name, size, alignment and fields of every payload.
fn payloads() -> Vec<(&'static str, &'static str, usize, usize, Fields)> {
    macro_rules! list {
        ($($name:ident)*) => {
            vec![$((
                stringify!($name),
                <$name as Payload>::TYPE_NAME,
                size_of::<$name>(),
                align_of::<$name>(),
                $name::FIELDS,
            )),*]
        };
    }
    list! {
        Stamp HandFrame JointState JointCommand GoalRequest GraspTarget GraspFigures GoalUpdate ReasonRecord
        ControlRequest ControlReply StopRequest StopAnswer ModuleEvent Percentiles HandStatus JointStatus Status SensorStatus
        FingerReport HandReport TickReport View SettingsRecord StepRecord TrackRecord TableRecord TaskRecord OrderRecord TickInputs HandWiringRecord RunHeader AgentSensors WheelCommands BaseState BaseCommand ObjectTruth WorldTruth
        AgentTruth FieldTruth TrialTruth WallTruth PostTruth ArenaTruth
    }
}

fn described() -> String {
    let mut text = String::new();
    for (_, wire, size, align, fields) in payloads() {
        writeln!(text, "{wire} size {size} align {align}").unwrap();
        for (field, offset, size) in fields {
            writeln!(text, "  {field} at {offset} size {size}").unwrap();
        }
    }
    text
}

#[test]
fn every_payload_is_laid_out_as_pinned() {
    let (golden, actual) = (include_str!("layout.golden"), described());
    if golden == actual {
        return;
    }
    let lines = |text: &str| text.lines().map(str::to_owned).collect::<HashSet<_>>();
    let (pinned, found) = (lines(golden), lines(&actual));
    let gone = golden
        .lines()
        .filter(|l| !found.contains(*l))
        .map(|l| format!("- {l}\n"));
    let new = actual
        .lines()
        .filter(|l| !pinned.contains(*l))
        .map(|l| format!("+ {l}\n"));
    let changes: String = gone.chain(new).collect();
    let path = concat!(env!("CARGO_TARGET_TMPDIR"), "/layout.actual");
    std::fs::write(path, actual).unwrap();
    panic!(
        "a payload layout differs from the golden file:\n{changes}a changed layout needs a new \
         version: raise the number in the type name and in its service name, then replace \
         layout.golden by {path}"
    );
}

#[test]
fn fields_follow_each_other_without_gaps() {
    for (name, _, size, _, fields) in payloads() {
        let mut end = 0;
        for (field, offset, field_size) in fields {
            assert_eq!(*offset, end, "gap before {name}.{field}");
            end = offset + field_size;
        }
        assert_eq!(end, size, "{name} has a gap at its end");
    }
}

#[test]
fn type_names_are_unique_versioned_and_name_the_type() {
    let mut seen = HashSet::new();
    for (name, wire, ..) in payloads() {
        // The enum `Reason` and its wire form share a name on the bus.
        let name = match name {
            "ReasonRecord" => "Reason",
            name => name,
        };
        let version = wire
            .strip_prefix("atas.")
            .and_then(|w| w.strip_prefix(name));
        let number = version
            .and_then(|v| v.strip_prefix(".v"))
            .and_then(|n| n.parse::<u32>().ok());
        assert!(
            number.is_some_and(|n| n > 0),
            "{wire} is not atas.{name}.v<number>"
        );
        assert!(seen.insert(wire), "{wire} appears twice");
    }
}
