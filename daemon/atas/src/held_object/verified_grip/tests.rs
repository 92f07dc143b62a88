//! Tests of the verified grip, some against its equations in plain arithmetic.

use super::*;
use crate::perception::ContactPercept;

/// Holds a load of 2 N for one second at this force per side, of which the drift is `drift_n`.
fn hold(grip: &mut GripVerification, normal_n: f64, drift_n: f64) {
    for _ in 0..1000 {
        grip.update(&pressed([normal_n; 2], 1e-3), (2.0, drift_n), 0.05);
    }
}

/// Verifies a load of 2 N at 3 N and returns the unheld time after one second at `then_n`, of which
/// the drift is `drift_n`.
fn unheld_s(then_n: f64, drift_n: f64) -> f64 {
    let mut grip = GripVerification::default();
    hold(&mut grip, 3.0, 0.0);
    assert!(!grip.is_held(), "not verified yet");
    assert_eq!(grip.unheld_s(), f64::INFINITY, "not verified yet");
    grip.set_verified();
    assert!(grip.is_held());
    hold(&mut grip, then_n, drift_n);
    grip.unheld_s()
}

#[test]
fn verification_lapses_when_the_grip_weakens() {
    for (what, then_n, drift_n, lapses) in [
        ("same force", 3.0, 0.0, false),
        ("higher force", 5.0, 0.0, false),
        ("tremor", 2.9, 0.0, false),
        ("lower force", 2.5, 0.0, true),
        ("force hidden by drift", 1.5, -1.5, false),
        ("force made up by drift", 3.0, 0.5, true),
    ] {
        let unheld_s = unheld_s(then_n, drift_n);
        let expected_s = if lapses { 0.9..1.0 } else { 0.0..1e-9 };
        assert!(expected_s.contains(&unheld_s), "{what}: {unheld_s} s");
    }
}

/// Frame of one tick with these normal forces per side, N.
fn pressed(normal_n: [f64; 2], step_s: f64) -> Percept {
    let side = |normal_n| ContactPercept {
        normal_n,
        ..ContactPercept::default()
    };
    Percept {
        sides: normal_n.map(side).into(),
        step_s,
        ..Percept::default()
    }
}

/// The equations of the module header, for frames of 1 ms.
#[derive(Clone, Copy, Default)]
struct Reference {
    load_n: f64,
    normal_n: [f64; 2],
    mean_n: f64,
    scatter_n2: f64,
    ratio: Option<f64>,
    held_ratio: f64,
    speed_m_s: f64,
    slide_m: f64,
}

fn towards(before: f64, now: f64, filter_s: f64) -> f64 {
    (before * filter_s + now * 1e-3) / (filter_s + 1e-3)
}

impl Reference {
    fn total_n(&self) -> f64 {
        self.normal_n[0] + self.normal_n[1]
    }

    fn advance(&mut self, load_n: f64, normal_n: [f64; 2], is_verified: bool) {
        let filter_s = 0.004 * (1.0 + 0.3 / load_n.max(0.01));
        self.load_n = towards(self.load_n, load_n, filter_s);
        for (filtered_n, now_n) in self.normal_n.iter_mut().zip(normal_n) {
            *filtered_n = towards(*filtered_n, now_n, filter_s);
        }
        self.mean_n = towards(self.mean_n, self.load_n, 0.7);
        let off_n = self.load_n - self.mean_n;
        self.scatter_n2 = towards(self.scatter_n2, off_n * off_n, 0.7);
        let ratio = self.load_n / self.total_n().max(0.01);
        self.ratio = Some(towards(self.ratio.unwrap_or(ratio), ratio, 0.03));
        let carried_n = 1.05 * (self.held_ratio * self.total_n()).max(self.mean_n);
        let excess = 1.0 - carried_n / self.load_n.max(0.01);
        if is_verified && excess > 0.0 {
            self.speed_m_s += 9.81 * excess * 1e-3;
            self.slide_m += self.speed_m_s * 1e-3;
        } else {
            (self.speed_m_s, self.slide_m) = (0.0, 0.0);
        }
    }

