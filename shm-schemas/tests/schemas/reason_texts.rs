//! Golden texts: the sentence of every cause with several values, indices and modules.

use shm_schemas::{Cause, ModuleId, ReasonRecord};
use std::collections::HashSet;
use std::fmt::Write;

/// Values with their limits: zero, above, below, no posture, large, and nothing received yet.
const NUMBERS: [(f64, f64); 6] = [
    (0.0, 0.0),
    (0.55, 0.4),
    (-0.03, 0.2),
    (0.0123, 0.0),
    (6.25e6, 5e6),
    (f64::INFINITY, 5e6),
];

/// Values of causes that count or that name a code.
const WHOLE_NUMBERS: [(f64, f64); 6] = [
    (0.0, 0.0),
    (1.0, 0.0),
    (7.0, 1.0),
    (3.0, 2.0),
    (99.0, 40.0),
    (1e5, 1e5),
];

const WHOLE: [Cause; 9] = [
    Cause::UNKNOWN_GOAL,
    Cause::BUSY,
    Cause::NOT_READY,
    Cause::TASK_TOO_LONG,
    Cause::FRAMES_LOST,
    Cause::FRAME_CORRUPT,
    Cause::FRAMES_FROZEN,
    Cause::ELEMENT_STUCK,
    Cause::TARGET_UNKNOWN,
];

/// Indices: hands, joints, fields of goals and targets, two bodies, unknown ones.
const INDICES: [u32; 8] = [0, 1, 3, 4, 8, 9, 4619, 1_000_000];

fn samples(cause: Cause) -> Vec<ReasonRecord> {
    let numbers = if WHOLE.contains(&cause) {
        WHOLE_NUMBERS
    } else {
        NUMBERS
    };
    let reason = |(value, limit), index, module| ReasonRecord {
        cause,
        module,
        value,
        limit,
        index,
        pad: 0,
    };
    let by_number = numbers.map(|pair| reason(pair, 2, ModuleId::NONE));
    let by_index = INDICES.map(|index| {
        let [with_limit, without_limit] = [numbers[1], numbers[3]];
        [
            reason(with_limit, index, ModuleId::NONE),
            reason(without_limit, index, ModuleId::NONE),
        ]
    });
    let by_module = [ModuleId::FORCE_LIMIT, ModuleId(77)].map(|id| reason(numbers[1], 1, id));
    let all = by_number.into_iter().chain(by_index.into_iter().flatten());
    all.chain(by_module).collect()
}

/// Returns the different texts of each cause, each with the first sample that has it.
fn texts() -> String {
    let mut text = String::new();
    for cause in Cause::ALL.iter().copied().chain([Cause(999)]) {
        writeln!(text, "{cause}").unwrap();
        let mut seen = HashSet::new();
        for reason in samples(cause) {
            let ReasonRecord {
                module: ModuleId(module),
                value,
                limit,
                index,
                ..
            } = reason;
            if seen.insert(reason.to_string()) {
                writeln!(text, "  {value} {limit} {index} {module}: {reason}").unwrap();
            }
        }
    }
    text
}

#[test]
fn texts_match_the_golden_file() {
    let (golden, actual) = (include_str!("reason_texts.golden"), texts());
    if golden == actual {
        return;
    }
    let path = concat!(env!("CARGO_TARGET_TMPDIR"), "/reason_texts.actual");
    std::fs::write(path, &actual).unwrap();
    let changed = golden.lines().zip(actual.lines()).find(|(a, b)| a != b);
    panic!(
        "a text differs from the golden file, first {changed:?}; review it, then replace \
         reason_texts.golden by {path}"
    );
}
