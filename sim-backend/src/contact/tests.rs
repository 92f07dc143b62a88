//! Contact model against the reference values of the tactile design.

use super::*;
use crate::pad::{BRISTLES_PER_ELEMENT, FOUNDATION_N_M3};
use shm_schemas::capacity::ELEMENTS;
use shm_schemas::layout::{DOME_RADIUS_M, NamedLayout};

const DT_S: f64 = 250e-6;
const HALF_M: f64 = 0.025;

/// Fingertip that presses along +x on the −x face of a cube.
struct Bench {
    pad: Pad,
    contact: Contact,
    /// Distance from the tip frame's origin to the skin, m.
    radius_m: f64,
    surface: Surface,
}

impl Bench {
    fn new(bristles_per_element: usize, stiffness_n_m: f64) -> Self {
        Self::from_pad(
            Pad::dome(DOME_RADIUS_M, bristles_per_element),
            stiffness_n_m,
        )
    }

    fn from_layout_name(layout: &str) -> Self {
        let layout: NamedLayout = layout.parse().expect("layout name");
        let pad =
            Pad::from_layout(layout, layout.depth_m()).expect("layout with element positions");
        Self {
            radius_m: layout.depth_m(),
            ..Self::from_pad(pad, f64::INFINITY)
        }
    }

    fn from_pad(pad: Pad, stiffness_n_m: f64) -> Self {
        let shape = Shape::Box {
            half_m: Vector3::repeat(HALF_M),
        };
        Self {
            radius_m: DOME_RADIUS_M,
            contact: Contact::new(&pad),
            pad,
            surface: Surface {
                shape,
                friction: 0.5,
                mass_kg: 0.3,
                stiffness_n_m,
            },
        }
    }

    /// Simulates one step at this indentation and height with this upward speed; returns (normal,
    /// tangential) force.
    fn press(&mut self, depth_m: f64, height_m: f64, up_m_s: f64) -> (f64, f64) {
        let approach = Approach {
            // Dome axis z along the cube's x; −x of the tip along the cube's z.
            object_from_tip: Matrix3::new(0.0, 0.0, 1.0, 0.0, 1.0, 0.0, -1.0, 0.0, 0.0),
            centre_m: Vector3::new(-HALF_M - self.radius_m + depth_m, 0.0, height_m),
            velocity_m_s: Vector3::new(0.0, 0.0, up_m_s),
            angular_rad_s: Vector3::zeros(),
        };
        let wrench = self
            .contact
            .press(&self.pad, &self.surface, &approach, DT_S);
        (wrench.force_n.x, wrench.force_n.z)
    }

    fn normal_n(&mut self, depth_m: f64) -> f64 {
        self.press(depth_m, 0.0, 0.0).0
    }

    /// Returns the number of touching elements, and of those with at least half of the bristles
    /// slipping.
    fn elements(&self) -> (usize, usize) {
        let mut touching = [0; ELEMENTS];
        let mut slipping = [0; ELEMENTS];
        for patch in &self.contact.patches {
            let bristles = &self.contact.block_states[patch.block].bristles;
            for lane in patch.touching {
                let element = self.pad.element_of(patch.block, lane);
                touching[element] += 1;
                slipping[element] += usize::from(bristles.slipping(lane));
            }
        }
        let slips = |e: &usize| touching[*e] > 0 && 2 * slipping[*e] >= touching[*e];
        (
            touching.iter().filter(|n| **n > 0).count(),
            (0..ELEMENTS).filter(slips).count(),
        )
    }
}

#[test]
fn force_over_indentation_matches_the_design() {
    for (depth_m, expected_n) in [
        (0.2e-3, 0.25),
        (0.3e-3, 0.60),
        (0.5e-3, 1.84),
        (0.8e-3, 4.65),
    ] {
        let force_n = Bench::new(BRISTLES_PER_ELEMENT, f64::INFINITY).normal_n(depth_m);
        let error = force_n / expected_n - 1.0;
        assert!(
            error.abs() < 0.025,
            "{depth_m} m: {force_n} N, design {expected_n} N"
        );
    }
}

