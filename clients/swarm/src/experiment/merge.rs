//! Merges the shards of an experiment.

use std::collections::BTreeMap;
use std::path::Path;

use super::missing::Missing;
use super::plan::Plan;
use super::store::{Store, check_same_plan, read_folder};
use crate::error::{Error, Result};
use crate::run::{Job, Record};

/// Content of a merged folder.
#[derive(Debug)]
pub struct Merged {
    /// Plan of every shard.
    pub plan: Plan,
    /// All runs, sorted.
    pub records: Vec<Record>,
    /// Runs of the plan that no shard contains.
    pub missing: Missing,
}

/// Collects the runs of `shards` in `folder`, which may already contain some.
///
/// # Errors
/// The shards belong to different experiments, two of them differ in a run, or a folder cannot be
/// read or written.
pub fn merge(folder: &Path, shards: &[&Path]) -> Result<Merged> {
    let Some(first) = shards.first() else {
        return Err(Error::refused(
            "merge",
            "no shard was given",
            "at least one folder",
            "give the folders of the shards",
        ));
    };
    let (plan, _) = read_folder(first)?;
    let (mut store, present) = Store::open(folder, &plan)?;
    // Existing runs may be a shard of their own, or come from the given shards.
    let folders = shards.len()..=shards.len() + usize::from(!present.is_empty());
    let mut merged: BTreeMap<Job, Record> = present
        .into_iter()
        .map(|record| (record.job(), record))
        .collect();
    for shard in shards {
        let (found, records) = read_folder(shard)?;
        check_same_plan(shard, &plan, &found)?;
        for record in records {
            match merged.get(&record.job()) {
                None => {
                    store.write(&record)?;
                    merged.insert(record.job(), record);
                }
                Some(known) if *known == record => {}
                Some(_) => {
                    return Err(Error::refused(
                        format_args!("merge {}", shard.display()),
                        format_args!(
                            "its run of {} agents, seed {} differs from that of another shard",
                            record.agents, record.seed
                        ),
                        "equal results for equal runs",
                        "find the damaged one and run its shard again",
                    ));
                }
            }
        }
    }
    store.sync()?;
    Ok(Merged {
        missing: Missing::new(&plan, folders, |job| merged.contains_key(job)),
        plan,
        records: merged.into_values().collect(),
    })
}
