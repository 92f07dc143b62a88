//! Command-line results that need no work (help, version, wrong usage) and error output.

use std::ffi::OsString;
use std::io::{self, ErrorKind, Write as _};
use std::process::ExitCode;

use serde_json::json;

/// Returns the exit code for a command line that requests no work. Prints help and version to
/// standard output; a closed pipe counts as success, any other write error returns
/// `write_error_exit`. All other cases are wrong usage.
#[must_use]
pub fn end(program: &str, error: &clap::Error, unwritten: u8) -> ExitCode {
    if error.use_stderr() {
        return wrong_usage(program, error);
    }
    match error.print().and_then(|()| io::stdout().flush()) {
        Err(failure) if failure.kind() != ErrorKind::BrokenPipe => {
            let sentence = format!("could not write to standard output: {failure}");
            tell(program, &sentence, unwritten, wants_json());
            ExitCode::from(unwritten)
        }
        _ => ExitCode::SUCCESS,
    }
}

fn wrong_usage(program: &str, error: &clap::Error) -> ExitCode {
    // The code of clap is 2, as in all tables of exit codes.
    let exit = u8::try_from(error.exit_code()).unwrap_or(u8::MAX);
    if wants_json() {
        let text = error.render().to_string();
        let sentence = text.trim_start_matches("error: ").trim_end();
        tell(program, sentence, exit, true);
    } else {
        // Standard error is closed: no other output is left.
        let _ = error.print();
    }
    ExitCode::from(exit)
}

/// Returns true if the command line contains `--format json`, even if it is otherwise invalid.
/// Results and errors are then printed as JSON.
#[must_use]
pub fn wants_json() -> bool {
    says_json(std::env::args_os().skip(1))
}

fn says_json(words: impl Iterator<Item = OsString>) -> bool {
    let words: Vec<OsString> = words.collect();
    let apart = words.windows(2).any(|pair| pair == ["--format", "json"]);
    apart || words.iter().any(|word| word == "--format=json")
}

/// Prints an error to standard error: as text after the program name, or as one JSON object.
pub fn tell(program: &str, sentence: &str, exit: u8, as_json: bool) {
    let line = if as_json {
        json!({ "error": sentence, "exit": exit }).to_string()
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
    fn json_is_asked_for_in_either_form() {
        let check = |line: &str, expected| {
            let words = line.split_whitespace().map(OsString::from);
            assert_eq!(says_json(words), expected, "{line}");
        };
        check("list --format json", true);
        check("--format=json fly", true);
        check("list --format human", false);
        check("--log-format json", false);
        check("json --format", false);
        check("", false);
    }
}
