//! Result of `atas recordings fetch`, the same for a local and a remote recording.

use std::path::Path;

use serde_json::json;

use crate::Output;

/// Prints the file and its size.
///
/// # Errors
/// Standard output cannot be written.
pub fn print_fetched(file: &Path, bytes: u64, output: &mut Output) -> anyhow::Result<()> {
    if output.is_json() {
        return output.json(&json!({ "file": file, "bytes": bytes }));
    }
    let name = file.display();
    output.line(format!(
        "{name}: {bytes} bytes; `atas record check {name}` checks it"
    ))
}
