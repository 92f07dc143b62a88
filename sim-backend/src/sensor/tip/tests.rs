//! Effects of the sensor model on the readings of a fingertip.

use proptest::prelude::*;

use super::*;
use crate::sensor_model::{
    CreepModel, DeadModel, DeadReading, DriftModel, HysteresisModel, WearModel,
};

const PERIOD_S: f64 = 0.001;

/// Noiseless sensor with exact gains and fine steps.
fn ideal() -> SensorModel {
    SensorModel {
        gain_spread: 0.0,
        noise_n: [0.0; 2],
        noise_ratio: 0.0,
        step_n: [1e-6; 2],
        ..SensorModel::default()
    }
}

/// Fingertip under an equal normal force on every element.
struct Bench {
    layout: Layout,
    tip: TipSensor,
}

impl Bench {
    fn new(model: &SensorModel) -> Self {
        Self::with_noise(model, 1.0)
    }

    fn with_noise(model: &SensorModel, noise_factor: f64) -> Self {
        model.check().expect("valid model");
        let layout = Layout::dome_41();
        let random = Random::new(1, 2);
        let mut tip = TipSensor::new(layout.count, model, PERIOD_S, noise_factor, random);
        tip.draw_model(model, 1, 0);
        Self { layout, tip }
    }

    fn read(&mut self, normal_n: f64) -> Vec<[f32; AXES]> {
        let count = self.layout.count;
        let force = |element: usize| -Vector3::from(self.layout.normal[element]) * normal_n;
        let force_n: Vec<_> = (0..count).map(force).collect();
        let mut reading_n = [[0.0_f32; AXES]; ELEMENTS];
        self.tip.sample(&self.layout, &force_n, &mut reading_n);
        reading_n[..count].to_vec()
    }

    /// Returns the normal reading of element 5 after `samples` samples of this force.
    fn normal_n(&mut self, normal_n: f64, samples: usize) -> f64 {
        let readings = (0..samples).map(|_| f64::from(self.read(normal_n)[5][0]));
        readings.last().expect("one sample")
    }
}

#[test]
fn readings_are_quantised() {
    let check = |value: f64, step: f64, expected: f64| {
        assert!(
            (quantised(value, step) - expected).abs() < 1e-12,
            "{value} in steps of {step}"
        );
    };
    check(0.0014, 0.001, 0.001);
    check(-0.0016, 0.001, -0.002);
    check(0.0, 0.001, 0.0);
    check(8.123_456, 0.001, 8.123);
    check(2.5, 1.0, 2.0);
    check(-1e9, 0.5, -1e9);
}

/// A normal force read on a tangential axis is crosstalk; a reading without force is bias.
#[test]
fn sensor_errors_add_crosstalk_and_bias() {
    let errors = Errors {
        crosstalk: 0.05,
        bias_n: 0.02,
        ..Errors::NONE
    };
    let mut of_errors = Bench::with_noise(&SensorModel::default(), 0.0);
    of_errors.tip.apply_errors(&errors, &mut Random::new(1, 3));
    let model = SensorModel {
        crosstalk: 0.05,
        bias_n: 0.02,
        ..SensorModel::default()
    };
    for mut bench in [of_errors, Bench::with_noise(&model, 0.0)] {
        let (silent_n, pressed_n) = (bench.read(0.0), bench.read(1.0));
        let (mut farthest, mut mean) = (0.0_f64, 0.0);
        for (silent_n, pressed_n) in silent_n.iter().zip(&pressed_n) {
            assert!(silent_n.iter().all(|bias_n| bias_n.abs() < 0.0206));
            let mixed = f64::from(pressed_n[1] - silent_n[1]);
            farthest = farthest.max(mixed.abs());
            mean += mixed / 41.0;
        }
        assert!(farthest > 0.03 && farthest < 0.056, "{farthest}");
        assert!(mean.abs() < 0.015, "{mean}");
    }
}

/// Constant force on one element: the mean of many samples shows the gain, the spread the noise.
#[test]
fn noise_grows_with_the_force() {
    for (normal_n, expected_n) in [(0.0, 0.003), (0.3, 0.004_243), (2.0, 0.020_224)] {
        let mut bench = Bench::new(&SensorModel::default());
        let readings: Vec<f64> = (0..20_000)
            .map(|_| f64::from(bench.read(normal_n)[5][0]))
            .collect();
        let mean_n = readings.iter().sum::<f64>() / 20_000.0;
        let squares = readings.iter().map(|r| (r - mean_n) * (r - mean_n));
        let deviation_n = (squares.sum::<f64>() / 20_000.0).sqrt();
        let gain = bench.tip.gain[5];
        assert!(
            (mean_n - gain * normal_n).abs() < 5e-4,
            "{mean_n} N for {normal_n} N"
        );
        assert!(
            (deviation_n / expected_n - 1.0).abs() < 0.03,
            "{deviation_n} N at {normal_n} N"
        );
    }
}

