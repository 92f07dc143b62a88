//! Dynamics of fingers, skin, object and table in steps of 500 µs; without arms and rotation stable
//! down to 12 g.

use crate::lanes::{Lanes, Mask};
use crate::skin::{
    BRISTLES, DAMPING_S, DAMPING_SHARE, KINETIC_RATIO, OBJECT_DAMPING_S, RINGS, SHEAR_RATIO, SKIN,
};
use crate::trial::GRAVITY_M_S2;

/// Simulation step, s.
pub(crate) const STEP_S: f32 = 500e-6;
/// Steps per tick of 1 ms.
pub(crate) const STEPS_PER_TICK: usize = 2;
/// Share of the position error corrected per step. Design choice: 4 ms model servo latency and lag.
const SERVO_SHARE: f32 = STEP_S / (0.004 + STEP_S);
/// Tip stiffness of a finger with compliant servos, N/m. Fitted to the force after a probe in the
/// full simulation; about that of the last two joints of the two-hand arm.
const FINGER_N_M: f32 = 6.3e3;
/// Stiffness of the table, N/m: four corners (`sim-backend/src/world_object.rs`).
const TABLE_N_M: f32 = 8e4;
/// Share of the object's momentum absorbed per step.
const TABLE_DAMPING: f32 = 0.2;

/// One finger represents both, because they press equally; the object only moves vertically.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Body<const N: usize> {
    /// Mass, kg; static friction; series stiffness of object and finger, N/m.
    mass_kg: Lanes<N>,
    friction: Lanes<N>,
    series_n_m: Lanes<N>,
    /// Closing since contact with the undeformed object, commanded and true, m.
    pub(crate) commanded_closing_m: Lanes<N>,
    closed_m: Lanes<N>,
    /// Deflection of object and finger, m.
    deflection_m: Lanes<N>,
    /// Height of the hand, commanded and true, m; height and speed of the object, m, m/s.
    pub(crate) commanded_hand_m: Lanes<N>,
    hand_m: Lanes<N>,
    pub(crate) raised_m: Lanes<N>,
    speed_m_s: Lanes<N>,
    /// Shear, m, and sliding bristles.
    shear_m: [Lanes<N>; BRISTLES],
    sliding: [Mask<N>; BRISTLES],
    /// Slip weighted by normal force, m.
    pub(crate) slip_m: Lanes<N>,
    /// Forces of one finger by ring, N.
    pub(crate) normal_n: [Lanes<N>; RINGS],
    pub(crate) shear_n: [Lanes<N>; RINGS],
}

impl<const N: usize> Body<N> {
    /// Objects on the table, fingers at first contact.
    #[inline(always)]
    pub(crate) fn new(mass_kg: Lanes<N>, friction: Lanes<N>, stiffness_n_m: Lanes<N>) -> Self {
        let zero = Lanes::splat(0.0);
        Self {
            mass_kg,
            friction,
            series_n_m: stiffness_n_m * FINGER_N_M / (stiffness_n_m + FINGER_N_M),
            commanded_closing_m: zero,
            closed_m: zero,
            deflection_m: zero,
            commanded_hand_m: zero,
            hand_m: zero,
            raised_m: zero,
            speed_m_s: zero,
            shear_m: [zero; BRISTLES],
            sliding: [Mask::NONE; BRISTLES],
            slip_m: zero,
            normal_n: [zero; RINGS],
            shear_n: [zero; RINGS],
        }
    }

    /// Adds `tremble_m` to the commanded height.
    #[inline(always)]
    pub(crate) fn step(&mut self, tremble_m: Lanes<N>) {
        let closed_m = self.closed_m.towards(self.commanded_closing_m, SERVO_SHARE);
        self.closed_m = closed_m;
        let before_m = self.hand_m;
        self.hand_m = before_m.towards(self.commanded_hand_m + tremble_m, SERVO_SHARE);
        let hand_m_s = (self.hand_m - before_m) * (1.0 / STEP_S);
        let skin_n_m = self.update_deflection();
        let friction_n = self.update_friction(hand_m_s - self.speed_m_s, skin_n_m);
        self.move_object(friction_n);
    }

