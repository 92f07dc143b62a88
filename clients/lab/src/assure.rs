//! `atas assure`: shows and checks the assurance case, and runs the commands of its evidence.

use std::io::IsTerminal;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Duration;

use anyhow::Context;
use atas_assurance::{
    Assessment, Case, Claim, Evidence, Extent, Origin, Outcome, PAGE, Results, SourceTree,
};
use atas_console::arguments::{Arguments, Assure};
use atas_console::{Exit, ExitError, Interrupt, Output, table};
use atas_processes::{Child, sibling_program};
use indicatif::{ProgressBar, ProgressStyle};
use serde_json::Value;

/// Version of this program and of its results.
const VERSION: &str = env!("CARGO_PKG_VERSION");
/// Time between two looks at a running command.
const POLL: Duration = Duration::from_millis(20);

pub(crate) fn assure(
    arguments: &Assure,
    interrupt: &Interrupt,
    output: &mut Output,
) -> anyhow::Result<()> {
    let case = Case::built_in()?;
    let tree = source_tree(&arguments.source)?;
    let folder = arguments.results.clone();
    let folder = folder.unwrap_or_else(|| tree.root().join(atas_assurance::RESULTS));
    let mut results = Results::load(&folder)
        .map_err(|error| ExitError::with_code(Exit::Input, format!("{error:#}")))?;
    let origin = Origin {
        version: VERSION,
        cores: std::thread::available_parallelism().map_or(1, usize::from),
        tree: &tree,
    };
    for file in &arguments.add {
        results.insert(added(file, &case, &origin)?);
        results.save(&folder, &case)?;
    }
    if arguments.run {
        let before = Assessment::new(&case, &results, &tree, VERSION);
        let chosen = case.chosen(&arguments.claims);
        let chosen =
            chosen.map_err(|error| ExitError::with_code(Exit::Usage, error.to_string()))?;
        let mut items = items(&case, &chosen);
        items.retain(|item| !arguments.missing || !before.has_shown(item));
        let run = Run {
            extent: case.extent.times(arguments.scale),
            origin: &origin,
            interrupt,
        };
        // Results of finished commands are kept after an interruption.
        for step in steps(&items) {
            results.insert(run.collect(&step)?);
            results.save(&folder, &case)?;
        }
    }
    let mut assessment = Assessment::new(&case, &results, &tree, VERSION);
    assessment.add_invalid_commands(is_command);
    if let Some(file) = &arguments.out {
        std::fs::write(file, atas_assurance::page(&assessment))
            .with_context(|| format!("could not write {}", file.display()))?;
    }
    if arguments.check {
        atas_assurance::compare_page(&mut assessment, &tree.root().join(PAGE))?;
    }
    if output.is_json() {
        output.json(&assessment)?;
    } else {
        print(&assessment, output)?;
    }
    let count = assessment.problems.len();
    if count == 0 || !(arguments.check || arguments.run) {
        return Ok(());
    }
    Err(ExitError::with_code(
        Exit::Failed,
        format!("the assurance case has {count} problems; each problem above names its remedy"),
    ))
}

/// Returns the evidence of claims, each item once.
fn items(case: &Case, claims: &[&Claim]) -> Vec<Evidence> {
    let mut items: Vec<Evidence> = Vec::new();
    for item in claims.iter().flat_map(|claim| case.evidence(claim)) {
        if !items.contains(&item) {
            items.push(item);
        }
    }
    items
}

/// Reads a result that a command of the case printed.
fn added(file: &Path, case: &Case, origin: &Origin<'_>) -> anyhow::Result<Vec<Outcome>> {
    let input = |error: anyhow::Error| {
        let text = format!("could not add the result {}: {error:#}", file.display());
        ExitError::with_code(Exit::Input, text)
    };
    let read = || {
        let report: Value = serde_json::from_str(&std::fs::read_to_string(file)?)?;
        let claims: Vec<&Claim> = case.claims.iter().collect();
        atas_assurance::from_report(&report, &items(case, &claims), origin)
    };
    read().map_err(input)
}

/// Returns the source tree, if it is that of this program.
fn source_tree(root: &Path) -> anyhow::Result<SourceTree> {
    let input = |text: String| Err(ExitError::with_code(Exit::Input, text));
    let file = root.join("clients/assurance/case.toml");
    match std::fs::read_to_string(&file) {
        Ok(text) if text == Case::TEXT => Ok(SourceTree::new(root)),
        Ok(_) => input(format!(
            "{} differs from the case of this program; build it again with `cargo build \
             --workspace`",
            file.display()
        )),
        Err(error) => input(format!(
            "could not find the source tree of ATAS in {}: {}: {error}; pass --source FOLDER",
            root.display(),
            file.display()
        )),
    }
}

