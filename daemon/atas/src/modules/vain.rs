//! Whether pressing is in vain: what is lifted bears no more of its weight on the fingers although they press harder.
//!
//! What slides through the fingers while they lift it loads them by as much more as they press more. What does not slide keeps
//! its load; then neither the shear of faces that stand askew, which grows with the pressing, nor a wrong reading of friction is a
//! cause to press on. This needs no friction coefficient.

/// Growth of the normal force, as a factor, after which pressing must have brought load (ours).
const PRESSED: f64 = 1.25;
/// Change of the load that counts as one: share, and least, N (ours: well above what noise makes of it).
const LOAD_SHARE: f64 = 0.1;
const LOAD_FLOOR_N: f64 = 0.02;
/// Time constant over which both are felt, s (ours: a few frames of noise).
const FELT_S: f64 = 0.03;

/// What the fingers have pressed with since the load changed last.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Vain {
    felt: Option<Felt>,
}

#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
struct Felt {
    /// Normal force and load, low-passed, N.
    normal_n: f64,
    load_n: f64,
    /// What they were when the load changed last; the least normal force since.
    from_normal_n: f64,
    from_load_n: f64,
}

impl Vain {
    /// Takes in what the fingers press with together and the load that they bear, N, after so much sensor time, s; `None` while
    /// nothing is lifted. True while pressing is in vain.
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