/// Tactile design: at 0.5 mm and μ = 0.5 the outer ring slips from 0.15 mm of shear; gross slip
/// begins at 0.35 mm.
#[test]
fn outer_elements_slip_first() {
    let mut bench = Bench::new(BRISTLES_PER_ELEMENT, f64::INFINITY);
    let speed_m_s = 0.002;
    for (shear_m, expected) in [
        (0.10e-3, (8, 0)),
        (0.15e-3, (8, 7)),
        (0.30e-3, (8, 7)),
        (0.35e-3, (8, 8)),
    ] {
        let steps = (shear_m / (speed_m_s * DT_S)).round() as u64 + 1 - bench.contact.step;
        for _ in 0..steps {
            let height_m = bench.contact.step as f64 * speed_m_s * DT_S;
            bench.press(0.5e-3, height_m, speed_m_s);
        }
        assert_eq!(
            bench.elements(),
            expected,
            "touching and slipping elements at {shear_m} m of shear"
        );
    }
}

/// Covers bristles that stick, slide, lift off and return, on all faces, soft and rigid.
#[test]
fn every_instruction_set_gives_the_same_bits() {
    let (radius_m, half_height_m) = (HALF_M, HALF_M);
    let shapes = [
        Shape::Box {
            half_m: Vector3::repeat(HALF_M),
        },
        Shape::Cylinder {
            radius_m,
            half_height_m,
        },
    ];
    for shape in shapes {
        for stiffness_n_m in [f64::INFINITY, 1500.0] {
            let mut bench = Bench::new(BRISTLES_PER_ELEMENT, stiffness_n_m);
            bench.surface.shape = shape;
            let mut other = bench.contact.clone();
            let mut touched = 0;
            for step in 0..800 {
                let t_s = f64::from(step) * DT_S;
                let depth_m = 4e-4 + 5e-4 * libm::sin(40.0 * t_s);
                let approach = Approach {
                    object_from_tip: Matrix3::new(0.0, 0.0, 1.0, 0.0, 1.0, 0.0, -1.0, 0.0, 0.0),
                    centre_m: Vector3::new(
                        -HALF_M - DOME_RADIUS_M + depth_m,
                        0.004 * libm::sin(15.0 * t_s),
                        0.02 + 0.05 * t_s,
                    ),
                    velocity_m_s: Vector3::new(0.02 * libm::cos(40.0 * t_s), 0.01, 0.05),
                    angular_rad_s: Vector3::new(0.3, -0.2, 0.1),
                };
                let wrench = bench
                    .contact
                    .press(&bench.pad, &bench.surface, &approach, DT_S);
                let portable = other.press_in::<portable::Numbers>(
                    (),
                    &bench.pad,
                    &bench.surface,
                    &approach,
                    DT_S,
                );
                assert_eq!(wrench, portable, "{shape:?} {stiffness_n_m} step {step}");
                assert_eq!(bench.contact.slip_m.to_bits(), other.slip_m.to_bits());
                touched += usize::from(bench.contact.is_touching());
            }
            assert!((300..800).contains(&touched), "{shape:?}: {touched}");
            assert!(bench.contact.slip_m > 1e-3, "{shape:?}");
        }
    }
}

#[test]
fn gross_slip_has_kinetic_friction() {
    let mut bench = Bench::new(BRISTLES_PER_ELEMENT, f64::INFINITY);
    let speed_m_s = 0.01;
    let forces =
        (1..1000).map(|step| bench.press(0.5e-3, f64::from(step) * speed_m_s * DT_S, speed_m_s));
    let (normal_n, tangential_n) = forces.last().unwrap_or_default();
    assert!(
        (tangential_n / normal_n - 0.9 * 0.5).abs() < 1e-3,
        "{tangential_n} over {normal_n}"
    );
    // 2.5 mm of travel; the difference is shear of the skin.
    assert!(
        (bench.contact.slip_m - 2.2e-3).abs() < 0.1e-3,
        "slipped {} m",
        bench.contact.slip_m
    );
}

