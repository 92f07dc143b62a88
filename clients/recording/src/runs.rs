//! Assignment of files to runs of the daemon.

// Numbers of a file or a device reach this arithmetic.
#![warn(clippy::arithmetic_side_effects)]

use std::path::PathBuf;

use crate::rows::Rows;

/// Groups files by run. A file that continues the run of the previous file belongs to that run.
///
/// # Errors
/// A file cannot be read up to its first tick.
pub fn runs(files: &[PathBuf]) -> anyhow::Result<Vec<Vec<PathBuf>>> {
    let mut runs: Vec<Vec<PathBuf>> = Vec::new();
    let mut before = None;
    for file in files {
        let rows = Rows::open(std::slice::from_ref(file))?;
        // Start time of the daemon, and its process.
        let begun = rows
            .header()
            .map(|header| (header.stamp.captured_ns, header.stamp.writer_epoch));
        match runs.last_mut() {
            Some(run) if begun.is_some() && begun == before => run.push(file.clone()),
            _ => runs.push(vec![file.clone()]),
        }
        before = begun;
    }
    Ok(runs)
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;
    use std::path::Path;

    use shm_schemas::{RunHeader, Stamp, TickInputs};

    use super::*;
    use crate::rotation::{Bounds, Recording};

    /// Creates a recording of one tick of a daemon that started at this time.
    fn recorded(out: &Path, started_ns: u64) -> PathBuf {
        let bounds = Bounds {
            file_bytes: None,
            files: None,
            total_bytes: None,
        };
        let mut recording = Recording::create(out, bounds, BTreeMap::new(), None).expect("made");
        let mut header: Box<RunHeader> = Box::default();
        let stamp = Stamp {
            captured_ns: started_ns,
            ..Stamp::default()
        };
        header.stamp = stamp;
        recording.begin_run(header).expect("begun");
        let part = Box::new(TickInputs {
            stamp,
            ..TickInputs::default()
        });
        recording.inputs(&part).expect("written");
        recording.finish().expect("finished");
        out.to_owned()
    }

    #[test]
    fn continuing_file_belongs_to_its_run() {
        let folder = tempfile::tempdir().expect("a folder");
        let file = |name: &str, started_ns| recorded(&folder.path().join(name), started_ns);
        let [first, on, other] = [file("a.mcap", 5), file("a-001.mcap", 5), file("b.mcap", 9)];
        let files = [first.clone(), on.clone(), other.clone()];
        let found = runs(&files).expect("readable");
        assert_eq!(found, [vec![first, on], vec![other]]);
        assert!(runs(&[folder.path().join("none.mcap")]).is_err());
    }
}
