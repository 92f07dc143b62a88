//! Hand tremor and bumps: vertical displacement of all fingertips, invisible to the encoders.
//!
//! Tremor has two tones (prototype): 12 Hz, and 45 Hz at a quarter of the amplitude, each with a
//! seeded phase. A resting hand has a fifth of the amplitude. Each tone is a phasor rotated once
//! per substep. A bump is one period of a raised cosine: displacement and velocity begin and end at
//! zero.

use crate::random::Random;

/// Frequencies, Hz, and relative amplitudes (tactile design).
const TONES: [(f64, f64); 2] = [(12.0, 1.0), (45.0, 0.25)];
/// Share of the amplitude at rest (prototype).
const REST_SHARE: f64 = 0.2;
/// Time constant between rest and motion, s. Design choice: avoids a jump of the displacement.
const BLEND_S: f64 = 0.05;

#[derive(Clone, Debug)]
pub(crate) struct Vibration {
    amplitude_m: f64,
    share: f64,
    tones: [Tone; 2],
    /// Length of a substep, s.
    dt_s: f64,
    bump: Option<Bump>,
    /// Present displacement by the bump, m.
    bump_m: f64,
}

/// Bump of the arm: displacement height/2 · (1 − cos(2π·t/duration)).
#[derive(Clone, Copy, Debug)]
struct Bump {
    height_m: f64,
    duration_s: f64,
    elapsed_s: f64,
}

#[derive(Clone, Debug)]
struct Tone {
    omega_rad_s: f64,
    weight: f64,
    /// Cosine and sine of the current phase, and of the phase step per substep.
    phase: [f64; 2],
    advance: [f64; 2],
}

impl Vibration {
    pub(crate) fn new(amplitude_m: f64, dt_s: f64, random: &mut Random) -> Self {
        let tone = |(frequency_hz, weight): (f64, f64), random: &mut Random| {
            let omega_rad_s = core::f64::consts::TAU * frequency_hz;
            let phasor = |angle: f64| [libm::cos(angle), libm::sin(angle)];
            let phase = phasor(random.between(0.0, core::f64::consts::TAU));
            Tone {
                omega_rad_s,
                weight,
                phase,
                advance: phasor(omega_rad_s * dt_s),
            }
        };
        Self {
            amplitude_m,
            share: REST_SHARE,
            tones: TONES.map(|t| tone(t, random)),
            dt_s,
            bump: None,
            bump_m: 0.0,
        }
    }

    /// Starts a bump; it replaces one that has not ended.
    pub(crate) fn bump(&mut self, height_m: f64, duration_s: f64) {
        self.bump = Some(Bump {
            height_m,
            duration_s,
            elapsed_s: 0.0,
        });
    }

    /// Filters the amplitude towards rest or motion; call once per `dt_s`.
    pub(crate) fn blend(&mut self, moving: bool, dt_s: f64) {
        let wanted = if moving { 1.0 } else { REST_SHARE };
        self.share += (wanted - self.share) * (dt_s / BLEND_S);
    }

    /// Advances one substep; returns displacement, m, and velocity, m/s.
    pub(crate) fn step(&mut self) -> (f64, f64) {
        let scale_m = self.amplitude_m * self.share;
        let mut sum = self.step_bump();
        self.bump_m = sum.0;
        for tone in &mut self.tones {
            let [cos, sin] = tone.advance_phase();
            sum.0 += scale_m * tone.weight * sin;
            sum.1 += scale_m * tone.weight * tone.omega_rad_s * cos;
        }
        sum
    }

    /// Returns the present displacement by a bump, without tremor, m.
    pub(crate) fn bump_m(&self) -> f64 {
        self.bump_m
    }

    fn step_bump(&mut self) -> (f64, f64) {
        let Some(bump) = &mut self.bump else {
            return (0.0, 0.0);
        };
        bump.elapsed_s += self.dt_s;
        let bump = *bump;
        if bump.elapsed_s >= bump.duration_s {
            self.bump = None;
            return (0.0, 0.0);
        }
        bump.motion()
    }
}

impl Bump {
    /// Returns displacement, m, and velocity, m/s.
    fn motion(self) -> (f64, f64) {
        let omega_rad_s = core::f64::consts::TAU / self.duration_s;
        let (sin, cos) = libm::sincos(omega_rad_s * self.elapsed_s);
        let half_m = self.height_m / 2.0;
        (half_m * (1.0 - cos), half_m * omega_rad_s * sin)
    }
}

impl Tone {
    fn advance_phase(&mut self) -> [f64; 2] {
        let ([c, s], [a, b]) = (self.phase, self.advance);
        self.phase = [c * a - s * b, s * a + c * b];
        self.phase
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const DT_S: f64 = 250e-6;

    /// Returns the largest displacement in a second; checks the velocity against differences.
    fn largest_m(moving: bool) -> f64 {
        let mut vibration = Vibration::new(1e-5, DT_S, &mut Random::new(1, 1));
        let (mut largest_m, mut before_m) = (0.0_f64, f64::NAN);
        for step in 0..8000 {
            vibration.blend(moving, DT_S);
            let (at_m, at_m_s) = vibration.step();
            if step > 4000 {
                largest_m = largest_m.max(at_m.abs());
                let difference_m_s = (at_m - before_m) / DT_S;
                assert!(
                    (difference_m_s - at_m_s).abs() < 1e-4,
                    "{difference_m_s} and {at_m_s} m/s"
                );
            }
            before_m = at_m;
        }
        largest_m
    }

    #[test]
    fn bump_rises_to_its_height_and_returns() {
        let mut vibration = Vibration::new(0.0, DT_S, &mut Random::new(1, 1));
        assert_eq!(vibration.step(), (0.0, 0.0));
        vibration.bump(0.004, 0.1);
        let motion: Vec<(f64, f64)> = (0..500).map(|_| vibration.step()).collect();
        let largest_m = motion.iter().map(|(at_m, _)| *at_m).fold(0.0, f64::max);
        assert!((largest_m - 0.004).abs() < 1e-6, "{largest_m} m");
        for pair in motion.windows(2) {
            let difference_m_s = (pair[1].0 - pair[0].0) / DT_S;
            assert!((difference_m_s - pair[1].1).abs() < 5e-3, "{pair:?}");
        }
        assert_eq!(motion[450], (0.0, 0.0), "ended after 0.1 s");
        assert_eq!(vibration.bump_m(), 0.0);
    }

    #[test]
    fn moving_hand_vibrates_five_times_more() {
        let (moving_m, resting_m) = (largest_m(true), largest_m(false));
        assert!((moving_m / 1.25e-5 - 1.0).abs() < 0.05, "{moving_m} m");
        assert!(
            (moving_m / resting_m - 5.0).abs() < 0.1,
            "{moving_m} and {resting_m} m"
        );
    }
}
