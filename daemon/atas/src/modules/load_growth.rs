//! Load growth: closes the grip when the load of a suspended object exceeds the load that the grip
//! can hold.
//!
//! Lift verification has shown that a grip force F_n holds a load L. By Coulomb friction, a load L'
//! then needs F_n·L'/L. The skin gives way by d(F) = a·F^p, so the missing force needs the closing
//! distance d(F_n·L'/L) − d(F_n). The fingertips close it within a time constant, without passing
//! F_2. While an object slides, friction bounds the measured load; the grip then closes until the
//! object stops.
//!
//! The load must also exceed its own mean. If only the grip force seems to fall, because the zero
//! of a sensor drifts, the load has not grown.

use crate::held_object::VerifiedGrip;
use robot_model::Compression;

/// Excess over the load that the grip can hold: begins and ends closing (design choice: above hand
/// tremor; hysteresis).
const BEGIN_SHARE: f64 = 0.04;
const END_SHARE: f64 = 0.02;
/// Standard deviations of the load that the excess must exceed (design choice: at 4.5, a sponge
/// falls before the grip responds).
const SCATTER_MARGIN: f64 = 3.5;
/// Time constants of closing, s, to which the delay of the frames is added. Design choice,
/// measured with steps of half the weight: the finger is about three times as soft as its skin,
/// and a servo lags by a few milliseconds. With the second one, the grip approaches F_2 without
/// overshoot.
const CLOSING_S: f64 = 0.002;
const APPROACHING_F2_S: f64 = 0.005;
/// Largest closing speed, m/s (design choice: as fast as a release opens).
const CLOSING_MAX_M_S: f64 = 0.03;

#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct LoadGrowth {
    grown: bool,
}

impl LoadGrowth {
    /// Returns the closing speed per side, m/s, zero if the grip can hold the load. Inputs: load,
    /// `None` unless a verified object is suspended; smallest and largest normal force of the
    /// sides and F_2, N; compression of the skin; delay of the frames, s.
    pub(super) fn closing_m_s(
        &mut self,
        verified: Option<VerifiedGrip>,
        (weakest_n, strongest_n): (f64, f64),
        f2_n: f64,
        skin: &Compression,
        delay_s: f64,
    ) -> f64 {
        let grown = verified.filter(|verified| self.has_grown(verified));
        self.grown = grown.is_some();
        let Some(VerifiedGrip { load_n, held_n, .. }) = grown else {
            return 0.0;
        };
        let depth_m = |force_n: f64| skin.depth_m(force_n.max(0.0));
        let missing_m = depth_m(weakest_n * load_n / held_n) - depth_m(weakest_n);
        let allowed_m = depth_m(f2_n) - depth_m(strongest_n);
        (missing_m / (CLOSING_S + delay_s))
            .min(allowed_m / (APPROACHING_F2_S + delay_s))
            .clamp(0.0, CLOSING_MAX_M_S)
    }

    /// Returns true while the load exceeds the load that the grip can hold.
    pub(super) fn is_active(&self) -> bool {
        self.grown
    }

    fn has_grown(&self, verified: &VerifiedGrip) -> bool {
        let VerifiedGrip { load_n, held_n, .. } = *verified;
        let limit_n = if self.grown {
            (1.0 + END_SHARE) * held_n
        } else {
            let margin_n = (BEGIN_SHARE * held_n).max(SCATTER_MARGIN * verified.scatter_n);
            held_n.max(verified.mean_n) + margin_n
        };
        held_n > 0.0 && load_n > limit_n
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use robot_model::Skin;

    /// Returns the closing speed, mm/s, at 4 N per side and F_2 of `f2_n`, for a load of `load_n`,
    /// of which the grip holds 2 N.
    fn closing_mm_s(growth: &mut LoadGrowth, load_n: f64, scatter_n: f64, f2_n: f64) -> f64 {
        let verified = VerifiedGrip {
            load_n,
            held_n: 2.0,
            mean_n: 2.0,
            scatter_n,
            normal_n: [4.0; 2].into(),
            verified_normal_n: [4.0; 2].into(),
            closed_m: 0.0,
        };
        let skin = Skin::DOME_41.compression;
        1e3 * growth.closing_m_s(Some(verified), (4.0, 4.0), f2_n, &skin, 1e-3)
    }

    #[test]
    fn closing_speed_follows_the_missing_force() {
        for (load_n, scatter_n, f2_n, expected_mm_s) in [
            (1.0, 0.0, 8.0, 0.0..0.001),
            (2.07, 0.0, 8.0, 0.0..0.001),
            (2.1, 0.0, 8.0, 5.0..8.0),
            (2.1, 0.05, 8.0, 0.0..0.001),
            (3.0, 0.05, 8.0, 29.0..31.0),
            (3.0, 0.0, 4.2, 3.0..5.0),
            (3.0, 0.0, 4.0, 0.0..0.001),
            (3.0, 0.0, 2.0, 0.0..0.001),
        ] {
            let speed_mm_s = closing_mm_s(&mut LoadGrowth::default(), load_n, scatter_n, f2_n);
            assert!(
                expected_mm_s.contains(&speed_mm_s),
                "{load_n} N, scatter {scatter_n} N, F_2 {f2_n} N: {speed_mm_s} mm/s"
            );
        }
    }

    #[test]
    fn closing_continues_until_the_grip_holds_the_load() {
        let mut growth = LoadGrowth::default();
        let mut is_closing = |load_n: f64| {
            closing_mm_s(&mut growth, load_n, 0.0, 8.0);
            growth.is_active()
        };
        let loads_n = [2.06, 2.1, 2.06, 2.03, 2.06];
        assert_eq!(
            loads_n.map(&mut is_closing),
            [false, true, true, false, false]
        );
    }

    /// Regression: with a falling zero and without joint torques, the hand crushed more objects.
    #[test]
    fn seemingly_weaker_grip_does_not_close_under_a_steady_load() {
        let (skin, mut growth) = (Skin::DOME_41.compression, LoadGrowth::default());
        let steady = VerifiedGrip {
            load_n: 2.0,
            held_n: 1.5,
            mean_n: 2.0,
            scatter_n: 0.0,
            normal_n: [4.0; 2].into(),
            verified_normal_n: [4.0; 2].into(),
            closed_m: 0.0,
        };
        let speed_m_s = growth.closing_m_s(Some(steady), (3.0, 3.0), 8.0, &skin, 1e-3);
        assert_eq!(speed_m_s, 0.0);
    }

    #[test]
    fn unverified_grip_does_not_follow_a_load() {
        let (skin, mut growth) = (Skin::DOME_41.compression, LoadGrowth::default());
        assert_eq!(growth.closing_m_s(None, (4.0, 4.0), 8.0, &skin, 1e-3), 0.0);
        assert!(!growth.is_active());
    }
}
