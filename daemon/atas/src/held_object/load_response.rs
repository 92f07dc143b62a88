//! Load response: detects closing that does not increase the load of a lifted object.
//!
//! The load of a slipping object grows with the grip force; that of a held object does not. Without
//! a load response, neither shear from misaligned faces nor a wrong friction reading justifies more
//! force. The method needs no friction coefficient.

use crate::filter::low_pass;

/// Growth factor of the normal force that requires a load response (design choice).
const CLOSING_GROWTH: f64 = 1.25;
/// Smallest load response: share, and minimum in N (design choice: well above noise).
const LOAD_SHARE: f64 = 0.1;
const LOAD_FLOOR_N: f64 = 0.02;
/// Time constant of both forces, s (design choice: a few frames of noise).
const FILTER_S: f64 = 0.03;

#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct LoadResponse {
    filtered: Option<FilteredForces>,
}

#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
struct FilteredForces {
    /// Low-passed normal force and load, N.
    normal_n: f64,
    load_n: f64,
    /// Smallest normal force since the last change of load, and load at that change, N.
    reference_normal_n: f64,
    reference_load_n: f64,
}

impl LoadResponse {
    /// Updates with total normal force and load, N, and the sensor time, s; `None` while nothing is
    /// lifted. Returns true while the load does not respond.
    pub(super) fn is_unresponsive(&mut self, forces_n: Option<(f64, f64)>, step_s: f64) -> bool {
        let Some((normal_n, load_n)) = forces_n else {
            self.filtered = None;
            return false;
        };
        let measured = self.filtered.get_or_insert(FilteredForces {
            normal_n,
            load_n,
            reference_normal_n: normal_n,
            reference_load_n: load_n,
        });
        measured.normal_n = low_pass(measured.normal_n, normal_n, step_s, FILTER_S);
        measured.load_n = low_pass(measured.load_n, load_n, step_s, FILTER_S);
        let change_n = (measured.load_n - measured.reference_load_n).abs();
        if change_n > LOAD_FLOOR_N.max(LOAD_SHARE * measured.reference_load_n.abs()) {
            (measured.reference_normal_n, measured.reference_load_n) =
                (measured.normal_n, measured.load_n);
        } else if measured.normal_n < measured.reference_normal_n {
            measured.reference_normal_n = measured.normal_n;
        }
        measured.normal_n > CLOSING_GROWTH * measured.reference_normal_n
    }
}
