//! Lines of `runs.jsonl`: one finished run each, with a hash over the plan and the run. The hash
//! detects edited, damaged and foreign lines.

use serde::{Deserialize, Serialize};

use super::plan::Plan;
use crate::error::{Error, Result};
use crate::files::sha256;
use crate::run::Record;

/// Writes and verifies the hashed lines of one experiment.
#[derive(Clone, Debug)]
pub(super) struct Seal {
    plan: String,
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Line {
    sha256: String,
    run: Record,
}

impl Seal {
    pub(super) fn new(plan: &Plan) -> Result<Self> {
        let plan = serde_json::to_vec(plan).map_err(Error::from_part)?;
        Ok(Self {
            plan: sha256(&plan),
        })
    }

    /// Returns a finished run as a line with line break.
    pub(super) fn line(&self, run: &Record) -> Result<String> {
        let line = Line {
            sha256: self.hash(run)?,
            run: run.clone(),
        };
        let mut text = serde_json::to_string(&line).map_err(Error::from_part)?;
        text.push('\n');
        Ok(text)
    }

    /// Returns the run of a line, or the fault of the line.
    pub(super) fn open(&self, line: &str) -> std::result::Result<Record, String> {
        let Line { sha256, run } = serde_json::from_str(line).map_err(|error| error.to_string())?;
        let expected = self.hash(&run).map_err(|error| error.to_string())?;
        if sha256 == expected {
            Ok(run)
        } else {
            Err("its hash does not match this run and experiment".to_owned())
        }
    }

    fn hash(&self, run: &Record) -> Result<String> {
        let run = serde_json::to_string(run).map_err(Error::from_part)?;
        Ok(sha256(format!("{}{run}", self.plan).as_bytes()))
    }
}
