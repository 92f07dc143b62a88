//! Table file of a grasp: bits, levels, rows and origin. A task configuration contains the same
//! entries as an inline table.

use std::fmt::Write as _;
use std::path::Path;

use atas_core::tasks::BehaviourTable;
use serde::{Deserialize, Serialize};
use shm_schemas::SensorBit;

use super::course::{self, Family};
use super::evolve::evaluate_table;
use crate::error::{Error, Result};
use crate::evaluate::GoalPoints;
use crate::files::{is_of_kind, read_text, write_toml};

/// Value of `kind` in files of this type.
pub const KIND: &str = "grasp-table";

/// A grasp table with its origin.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct GraspFile {
    /// File type, [`KIND`].
    pub kind: String,
    /// Seed of the run.
    pub seed: u64,
    /// Generations of the run.
    pub generations: u32,
    /// True if Module 3 was active.
    pub force_limit: bool,
    /// Points per object family.
    pub points: GoalPoints,
    /// Sensor bits, the lowest bit of the row number first.
    pub bits: Vec<String>,
    /// Closing speed of the fingers per level, m/s.
    pub fingers_m_s: Vec<f64>,
    /// Factor of the hand's speed per level.
    pub hand: Vec<f64>,
    /// Per row the level of the fingers and of the hand.
    pub rows: String,
    /// Hash of the table, as the controller computes it.
    pub hash: String,
}

impl GraspFile {
    /// Creates the file of a table.
    #[must_use]
    pub fn new(
        table: &BehaviourTable,
        (seed, generations): (u64, u32),
        force_limit: bool,
        points: GoalPoints,
    ) -> Self {
        Self {
            kind: KIND.to_owned(),
            seed,
            generations,
            force_limit,
            points,
            bits: table.bits().map(|bit| bit.name().to_owned()).collect(),
            fingers_m_s: table.fingers_m_s().to_vec(),
            hand: table.hand().to_vec(),
            rows: rows_text(table),
            hash: format!("{:016x}", table.hash()),
        }
    }

    /// Returns whether a text is a file of this type.
    #[must_use]
    pub fn is_grasp_file(text: &str) -> bool {
        is_of_kind(text, KIND)
    }

    /// Writes the file atomically.
    pub fn write(&self, path: &Path) -> Result<()> {
        write_toml(path, self)
    }

    /// Reads a file and evaluates its table again.
    ///
    /// # Errors
    /// The file has another type, its table is invalid, or its points do not match.
    pub fn read(path: &Path, families: &[Family]) -> Result<(Self, BehaviourTable)> {
        let refuse = |was: String| {
            Error::refused(
                format_args!("use {}", path.display()),
                was,
                "a grasp table written by ebts evolve grasp",
                "evolve it again",
            )
        };
        let (file, table) = Self::parse(&read_text(path)?).map_err(&refuse)?;
        let genome = course::genome(&table)
            .ok_or_else(|| refuse("its bits or levels are not those of the course".to_owned()))?;
        let (points, ..) = evaluate_table(families, &genome, file.force_limit);
        if points != file.points {
            return Err(refuse(format!(
                "its table earns {points:?}, but the file has {:?}",
                file.points
            )));
        }
        Ok((file, table))
    }

    /// Parses the text of a file; does not evaluate its table.
    ///
    /// # Errors
    /// The cause as text: another type, an invalid table, or a hash of other rows.
    pub fn parse(text: &str) -> core::result::Result<(Self, BehaviourTable), String> {
        let file: Self = toml::from_str(text).map_err(|error| error.to_string())?;
        let table = file.table()?;
        if file.kind != KIND || file.hash != format!("{:016x}", table.hash()) {
            return Err(format!(
                "its hash does not match its rows, {:016x}",
                table.hash()
            ));
        }
        Ok((file, table))
    }

    /// Returns the fitness stored in the file.
    #[must_use]
    pub fn fitness(&self) -> f32 {
        self.points.iter().sum()
    }

    fn table(&self) -> core::result::Result<BehaviourTable, String> {
        let bit = |name: &String| {
            SensorBit::from_name(name).ok_or_else(|| format!("\"{name}\" is no sensor bit"))
        };
        let bits: Vec<SensorBit> = self
            .bits
            .iter()
            .map(bit)
            .collect::<core::result::Result<_, _>>()?;
        let row = |text: &str| {
            let digits: Vec<usize> = text
                .bytes()
                .map(|b| usize::from(b.wrapping_sub(b'0')))
                .collect();
            <[usize; 2]>::try_from(digits).map_err(|_| format!("{text:?} is no row of two digits"))
        };
        let rows: Vec<_> = self
            .rows
            .split_whitespace()
            .map(row)
            .collect::<core::result::Result<_, _>>()?;
        BehaviourTable::validated(&bits, &self.fingers_m_s, &self.hand, rows.into_iter())
            .map_err(|fault| fault.to_string())
    }

    /// Returns a task of the daemon configuration with this table.
    #[must_use]
    pub fn to_task(&self, name: &str) -> String {
        let levels = |levels: &[f64]| {
            let levels: Vec<String> = levels.iter().map(|level| format!("{level:?}")).collect();
            levels.join(", ")
        };
        let mut text = format!("[tasks.{name}]\nacting = [\n");
        for step in STEPS {
            let _ = writeln!(text, "    {{ {step} }},");
        }
        let bits: Vec<String> = self.bits.iter().map(|bit| format!("\"{bit}\"")).collect();
        let _ = writeln!(
            text,
            "]\ntable = {{ bits = [{}], fingers_m_s = [{}], hand = [{}], rows = \"{}\", hash = \"{}\" }}",
            bits.join(", "),
            levels(&self.fingers_m_s),
            levels(&self.hand),
            self.rows,
            self.hash
        );
        text
    }
}

/// Steps of the built-in grasp up to the probe; then the table grips, lifts and holds, with Module
/// 3.
const STEPS: [&str; 6] = [
    r#"step = "reach", motion = "reach", waypoint = "before-source", modules = ["carry", "contact guard"], transition = "arrived", timeout_s = 20.0"#,
    r#"step = "descend", motion = "reach", waypoint = "source", modules = ["carry", "contact guard"], transition = "arrived", timeout_s = 10.0"#,
    r#"step = "approach", motion = "stay", modules = ["first touch"], transition = "all-touched", timeout_s = 20.0"#,
    r#"step = "probe", motion = "stay", modules = ["stiffness probe"], transition = "stiffness-known", timeout_s = 3.0"#,
    r#"step = "lift", motion = "carry", waypoint = "lifted", modules = ["carry", "stiffness probe", "force limit", "behaviour table"], transition = "arrived", timeout_s = 20.0"#,
    r#"step = "hold", motion = "stay", modules = ["stiffness probe", "force limit", "behaviour table"], transition = "held""#,
];

fn rows_text(table: &BehaviourTable) -> String {
    let row = |row: usize| {
        let [fingers, hand] = table.levels(row);
        format!("{fingers}{hand}")
    };
    (0..table.rows()).map(row).collect::<Vec<_>>().join(" ")
}
