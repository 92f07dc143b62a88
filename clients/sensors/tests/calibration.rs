//! Calibration: fits to presses with known forces, files, rejection of invalid ones.

use atas_sensors::calibration::{
    Calibration, Drift, FitError, Model, Point, Press, Quality, Silence, Thresholds,
    UnloadedRecording, fit, fit_block, measure_silence, total_n,
};
use atas_sensors::plan::Plan;
use atas_sensors::reading::Quantity;
use proptest::prelude::*;
use shm_schemas::Layout;
use shm_schemas::capacity::ELEMENTS;

/// Numbers from −1 to 1 (SplitMix64).
struct Draw(u64);

impl Draw {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }
}

/// Counts per newton of one dome with swapped and turned axes and 8 % crosstalk.
const COUNTS_PER_N: [[f64; 3]; 3] = [[3.0, 25.0, 2.0], [-1.5, 2.2, 30.0], [-60.0, 3.0, 4.0]];
const ZERO: [f64; 3] = [120.0, -35.0, 7.0];

fn dome(force_n: [f64; 3], noise: f64, draw: &mut Draw) -> Vec<f64> {
    let row = |row: usize| -> f64 { (0..3).map(|k| COUNTS_PER_N[row][k] * force_n[k]).sum() };
    (0..3)
        .map(|axis| ZERO[axis] + row(axis) + noise * draw.next())
        .collect()
}

/// Five magnetometers with a nonlinear flux.
fn skin(force_n: [f64; 3], noise: f64, draw: &mut Draw) -> Vec<f64> {
    let [n, a, b] = force_n;
    let magnet = |m: usize| {
        let m = m as f64;
        let bent = n / (1.0 + 0.04 * n);
        [
            40.0 * a + 6.0 * m * n + 4.0 * b,
            -35.0 * b + 5.0 * (m - 2.0) * n,
            -90.0 * bent - 8.0 * m * a,
        ]
    };
    (0..5)
        .flat_map(magnet)
        .map(|flux| flux + noise * draw.next())
        .collect()
}

fn bench(
    of: impl Fn([f64; 3], f64, &mut Draw) -> Vec<f64>,
    noise: f64,
) -> (Vec<Press>, Silence, Vec<Vec<f64>>) {
    let mut draw = Draw(3);
    let quiet: Vec<Vec<f64>> = (0..400).map(|_| of([0.0; 3], noise, &mut draw)).collect();
    let press = |draw: &mut Draw| {
        let direction = [
            3.0 + 2.5 * draw.next(),
            2.0 * draw.next(),
            2.0 * draw.next(),
        ];
        let points = (1..=30).map(|step| {
            let force_n = direction.map(|n| n * f64::from(step) / 30.0);
            let values = of(force_n, noise, draw);
            Point { values, force_n }
        });
        Press {
            points: points.collect(),
        }
    };
    let presses = (0..40).map(|_| press(&mut draw)).collect();
    let silence = measure_silence(&quiet).expect("enough frames");
    (presses, silence, quiet)
}

fn dome_1() -> Layout {
    Layout::from_name("dome-1").expect("a layout")
}

#[test]
fn scale_axes_and_crosstalk_are_fitted_together() {
    let (presses, silence, quiet) = bench(dome, 1.0);
    for (zero, expected) in silence.zero.iter().zip(ZERO) {
        assert!((zero - expected).abs() < 0.15, "{zero} {expected}");
    }
    let fitted = fit(&presses, &silence, Model::Matrix, &dome_1(), "a bench").expect("a fit");
    let calibration = &fitted.calibration;
    assert!(
        calibration.quality.error_n.iter().all(|n| *n < 0.04),
        "{:?}",
        calibration.quality
    );
    let mut draw = Draw(99);
    for force_n in [[5.0, 0.0, 0.0], [2.0, 1.0, -0.5], [0.3, 0.0, 0.3]] {
        let told_n = total_n(calibration, &dome_1(), &dome(force_n, 0.0, &mut draw));
        for (told_n, known_n) in told_n.iter().zip(force_n) {
            assert!((told_n - known_n).abs() < 0.02, "{told_n} {known_n}");
        }
    }
    // Noise of ±1 count of 60 per newton is 10 mN; eight of them begin a touch.
    let thresholds =
        Thresholds::from_recording(calibration, &quiet, 4.0, 8.0).expect("enough frames");
    assert!(
        (0.05..0.2).contains(&thresholds.touch_on_n),
        "{thresholds:?}"
    );
    assert!(
        thresholds.touch_off_n < thresholds.touch_on_n,
        "{thresholds:?}"
    );
}

