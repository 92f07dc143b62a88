//! Evidence: the command that collects it, and its definition.

use std::path::{Path, PathBuf};

use atas_faults::{Fault, find};

use crate::extent::Extent;

/// Item of evidence.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Evidence {
    /// Fault of the catalogue in virtual time, by number.
    Injection(&'static str),
    /// Fault of the catalogue with a daemon process, by number.
    Process(&'static str),
    /// Test, `file::name`.
    Test(String),
    /// Random tasks with random events.
    Soak,
    /// Stops during a flood of requests.
    Stops,
}

impl Evidence {
    /// Returns the evidence of a row of the catalogue; `None` if it has none.
    #[must_use]
    pub fn of_fault(fault: &Fault) -> Option<Self> {
        use atas_faults::Evidence as Shown;
        match fault.evidence {
            Shown::Injected(..) => Some(Self::Injection(fault.id)),
            Shown::Process(..) => Some(Self::Process(fault.id)),
            Shown::Test(test) => Some(Self::Test(test.to_owned())),
            Shown::Nothing(_) => None,
        }
    }

    /// Returns the name of its result.
    #[must_use]
    pub fn key(&self) -> String {
        match self {
            Self::Injection(id) | Self::Process(id) => (*id).to_owned(),
            Self::Test(test) => test.clone(),
            Self::Soak => "soak".to_owned(),
            Self::Stops => "stops".to_owned(),
        }
    }

    /// Returns the name of the file that stores its result.
    #[must_use]
    pub fn file(&self) -> &'static str {
        match self {
            Self::Injection(_) | Self::Process(_) => "faults.json",
            Self::Test(_) => "tests.json",
            Self::Soak => "soak.json",
            Self::Stops => "stops.json",
        }
    }

    /// Returns its short name for a table.
    #[must_use]
    pub fn title(&self) -> String {
        match self {
            Self::Injection(id) | Self::Process(id) => {
                let row = find(id).next();
                row.map_or_else(String::new, |row| format!("{id} {}", row.name))
            }
            Self::Test(test) => test
                .rsplit_once("::")
                .map_or("", |(_, name)| name)
                .to_owned(),
            Self::Soak => "random runs".to_owned(),
            Self::Stops => "stops under load".to_owned(),
        }
    }

    /// Returns the required result.
    #[must_use]
    pub fn requirement(&self) -> String {
        match self {
            Self::Injection(id) | Self::Process(id) => {
                let reaction = find(id).next().and_then(|row| row.evidence.reaction());
                reaction.map_or_else(String::new, atas_faults::Reaction::text)
            }
            Self::Test(_) => "passes".to_owned(),
            Self::Soak => "no violation".to_owned(),
            Self::Stops => "within 3 ticks".to_owned(),
        }
    }

    /// Returns the unit of one trial.
    #[must_use]
    pub fn trial(&self) -> &'static str {
        match self {
            Self::Injection(_) | Self::Process(_) => "runs",
            Self::Test(_) => "test",
            Self::Soak => "ticks",
            Self::Stops => "stops",
        }
    }

    /// Returns the unit of the worst value and of the bound.
    #[must_use]
    pub fn unit(&self) -> &'static str {
        match self {
            Self::Soak => "violations",
            _ => "ticks",
        }
    }

    /// Returns the least extent: seeds, ticks or stops.
    #[must_use]
    pub fn extent(&self, extent: &Extent) -> u64 {
        match self {
            Self::Injection(_) => extent.seeds,
            Self::Process(_) => extent.process_seeds,
            Self::Test(_) => 1,
            Self::Soak => extent.ticks,
            Self::Stops => extent.stops,
        }
    }

    /// Returns the commands that collect these items, without `--format json`.
    #[must_use]
    pub fn commands(items: &[Self], extent: &Extent) -> Vec<String> {
        let ids = |is_process: bool| {
            let ids = items.iter().filter_map(move |item| match item {
                Self::Injection(id) if !is_process => Some(*id),
                Self::Process(id) if is_process => Some(*id),
                _ => None,
            });
            ids.collect::<Vec<_>>()
        };
        let mut commands = Vec::new();
        let faults = [
            (ids(false), extent.seeds),
            (ids(true), extent.process_seeds),
        ];
        for (ids, seeds) in faults.into_iter().filter(|(ids, _)| !ids.is_empty()) {
            commands.push(format!("atas fault run {} --seeds {seeds}", ids.join(" ")));
        }
        if items.contains(&Self::Soak) {
            commands.push(format!("atas soak --ticks {}", extent.ticks));
        }
        if items.contains(&Self::Stops) {
            commands.push(format!("atas bench stop --count {}", extent.stops));
        }
        commands.extend(Self::test_command(items));
        commands
    }

    /// Returns the command of all tests among these items; `None` without any.
    #[must_use]
    pub fn test_command(items: &[Self]) -> Option<String> {
        let tests = items.iter().filter_map(|item| match item {
            Self::Test(test) => test.split_once("::"),
            _ => None,
        });
        let (mut targets, mut names) = (Vec::new(), Vec::new());
        for (file, name) in tests {
            let target = target(Path::new(file));
            if !targets.contains(&target) {
                targets.push(target);
            }
            names.push(name);
        }
        (!names.is_empty()).then(|| {
            let (targets, names) = (targets.join(" "), names.join(" "));
            format!("cargo test --workspace --no-fail-fast {targets} -- {names}")
        })
    }

    /// Returns the fingerprint of its definition: a result of another one is stale. `None` if the
    /// evidence does not exist in the source tree.
    #[must_use]
    pub fn fingerprint(&self, tree: &SourceTree) -> Option<String> {
        let definition = match self {
            Self::Injection(id) | Self::Process(id) => {
                let row = find(id).next()?;
                format!("{:?} {}", row.evidence, self.requirement())
            }
            Self::Test(test) => tree.test(test)?,
            Self::Soak | Self::Stops => String::new(),
        };
        Some(format!("{:08x}", crc32fast::hash(definition.as_bytes())))
    }
}

/// Returns the option of Cargo that selects the test target of a file.
fn target(file: &Path) -> String {
    let parts: Vec<_> = file.iter().filter_map(|part| part.to_str()).collect();
    // The last folder `tests` holds the targets: files, or folders with modules.
    let folder = parts.iter().rposition(|part| *part == "tests");
    let name = folder.and_then(|index| parts.get(index + 1));
    name.map_or_else(
        || "--lib".to_owned(),
        |name| format!("--test {}", name.trim_end_matches(".rs")),
    )
}

/// Source tree with the tests.
#[derive(Clone, Debug)]
pub struct SourceTree {
    root: PathBuf,
}

impl SourceTree {
    /// Uses the tree in this folder.
    #[must_use]
    pub fn new(root: &Path) -> Self {
        Self {
            root: root.to_owned(),
        }
    }

    /// Returns the folder of the tree.
    #[must_use]
    pub fn root(&self) -> &Path {
        &self.root
    }

    /// Returns the source of a test, `file::name`; `None` if it does not exist.
    fn test(&self, test: &str) -> Option<String> {
        let (file, name) = test.split_once("::")?;
        let text = std::fs::read_to_string(self.root.join(file)).ok()?;
        let start = text.find(&format!("fn {name}("))?;
        let line = text[..start].rfind('\n').map_or(0, |end| end + 1);
        let indent = &text[line..start];
        let indent = &indent[..indent.len() - indent.trim_start().len()];
        let end = text[start..].find(&format!("\n{indent}}}\n"));
        Some(text[start..end.map_or(text.len(), |end| start + end)].to_owned())
    }
}
