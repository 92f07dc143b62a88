//! Contact motion in multiples of sensor noise: noise against motion, at any rate and in any unit.

use crate::support::{MS_NS, frame, robot};
use atas_core::intake::FrameIntake;
use atas_core::perception::{MotionPercept, Perception};
use atas_core::settings::Settings;
use atas_core::{HandSensorSetup, Tick};
use robot_model::HandSide;
use shm_schemas::Hand;

/// Stateless uniform noise from −1 to 1: SplitMix64 of the index.
fn noise(index: u64) -> f64 {
    let mut z = index.wrapping_mul(0x9E37_79B9_7F4A_7C15);
    z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    (z ^ (z >> 31)) as f64 / u64::MAX as f64 * 2.0 - 1.0
}

/// All comparisons over three seconds of 41 elements that move at `speed` per second, in units of
/// `unit_n`, N.
fn percepts(
    rate_hz: u64,
    speed: f64,
    noise_n: f64,
    unit_n: f64,
    masked: u64,
) -> Vec<MotionPercept> {
    let wiring = HandSensorSetup::default();
    let settings = Settings::default();
    let mut intake = FrameIntake::new(Hand::LEFT, &wiring);
    let mut perception = Perception::new(&wiring, robot().hand(HandSide::Right));
    let mut found = Vec::new();
    for index in 0..3 * rate_hz {
        let now_ns = 1_000 * MS_NS + index * 1_000_000_000 / rate_hz;
        let mut frame = frame(Hand::LEFT, index, now_ns);
        for element in 0..41 {
            for axis in 0..3 {
                let still = 0.5 + 0.01 * element as f64;
                let moved = speed * index as f64 / rate_hz as f64 * ((element + axis) % 3) as f64;
                let flicker = noise_n * noise(index * 123 + (3 * element + axis) as u64);
                frame.force_n[0][element][axis] = ((still + moved + flicker) * unit_n) as f32;
            }
        }
        frame.valid_mask[0] &= !masked;
        if masked != 0 {
            frame.force_n[0][0] = [f32::NAN; 3];
        }
        frame.seal();
        let tick = Tick { index, now_ns };
        perception.begin();
        let checked = intake
            .validate(&frame, tick, &settings.intake)
            .expect("a valid frame");
        perception.update(&checked, false, &settings);
        let motion = perception.percept().fingertips[0].motion;
        if motion.comparisons as usize > found.len() {
            found.push(motion);
        }
    }
    found
}

#[test]
fn common_drift_is_motion_and_noise_is_not() {
    for rate_hz in [30, 100, 1000] {
        let still = percepts(rate_hz, 0.0, 0.01, 1.0, 0);
        assert!(still.len() > 25, "{rate_hz} Hz: {}", still.len());
        for motion in &still[2..] {
            assert!(
                (0.6..1.6).contains(&motion.level) && motion.share == 0.0,
                "{rate_hz} Hz: {motion:?}"
            );
        }
        // On one element, a fifth of the noise per 0.15 s window would be undetectable.
        let moving = percepts(rate_hz, 0.1, 0.01, 1.0, 0);
        let last = moving.last().expect("comparisons");
        assert!(last.share == 1.0, "{rate_hz} Hz: {last:?}");
    }
}

#[test]
fn motion_is_independent_of_the_unit() {
    let newtons = percepts(100, 0.05, 0.01, 1.0, 0);
    let counts = percepts(100, 0.05, 0.01, 8.0, 0);
    assert_eq!(newtons.len(), counts.len());
    for (a, b) in newtons.iter().zip(&counts) {
        assert!((a.level - b.level).abs() < 0.01 * a.level, "{a:?} {b:?}");
    }
}

#[test]
fn noise_free_sensor_reports_no_motion() {
    for motion in percepts(1000, 0.0, 0.0, 1.0, 0) {
        assert_eq!((motion.level, motion.share), (0.0, 0.0));
    }
}

/// Regression: a silent element must not look like a common motion to zero.
#[test]
fn silent_element_is_not_motion() {
    for motion in &percepts(1000, 0.0, 0.01, 1.0, 1)[2..] {
        assert!(
            motion.level.is_finite() && motion.share == 0.0,
            "{motion:?}"
        );
    }
}
