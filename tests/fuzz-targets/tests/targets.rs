//! Every target on its seeds and on a bounded number of mutations.

use std::time::Duration;

use atas_fuzz::run::{Extent, collect_panics, run};
use atas_fuzz::{Target, targets};

/// Seed of the mutations. A failure names its execution.
const SEED: u64 = 36;
/// Most time per target. Design choice: all targets together take less than a minute.
const TIME: Duration = Duration::from_secs(2);

fn failures(target: &Target) -> Option<String> {
    let report = run(
        target,
        Extent {
            executions: target.test_executions,
            time: Some(TIME),
            seed: SEED,
            threads: 2,
        },
    );
    let [first, ..] = &report.failures[..] else {
        return None;
    };
    Some(format!(
        "{}: {} of {} executions failed; the first: {}; repeat it with `cargo run --release -p \
         atas-fuzz -- {} --seed {SEED} --execution {}`",
        target.name, report.failed, report.executions, first.cause, target.name, first.execution
    ))
}

#[test]
fn targets_survive_seeds_and_mutations() {
    collect_panics();
    let failed: Vec<String> = targets().filter_map(|target| failures(&target)).collect();
    assert!(failed.is_empty(), "{}", failed.join("\n"));
}

#[test]
fn every_target_has_a_coverage_guided_twin() {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../fuzz/fuzz_targets");
    let mut files: Vec<String> = std::fs::read_dir(folder)
        .expect("the folder of targets")
        .map(|entry| entry.expect("readable").path())
        .map(|path| {
            path.file_stem()
                .expect("a name")
                .to_string_lossy()
                .into_owned()
        })
        .collect();
    files.sort_unstable();
    let mut names: Vec<String> = targets().map(|target| target.name.to_owned()).collect();
    names.sort_unstable();
    assert_eq!(files, names);
}