#[test]
fn quadratic_fit_converts_flux_better() {
    let (presses, silence, _) = bench(skin, 0.5);
    let error_n = |model: Model| {
        let fitted = fit(&presses, &silence, model, &dome_1(), "a bench").expect("a fit");
        assert_eq!(
            (
                fitted.calibration.elements_in(),
                fitted.calibration.elements_out()
            ),
            (5, 1)
        );
        fitted.calibration.quality.error_n[0]
    };
    let (linear_n, squares_n) = (error_n(Model::Resultant), error_n(Model::ResultantSquares));
    assert!(
        squares_n < 0.03 && squares_n < 0.5 * linear_n,
        "{squares_n} {linear_n}"
    );
}

/// Presses differ in position: each value of each press has a different error of a few per cent.
#[test]
fn fit_ignores_differences_between_press_positions() {
    let error_n = |placed: f64, ridges: core::ops::RangeInclusive<f64>| {
        let (mut presses, silence, _) = bench(skin, 0.5);
        let mut draw = Draw(31);
        for press in &mut presses {
            let off: Vec<f64> = (0..15).map(|_| 1.0 + placed * draw.next()).collect();
            for point in &mut press.points {
                let values = point.values.iter_mut().zip(&off);
                values.for_each(|(value, off)| *value *= off);
            }
        }
        let layout = dome_1();
        let fitted = fit(&presses, &silence, Model::ResultantSquares, &layout, "").expect("a fit");
        let quality = fitted.calibration.quality;
        let ridge = quality.ridge.expect("a resultant has one");
        assert!(ridges.contains(&ridge), "{placed}: {quality:?}");
        let again = fit(&presses, &silence, Model::ResultantSquares, &layout, "").expect("a fit");
        assert_eq!(again.calibration, fitted.calibration);
        quality.error_n[0]
    };
    let exact_n = error_n(0.0, 1e-7..=1e-4);
    assert!(exact_n < 0.01, "{exact_n}");
    let placed_n = error_n(0.05, 1e-4..=1e-1);
    // With 1e-7 every press reads 0.08 N.
    assert!(placed_n < 0.06, "{placed_n}");
}

#[test]
fn calibration_file_reads_back_or_is_rejected() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("tip.toml");
    let (presses, silence, _) = bench(dome, 1.0);
    let calibration = fit(&presses, &silence, Model::Matrix, &dome_1(), "a bench")
        .expect("a fit")
        .calibration;
    calibration.save(&path).expect("saved");
    assert_eq!(Calibration::open(&path).expect("read"), calibration);
    assert!(
        calibration.save(&path).is_err(),
        "a calibration overwrote a file"
    );
    let text = std::fs::read_to_string(&path).expect("text");
    let check = |from: &str, to: &str, part: &str| {
        assert!(text.contains(from), "{from:?} is not in {text}");
        std::fs::write(&path, text.replacen(from, to, 1)).expect("written");
        let error = Calibration::open(&path).expect_err(part).to_string();
        assert!(error.contains(part), "{error}");
    };
    check("format = 1", "format = 2", "calibrate again");
    check("zero = [", "zero = [1.0, ", "needs 3 per element");
    check("newtons = [[[", "newtons = [[[nan, ", "rows of 3 numbers");
    check("model = \"matrix\"", "model = \"guess\"", "guess");
    check("source", "sauce", "sauce");
}

