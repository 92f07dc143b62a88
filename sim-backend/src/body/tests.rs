//! Tests of objects on the table and in free fall.

use super::*;

const DT_S: f64 = 250e-6;

fn cube(mass_kg: f64) -> Body {
    let shape = Shape::Box {
        half_m: Vector3::repeat(0.025),
    };
    Body::standing(shape, mass_kg, [0.3, -0.1, 0.0], 0.4)
}

fn energy_j(body: &Body) -> f64 {
    let spin = body.base_from_body.tr_mul(&body.angular_rad_s);
    let turning = spin.dot(&spin.component_mul(&body.inertia_kg_m2));
    0.5 * (body.mass_kg * body.velocity_m_s.norm_squared() + turning)
        + body.mass_kg * GRAVITY_M_S2 * body.position_m.z
}

#[test]
fn standing_object_stays_at_rest() {
    for (shape, mass_kg) in [
        (
            Shape::Box {
                half_m: Vector3::new(0.025, 0.025, 0.03),
            },
            0.3,
        ),
        (
            Shape::Box {
                half_m: Vector3::new(0.03, 0.03, 0.025),
            },
            0.012,
        ),
        (
            Shape::Cylinder {
                radius_m: 0.03,
                half_height_m: 0.06,
            },
            0.5,
        ),
    ] {
        let mut body = Body::standing(shape, mass_kg, [0.3, -0.1, 0.0], 0.4);
        let start_m = body.position_m;
        (0..8000).for_each(|_| body.step(&Ground::default(), DT_S));
        assert!(
            (body.position_m - start_m).norm() < 1e-9,
            "{shape:?} moved to {}",
            body.position_m
        );
        assert!(
            body.tilt_rad() < 1e-7,
            "{shape:?} tilted by {}",
            body.tilt_rad()
        );
        let weight_n = mass_kg * GRAVITY_M_S2;
        assert!(
            (body.table_n / weight_n - 1.0).abs() < 1e-9,
            "{} N of {weight_n} N",
            body.table_n
        );
    }
}

#[test]
fn falling_object_loses_energy_only_on_landing() {
    let mut body = cube(0.1);
    body.position_m.z = 0.1;
    body.angular_rad_s = Vector3::new(3.0, -2.0, 5.0);
    let start_j = energy_j(&body);
    (0..400).for_each(|_| body.step(&Ground::default(), DT_S));
    assert!(
        (energy_j(&body) / start_j - 1.0).abs() < 2e-3,
        "{} J of {start_j} J",
        energy_j(&body)
    );
    let mut highest_j = energy_j(&body);
    for _ in 0..40 {
        (0..400).for_each(|_| body.step(&Ground::default(), DT_S));
        assert!(
            energy_j(&body) <= highest_j * 1.0001,
            "{} J after {highest_j} J",
            energy_j(&body)
        );
        highest_j = energy_j(&body);
    }
    assert!(
        body.velocity_m_s.norm() < 1e-3,
        "still moving at {}",
        body.velocity_m_s
    );
}

#[test]
fn table_friction_stops_a_sliding_object() {
    let mut body = cube(0.2);
    body.velocity_m_s.x = 0.1;
    let start_m = body.position_m.x;
    (0..4000).for_each(|_| body.step(&Ground::default(), DT_S));
    let expected_m = 0.1 * 0.1 / (2.0 * TABLE_FRICTION * GRAVITY_M_S2);
    let slid_m = body.position_m.x - start_m;
    assert!(
        (slid_m / expected_m - 1.0).abs() < 0.1,
        "slid {slid_m} m, expected {expected_m} m"
    );
    assert!(body.velocity_m_s.norm() < 1e-6);
}

#[test]
fn pushed_object_tips_over_and_rests() {
    let shape = Shape::Cylinder {
        radius_m: 0.02,
        half_height_m: 0.06,
    };
    let mut body = Body::standing(shape, 0.2, [0.0; 3], 0.0);
    body.orientation = rotated(body.orientation, &Vector3::new(0.0, 0.4, 0.0));
    body.base_from_body = rotation_matrix(body.orientation);
    (0..12_000).for_each(|_| body.step(&Ground::default(), DT_S));
    assert!(
        (body.tilt_rad() - core::f64::consts::FRAC_PI_2).abs() < 0.01,
        "tilt {}",
        body.tilt_rad()
    );
    assert!(
        body.clearance_m(&Ground::default()).abs() < 1e-3,
        "clearance {}",
        body.clearance_m(&Ground::default())
    );
}
