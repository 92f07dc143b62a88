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

#[cfg(test)]
mod tests {
    use super::*;

    /// Steps of one time constant: each moves half of the way.
    fn step(response: &mut LoadResponse, normal_n: f64, load_n: f64) -> bool {
        response.is_unresponsive(Some((normal_n, load_n)), FILTER_S)
    }

    fn started(normal_n: f64, load_n: f64) -> LoadResponse {
        let mut response = LoadResponse::default();
        assert!(!step(&mut response, normal_n, load_n));
        response
    }

    #[test]
    fn growth_by_a_quarter_without_load_is_unresponsive() {
        for (normal_n, load_n, expected) in [
            (6.0, 1.0, false),
            (6.25, 1.0, true),
            (8.0, 1.0, true),
            (8.0, 1.25, false),
            (8.0, 0.75, false),
            (8.0, 1.125, true),
        ] {
            // The first step moves half of the way from 4 N.
            let mut response = started(4.0, 1.0);
            assert_eq!(
                step(&mut response, normal_n, load_n),
                expected,
                "{normal_n} N, {load_n} N"
            );
        }
    }

    #[test]
    fn small_load_responds_above_the_noise() {
        for (load_n, responds) in [(0.135, false), (0.16, true), (0.065, false), (0.04, true)] {
            let mut response = started(4.0, 0.1);
            let is_unresponsive = step(&mut response, 8.0, load_n);
            assert_eq!(is_unresponsive, !responds, "{load_n} N");
        }
        let mut response = started(4.0, 0.0);
        assert!(step(&mut response, 8.0, 0.04), "the noise floor itself");
        // Upward loads count as well: 10 % of 1 N.
        for (load_n, responds) in [(-1.125, false), (-1.25, true)] {
            let mut response = started(4.0, -1.0);
            assert_eq!(step(&mut response, 8.0, load_n), !responds, "{load_n} N");
        }
    }

    #[test]
    fn growth_counts_from_the_smallest_force() {
        let mut response = started(4.0, 1.0);
        assert!(!step(&mut response, 2.0, 1.0), "3 N");
        assert!(!step(&mut response, 4.0, 1.0), "3.5 N");
        assert!(step(&mut response, 4.5, 1.0), "4 N");
        assert!(!response.is_unresponsive(None, FILTER_S), "set down");
        assert!(!step(&mut response, 8.0, 1.0), "starts again");
    }

    #[test]
    fn changed_load_restarts_the_comparison() {
        let mut response = started(4.0, 1.0);
        assert!(!step(&mut response, 8.0, 2.0), "the load responds at 6 N");
        assert!(
            !step(&mut response, 8.0, 1.5),
            "7 N is less than a quarter above 6 N"
        );
        assert!(step(&mut response, 9.0, 1.5), "8 N");
    }
}
