//! Kernel state of a process or thread from its `stat` file (`proc_pid_stat(5)`).

use std::io;
use std::path::Path;

/// State of a process (`/proc/PID`) or a thread (`/proc/PID/task/TID`).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Stat {
    /// `R` running, `S` sleeping, `D` waiting for a device, `Z` ended, `T` stopped, `t` traced.
    pub state: char,
    /// Minor and major page faults since the start.
    pub page_faults: u64,
}

impl Stat {
    /// Reads the state of the process or thread with this `/proc` folder.
    ///
    /// # Errors
    /// The process or thread has ended, or the file does not match `proc_pid_stat(5)`.
    pub fn read(folder: &Path) -> io::Result<Self> {
        let path = folder.join("stat");
        let text = std::fs::read_to_string(&path)?;
        Self::parse(&text).ok_or_else(|| {
            let what = format!(
                "could not read {}: unexpected content {text:?}",
                path.display()
            );
            io::Error::new(io::ErrorKind::InvalidData, what)
        })
    }

    /// Returns true if a signal or a debugger has stopped the process until it is continued.
    #[must_use]
    pub fn is_stopped(&self) -> bool {
        matches!(self.state, 'T' | 't')
    }

    fn parse(text: &str) -> Option<Self> {
        // The name (field 2) may contain any character; it ends at the last parenthesis.
        let (_, after_name) = text.rsplit_once(')')?;
        let fields: Vec<&str> = after_name.split_whitespace().collect();
        let field = |number: usize| fields.get(number - 3).copied();
        let count = |number| field(number)?.parse::<u64>().ok();
        Some(Self {
            state: field(3)?.chars().next()?,
            page_faults: count(10)?.checked_add(count(12)?)?,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fields_are_parsed_after_the_name() {
        let check = |text: &str, expected: Option<(char, u64)>| {
            let stat = Stat::parse(text).map(|stat| (stat.state, stat.page_faults));
            assert_eq!(stat, expected, "{text:?}");
        };
        let rest = "1 7 7 0 -1 4194560 700 90 30 4 5 6";
        check(&format!("7 (atasd) S {rest}"), Some(('S', 730)));
        check(&format!("7 (a) R 1 (b) T {rest}"), Some(('T', 730)));
        check("7 (atasd) S 1 7", None);
        check("7 (atasd", None);
        check("", None);
    }

    #[test]
    fn own_thread_is_reported_as_running() {
        let own = Stat::read(Path::new("/proc/thread-self")).expect("the own thread exists");
        assert_eq!((own.state, own.is_stopped()), ('R', false));
        let gone = Stat::read(Path::new("/proc/0")).expect_err("process 0 does not exist");
        assert_eq!(gone.kind(), io::ErrorKind::NotFound);
    }
}
