//! Results in words and columns.

use std::fmt::Write as _;

use ebts::analysis::{Findings, Verdict};
use ebts::experiment::Summary;
use ebts::stats::Estimate;

use super::experiment::Comparison;

/// The part of solved four-agent trials in which redundant agents have to keep out for the finding to hold (ours: the paper
/// shows two examples and gives no rate).
const KEEP_OUT_BORDER: f64 = 0.5;

fn interval(Estimate { value, low, high }: Estimate) -> String {
    format!("{value:.2} [{low:.2}, {high:.2}]")
}

/// The table of Fig. 14.
pub(super) fn summary(summary: &Summary) -> String {
    let mut text = format!(
        "preset {}: {} runs per team size, {} generations, {:.2} s wall, {:.2} s on all cores\n\n",
        summary.preset, summary.seeds, summary.generations, summary.wall_s, summary.cpu_s
    );
    let _ = writeln!(
        text,
        "agents      q1  median      q3    mean   maximum fitness, of 800"
    );
    for c in &summary.conditions {
        let _ = writeln!(
            text,
            "{:>6}  {:>6.1}  {:>6.1}  {:>6.1}  {:>6.1}",
            c.agents, c.q1, c.median, c.q3, c.mean
        );
    }
    text + "\n"
}

/// Every finding of the paper with its interval and verdict.
pub(super) fn findings(findings: &Findings) -> String {
    let Findings {
        ratio,
        order,
        single,
        redundancy,
    } = findings;
    let mut text =
        String::from("what the paper found, and what these runs say (95 % bootstrap intervals):\n");
    let mut line = |what: &str, value: String, verdict: Verdict| {
        let _ = writeln!(text, "  {what:<66} {value:<20} {verdict}");
    };
    let mut share = |what: &str, estimate: Estimate, border: f64| {
        line(what, interval(estimate), Verdict::above(border, estimate));
    };
    share(
        "several agents reach 5 × one: smallest median / median of one",
        *ratio,
        5.0,
    );
    share(
        "  P(a run with several ≥ 5 × a run with one)",
        order.multi_ge_5x_single,
        0.5,
    );
    share(
        "three beat four: P(run of 3 > run of 4)",
        order.three_gt_four,
        0.5,
    );
    share(
        "two beat four: P(run of 2 > run of 4)",
        order.two_gt_four,
        0.5,
    );
    share(
        "three are optimal: P(run of 3 > run of 2)",
        order.three_gt_two,
        0.5,
    );
    share(
        "one agent is trapped (circles, stands still, ends at the object)",
        single.trapped,
        0.5,
    );
    share(
        "  it circles: a full turn or more in frames 91 to 270",
        single.circling,
        0.5,
    );
    share(
        "redundant agents keep out: 2 or 3 of 4 push in a solved trial",
        redundancy.keep_out,
        KEEP_OUT_BORDER,
    );
    let pushers = redundancy
        .by_pushers
        .map(|count| count.to_string())
        .join(", ");
    let _ = writeln!(
        text,
        "  one agent solves {:.2} of 8 goals; {} trials of four solved, by 0, 1, 2, 3, 4 pushers: {pushers}",
        single.solved_per_run, redundancy.solved
    );
    if Verdict::above(0.5, order.three_gt_two) == Verdict::DoesNotReproduce {
        text.push_str("  two agents beat three here: the paper's \"three agents are optimum\" does not reproduce on this preset\n");
    }
    text
}

/// Evolved tables against baselines and on held-out trials.
pub(super) fn comparisons(comparisons: &[Comparison]) -> String {
    let mut text = String::from(
        "\nfitness of 800   |  baselines                         |  held out, median over runs\n\
         agents  evolved  |  by hand  random mean  best of n    |  goals  starts  goals and starts\n",
    );
    for c in comparisons {
        let (b, h) = (&c.baselines, &c.held_out);
        let _ = writeln!(
            text,
            "{:>6}  {:>7.1}  |  {:>7.1}  {:>11.1}  {:>5.1} of {:<5} |  {:>5.1}  {:>6.1}  {:>16.1}",
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