    #[track_caller]
    fn check(&self, grip: &GripVerification, shown: Option<VerifiedGrip>) {
        let near = |a: f64, b: f64| assert!((a - b).abs() < 1e-10, "{a} instead of {b}");
        near(grip.load_ratio.unwrap(), self.ratio.unwrap());
        near(grip.overload_m(), self.slide_m);
        let Some(shown) = shown else { return };
        near(shown.load_n, self.load_n);
        near(shown.held_n, self.held_ratio * self.total_n());
        near(shown.mean_n, self.mean_n);
        near(shown.scatter_n, self.scatter_n2.sqrt());
        near(
            shown.normal_n[robot_model::GraspSide::First],
            self.normal_n[0],
        );
        near(
            shown.normal_n[robot_model::GraspSide::Second],
            self.normal_n[1],
        );
    }
}

#[test]
fn grip_follows_its_equations() {
    let (mut grip, mut reference) = (GripVerification::default(), Reference::default());
    let profile = [
        (300, 1.0, [2.0, 2.5]),
        (100, 1.1, [2.2, 2.4]),
        (80, 4.0, [2.2, 2.4]),
        (100, 1.0, [3.0, 2.0]),
        (50, 0.005, [3.0, 2.0]),
        (50, 2.0, [0.0, 0.001]),
    ];
    let mut slides = 0;
    for (phase, (ticks, load_n, normal_n)) in profile.into_iter().enumerate() {
        for _ in 0..ticks {
            let shown = grip.update(
                &pressed(normal_n, 1e-3),
                (load_n, 0.0),
                0.05 - 0.001 * phase as f64,
            );
            assert_eq!(shown.is_some(), phase > 0);
            reference.advance(load_n, normal_n, phase > 0);
            reference.check(&grip, shown);
            let closed_m = shown.map_or(0.0, |grip| grip.closed_m);
            assert!((closed_m - 0.001 * phase as f64).abs() < 1e-12);
            slides += usize::from(grip.overload_m() > 0.0);
        }
        if phase == 0 {
            grip.set_verified();
            reference.held_ratio = reference.load_n / reference.total_n();
        }
    }
    assert!(slides > 100, "{slides} ticks with an overload");
}

#[test]
fn verification_without_force_divides_by_the_smallest_force() {
    let mut grip = GripVerification::default();
    grip.update(&pressed([0.0; 2], 1e3), (1.0, 0.0), 0.05);
    grip.set_verified();
    let expected = grip.load_n / NORMAL_MIN_N;
    assert_eq!(grip.held_ratio, Some(expected));
}

#[test]
fn forgotten_grip_forgets_its_slide() {
    let mut grip = GripVerification::default();
    let hold = |grip: &mut GripVerification, load_n: f64| {
        for _ in 0..100 {
            grip.update(&pressed([2.0; 2], 1e-3), (load_n, 0.0), 0.05);
        }
        grip.overload_m()
    };
    hold(&mut grip, 1.0);
    grip.set_verified();
    assert!(hold(&mut grip, 9.0) > 0.0);
    grip.forget();
    assert_eq!(hold(&mut grip, 9.0), 0.0);
    assert!(!grip.is_held());
}

/// A found grip holds the largest ratio of its first 150 ms.
#[test]
fn found_grip_is_measured_at_first() {
    let mut grip = GripVerification::for_found_grip();
    assert_eq!(grip.unheld_s(), 0.0);
    let step = |grip: &mut GripVerification, load_n: f64| {
        grip.update(&pressed([1.0; 2], MEASURING_S / 2.0), (load_n, 0.0), 0.05);
        grip.held_ratio.unwrap()
    };
    let ratios = [1.0, 2.0, 9.0, 9.0].map(|load_n| step(&mut grip, load_n));
    assert!(ratios[0] > 0.0 && ratios[1] > ratios[0], "{ratios:?}");
    assert_eq!(ratios[2..], [ratios[1]; 2], "{ratios:?}");
    assert!(!grip.is_held() && grip.unheld_s() > 0.0);
}
