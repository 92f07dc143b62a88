//! Kind of a recording, determined by its columns.

use anyhow::bail;
use serde::Serialize;

use super::sheet::Sheet;

/// Largest number in an element's column name.
const SERIES_MAX: usize = 64;

/// Kind of a recording, with the indices of its columns.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Kind {
    /// One fingertip on an object, evaluated for slip. Columns per element: `ff_e1`… in counts, or
    /// three axes `normal0_n,tangential10_n,tangential20_n`… as `atas-sensor --dry-run` writes
    /// them.
    Slip {
        /// Normal and tangential axes per element; a single-axis electrode has only the first.
        elements: Vec<[Option<usize>; 3]>,
    },
    /// Fingers with three-axis fingertips that squeeze an object, evaluated as hard or soft.
    /// Columns: `f1_x,f1_y,f1_z,pos1_deg`….
    Squeeze {
        /// Force axes per finger, N.
        forces: Vec<[usize; 3]>,
        /// Angle per finger, degrees.
        angles: Vec<usize>,
    },
    /// One finger that presses an object until it ruptures. Columns: `force_N,pos_mm`.
    Press {
        /// Force, N.
        force: usize,
        /// Position along the pressing direction, mm.
        position: usize,
    },
    /// One three-axis fingertip with intermittent contact. Columns:
    /// `fx_counts,fy_counts,fz_counts`, or `normal_n,tangential1_n,tangential2_n`.
    Touch {
        /// x, y, z in counts, or normal and tangential forces in N.
        axes: [usize; 3],
        /// True for counts.
        is_counts: bool,
    },
}

/// Evaluated property, as named in reports.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Property {
    /// Slip or stable contact.
    Slip,
    /// Hard or soft.
    Hardness,
    /// Rupture force.
    Rupture,
    /// Contact.
    Touch,
}

impl Kind {
    /// Determines the kind from the columns of a sheet.
    ///
    /// # Errors
    /// No kind has these columns; the message lists the required ones.
    pub fn from_sheet(sheet: &Sheet) -> anyhow::Result<Self> {
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
            "could not evaluate {}: no kind of recording has its columns ({}); slip needs ff_e1… \
             or normal0_n…, hardness f1_x,f1_y,f1_z,pos1_deg…, rupture force_N and pos_mm, contact \
             fx_counts,fy_counts,fz_counts",
            sheet.path.display(),
            listed(sheet)
        )
    }

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

    /// Returns the evaluated property.
    #[must_use]
    pub fn property(&self) -> Property {
        match self {
            Self::Slip { .. } => Property::Slip,
            Self::Squeeze { .. } => Property::Hardness,
            Self::Press { .. } => Property::Rupture,
            Self::Touch { .. } => Property::Touch,
        }
    }
}

fn squeeze(sheet: &Sheet) -> Option<Kind> {
    let (mut forces, mut angles) = (Vec::new(), Vec::new());
    for finger in 1..=shm_schemas::capacity::FINGERS {
        let axis = |axis: &str| sheet.column(&format!("f{finger}_{axis}"));
        let angle = sheet.column(&format!("pos{finger}_deg"));
        // Stiffness needs forces and angle of the same finger.
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

fn series(sheet: &Sheet, names: impl Fn(usize) -> [String; 3]) -> Vec<[Option<usize>; 3]> {
    (0..=SERIES_MAX)
        .map(|element| names(element).map(|name| sheet.column(&name)))
        .filter(|columns| columns[0].is_some())
        .take(shm_schemas::capacity::ELEMENTS)
        .collect()
}

fn listed(sheet: &Sheet) -> String {
    let shown: Vec<&str> = sheet.columns().iter().take(8).map(String::as_str).collect();
    let more = if sheet.columns().len() > shown.len() {
        ", …"
    } else {
        ""
    };
    format!("{}{more}", shown.join(", "))
}
