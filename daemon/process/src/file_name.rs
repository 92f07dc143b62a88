//! Names of output files. The suffix of a name selects the file format.

use std::path::{Path, PathBuf};

/// Returns the suffix in lower case (`SVG` equals `svg`), or an empty string if there is none.
#[must_use]
pub fn suffix(path: &Path) -> String {
    let suffix = path.extension().unwrap_or_default();
    suffix.to_string_lossy().to_ascii_lowercase()
}

/// Parses the name of an output file and checks that it has one of the suffixes.
///
/// # Errors
/// A message with the allowed suffixes.
///
/// ```
/// use atas_process::file_name::parse_with_suffix;
///
/// assert!(parse_with_suffix("run.mcap", &["mcap"]).is_ok());
/// assert!(parse_with_suffix("run.txt", &["mcap"]).is_err());
/// ```
pub fn parse_with_suffix(text: &str, suffixes: &[&str]) -> Result<PathBuf, String> {
    let path = PathBuf::from(text);
    if suffixes.contains(&suffix(&path).as_str()) {
        return Ok(path);
    }
    Err(format!("file name must end in .{}", suffixes.join(", .")))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn suffix_is_checked_in_any_case() {
        let check = |text: &str, suffixes: &[&str], is_one: bool| {
            assert_eq!(parse_with_suffix(text, suffixes).is_ok(), is_one, "{text}");
        };
        let pictures = ["svg", "png"];
        check("x.svg", &pictures, true);
        check("x.SVG", &pictures, true);
        check("folder.svg/x.Png", &pictures, true);
        check("x.svg.gz", &pictures, false);
        check("x", &pictures, false);
        check(".svg", &pictures, false);
        check("x.toml", &["toml"], true);
        check("x.json", &["toml"], false);
    }
}
