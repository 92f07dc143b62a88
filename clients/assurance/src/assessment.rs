//! Assessment of the case: results of each claim, and all problems.

use serde::Serialize;

use crate::case::{Case, Claim, Goal, NotClaimed, Strategy};
use crate::evidence::{Evidence, SourceTree};
use crate::extent::Extent;
use crate::outcome::Outcome;
use crate::results::Results;

/// Case with the last results.
#[derive(Clone, Debug, Serialize)]
pub struct Assessment {
    /// Version of the programs.
    pub version: String,
    /// Top goal.
    pub goal: Goal,
    /// True if all claims are shown.
    pub is_shown: bool,
    /// Least extent of the evidence.
    pub extent: Extent,
    /// Parts of the argument.
    pub strategies: Vec<Strategy>,
    /// Claims in the order of the case.
    pub claims: Vec<AssessedClaim>,
    /// Rows of the fault catalogue without claim.
    pub not_claimed: Vec<NotClaimed>,
    /// Limits of the whole case.
    pub limits: Vec<String>,
    /// Defects of the case and of its evidence.
    pub problems: Vec<Problem>,
}

/// Claim with its results.
#[derive(Clone, Debug, Serialize)]
pub struct AssessedClaim {
    /// Number.
    pub id: String,
    /// Short name.
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
    pub assumptions: Vec<String>,
    /// True if all its evidence passed.
    pub is_shown: bool,
    /// Commands that collect its evidence.
    pub commands: Vec<String>,
    /// Evidence with results.
    pub evidence: Vec<AssessedEvidence>,
}

/// Item of evidence with its last result.
#[derive(Clone, Debug, Serialize)]
pub struct AssessedEvidence {
    /// Number of the fault, `file::name` of the test, `soak` or `stops`.
    pub evidence: String,
    /// Name for a table.
    pub title: String,
    /// Required result.
    pub requirement: String,
    /// Unit of one trial.
    pub trial: &'static str,
    /// Unit of the worst value and of the bound.
    pub unit: &'static str,
    /// True if the evidence exists and passed.
    pub is_shown: bool,
    /// Last result.
    pub last: Option<Outcome>,
}

/// Defect of the case or of its evidence.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Problem {
    /// Number of the claim or of the fault; `page` for the page of the guide.
    pub subject: String,
    /// Evidence with defect and remedy.
    pub text: String,
}

impl std::fmt::Display for Problem {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}: {}", self.subject, self.text)
    }
}

impl Assessment {
    /// Assesses the case of this version.
    #[must_use]
    pub fn new(case: &Case, results: &Results, tree: &SourceTree, version: &str) -> Self {
        let mut problems: Vec<Problem> = case
            .defects()
            .into_iter()
            .map(|(subject, text)| Problem { subject, text })
            .collect();
        let claims = case.claims.iter().map(|claim| {
            let items = case.evidence(claim);
            let before = problems.len();
            let evidence: Vec<AssessedEvidence> = items
                .iter()
                .map(|item| {
                    let last = results.get(&item.key());
                    let defect = defect((claim, item), last, case, tree, version);
                    let is_shown = defect.is_none();
                    problems.extend(defect.map(|text| problem(claim, item, &text)));
                    assessed(item, last, is_shown)
                })
                .collect();
            let has_defect = problems.iter().any(|problem| problem.subject == claim.id);
            let is_shown = problems.len() == before && !has_defect;
            let commands = Evidence::commands(&items, &case.extent);
            assessed_claim(claim, is_shown, commands, evidence)
        });
        let claims: Vec<AssessedClaim> = claims.collect();
        Self {
            version: version.to_owned(),
            goal: case.goal.clone(),
            is_shown: problems.is_empty(),
            extent: case.extent,
            strategies: case.strategies.clone(),
            claims,
            not_claimed: case.not_claimed.clone(),
            limits: case.limits.items.clone(),
            problems,
        }
    }

    /// Returns true if the item exists and passed.
    #[must_use]
    pub fn has_shown(&self, item: &Evidence) -> bool {
        let mut known = self.claims.iter().flat_map(|claim| &claim.evidence);
        known.any(|known| known.evidence == item.key() && known.is_shown)
    }

    /// Adds a problem for each command that `check` rejects.
    pub fn add_invalid_commands(&mut self, check: impl Fn(&str) -> Result<(), String>) {
        for claim in &mut self.claims {
            for command in &claim.commands {
                let Err(reason) = check(command) else {
                    continue;
                };
                claim.is_shown = false;
                self.is_shown = false;
                self.problems.push(Problem {
                    subject: format!("{} {}", claim.id, claim.name),
                    text: format!(
                        "the command `{command}` does not exist ({reason}); correct case.toml"
                    ),
                });
            }
        }
    }
}

fn problem(claim: &Claim, item: &Evidence, text: &str) -> Problem {
    Problem {
        subject: format!("{} {}", claim.id, claim.name),
        text: format!("{} {text}", item.key()),
    }
}

/// Returns the reason why an item does not show its claim, with the remedy.
fn defect(
    (claim, item): (&Claim, &Evidence),
    last: Option<&Outcome>,
    case: &Case,
    tree: &SourceTree,
    version: &str,
) -> Option<String> {
    let Some(definition) = item.fingerprint(tree) else {
        return Some("does not exist; correct its name in case.toml".to_owned());
    };
    let again = format!("run `atas assure --run --missing {}`", claim.id);
    let Some(last) = last else {
        return Some(format!("has no result; {again}"));
    };
    let required = item.extent(&case.extent);
    if let Some(reason) = last.skipped.as_ref().filter(|_| last.tried == 0) {
        return Some(format!(
            "was skipped: {reason}; {again} on a machine that permits it"
        ));
    }
    if last.version != version {
        let of = &last.version;
        return Some(format!(
            "is stale: its result is of version {of}, not {version}; {again}"
        ));
    }
    if last.definition != definition {
        return Some(format!(
            "is stale: its definition changed after its last result; {again}"
        ));
    }
    if !last.has_passed() {
        let (passed, tried, trial) = (last.passed, last.tried, item.trial());
        return Some(format!(
            "failed: {passed} of {tried} {trial} passed{}; repair the cause, then {again}",
            worst(last, item.unit())
        ));
    }
    (last.extent < required).then(|| {
        format!(
            "is too small: extent {}, the case requires {required}; {again}",
            last.extent
        )
    })
}

fn worst(last: &Outcome, unit: &str) -> String {
    match (last.worst, last.bound) {
        (Some(worst), Some(bound)) => format!(", worst {worst} of {bound} {unit}"),
        _ => String::new(),
    }
}

fn assessed(item: &Evidence, last: Option<&Outcome>, is_shown: bool) -> AssessedEvidence {
    AssessedEvidence {
        evidence: item.key(),
        title: item.title(),
        requirement: item.requirement(),
        trial: item.trial(),
        unit: item.unit(),
        is_shown,
        last: last.cloned(),
    }
}

fn assessed_claim(
    claim: &Claim,
    is_shown: bool,
    commands: Vec<String>,
    evidence: Vec<AssessedEvidence>,
) -> AssessedClaim {
    let Claim {
        id,
        name,
        strategy,
        text,
        context,
        argument,
        assumptions,
        ..
    } = claim.clone();
    let joined = |text: String| text.split_whitespace().collect::<Vec<_>>().join(" ");
    AssessedClaim {
        id,
        name,
        strategy,
        text,
        context: joined(context),
        argument: joined(argument),
        assumptions,
        is_shown,
        commands,
        evidence,
    }
}
