//! Command-line results that need no work (help, version, wrong usage) and error output.

use std::ffi::OsString;
use std::io::{self, ErrorKind, Write as _};
use std::process::ExitCode;

use serde_json::json;

use crate::exit::Exit;

/// Returns the exit code for a command line that requests no work. Prints help and version to
/// standard output; a closed pipe counts as success, any other write error is
/// [`Exit::Failed`]. All other cases are [`Exit::Usage`].
#[must_use]
pub fn exit_without_work(program: &str, error: &clap::Error) -> ExitCode {
    if error.use_stderr() {
        return wrong_usage(program, error);
    }
    match error.print().and_then(|()| io::stdout().flush()) {
        Err(failure) if failure.kind() != ErrorKind::BrokenPipe => {
            let sentence = format!("could not write to standard output: {failure}");
            print_error(program, &sentence, Exit::Failed, json_requested());
            Exit::Failed.into()
        }
        _ => ExitCode::SUCCESS,
    }
}

fn wrong_usage(program: &str, error: &clap::Error) -> ExitCode {
    if json_requested() {
        let text = error.render().to_string();
        let sentence = text.trim_start_matches("error: ").trim_end();
        print_error(program, sentence, Exit::Usage, true);
    } else {
        // Standard error is closed: no other output is left.
        let _ = error.print();
    }
    Exit::Usage.into()
}

/// Returns true if the command line contains `--format json`, even if it is otherwise invalid.
/// Results and errors are then printed as JSON.
#[must_use]
pub fn json_requested() -> bool {
    has_json_format(std::env::args_os().skip(1))
}

fn has_json_format(words: impl Iterator<Item = OsString>) -> bool {
    let words: Vec<OsString> = words.collect();
    let apart = words.windows(2).any(|pair| pair == ["--format", "json"]);
    apart || words.iter().any(|word| word == "--format=json")
}

/// Prints an error to standard error: as text after the program name, or as one JSON object.
pub fn print_error(program: &str, sentence: &str, exit: Exit, as_json: bool) {
    let line = if as_json {
        json!({ "error": sentence, "exit": exit.code() }).to_string()
    } else {
        format!("{program}: {sentence}")
    };
    // If standard error is closed, the exit code still reports the failure.
    let _ = writeln!(io::stderr(), "{line}");
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn json_format_is_found_in_both_spellings() {
        let check = |line: &str, expected| {
            let words = line.split_whitespace().map(OsString::from);
            assert_eq!(has_json_format(words), expected, "{line}");
        };
        check("list --format json", true);
        check("--format=json fly", true);
        check("list --format human", false);
        check("--log-format json", false);
        check("json --format", false);
        check("", false);
    }
}
