//! The built-in layouts: geometry and pinned hashes.

use shm_schemas::Layout;
use shm_schemas::layout::{DOME_HALF_ANGLE_RAD, DOME_RADIUS_M};

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    (0..3).map(|i| a[i] * b[i]).sum()
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]
}

fn close(a: [f64; 3], b: [f64; 3]) -> bool {
    (0..3).all(|i| (a[i] - b[i]).abs() < 1e-12)
}

#[test]
fn axes_are_unit_orthonormal_and_right_handed() {
    let dome = Layout::dome_41();
    for i in 0..dome.count {
        let (d, t1, t2) = (dome.normal[i], dome.tangent1[i], dome.tangent2[i]);
        for axis in [d, t1, t2] {
            assert!((dot(axis, axis) - 1.0).abs() < 1e-12, "element {i}");
        }
        assert!(close(t1, cross(t2, d)), "element {i}");
        assert!(dot(d, t2).abs() < 1e-12, "element {i}");
        // t2 is up (−x), made normal to d.
        let along = -d[0];
        let up = [-1.0 - d[0] * along, -d[1] * along, -d[2] * along];
        let norm = dot(up, up).sqrt();
        assert!(close(t2, up.map(|u| u / norm)), "element {i}");
    }
}

#[test]
fn rings_hold_1_7_13_20_elements_within_35_degrees() {
    let dome = Layout::dome_41();
    assert_eq!(dome.count, 41);
    let mut rings: Vec<(f64, usize)> = Vec::new();
    for normal in &dome.normal[..41] {
        match rings.last_mut() {
            Some((z, n)) if (*z - normal[2]).abs() < 1e-12 => *n += 1,
            _ => rings.push((normal[2], 1)),
        }
    }
    assert_eq!(
        rings.iter().map(|r| r.1).collect::<Vec<_>>(),
        [1, 7, 13, 20]
    );
    assert!(rings.iter().all(|&(z, _)| z > DOME_HALF_ANGLE_RAD.cos()));
    assert!(rings.is_sorted_by(|inner, outer| inner.0 > outer.0));
}

#[test]
fn pole_element_faces_z_with_second_tangent_up() {
    for dome in [Layout::dome_41(), Layout::from_name("dome-1").unwrap()] {
        assert!(close(dome.normal[0], [0.0, 0.0, 1.0]));
        assert!(close(dome.tangent2[0], [-1.0, 0.0, 0.0]));
        assert!(close(dome.tangent1[0], [0.0, 1.0, 0.0]));
    }
}

#[test]
fn elements_have_equal_area_and_even_spacing() {
    let dome = Layout::dome_41();
    for (normal, position_m) in dome.normal.iter().zip(&dome.position_m).take(dome.count) {
        assert!(close(*position_m, normal.map(|d| d * DOME_RADIUS_M)));
    }
    // Tactile design: 6.2 mm² each.
    assert!((dome.element_area_m2 - 6.2e-6).abs() < 0.1e-6);
    for (first, n) in [(1, 7), (8, 13), (21, 20)] {
        let step = dot(dome.normal[first], dome.normal[first + 1]);
        let closing = dot(dome.normal[first + n - 1], dome.normal[first]);
        assert!((step - closing).abs() < 1e-12, "ring of {n}");
    }
}

/// Other languages compute the hash from the protocol text, so it must not change.
#[test]
fn hashes_are_pinned() {
    for (name, hash) in [
        ("dome-41", 0x9528_63cb_70a3_5143),
        ("dome-1", 0xa5e7_9ed5_0910_3aea),
    ] {
        assert_eq!(Layout::from_name(name).unwrap().hash(), hash, "{name}");
    }
}

#[test]
fn another_layout_has_another_hash() {
    let dome = Layout::dome_41();
    let changed = |change: &dyn Fn(&mut Layout)| {
        let mut layout = dome;
        change(&mut layout);
        layout.hash()
    };
    let variants = [
        dome.hash(),
        changed(&|l| l.count = 40),
        changed(&|l| l.normal.swap(1, 2)),
        changed(&|l| l.tangent1[40] = l.tangent1[40].map(|v| -v)),
        changed(&|l| l.tangent2[0][1] += 2e-6),
        Layout::from_name("dome-1").unwrap().hash(),
    ];
    for (i, a) in variants.iter().enumerate() {
        assert!(variants[..i].iter().all(|b| b != a), "variant {i}");
    }
    // Rounding differences and unused elements do not change the hash.
    assert_eq!(changed(&|l| l.normal[5][0] += 1e-10), dome.hash());
    assert_eq!(changed(&|l| l.normal[60] = [1.0; 3]), dome.hash());
}

#[test]
fn layouts_are_found_by_name() {
    for name in Layout::NAMES {
        assert!(Layout::from_name(name).is_some(), "{name}");
    }
    assert!(Layout::from_name("dome-42").is_none());
}
