//! The ends that a command line leads to by itself, help, a version and wrong usage; and the one line that tells an error.

use std::ffi::OsString;
use std::io::{self, ErrorKind, Write as _};
use std::process::ExitCode;

use serde_json::json;

/// The end of a process whose command line asks for no work. Help and versions are printed: a reader that has seen enough is no
/// failure, a full disk is one, with the exit code `unwritten`. Everything else is wrong usage.
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
    // Of clap: 2, as in all tables of exit codes.
    let exit = u8::try_from(error.exit_code()).unwrap_or(u8::MAX);
    if wants_json() {
        let text = error.render().to_string();
        let sentence = text.trim_start_matches("error: ").trim_end();
        tell(program, sentence, exit, true);
    } else {
        // With standard error gone there is nobody left to tell.
        let _ = error.print();
    }
    ExitCode::from(exit)
}

/// Whether results, and so errors, are for programs: whether `--format json` is on the command line, even on one that is wrong
/// elsewhere.
#[must_use]
pub fn wants_json() -> bool {
    says_json(std::env::args_os().skip(1))
}

fn says_json(words: impl Iterator<Item = OsString>) -> bool {
    let words: Vec<OsString> = words.collect();
    let apart = words.windows(2).any(|pair| pair == ["--format", "json"]);
    apart || words.iter().any(|word| word == "--format=json")
}

/// Tells an error on standard error: a sentence under the program's name, or one JSON object.
pub fn tell(program: &str, sentence: &str, exit: u8, as_json: bool) {
    let line = if as_json {
        json!({ "error": sentence, "exit": exit }).to_string()
    } else {
        format!("{program}: {sentence}")
    };
    // With standard error gone there is nobody left to tell; the exit code still says it.
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
