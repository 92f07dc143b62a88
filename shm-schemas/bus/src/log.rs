//! Forwards iceoryx2's log lines to `tracing`, truncated.
//!
//! iceoryx2 0.10 appends the whole object concerned, up to 29 kB. The event stands at the start of
//! the message.

use std::fmt::{self, Write};
use std::sync::Once;

use iceoryx2::prelude::{LogLevel, set_log_level, set_logger};
use iceoryx2_log_types::Log;

/// Maximum line, bytes. Design choice: four lines of a terminal.
const LINE_MAX: usize = 320;

/// Forwards iceoryx2's warnings and errors to `tracing`. Lower levels are off, so that a tick
/// formats nothing.
pub(crate) fn install() {
    static ONCE: Once = Once::new();
    static BRIDGE: Bridge = Bridge;
    ONCE.call_once(|| {
        set_logger(&BRIDGE);
        set_log_level(LogLevel::Warn);
    });
}

struct Bridge;

impl Log for Bridge {
    fn log(&self, level: LogLevel, _origin: fmt::Arguments<'_>, message: fmt::Arguments<'_>) {
        let line = Line::from_args(message);
        match level {
            LogLevel::Error | LogLevel::Fatal => tracing::error!(target: "iceoryx2", "{line}"),
            LogLevel::Warn => tracing::warn!(target: "iceoryx2", "{line}"),
            _ => tracing::debug!(target: "iceoryx2", "{line}"),
        }
    }
}

#[derive(Debug, Default)]
struct Line {
    text: String,
    cut: bool,
}

impl Line {
    fn from_args(message: fmt::Arguments<'_>) -> Self {
        let mut line = Self::default();
        // The only error is the truncation.
        let _ = line.write_fmt(message);
        line
    }
}

impl Write for Line {
    fn write_str(&mut self, part: &str) -> fmt::Result {
        let mut end = part.len().min(LINE_MAX - self.text.len());
        while !part.is_char_boundary(end) {
            end -= 1;
        }
        self.text.push_str(&part[..end]);
        self.cut = end < part.len();
        if self.cut { Err(fmt::Error) } else { Ok(()) }
    }
}

impl fmt::Display for Line {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.text)?;
        f.write_str(if self.cut { "…" } else { "" })
    }
}

#[cfg(test)]
mod tests {
    use super::{LINE_MAX, Line};

    fn check(message: &str, shown: &str) {
        assert_eq!(
            Line::from_args(format_args!("{message}")).to_string(),
            shown
        );
    }

    #[test]
    fn line_is_truncated_at_a_character_boundary() {
        check("short", "short");
        let full = "x".repeat(LINE_MAX);
        check(&full, &full);
        check(&"x".repeat(29_000), &format!("{full}…"));
        check(
            &"ä".repeat(29_000),
            &format!("{}…", "ä".repeat(LINE_MAX / 2)),
        );
    }
}
