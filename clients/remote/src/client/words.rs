//! Words of the command line for the server.

use std::ffi::OsString;

use anyhow::anyhow;

/// Options that select the server.
const SELECTION: [&str; 2] = ["--remote", "--remote-config"];

/// Returns the words without the options that select the server.
pub(super) fn without_selection(
    words: impl Iterator<Item = OsString>,
) -> anyhow::Result<Vec<String>> {
    let mut kept = Vec::new();
    let mut words = words;
    while let Some(word) = words.next() {
        let word = word
            .into_string()
            .map_err(|word| anyhow!("{} is not UTF-8", word.display()))?;
        let name = word.split_once('=').map_or(&*word, |(name, _)| name);
        if !SELECTION.contains(&name) {
            kept.push(word);
        } else if name.len() == word.len() {
            // The value follows.
            words.next();
        }
    }
    Ok(kept)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn selection_is_removed_in_both_spellings() {
        let check = |line: &str, expected: &str| {
            let words = line.split_whitespace().map(OsString::from);
            let kept = without_selection(words).expect("UTF-8").join(" ");
            assert_eq!(kept, expected, "{line}");
        };
        check("--remote lab status", "status");
        check("status --remote=lab --watch", "status --watch");
        check(
            "grasp --remote lab --at 1,2,3 --remote-config a.toml",
            "grasp --at 1,2,3",
        );
        check("status", "status");
    }
}
