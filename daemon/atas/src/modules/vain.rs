//! Load response: detects closing that does not increase the load of a lifted object.
//!
//! The load of a slipping object grows with the grip force; that of a held object does not. Without
//! a load response, neither shear from misaligned faces nor a wrong friction reading justifies more
//! force. The method needs no friction coefficient.

/// Growth factor of the normal force that requires a load response (design choice).
const PRESSED: f64 = 1.25;
/// Smallest load response: share, and minimum in N (design choice: well above noise).
const LOAD_SHARE: f64 = 0.1;
const LOAD_FLOOR_N: f64 = 0.02;
/// Time constant of both forces, s (design choice: a few frames of noise).
const FELT_S: f64 = 0.03;

#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Vain {
    felt: Option<Felt>,
}

#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
struct Felt {
    /// Low-passed normal force and load, N.
    normal_n: f64,
    load_n: f64,
    /// Smallest normal force since the last change of load, and load at that change, N.
    from_normal_n: f64,
    from_load_n: f64,
}

impl Vain {
    /// Updates with total normal force and load, N, and the sensor time, s; `None` while nothing is
    /// lifted. Returns true while the load does not respond.
    pub(super) fn follow(&mut self, forces_n: Option<(f64, f64)>, step_s: f64) -> bool {
        let Some((normal_n, load_n)) = forces_n else {
            self.felt = None;
            return false;
        };
        let felt = self.felt.get_or_insert(Felt {
            normal_n,
            load_n,
            from_normal_n: normal_n,
            from_load_n: load_n,
        });
        let share = step_s / (FELT_S + step_s);
        felt.normal_n += (normal_n - felt.normal_n) * share;
        felt.load_n += (load_n - felt.load_n) * share;
        let change_n = (felt.load_n - felt.from_load_n).abs();
        if change_n > LOAD_FLOOR_N.max(LOAD_SHARE * felt.from_load_n.abs()) {
            (felt.from_normal_n, felt.from_load_n) = (felt.normal_n, felt.load_n);
        } else if felt.normal_n < felt.from_normal_n {
            felt.from_normal_n = felt.normal_n;
        }
        felt.normal_n > PRESSED * felt.from_normal_n
    }
}