#[test]
fn normal_and_shear_differ_in_noise_and_step() {
    let model = SensorModel {
        noise_n: [0.0, 0.02],
        step_n: [0.5, 0.01],
        noise_ratio: 0.0,
        gain_spread: 0.0,
        ..SensorModel::default()
    };
    let mut bench = Bench::new(&model);
    let mut shear_n = Vec::new();
    for _ in 0..500 {
        for reading_n in bench.read(0.6) {
            assert_eq!(reading_n[0], 0.5, "the normal axis has no noise");
            shear_n.push(f64::from(reading_n[1]));
        }
    }
    let deviation_n = (shear_n.iter().map(|n| n * n).sum::<f64>() / shear_n.len() as f64).sqrt();
    // Quantisation adds a variance of step²/12.
    let expected_n = (0.02_f64 * 0.02 + 0.01 * 0.01 / 12.0).sqrt();
    assert!(
        (deviation_n / expected_n - 1.0).abs() < 0.02,
        "{deviation_n}"
    );
}

#[test]
fn saturation_limits_readings_in_both_directions() {
    let model = SensorModel {
        saturation_n: Some([2.0, 0.5]),
        bias_n: 1.0,
        ..ideal()
    };
    let mut bench = Bench::new(&model);
    let silent_n = bench.read(0.0);
    assert!(silent_n.iter().any(|[_, a, _]| *a == 0.5));
    assert!(silent_n.iter().any(|[_, a, _]| *a == -0.5));
    assert!(
        silent_n
            .iter()
            .all(|[_, a, b]| a.abs() <= 0.5 && b.abs() <= 0.5)
    );
    assert!(bench.read(10.0).iter().all(|[n, ..]| *n == 2.0));
    assert!(bench.read(-10.0).iter().all(|[n, ..]| *n == -2.0));
}

#[test]
fn hysteresis_and_creep_act_on_every_element() {
    let hysteresis = HysteresisModel {
        share: 0.05,
        full_scale_n: [1.0, 0.5],
    };
    let mut bench = Bench::new(&SensorModel {
        hysteresis: Some(hysteresis),
        ..ideal()
    });
    let loading_n = bench.normal_n(0.5, 1);
    bench.normal_n(1.0, 1);
    let width_n = bench.normal_n(0.5, 1) - loading_n;
    assert!((width_n - 0.05).abs() < 1e-5, "{width_n}");
    assert!(bench.normal_n(0.0, 1).abs() < 1e-6);
    let mut bench = Bench::new(&SensorModel {
        creep: Some(CreepModel { per_decade: 0.05 }),
        ..ideal()
    });
    let after_1_s = bench.normal_n(1.0, 1000);
    let rise = bench.normal_n(1.0, 9000) - after_1_s;
    assert!(
        (after_1_s - 1.0).abs() < 1e-5 && (rise - 0.05).abs() < 0.005,
        "{rise}"
    );
}

#[test]
fn drift_is_a_ramp_with_start_and_limit() {
    let model = SensorModel {
        drift: Some(DriftModel {
            rate_n_s: [0.41, -0.082, 0.0],
            limit_n: 0.41,
            from_s: 0.5,
        }),
        ..ideal()
    };
    let mut bench = Bench::new(&model);
    for tick in 0..3000 {
        let since_s = (f64::from(tick) * PERIOD_S - 0.5).max(0.0);
        let expected_n = [
            (0.01 * since_s).min(0.01),
            (-0.002 * since_s).max(-0.01),
            0.0,
        ];
        for reading_n in bench.read(0.0) {
            for (n, expected_n) in reading_n.into_iter().zip(expected_n) {
                assert!(
                    (f64::from(n) - expected_n).abs() < 2e-6,
                    "{tick}: {n} {expected_n}"
                );
            }
        }
    }
}

#[test]
fn dead_elements_read_zero_or_their_last_value() {
    for (reading, expected_n) in [(DeadReading::Zero, 0.0), (DeadReading::Last, 0.7)] {
        let dead = DeadModel {
            share: 0.3,
            reading,
            from_s: 0.01,
        };
        let mut bench = Bench::new(&SensorModel {
            dead: Some(dead),
            ..ideal()
        });
        let failed = |readings: Vec<[f32; AXES]>, alive_n: f64| {
            let is_alive = |n: f32| (f64::from(n) - alive_n).abs() < 1e-6;
            let failed = readings.iter().filter(|[n, ..]| !is_alive(*n));
            failed.clone().for_each(|[n, ..]| {
                assert!((f64::from(*n) - expected_n).abs() < 1e-6, "{n}");
            });
            failed.count()
        };
        assert_eq!(
            (0..10).map(|_| failed(bench.read(0.7), 0.7)).sum::<usize>(),
            0
        );
        bench.read(0.7);
        let count = failed(bench.read(1.5), 1.5);
        assert!(
            (5..20).contains(&count),
            "{count} of 41 for a probability of 0.3"
        );
        assert_eq!(failed(bench.read(2.5), 2.5), count);
    }
}