#[test]
fn insufficient_presses_are_rejected_with_the_reason() {
    let (presses, silence, _) = bench(dome, 1.0);
    let check = |presses: &[Press], layout: &str, part: &str| {
        let layout = Layout::from_name(layout).expect("a layout");
        let error = fit(presses, &silence, Model::Matrix, &layout, "").expect_err(part);
        assert!(error.to_string().contains(part), "{error}");
    };
    check(&presses[..4], "dome-1", "5 or more");
    check(&presses, "pad-2", "needs 6");
    let still = |keep: usize| {
        let mut draw = Draw(5);
        let mut press = Press::default();
        for step in 1..20 {
            let mut force_n = [0.0; 3];
            force_n[keep] = f64::from(step) * 0.1;
            let values = dome(force_n, 0.0, &mut draw);
            press.points.push(Point { values, force_n });
        }
        press
    };
    check(&vec![still(0); 6], "dome-1", "could not determine all axes");
    let mut broken = presses.clone();
    broken[7].points[0].values[1] = f64::NAN;
    check(&broken, "dome-1", "press 7");
    assert_eq!(
        fit(&[], &silence, Model::Matrix, &dome_1(), "").expect_err("none"),
        FitError::TooFewPresses(0)
    );
}

/// Two elements in newtons: warmth moves the first, time the second, 25 frames a second.
fn quiet(seconds: usize, n_k: f64, n_min: f64, swing_k: f64) -> UnloadedRecording {
    let mut draw = Draw(17);
    let mut quiet = UnloadedRecording::default();
    for frame in 0..25 * seconds {
        let at_s = frame as f64 / 25.0;
        // Complete periods, which do not look like drift.
        let warmth_k = swing_k / 2.0 * (core::f64::consts::TAU * at_s / 20.0).cos();
        let mut noise = || 0.01 * draw.next();
        let first = [
            n_k * warmth_k + noise(),
            noise(),
            -0.5 * n_k * warmth_k + noise(),
        ];
        let second = [noise(), n_min * at_s / 60.0 + noise(), noise()];
        quiet.frames.push([first, second].concat());
        quiet.times_s.push(at_s);
        quiet.temperatures_c.push(25.0 + warmth_k);
    }
    quiet
}

#[test]
fn drift_is_reported_per_element_and_per_kelvin() {
    let unit = |axis: usize| (0..3).map(|k| f64::from(k == axis)).collect();
    let mut calibration = Calibration {
        format: 1,
        source: "newtons".to_owned(),
        model: Model::Matrix,
        zero: vec![0.0; 6],
        newtons: vec![[unit(0), unit(1), unit(2)], [unit(0), unit(1), unit(2)]],
        quality: Quality::default(),
        drift: None,
    };
    let near = |found: f64, expected: f64, by: f64| {
        assert!((found - expected).abs() <= by, "{found} {expected}");
    };
    for (n_k, n_min) in [(0.03, 0.05), (-0.2, 0.0), (0.0, 0.4), (0.0, 0.0)] {
        let drift =
            Drift::from_recording(&calibration, &quiet(120, n_k, n_min, 4.0)).expect("long enough");
        near(drift.watched_s, 120.0, 0.1);
        near(drift.element_n_min[0], 0.0, 2e-3 + 0.01 * n_k.abs());
        near(drift.element_n_min[1], n_min, 2e-3);
        let warmth = drift.warmth.as_ref().expect("it warmed");
        near(warmth.span_k, 4.0, 1e-3);
        for (axis, expected) in [n_k, 0.0, -0.5 * n_k].into_iter().enumerate() {
            near(warmth.element_n_k[0][axis], expected, 1e-3);
            near(warmth.total_n_k[axis], expected, 1e-3 + 0.01 * n_min);
        }
        near(warmth.largest_total_n_k(), n_k.abs(), 1e-3 + 0.01 * n_min);
        if n_min > 0.0 {
            assert_eq!(drift.worst().0, 1);
        }
        // Text for users, next to the numbers.
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("tip.toml");
        calibration.drift = Some(drift);
        calibration.save(&path).expect("saved");
        assert_eq!(Calibration::open(&path).expect("read"), calibration);
        let text = std::fs::read_to_string(&path).expect("text");
        let broken = text.replacen("watched_s = ", "watched_s = nan # ", 1);
        std::fs::write(&path, broken).expect("written");
        let error = Calibration::open(&path).expect_err("no number").to_string();
        assert!(error.contains("not finite"), "{error}");
    }
    let of = |quiet: &UnloadedRecording| Drift::from_recording(&calibration, quiet);
    assert!(
        of(&quiet(120, 0.1, 0.0, 0.4))
            .expect("long enough")
            .warmth
            .is_none()
    );
    let unknown = UnloadedRecording {
        temperatures_c: Vec::new(),
        ..quiet(120, 0.1, 0.0, 4.0)
    };
    assert!(of(&unknown).expect("long enough").warmth.is_none());
    assert!(of(&quiet(1, 0.1, 0.0, 4.0)).is_none());
}

