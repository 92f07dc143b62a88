//! The lines of `runs.jsonl`: one finished run each, sealed with a hash over the plan and the run, so that a line that was
//! edited, damaged or taken from another experiment is noticed.

use serde::{Deserialize, Serialize};

use super::plan::Plan;
use crate::error::{Error, Result};
use crate::files::sha256;
use crate::run::Record;

/// Seals and opens the lines of one experiment.
#[derive(Clone, Debug)]
pub(super) struct Seal {
    /// Hash of the plan.
    plan: String,
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Line {
    sha256: String,
    run: Record,
}

impl Seal {
    /// The seal of an experiment.
    pub(super) fn new(plan: &Plan) -> Result<Self> {
        let plan = serde_json::to_vec(plan).map_err(Error::from_part)?;
        Ok(Self {
            plan: sha256(&plan),
        })
    }

    /// A finished run as a line, with its end.
    pub(super) fn line(&self, run: &Record) -> Result<String> {
        let line = Line {
            sha256: self.hash(run)?,
            run: run.clone(),
        };
        let mut text = serde_json::to_string(&line).map_err(Error::from_part)?;
        text.push('\n');
        Ok(text)
    }

    /// The run of a line, or what is wrong with the line.
    pub(super) fn open(&self, line: &str) -> std::result::Result<Record, String> {
        let Line { sha256, run } = serde_json::from_str(line).map_err(|error| error.to_string())?;
        let expected = self.hash(&run).map_err(|error| error.to_string())?;
        if sha256 == expected {
            Ok(run)
        } else {
            Err("its seal does not fit this run and this experiment".to_owned())
        }
    }

    fn hash(&self, run: &Record) -> Result<String> {
        let run = serde_json::to_string(run).map_err(Error::from_part)?;
        Ok(sha256(format!("{}{run}", self.plan).as_bytes()))
    }
}
