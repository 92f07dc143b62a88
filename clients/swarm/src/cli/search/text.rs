//! Text output of a search.

use std::fmt::Write as _;

use ebts::search::{ClaimScore, CoOccurrence};

use super::{Found, Searched};
use crate::cli::report::interval;

pub(super) fn describe(searched: &Searched) -> String {
    let mut text = format!("search around preset {}\n\n", searched.preset);
    text += "stage  presets  runs per team size, further seeds\n";
    for stage in &searched.stages {
        let last = stage.first_seed + stage.seeds - 1;
        let _ = writeln!(
            text,
            "{:>5}  {:>7}  {:>4}, {} to {last}",
            stage.number, stage.candidates, stage.seeds, stage.first_seed
        );
    }
    let last = searched.verdict_first_seed + searched.verdict_seeds - 1;
    let _ = writeln!(
        text,
        "verdict: {} runs per team size, seeds {} to {last}\n\
         chance: probability of a finding, on the tuning seeds",
        searched.verdict_seeds, searched.verdict_first_seed
    );
    for found in &searched.best {
        let changes = match found.changes.as_str() {
            "" => "unchanged preset",
            changes => changes,
        };
        let changes = changes.replace(' ', "\n  ");
        let _ = writeln!(text, "\n{}\n  {changes}", found.file.display());
        text += &claims(found);
    }
    text + &pairs(&searched.together)
}

fn claims(found: &Found) -> String {
    let mut text = format!("  {:<43} chance  verdict [95 %]\n", "finding");
    let both = found.tuning.claims.iter().zip(&found.verdict.claims);
    for (tuning, verdict) in both {
        let message = verdict
            .verdict
            .map_or(String::new(), |message| message.to_string());
        let ClaimScore {
            claim, estimate, ..
        } = verdict;
        let _ = writeln!(
            text,
            "  {:<43} {:>4.2} {:<18} {message}",
            claim.description(),
            tuning.chance,
            interval(*estimate)
        );
    }
    let all = if found.all_hold { "yes" } else { "NO" };
    let _ = writeln!(
        text,
        "  all of them at 95 %: {all}; probability of all: {:.2} (tuning: {:.2})",
        found.verdict.chance_of_all, found.tuning.chance_of_all
    );
    text
}

fn pairs(together: &[CoOccurrence]) -> String {
    let mut text =
        String::from("\npresets of stage 1 that show both findings, the first, the second\n");
    for pair in together {
        let names = format!("{} and {}", pair.one, pair.other);
        let _ = writeln!(
            text,
            "  {names:<43} {:>5} of {:>5}, {:>5}",
            pair.show_both, pair.show_one, pair.show_other
        );
    }
    text
}