#[test]
fn wear_reduces_the_gain_with_use() {
    let wear = WearModel {
        loss: 0.1,
        loss_per_n_s: 0.01,
        loss_max: 0.3,
    };
    let mut bench = Bench::new(&SensorModel {
        wear: Some(wear),
        ..ideal()
    });
    assert!((bench.normal_n(2.0, 1) - 1.8).abs() < 1e-4, "new");
    // Impulse of 2 N for 4.999 s more: 10 N·s.
    assert!((bench.normal_n(2.0, 4999) - 1.6).abs() < 1e-4, "used");
    assert!((bench.normal_n(2.0, 20_000) - 1.4).abs() < 1e-4, "limit");
    assert!(bench.normal_n(-2.0, 1) < -1.39, "a pull adds no wear");
}

#[test]
fn unused_effects_keep_every_bit() {
    let off = SensorModel {
        hysteresis: Some(HysteresisModel {
            share: 0.0,
            full_scale_n: [1.0; 2],
        }),
        creep: Some(CreepModel { per_decade: 0.0 }),
        drift: Some(DriftModel {
            rate_n_s: [0.0; 3],
            limit_n: 1.0,
            from_s: 0.0,
        }),
        dead: Some(DeadModel {
            share: 0.0,
            reading: DeadReading::Zero,
            from_s: 0.0,
        }),
        wear: Some(WearModel::default()),
        ..SensorModel::default()
    };
    let (mut plain, mut with_off) = (Bench::new(&SensorModel::default()), Bench::new(&off));
    for tick in 0..200 {
        let force_n = f64::from(tick % 17) * 0.1;
        assert_eq!(plain.read(force_n), with_off.read(force_n));
    }
}

/// One effect must not change the draws of another: the noise stays the same.
#[test]
fn effects_do_not_change_the_noise_draws() {
    let drifting = SensorModel {
        drift: Some(DriftModel {
            rate_n_s: [41.0, 0.0, 0.0],
            limit_n: 41.0,
            from_s: 0.0,
        }),
        dead: Some(DeadModel {
            share: 0.1,
            reading: DeadReading::Zero,
            from_s: 0.0,
        }),
        ..SensorModel::default()
    };
    let (mut plain, mut other) = (Bench::new(&SensorModel::default()), Bench::new(&drifting));
    for tick in 0..100 {
        let (plain_n, other_n) = (plain.read(0.5), other.read(0.5));
        for ([plain_n, ..], [other_n, ..]) in plain_n.into_iter().zip(other_n) {
            let drift_n = f64::from(other_n - plain_n);
            assert!(other_n == 0.0 || (drift_n - f64::from(tick) * 1e-3).abs() < 1.1e-3);
        }
    }
}

prop_compose! {
    fn any_model()(
        [crosstalk, gain_spread, dead, loss] in prop::array::uniform4(0.0..0.5_f64),
        share in 0.0..0.2_f64,
        per_decade in -0.2..0.5_f64,
        full_scale_n in prop::array::uniform2(1e-6..1e4_f64),
        rate_n_s in prop::array::uniform3(-100.0..100.0_f64),
        step_n in prop::array::uniform2(1e-6..10.0_f64),
        saturation_n in prop::option::of(prop::array::uniform2(1e-6..1e4_f64)),
    ) -> SensorModel {
        SensorModel {
            crosstalk,
            gain_spread,
            step_n,
            saturation_n,
            hysteresis: Some(HysteresisModel { share, full_scale_n }),
            creep: Some(CreepModel { per_decade }),
            drift: Some(DriftModel { rate_n_s, limit_n: 5.0, from_s: 0.0 }),
            dead: Some(DeadModel { share: dead, reading: DeadReading::Last, from_s: 0.01 }),
            wear: Some(WearModel { loss, loss_per_n_s: loss, loss_max: 0.9 }),
            ..SensorModel::default()
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]
    #[test]
    fn readings_stay_finite_and_bounded(
        model in any_model(),
        forces_n in prop::collection::vec(-1e3..1e3_f64, 1..50),
    ) {
        let mut bench = Bench::new(&model);
        let most_n = forces_n.iter().fold(0.0_f64, |most, n| most.max(n.abs()));
        for force_n in forces_n {
            for reading_n in bench.read(force_n) {
                for (axis, n) in reading_n.into_iter().enumerate() {
                    prop_assert!(n.is_finite());
                    let (n, pair) = (f64::from(n.abs()), axis.min(1));
                    let limit_n = model.saturation_n.map_or(f64::INFINITY, |of| of[pair]);
                    prop_assert!(n <= limit_n + model.step_n[pair]);
                    // Gain up to 1 + 6·spread, crosstalk of three axes, creep and hysteresis.
                    prop_assert!(n <= 40.0 * most_n + 10.0 + model.step_n[pair]);
                }
            }
        }
    }
}