#[test]
fn slip_counts_from_zero_in_a_new_grasp() {
    let mut bench = Bench::new(BRISTLES_PER_ELEMENT, f64::INFINITY);
    for step in 0..1000 {
        bench.press(0.5e-3, f64::from(step) * 2.5e-6, 0.01);
    }
    bench.press(-1e-3, 0.0, 0.0);
    bench.press(0.5e-3, 0.0, 0.0);
    assert!(
        bench.contact.slip_m > 1e-3,
        "a bounce continues the same grasp"
    );
    (0..201).for_each(|_| _ = bench.press(-1e-3, 0.0, 0.0));
    bench.press(0.5e-3, 0.0, 0.0);
    assert_eq!(bench.contact.slip_m, 0.0);
}

/// Checks the slope of force over total closing in the 100 ms after first touch, both fingers
/// closing at 2 mm/s through 5 kN/m. One bristle per element gives a wrong slope (tactile design:
/// 524 instead of 844 N/m).
#[test]
fn one_bristle_per_element_is_too_soft() {
    let (coarse, fine) = (probe_slope_n_m(1), probe_slope_n_m(BRISTLES_PER_ELEMENT));
    assert!(
        (0.55..0.70).contains(&(coarse / fine)),
        "{coarse} and {fine} N/m"
    );
}

fn probe_slope_n_m(bristles_per_element: usize) -> f64 {
    const FINGER_N_M: f64 = 5000.0;
    let mut bench = Bench::new(bristles_per_element, f64::INFINITY);
    let mut force_n = |closed_m: f64| {
        let (mut low_m, mut high_m) = (0.0, closed_m);
        for _ in 0..40 {
            let depth_m = 0.5 * (low_m + high_m);
            let too_deep = bench.normal_n(depth_m) > FINGER_N_M * (closed_m - depth_m);
            if too_deep {
                high_m = depth_m
            } else {
                low_m = depth_m
            }
        }
        FINGER_N_M * (closed_m - low_m)
    };
    let path = (1..2000).map(|tick| f64::from(tick) * 2e-6);
    let points: Vec<(f64, f64)> = path
        .map(|closed_m| (2.0 * closed_m, force_n(closed_m)))
        .skip_while(|(_, n)| *n < 0.06)
        .take(100)
        .collect();
    let mean =
        |of: &dyn Fn(&(f64, f64)) -> f64| points.iter().map(of).sum::<f64>() / points.len() as f64;
    let (x, y) = (mean(&|p| p.0), mean(&|p| p.1));
    mean(&|p| (p.0 - x) * (p.1 - y)) / mean(&|p| (p.0 - x) * (p.0 - x))
}

/// At rest, skin and object are springs in series.
#[test]
fn soft_object_and_skin_share_the_indentation() {
    for stiffness_n_m in [400.0, 1500.0, 3e4] {
        let mut bench = Bench::new(BRISTLES_PER_ELEMENT, stiffness_n_m);
        let force_n = (0..2000)
            .map(|_| bench.normal_n(1e-3))
            .last()
            .unwrap_or_default();
        let compression_m = bench.contact.compression.depth_m;
        assert!(
            (force_n / (stiffness_n_m * compression_m) - 1.0).abs() < 1e-6,
            "{force_n} N, {compression_m} m"
        );
        let skin_n = Bench::new(BRISTLES_PER_ELEMENT, f64::INFINITY).normal_n(1e-3 - compression_m);
        assert!(
            (force_n / skin_n - 1.0).abs() < 1e-6,
            "{force_n} N, skin {skin_n} N"
        );
    }
}

