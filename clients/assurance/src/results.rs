//! Stored results: one JSON file per kind of evidence.

use std::collections::BTreeMap;
use std::path::Path;

use anyhow::Context;

use crate::case::Case;
use crate::outcome::Outcome;

/// Files of a folder of results.
const FILES: [&str; 4] = ["faults.json", "soak.json", "stops.json", "tests.json"];

/// Results by the name of their evidence.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Results(BTreeMap<String, Outcome>);

impl Results {
    /// Reads the results of a folder. A missing file has no results.
    ///
    /// # Errors
    /// A file cannot be read, or is malformed.
    pub fn load(folder: &Path) -> anyhow::Result<Self> {
        let mut results = Self::default();
        for path in FILES.map(|file| folder.join(file)) {
            let text = match std::fs::read_to_string(&path) {
                Ok(text) => text,
                Err(error) if error.kind() == std::io::ErrorKind::NotFound => continue,
                Err(error) => {
                    return Err(error)
                        .with_context(|| format!("could not read {}", path.display()));
                }
            };
            let outcomes: Vec<Outcome> = serde_json::from_str(&text)
                .with_context(|| format!("could not read the results in {}", path.display()))?;
            results.insert(outcomes);
        }
        Ok(results)
    }

    /// Adds new results. A skipped one does not replace an earlier result.
    pub fn insert(&mut self, outcomes: impl IntoIterator<Item = Outcome>) {
        for outcome in outcomes {
            let earlier = self.0.get(&outcome.evidence);
            let has_run = earlier.is_some_and(|earlier| earlier.tried > 0);
            if outcome.tried > 0 || !has_run {
                self.0.insert(outcome.evidence.clone(), outcome);
            }
        }
    }

    /// Returns a result by the name of its evidence.
    #[must_use]
    pub fn get(&self, key: &str) -> Option<&Outcome> {
        self.0.get(key)
    }

    /// Writes the results that the case uses. Every result is one line.
    ///
    /// # Errors
    /// The folder or a file cannot be written.
    pub fn save(&self, folder: &Path, case: &Case) -> anyhow::Result<()> {
        std::fs::create_dir_all(folder)
            .with_context(|| format!("could not make the folder {}", folder.display()))?;
        let mut files: BTreeMap<&str, BTreeMap<&str, &Outcome>> = BTreeMap::new();
        for claim in &case.claims {
            for item in case.evidence(claim) {
                if let Some((key, outcome)) = self.0.get_key_value(&item.key()) {
                    files.entry(item.file()).or_default().insert(key, outcome);
                }
            }
        }
        for (file, outcomes) in files {
            let lines: Result<Vec<String>, _> =
                outcomes.values().map(serde_json::to_string).collect();
            let lines = lines.context("could not write JSON")?;
            let path = folder.join(file);
            std::fs::write(&path, format!("[\n{}\n]\n", lines.join(",\n")))
                .with_context(|| format!("could not write {}", path.display()))?;
        }
        Ok(())
    }
}
