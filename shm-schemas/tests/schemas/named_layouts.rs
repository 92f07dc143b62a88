//! Parsing, formatting and geometry of named layouts.

use shm_schemas::Layout;
use shm_schemas::layout::NamedLayout;

#[test]
fn layout_name_round_trips() {
    for name in [
        "dome-41",
        "dome-1",
        "pad-31",
        "flat-4x4-4.5",
        "flat-1x64-1",
        "cylinder-6x5-3-12.5",
    ] {
        let named: NamedLayout = name.parse().expect(name);
        assert_eq!(named.to_string(), name);
    }
}

#[test]
fn invalid_layout_names_are_rejected() {
    for name in [
        "",
        "dome",
        "dome-42",
        "dome-41-1",
        "pad-0",
        "pad-65",
        "pad--3",
        "flat-4x4",
        "flat-4-4.5",
        "flat-0x4-4.5",
        "flat-9x8-4.5",
        "flat-4x4-0",
        "flat-4x4-NaN",
        "flat-4x4-inf",
        "flat-4x4-4.5-12",
        "cylinder-4x4-4.5",
        "cylinder-4x4-4.5-1",
        "cylinder-4x4-4.5-12-3",
        // The outermost elements would face backwards.
        "cylinder-1x8-10-5",
        "Flat-4x4-4.5",
    ] {
        assert!(name.parse::<NamedLayout>().is_err(), "{name}");
    }
}

#[test]
fn flat_pad_is_a_grid_facing_forwards() {
    let pad = Layout::from_name("flat-2x3-4").expect("valid layout");
    assert_eq!((pad.count, pad.element_area_m2), (6, 0.004 * 0.004));
    let places_m = [
        [-0.002, -0.004, 0.015],
        [-0.002, 0.0, 0.015],
        [-0.002, 0.004, 0.015],
        [0.002, -0.004, 0.015],
        [0.002, 0.0, 0.015],
        [0.002, 0.004, 0.015],
    ];
    for (element, place_m) in places_m.into_iter().enumerate() {
        assert_eq!(pad.normal[element], [0.0, 0.0, 1.0], "{element}");
        let off = |axis: usize| (pad.position_m[element][axis] - place_m[axis]).abs();
        assert!((0..3).all(|axis| off(axis) < 1e-12), "{element}");
    }
    // A face taller than a dome is moved ahead so that it does not touch a table.
    let tall = Layout::from_name("flat-8x2-5").expect("valid layout");
    assert_eq!(tall.position_m[0][2], 0.02);
}

#[test]
fn cylinder_keeps_distances_along_its_surface() {
    let (radius_m, pitch_m) = (0.012, 0.0045);
    let pad = Layout::from_name("cylinder-3x4-4.5-12").expect("valid layout");
    for element in 0..pad.count {
        let (normal, [_, y, z]) = (pad.normal[element], pad.position_m[element]);
        // The cylinder axis passes through the tip origin, along x.
        assert!((y.hypot(z) - radius_m).abs() < 1e-12, "{element}");
        assert!((normal[1] * radius_m - y).abs() < 1e-12, "{element}");
        assert_eq!(normal[0], 0.0);
    }
    let angle = |element: usize| pad.normal[element][1].asin();
    assert!((radius_m * (angle(1) - angle(0)) - pitch_m).abs() < 1e-12);
    assert!((pad.position_m[4][0] - pad.position_m[0][0] - pitch_m).abs() < 1e-12);
}

/// Pads with equal normals differ in the element positions.
#[test]
fn hash_covers_positions_unless_layout_is_dome() {
    let names = [
        "pad-16",
        "flat-4x4-4.5",
        "flat-4x4-4.6",
        "flat-2x8-4.5",
        "cylinder-4x4-4.5-12",
        "cylinder-4x4-4.5-13",
    ];
    let hashes = names.map(|name| Layout::from_name(name).expect("valid layout").hash());
    for (i, a) in hashes.iter().enumerate() {
        assert!(!hashes[..i].contains(a), "{}", names[i]);
    }
    // Other languages compute these hashes from the protocol text.
    assert_eq!(hashes[1], 0x97e0_4f9a_9ea4_6b5d, "{:#x}", hashes[1]);
}
