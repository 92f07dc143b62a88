//! Text output of results in columns, at most 80 wide.

use std::fmt::Write as _;

use ebts::analysis::{Claim, Comparison, Findings, Transfer, Verdict};
use ebts::results::Summary;
use ebts::stats::Estimate;

pub(super) fn summary(summary: &Summary) -> String {
    let mut text = format!(
        "preset {}, fitness rule {}: {} runs per team size, {} generations\n\
         {:.2} s wall, {:.2} s on all cores\n\n",
        summary.preset,
        summary.fitness_rule,
        summary.seeds,
        summary.generations,
        summary.wall_s,
        summary.cpu_s
    );
    text += "agents      q1  median      q3    mean   maximum fitness, of 800\n";
    for c in &summary.conditions {
        let _ = writeln!(
            text,
            "{:>6}  {:>6.1}  {:>6.1}  {:>6.1}  {:>6.1}",
            c.agents, c.q1, c.median, c.q3, c.mean
        );
    }
    text + "\n"
}

pub(super) fn interval(estimate: Option<Estimate>) -> String {
    estimate.map_or("not run".to_owned(), |Estimate { value, low, high }| {
        format!("{value:.2} [{low:.2}, {high:.2}]")
    })
}

pub(super) fn findings(findings: &Findings) -> String {
    let mut text = String::from("findings of the paper in these runs [95 % bootstrap interval]:\n");
    for claim in Claim::ALL {
        let verdict = claim
            .verdict(findings)
            .map_or(String::new(), |verdict| verdict.to_string());
        let value = interval(claim.estimate(findings));
        let _ = writeln!(text, "  {:<43} {value:<19} {verdict}", claim.description());
    }
    if let Some(single) = &findings.single {
        let _ = writeln!(
            text,
            "  one agent solves {:.2} of 8 goals",
            single.solved_per_run
        );
    }
    if let Some(redundancy) = &findings.redundancy {
        let pushers = redundancy
            .by_pushers
            .map(|count| count.to_string())
            .join(", ");
        let _ = writeln!(
            text,
            "  {} trials of four solved, by 0, 1, 2, 3, 4 pushers: {pushers}",
            redundancy.solved
        );
    }
    text
}

pub(super) fn side_by_side(experiments: &[(Summary, Findings)]) -> String {
    let mut text = String::from("| preset, fitness rule, runs |");
    let teams: Vec<usize> = experiments.first().map_or(Vec::new(), |(summary, _)| {
        summary.conditions.iter().map(|c| c.agents).collect()
    });
    for agents in &teams {
        let _ = write!(text, " {agents} |");
    }
    text = text + "\n|---|" + &"---|".repeat(teams.len()) + "\n";
    for (summary, _) in experiments {
        let _ = write!(
            text,
            "| {}, {}, {} |",
            summary.preset, summary.fitness_rule, summary.seeds
        );
        for c in &summary.conditions {
            let _ = write!(text, " {:.0} / {:.0} / {:.0} |", c.q1, c.median, c.q3);
        }
        text.push('\n');
    }
    text += "\n| finding |";
    for (summary, _) in experiments {
        let _ = write!(text, " {}, {} |", summary.preset, summary.fitness_rule);
    }
    text = text + "\n|---|" + &"---|".repeat(experiments.len()) + "\n";
    for claim in Claim::ALL {
        let _ = write!(text, "| {} |", claim.description());
        for (_, findings) in experiments {
            let mark = match claim.verdict(findings) {
                Some(Verdict::DoesNotReproduce) => " **no**",
                Some(Verdict::Undecided) => " undecided",
                Some(Verdict::Reproduces) | None => "",
            };
            let _ = write!(text, " {}{mark} |", interval(claim.estimate(findings)));
        }
        text.push('\n');
    }
    text
}

pub(super) fn comparisons(comparisons: &[Comparison]) -> String {
    let mut text = String::from(
        "\nfitness of 800   |  baselines                    |  held out, median over runs\n\
         agents  evolved  |  by hand  random  best of n   |  goals  starts  both\n",
    );
    for c in comparisons {
        let (b, h) = (&c.baselines, &c.held_out);
        let _ = writeln!(
            text,
            "{:>6}  {:>7.1}  |  {:>7.1}  {:>6.1}  {:>5.1} of {:<4} |  {:>5.1}  {:>6.1}  {:>4.1}",
            c.agents,
            c.evolved_median,
            b.hand_written,
            b.random_mean,
            b.random_best,
            b.random_tables,
            h.goals,
            h.starts,
            h.goals_and_starts
        );
        let beaten = c.evolved_median > b.hand_written && c.evolved_median > b.random_best;
        if !beaten {
            let _ = writeln!(
                text,
                "        the median evolved table of {} does NOT beat every baseline",
                c.agents
            );
        }
    }
    text
}

pub(super) fn transfers(transfers: &[Transfer]) -> String {
    let mut text = String::from(
        "fitness of 800   evolved |  on the     unseen  unseen  both    kept of what was\n\
         agents  tables   on      |  preset's 8  goals  starts  unseen  evolved, on both\n",
    );
    for t in transfers {
        let _ = writeln!(
            text,
            "{:>6}  {:>6}  {:>7.1}  |  {:>10.1}  {:>5.1}  {:>6.1}  {:>6.1}  {}",
            t.agents,
            t.tables,
            t.training,
            t.preset,
            t.goals,
            t.starts,
            t.both,
            interval(Some(t.kept)),
        );
    }
    text
}