/// Returns the reason why a command of the case is not a command of `atas`.
fn is_command(command: &str) -> Result<(), String> {
    let words: Vec<&str> = command.split(' ').collect();
    if words[0] != "atas" {
        return Ok(());
    }
    let parsed = Arguments::from_words(&words);
    parsed.map(|_| ()).map_err(|error| error.kind().to_string())
}

fn print(assessment: &Assessment, output: &mut Output) -> anyhow::Result<()> {
    let mut rows = table(&["claim", "statement", "evidence", "state"]);
    for claim in &assessment.claims {
        let shown = claim.evidence.iter().filter(|item| item.is_shown).count();
        let state = if claim.is_shown { "shown" } else { "not shown" };
        rows.add_row([
            format!("{} {}", claim.id, claim.name),
            claim.text.clone(),
            format!("{shown} of {}", claim.evidence.len()),
            state.to_owned(),
        ]);
    }
    output.table(rows)?;
    for problem in &assessment.problems {
        output.line(format_args!("problem: {problem}"))?;
    }
    let claims = assessment.claims.iter();
    output.line(format_args!(
        "{} of {} claims are shown; faults not claimed: {}",
        claims.filter(|claim| claim.is_shown).count(),
        assessment.claims.len(),
        assessment.not_claimed.len()
    ))
}

/// Shows the running command; hidden if standard error is not a terminal.
fn progress(command: &str) -> ProgressBar {
    if !std::io::stderr().is_terminal() {
        return ProgressBar::hidden();
    }
    let style = ProgressStyle::with_template("{elapsed} {wide_msg}");
    let bar = ProgressBar::new_spinner().with_message(command.to_owned());
    bar.enable_steady_tick(Duration::from_secs(1));
    bar.with_style(style.unwrap_or_else(|_| ProgressStyle::default_spinner()))
}

/// Returns the items by command.
fn steps(items: &[Evidence]) -> Vec<Vec<Evidence>> {
    let kinds: [fn(&Evidence) -> bool; 5] = [
        |item| matches!(item, Evidence::Test(_)),
        |item| matches!(item, Evidence::Injection(_)),
        |item| matches!(item, Evidence::Process(_)),
        |item| *item == Evidence::Soak,
        |item| *item == Evidence::Stops,
    ];
    let steps = kinds.map(|is_kind| {
        let chosen = items.iter().filter(|item| is_kind(item));
        chosen.cloned().collect::<Vec<_>>()
    });
    steps.into_iter().filter(|step| !step.is_empty()).collect()
}

/// Execution of the commands of the evidence.
struct Run<'a> {
    extent: Extent,
    origin: &'a Origin<'a>,
    interrupt: &'a Interrupt,
}

impl Run<'_> {
    /// Runs the command of items of one kind and returns their results.
    fn collect(&self, items: &[Evidence]) -> anyhow::Result<Vec<Outcome>> {
        let commands = Evidence::commands(items, &self.extent);
        let command = commands.first().context("the items have a command")?;
        let lines = self.lines(command)?;
        if matches!(items[0], Evidence::Test(_)) {
            return Ok(atas_assurance::from_tests(&lines, items, self.origin));
        }
        let line = lines.last().map_or("", String::as_str);
        let report: Value = serde_json::from_str(line)
            .with_context(|| format!("`{command}` printed no result: {line:?}"))?;
        atas_assurance::from_report(&report, items, self.origin)
    }

    /// Runs a command and returns the lines that it prints. A failed command prints its result too.
    fn lines(&self, command: &str) -> anyhow::Result<Vec<String>> {
        let progress = progress(command);
        let mut words = command.split(' ');
        let is_atas = words.next() == Some("atas");
        let mut words: Vec<&str> = words.collect();
        let program = if is_atas {
            words.extend(["--format", "json"]);
            sibling_program("atas")?
        } else {
            std::env::var_os("CARGO").map_or_else(|| PathBuf::from("cargo"), PathBuf::from)
        };
        let folder = tempfile::tempdir().context("could not make a folder for the results")?;
        let name = if is_atas { "atas" } else { "cargo" };
        let root = self.origin.tree.root();
        let adjust = |command: &mut Command| {
            if !is_atas {
                // With CI set, a test fails if a program that it needs is missing.
                command.current_dir(root).env("CI", "true");
            }
        };
        let mut child = Child::start_adjusted(&program, name, &words, folder.path(), adjust)?;
        let status = loop {
            self.interrupt
                .check("no result of the last command was stored")?;
            if let Some(status) = child.exit_status()? {
                break status;
            }
            std::thread::sleep(POLL);
        };
        progress.finish_and_clear();
        let lines = child.results();
        anyhow::ensure!(
            !lines.is_empty(),
            "`{command}` printed no result ({status}); the end of its log:\n{}",
            child.tail()
        );
        Ok(lines)
    }
}
