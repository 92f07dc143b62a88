//! What a recording holds, by its columns.

use anyhow::bail;
use serde::Serialize;

use super::sheet::Sheet;

/// Electrodes, axes and fingers that are looked for.
const SERIES_MAX: usize = 64;

/// What a recording can be judged for, and where its columns are.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Kind {
    /// A fingertip on an object that is held or moved: slip against stable touch. Columns per element: `ff_e1`… in counts, or
    /// three axes `normal0_n,tangential10_n,tangential20_n`… as `atas-sensor --dry-run` writes them.
    Slip {
        /// Per element its normal and tangential axes; a bare electrode has only the first.
        elements: Vec<[Option<usize>; 3]>,
    },
    /// Fingers with three-axis fingertips that close on an object: hard against soft. `f1_x,f1_y,f1_z,pos1_deg`….
    Squeeze {
        /// Per finger its forces, N.
        forces: Vec<[usize; 3]>,
        /// Per finger its angle, degrees.
        angles: Vec<usize>,
    },
    /// One finger that presses until something gives way: `force_N,pos_mm`.
    Press {
        /// Force, N.
        force: usize,
        /// Position in the direction of pressing, mm.
        position: usize,
    },
    /// One three-axis fingertip that is touched now and then: `fx_counts,fy_counts,fz_counts`, or the same in newtons.
    Touch {
        /// x, y, z in the device's counts, or normal and tangential forces in newtons.
        axes: [usize; 3],
        /// Whether they are counts.
        is_counts: bool,
    },
}

/// What is judged, as reports name it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Judged {
    /// Slip against stable touch.
    Slip,
    /// Hard against soft.
    Hardness,
    /// The force at which something gives way.
    Rupture,
    /// Touches.
    Touch,
}

impl Kind {
    /// Looks at the columns of a sheet.
    ///
    /// # Errors
    /// No kind has these columns; the message names what each needs.
    pub fn of(sheet: &Sheet) -> anyhow::Result<Self> {
        let squeeze = squeeze(sheet);
        if let Some(kind) = squeeze {
            return Ok(kind);
        }
        if let (Some(force), Some(position)) = (
            sheet.first_of(&["force_N", "force_n"]),
            sheet.first_of(&["pos_mm", "position_mm"]),
        ) {
            return Ok(Self::Press { force, position });
        }
        let electrodes = series(sheet, |e| {
            [format!("ff_e{e}"), String::new(), String::new()]
        });
        if !electrodes.is_empty() {
            return Ok(Self::Slip {
                elements: electrodes,
            });
        }
        if let Some(kind) = touch(sheet) {
            return Ok(kind);
        }
        let skin = series(sheet, |e| {
            ["normal", "tangential1", "tangential2"].map(|axis| format!("{axis}{e}_n"))
        });
        if !skin.is_empty() {
            return Ok(Self::Slip { elements: skin });
        }
        bail!(
            "could not judge {} because no kind of recording has its columns ({}); slip needs ff_e1… or normal0_n…, hardness \
             f1_x,f1_y,f1_z,pos1_deg…, rupture force_N and pos_mm, touches fx_counts,fy_counts,fz_counts",
            sheet.path.display(),
            listed(sheet)
        )
    }

    /// The columns that are read, by what they are.
    pub(super) fn readings(&self) -> Vec<(&'static str, Vec<usize>)> {
        match self {
            Self::Slip { elements } => {
                let columns = elements.iter().flatten().flatten().copied();
                vec![("every element", columns.collect())]
            }
            Self::Squeeze { forces, angles } => {
                vec![
                    ("every force", forces.as_flattened().to_vec()),
                    ("every angle", angles.clone()),
                ]
            }
            Self::Press { force, position } => {
                vec![
                    ("the force", vec![*force]),
                    ("the position", vec![*position]),
                ]
            }
            Self::Touch { axes, .. } => vec![("every axis", axes.to_vec())],
        }
    }

    /// What is judged.
    #[must_use]
    pub fn judged(&self) -> Judged {
        match self {
            Self::Slip { .. } => Judged::Slip,
            Self::Squeeze { .. } => Judged::Hardness,
            Self::Press { .. } => Judged::Rupture,
            Self::Touch { .. } => Judged::Touch,
        }
    }
}

fn squeeze(sheet: &Sheet) -> Option<Kind> {
    let (mut forces, mut angles) = (Vec::new(), Vec::new());
    for finger in 1..=shm_schemas::capacity::FINGERS {
        let axis = |axis: &str| sheet.column(&format!("f{finger}_{axis}"));
        let angle = sheet.column(&format!("pos{finger}_deg"));
        // A finger without an angle, or an angle without a finger, says nothing about stiffness.
        if let (Some(x), Some(y), Some(z), Some(angle)) = (axis("x"), axis("y"), axis("z"), angle) {
            forces.push([x, y, z]);
            angles.push(angle);
        }
    }
    (!forces.is_empty()).then_some(Kind::Squeeze { forces, angles })
}

fn touch(sheet: &Sheet) -> Option<Kind> {
    let three = |names: [&str; 3]| -> Option<[usize; 3]> {
        Some([
            sheet.column(names[0])?,
            sheet.column(names[1])?,
            sheet.column(names[2])?,
        ])
    };
    let newtons = three(["normal_n", "tangential1_n", "tangential2_n"]).map(|axes| (axes, false));
    let counts = || three(["fx_counts", "fy_counts", "fz_counts"]).map(|axes| (axes, true));
    let (axes, is_counts) = newtons.or_else(counts)?;
    Some(Kind::Touch { axes, is_counts })
}

/// Elements whose first column is there, numbered from 0 or 1, gaps allowed.
fn series(sheet: &Sheet, names: impl Fn(usize) -> [String; 3]) -> Vec<[Option<usize>; 3]> {
    (0..=SERIES_MAX)
        .map(|element| names(element).map(|name| sheet.column(&name)))
        .filter(|columns| columns[0].is_some())
        .take(shm_schemas::capacity::ELEMENTS)
        .collect()
}

/// The first columns, for a message.
fn listed(sheet: &Sheet) -> String {
    let shown: Vec<&str> = sheet.columns().iter().take(8).map(String::as_str).collect();
    let more = if sheet.columns().len() > shown.len() {
        ", …"
    } else {
        ""
    };
    format!("{}{more}", shown.join(", "))
}
