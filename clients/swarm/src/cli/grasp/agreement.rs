//! `ebts agreement`: agreement of reduced and full grasp simulation.

use std::fmt::Write as _;

use clap::Args;
use indicatif::ProgressBar;

use ebts::error::{Error, Result};
use ebts::grasp::agreement::{self, Agreement};

use super::{Format, answer, stop_flag, style};

#[derive(Debug, Args)]
#[command(after_help = "Example:\n  ebts agreement --seeds 4")]
pub(crate) struct AgreementArgs {
    /// Members of each of the eight object families; 32 rule sets are simulated on each.
    #[arg(long, default_value_t = 4, value_parser = clap::value_parser!(u64).range(1..=1000))]
    seeds: u64,
    /// First seed of the families.
    #[arg(long, default_value_t = 7_500_001)]
    first_seed: u64,
    /// Threads; all cores by default.
    #[arg(long, default_value_t = 0)]
    threads: usize,
}

pub(in crate::cli) fn agreement(args: AgreementArgs, format: Format) -> Result<()> {
    let stop = stop_flag()?;
    let bar = ProgressBar::new(agreement::jobs(args.seeds)).with_style(style("grasp"));
    let tick = || bar.inc(1);
    let measured = agreement::measure(args.seeds, args.first_seed, args.threads, &stop, tick)?;
    bar.finish_and_clear();
    let measured = measured.ok_or_else(|| {
        Error::Interrupted("interrupted: nothing was saved; run the command again".to_owned())
    })?;
    answer(format, &measured, || describe(&measured))
}

fn describe(measured: &Agreement) -> String {
    let Agreement {
        pairs,
        agree,
        share,
        first_seed,
        ..
    } = measured;
    let mut text = format!(
        "Reduced and full simulation agree on {agree} of {pairs} pairs of object and rule ({:.1} %), seeds from {first_seed}.\n\
         Verdicts, full / reduced:\n",
        share * 100.0
    );
    for (verdicts, count) in &measured.verdicts {
        let _ = writeln!(text, "  {verdicts:<18} {count}");
    }
    text += "By object:\n";
    for (object, share) in &measured.objects {
        let _ = writeln!(text, "  {object:<18} {:.0} %", share * 100.0);
    }
    text += "By rule:\n";
    for rule in &measured.rules {
        let _ = writeln!(text, "  {:>4.0} %  {}", rule.share * 100.0, rule.rule);
    }
    text
}