#[test]
fn element_forces_sum_to_the_total() {
    let mut bench = Bench::new(BRISTLES_PER_ELEMENT, f64::INFINITY);
    let mut total = (0.0, 0.0);
    for step in 1..200 {
        total = bench.press(0.5e-3, f64::from(step) * 5e-7, 0.002);
    }
    let mut force_n = [Vector3::zeros(); ELEMENTS];
    bench.contact.element_forces(&bench.pad, &mut force_n);
    let sum: Vector3<f64> = force_n.iter().sum();
    // The tip's normal force is opposite to the dome axis z; upward friction on the object is +x on
    // the tip.
    assert!(
        (sum.z + total.0).abs() < 1e-12 && (sum.x - total.1).abs() < 1e-12,
        "{sum} and {total:?}"
    );
}

#[test]
fn nothing_touches_beyond_an_edge() {
    let mut bench = Bench::new(BRISTLES_PER_ELEMENT, f64::INFINITY);
    let whole_n = bench.press(0.5e-3, 0.0, 0.0).0;
    let half_n = bench.press(0.5e-3, HALF_M, 0.0).0;
    assert!(
        (half_n / whole_n - 0.5).abs() < 0.1,
        "on the edge {half_n} N of {whole_n} N"
    );
    assert_eq!(bench.press(0.5e-3, HALF_M + 5e-3, 0.0).0, 0.0);
}

/// Rigid flat face: F = K·A·δ for a flat pad of area A, F = (4/3)·K·L·√(2R)·δ^1.5 for a cylinder of
/// length L and radius R.
#[test]
fn pad_and_cylinder_forces_match_their_shape() {
    let flat_n = |area_m2: f64| move |depth_m: f64| FOUNDATION_N_M3 * area_m2 * depth_m;
    let cylinder_n = |length_m: f64, radius_m: f64| {
        move |depth_m: f64| {
            FOUNDATION_N_M3 * length_m * 4.0 / 3.0 * (2.0 * radius_m).sqrt() * depth_m.powf(1.5)
        }
    };
    let check = |layout: &str, expected_n: &dyn Fn(f64) -> f64, tolerance: f64| {
        for depth_m in [1e-4, 2e-4, 4e-4] {
            let normal_n = Bench::from_layout_name(layout).normal_n(depth_m);
            let expected_n = expected_n(depth_m);
            assert!(
                (normal_n / expected_n - 1.0).abs() < tolerance,
                "{layout} at {depth_m} m: {normal_n} N, expected {expected_n}"
            );
        }
    };
    check("flat-4x4-4.5", &flat_n(0.018 * 0.018), 1e-9);
    check("flat-2x3-4", &flat_n(0.008 * 0.012), 1e-9);
    // Bristles are 1 mm apart, and the patch is a few bristles wide.
    check("cylinder-4x8-3-12", &cylinder_n(0.012, 0.012), 0.12);
    check("cylinder-2x4-6-40", &cylinder_n(0.012, 0.040), 0.12);
}

/// A pad whose lower half is below the cube reads forces on its upper half only; one element of a
/// one-element dome reads the sum of all.
#[test]
fn elements_read_only_their_own_area() {
    let felt_n = |layout: &str, height_m: f64| {
        let mut bench = Bench::from_layout_name(layout);
        bench.press(3e-4, height_m, 0.0);
        let mut force_n = [Vector3::zeros(); ELEMENTS];
        bench.contact.element_forces(&bench.pad, &mut force_n);
        force_n.map(|force_n| -force_n.z)
    };
    let pad_n = felt_n("flat-4x4-4.5", -HALF_M);
    let (upper_n, lower_n) = (&pad_n[..8], &pad_n[8..]);
    assert!(
        upper_n
            .iter()
            .all(|n| (n / upper_n[0] - 1.0).abs() < 1e-9 && *n > 0.5)
    );
    assert!(lower_n.iter().all(|n| *n == 0.0), "{lower_n:?}");
    let whole_n: f64 = felt_n("dome-41", 0.0).iter().sum();
    assert!((felt_n("dome-1", 0.0)[0] - whole_n).abs() < 1e-9);
}

#[test]
fn skin_without_element_positions_is_rejected() {
    let error = Pad::from_layout(NamedLayout::Pad { count: 16 }, DOME_RADIUS_M)
        .expect_err("layout without positions is rejected");
    assert!(error.to_string().contains("pad-16"), "{error}");
}