    /// One Newton step of the implicit spring-damper of object and finger. Returns the stiffness of
    /// the skin in contact, N/m.
    #[inline(always)]
    fn update_deflection(&mut self) -> Lanes<N> {
        let depth_m = self.closed_m - self.deflection_m;
        let zero = Lanes::splat(0.0);
        let (mut force_n, mut slope_n_m) = (zero, zero);
        for bristle in &SKIN {
            let deep_m = depth_m - bristle.from_m;
            let touches = deep_m.above(0.0);
            force_n = force_n + touches.select(deep_m, zero) * bristle.normal_n_m;
            slope_n_m = slope_n_m + touches.select(Lanes::splat(bristle.normal_n_m), zero);
        }
        let k = self.series_n_m;
        let residual_n = force_n - k * self.deflection_m;
        let share = k * (OBJECT_DAMPING_S / STEP_S) + k + slope_n_m;
        self.deflection_m = self.deflection_m + residual_n / share;
        slope_n_m
    }

    /// Shears every bristle up to its friction limit; returns the friction of one finger, N.
    #[inline(always)]
    fn update_friction(&mut self, rubbing_m_s: Lanes<N>, skin_n_m: Lanes<N>) -> Lanes<N> {
        let zero = Lanes::splat(0.0);
        let depth_m = self.closed_m - self.deflection_m;
        let bound_s = self.mass_kg * (DAMPING_SHARE / STEP_S) / skin_n_m;
        let damping_s = Lanes::splat(DAMPING_S).lesser(bound_s);
        let speed_m_s = rubbing_m_s.abs();
        let (mut sum_n, mut pressed_n, mut slid_n_m) = (zero, zero, zero);
        self.normal_n = [zero; RINGS];
        self.shear_n = [zero; RINGS];
        for (index, bristle) in SKIN.iter().enumerate() {
            let shear_n_m = bristle.normal_n_m * SHEAR_RATIO;
            let deep_m = depth_m - bristle.from_m;
            let touches = deep_m.above(0.0);
            let normal_n = touches.select(deep_m, zero) * bristle.normal_n_m;
            let stretched_m = self.shear_m[index] + rubbing_m_s * STEP_S;
            let trial_n = (stretched_m + rubbing_m_s * damping_s) * shear_n_m;
            let limit_n = self.sliding[index].select(
                self.friction * normal_n * KINETIC_RATIO,
                self.friction * normal_n,
            );
            let slides = trial_n.abs().gt(limit_n);
            let slid_n = limit_n.with_sign(trial_n);
            let carried_m = limit_n * (1.0 / shear_n_m);
            let calmed_s = damping_s.lesser(carried_m / (speed_m_s + f32::MIN_POSITIVE));
            let kept_m = slid_n * (1.0 / shear_n_m) - rubbing_m_s * calmed_s;
            let force_n = touches.select(slides.select(slid_n, trial_n), zero);
            self.shear_m[index] = touches.select(slides.select(kept_m, stretched_m), zero);
            self.sliding[index] = touches & slides;
            slid_n_m = slid_n_m + slides.select(normal_n * speed_m_s, zero);
            sum_n = sum_n + force_n;
            pressed_n = pressed_n + normal_n;
            self.normal_n[bristle.ring] = self.normal_n[bristle.ring] + normal_n;
            self.shear_n[bristle.ring] = self.shear_n[bristle.ring] + force_n;
        }
        let slid_m = slid_n_m * STEP_S / (pressed_n + f32::MIN_POSITIVE);
        self.slip_m = self.slip_m + slid_m;
        sum_n
    }

    /// Object under friction of both fingers, weight and table support.
    #[inline(always)]
    fn move_object(&mut self, friction_n: Lanes<N>) {
        let zero = Lanes::splat(0.0);
        let weight_n = self.mass_kg * GRAVITY_M_S2;
        let stands = self.raised_m.below(0.0);
        let damped_n = self.speed_m_s * self.mass_kg * (TABLE_DAMPING / STEP_S);
        let support_n = (zero - self.raised_m * TABLE_N_M - damped_n).greater(zero);
        let table_n = stands.select(support_n, zero);
        let force_n = friction_n * 2.0 - weight_n + table_n;
        self.speed_m_s = self.speed_m_s + force_n * STEP_S / self.mass_kg;
        self.raised_m = self.raised_m + self.speed_m_s * STEP_S;
    }
}