#[test]
fn rigid_block_gives_fingertip_compression() {
    let mut draw = Draw(11);
    for (compression_m, exponent) in [(0.00044, 0.48), (0.0002, 1.0), (0.001, 0.33)] {
        let points: Vec<(f64, f64)> = (0..300)
            .map(|i| {
                let force_n = 0.1 + 0.02 * f64::from(i);
                (
                    0.02 + 2.0 * compression_m * force_n.powf(exponent) + 1e-6 * draw.next(),
                    force_n,
                )
            })
            .collect();
        let block = fit_block(&points, 0.1, 2).expect("a compression");
        assert!(
            (block.tip_compression_m / compression_m - 1.0).abs() < 0.03,
            "{block:?}"
        );
        assert!((block.tip_exponent - exponent).abs() < 0.02, "{block:?}");
    }
    assert_eq!(fit_block(&[(0.0, 1.0); 5], 0.1, 2), None);
    assert_eq!(fit_block(&[(f64::NAN, 1.0); 50], 0.1, 2), None);
    assert_eq!(fit_block(&[(0.01, 1.0); 50], 0.1, 2), None);
}

/// Frames that `atas-sensor hand FILE` publishes with such a calibration.
#[test]
fn sensor_process_applies_only_its_calibration() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("tip.toml");
    let (presses, silence, _) = bench(dome, 1.0);
    let fitted = fit(&presses, &silence, Model::Matrix, &dome_1(), "a bench").expect("a fit");
    fitted.calibration.save(&path).expect("saved");
    let plan = |sensor: &str, calibrations: &str| {
        Plan::from_toml(&format!(
            "hand = \"left\"\n[[port]]\nsensor = \"{sensor}\"\ndevice = \"/dev/null\"\ncalibration = {calibrations}\n"
        ))
        .map_err(|failure| failure.to_string())
    };
    let tip = format!("{:?}", path.display().to_string());
    let seats = plan("optoforce", &tip).expect("a plan").slots();
    let mut forces_n = [[0.0; 3]; ELEMENTS];
    let values = dome([2.0, 0.5, -0.3], 0.0, &mut Draw(1));
    let count = seats[0]
        .newtons
        .write(0, Quantity::Force, &values, &mut forces_n);
    assert_eq!(count, 1);
    for (told_n, known_n) in forces_n[0].iter().zip([2.0, 0.5, -0.3]) {
        assert!((told_n - known_n).abs() < 0.02, "{told_n} {known_n}");
    }
    let check = |sensor: &str, calibrations: &str, part: &str| {
        let error = plan(sensor, calibrations).err().unwrap_or_default();
        assert!(error.contains(part), "{error}");
    };
    check("anyskin", &tip, "the sensor has 5");
    check("optoforce", "\"no/such.toml\"", "no/such.toml");
    check("optoforce", &format!("[{tip}, {tip}]"), "left over");
}

proptest! {
    #[test]
    fn any_device_output_is_survived(values in prop::collection::vec(any::<f64>(), 0..20)) {
        let (presses, silence, _) = bench(dome, 1.0);
        let fitted = fit(&presses[..6], &silence, Model::Matrix, &dome_1(), "").expect("a fit");
        let force_n = fitted.calibration.force_n(0, &values);
        if values.len() < 3 {
            prop_assert!(force_n.iter().all(|n| n.is_nan()), "{force_n:?}");
        } else if values[..3].iter().all(|value| value.abs() < 1e100) {
            prop_assert!(force_n.iter().all(|n| n.is_finite()), "{force_n:?}");
        }
    }
}
