//! Results in words and columns, at most 80 wide.

use std::fmt::Write as _;

use ebts::analysis::{Comparison, Findings, Verdict};
use ebts::results::Summary;
use ebts::stats::Estimate;

/// The part of solved four-agent trials in which redundant agents have to keep out for the finding to hold (ours: the paper
/// shows two examples and gives no rate).
const KEEP_OUT_BORDER: f64 = 0.5;

/// The table of Fig. 14.
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

/// A finding of the paper: what it says, what was estimated, and where the border is.
struct Row {
    what: &'static str,
    estimate: Option<Estimate>,
    border: f64,
}

impl Row {
    fn value(&self) -> String {
        self.estimate
            .map_or("not run".to_owned(), |Estimate { value, low, high }| {
                format!("{value:.2} [{low:.2}, {high:.2}]")
            })
    }

    fn verdict(&self) -> Option<Verdict> {
        self.estimate
            .map(|estimate| Verdict::above(self.border, estimate))
    }
}

/// The paper's findings, in its order.
fn rows(findings: &Findings) -> [Row; 8] {
    let Findings {
        ratio,
        order,
        single,
        redundancy,
        ..
    } = findings;
    let row = |what, estimate, border| Row {
        what,
        estimate,
        border,
    };
    let (single, redundancy) = (single.as_ref(), redundancy.as_ref());
    [
        row("several reach 5 x one: smallest/one median", *ratio, 5.0),
        row(
            "P(a run of several >= 5 x a run of one)",
            order.multi_ge_5x_single,
            0.5,
        ),
        row(
            "three beat four: P(run of 3 > run of 4)",
            order.three_gt_four,
            0.5,
        ),
        row(
            "two beat four: P(run of 2 > run of 4)",
            order.two_gt_four,
            0.5,
        ),
        row(
            "three are optimal: P(run of 3 > run of 2)",
            order.three_gt_two,
            0.5,
        ),
        row(
            "one agent does not get away",
            single.map(|single| single.trapped),
            0.5,
        ),
        row(
            "one agent circles (frames 91 to 270)",
            single.map(|single| single.circling),
            0.5,
        ),
        row(
            "redundant agents keep out of solved trials",
            redundancy.map(|redundancy| redundancy.keep_out),
            KEEP_OUT_BORDER,
        ),
    ]
}

/// Every finding of the paper with its interval and verdict.
pub(super) fn findings(findings: &Findings) -> String {
    let mut text =
        String::from("what the paper found, and what these runs say [95 % bootstrap interval]:\n");
    for row in rows(findings) {
        let verdict = row
            .verdict()
            .map_or(String::new(), |verdict| verdict.to_string());
        let _ = writeln!(text, "  {:<43} {:<19} {verdict}", row.what, row.value());
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

/// Several experiments side by side, as tables that Markdown understands.
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
    let columns: Vec<[Row; 8]> = experiments
        .iter()
        .map(|(_, findings)| rows(findings))
        .collect();
    for index in 0..8 {
        let _ = write!(
            text,
            "| {} |",
            columns.first().map_or("", |rows| rows[index].what)
        );
        for rows in &columns {
            let mark = match rows[index].verdict() {
                Some(Verdict::DoesNotReproduce) => " **no**",
                Some(Verdict::Undecided) => " undecided",
                Some(Verdict::Reproduces) | None => "",
            };
            let _ = write!(text, " {}{mark} |", rows[index].value());
        }
        text.push('\n');
    }
    text
}

/// Evolved tables against baselines and on held-out trials.
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
