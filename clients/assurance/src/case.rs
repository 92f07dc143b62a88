//! The case: goal, strategies, claims, and faults that are not claimed.

use std::collections::BTreeSet;

use anyhow::Context;
use atas_faults::{CATALOGUE, Fault, find};
use serde::{Deserialize, Serialize};

use crate::evidence::Evidence;
use crate::extent::Extent;

/// Assurance case.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Case {
    /// Top goal.
    pub goal: Goal,
    /// Least extent of the evidence.
    pub extent: Extent,
    /// Parts of the argument.
    pub strategies: Vec<Strategy>,
    /// Claims, each below one strategy.
    pub claims: Vec<Claim>,
    /// Rows of the fault catalogue without claim.
    pub not_claimed: Vec<NotClaimed>,
    /// Limits of the whole case.
    pub limits: Limits,
}

/// Top goal.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Goal {
    /// Statement.
    pub text: String,
    /// Definitions and conditions.
    pub context: Vec<String>,
}

/// Part of the argument.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Strategy {
    /// Number, for example `S1`.
    pub id: String,
    /// Statement.
    pub text: String,
}

/// Claim with argument and evidence.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Claim {
    /// Number, for example `G01`.
    pub id: String,
    /// Short name, for example `command-limits`.
    pub name: String,
    /// Number of its strategy.
    pub strategy: String,
    /// Statement.
    pub text: String,
    /// Situations and conditions.
    pub context: String,
    /// Reason why the evidence supports the claim.
    pub argument: String,
    /// Conditions that the evidence does not show.
    #[serde(default)]
    pub assumptions: Vec<String>,
    /// Rows of the fault catalogue.
    #[serde(default)]
    pub faults: Vec<String>,
    /// Tests, `file::name`.
    #[serde(default)]
    pub tests: Vec<String>,
    /// True: the runs of all injected faults are evidence.
    #[serde(default)]
    pub all_faults: bool,
    /// True: random runs are evidence.
    #[serde(default)]
    pub soak: bool,
    /// True: stops under load are evidence.
    #[serde(default)]
    pub stops: bool,
}

/// Row of the fault catalogue without claim.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct NotClaimed {
    /// Number of the fault.
    pub fault: String,
    /// Reason.
    pub reason: String,
}

/// Limits of the whole case.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Limits {
    /// One sentence or two each.
    pub items: Vec<String>,
}

impl Case {
    /// Text of the case of this version.
    pub const TEXT: &str = include_str!("../case.toml");

    /// Returns the case of this version.
    ///
    /// # Errors
    /// `case.toml` is malformed.
    pub fn built_in() -> anyhow::Result<Self> {
        Self::parse(Self::TEXT)
    }

    /// Parses a case.
    ///
    /// # Errors
    /// The text is not TOML, or a key is missing or unknown.
    pub fn parse(text: &str) -> anyhow::Result<Self> {
        toml::from_str(text).context("could not read the assurance case case.toml")
    }

    /// Returns the claims with these numbers or names; all without any.
    ///
    /// # Errors
    /// A claim is unknown.
    pub fn chosen(&self, names: &[String]) -> anyhow::Result<Vec<&Claim>> {
        if names.is_empty() {
            return Ok(self.claims.iter().collect());
        }
        let find = |name: &String| {
            let is_named = |claim: &&Claim| claim.id == *name || claim.name == *name;
            let found = self.claims.iter().find(is_named);
            found.with_context(|| {
                format!("could not find the claim {name:?}; `atas assure` lists all")
            })
        };
        names.iter().map(find).collect()
    }

    /// Returns the evidence of a claim, each item once. Unknown faults are left out.
    #[must_use]
    pub fn evidence(&self, claim: &Claim) -> Vec<Evidence> {
        let named = claim.faults.iter().flat_map(|number| find(number));
        let all = CATALOGUE.iter().filter(|fault| {
            let is_injected = fault.evidence.reaction().is_some();
            claim.all_faults && is_injected && !self.excludes(fault)
        });
        let mut evidence: Vec<Evidence> = named.chain(all).filter_map(Evidence::of_fault).collect();
        evidence.extend(claim.soak.then_some(Evidence::Soak));
        evidence.extend(claim.stops.then_some(Evidence::Stops));
        evidence.extend(claim.tests.iter().cloned().map(Evidence::Test));
        let mut seen = BTreeSet::new();
        evidence.retain(|item| seen.insert(item.key()));
        evidence
    }

    /// Returns true if the row of the catalogue is listed as not claimed.
    #[must_use]
    pub fn excludes(&self, fault: &Fault) -> bool {
        let mut excluded = self.not_claimed.iter();
        excluded.any(|row| find(&row.fault).any(|found| found.id == fault.id))
    }

    /// Returns the defects of the case alone, without results: unknown names, claims without
    /// evidence, and rows of the catalogue that are neither claimed nor listed.
    #[must_use]
    pub fn defects(&self) -> Vec<(String, String)> {
        let mut defects = Vec::new();
        let mut names = BTreeSet::new();
        for claim in &self.claims {
            let mut add = |text: String| defects.push((claim.id.clone(), text));
            for name in [&claim.id, &claim.name] {
                if !names.insert(name) {
                    add(format!("the name {name} appears twice; rename one claim"));
                }
            }
            if !self
                .strategies
                .iter()
                .any(|known| known.id == claim.strategy)
            {
                add(format!(
                    "the strategy {} is unknown; add it",
                    claim.strategy
                ));
            }
            for number in &claim.faults {
                let mut found = find(number).peekable();
                if found.peek().is_none() {
                    add(format!(
                        "the fault {number} does not exist; `atas fault list` prints all"
                    ));
                }
                for fault in found.filter(|fault| Evidence::of_fault(fault).is_none()) {
                    add(format!(
                        "the fault {} has no evidence; list it as not claimed",
                        fault.id
                    ));
                }
            }
            if self.evidence(claim).is_empty() {
                add("the claim has no evidence; add faults or tests, or remove it".to_owned());
            }
        }
        for row in &self.not_claimed {
            if find(&row.fault).next().is_none() {
                defects.push((
                    row.fault.clone(),
                    "the fault does not exist; remove it from not_claimed".to_owned(),
                ));
            }
        }
        defects.extend(CATALOGUE.iter().filter_map(|fault| self.defect(fault)));
        defects
    }

    /// Returns the defect of a row of the catalogue: claimed nowhere, or claimed and excluded.
    fn defect(&self, fault: &Fault) -> Option<(String, String)> {
        let mut named = self.claims.iter().flat_map(|claim| &claim.faults);
        let is_claimed = named.any(|number| find(number).any(|found| found.id == fault.id));
        let text = match (is_claimed, self.excludes(fault)) {
            (false, false) => "no claim cites the fault; cite it, or list it as not claimed",
            (true, true) => "the fault is claimed and listed as not claimed; choose one",
            _ => return None,
        };
        Some((fault.id.to_owned(), text.to_owned()))
    }
}
