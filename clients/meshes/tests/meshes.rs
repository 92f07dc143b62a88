//! Meshes of a robot file: formats, places, scale, reduction, and files that cannot be drawn.

use std::fmt::Write as _;
use std::fs;
use std::path::Path;

use atas_meshes::{Mesh, Meshes, TRIANGLES_MAX, find};
use robot_model::{RobotFiles, SHIPPED};

const TETRAHEDRON: [[f64; 3]; 4] = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
const OUTWARD: [[usize; 3]; 4] = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]];

fn stl(points: &[[f64; 3]], triangles: &[[usize; 3]]) -> String {
    let mut text = String::from("solid test\n");
    for corners in triangles {
        text.push_str("facet normal 0 0 0\nouter loop\n");
        for [x, y, z] in corners.map(|corner| points[corner]) {
            writeln!(text, "vertex {x} {y} {z}").unwrap();
        }
        text.push_str("endloop\nendfacet\n");
    }
    text + "endsolid test\n"
}

fn obj(points: &[[f64; 3]], triangles: &[[usize; 3]]) -> String {
    let mut text = String::new();
    for [x, y, z] in points {
        writeln!(text, "v {x} {y} {z}").unwrap();
    }
    for [a, b, c] in triangles.iter().map(|corners| corners.map(|at| at + 1)) {
        writeln!(text, "f {a} {b} {c}").unwrap();
    }
    text
}

/// A sphere of radius 1 with `bands` bands of twice as many triangles.
fn sphere(bands: usize) -> (Vec<[f64; 3]>, Vec<[usize; 3]>) {
    let around = 2 * bands;
    let angle = |at: usize, of: usize, full: f64| full * at as f64 / of as f64;
    let mut points = Vec::new();
    for band in 0..=bands {
        let (sin, cos) = angle(band, bands, std::f64::consts::PI).sin_cos();
        for at in 0..around {
            let (y, x) = angle(at, around, std::f64::consts::TAU).sin_cos();
            points.push([sin * x, sin * y, cos]);
        }
    }
    let mut triangles = Vec::new();
    for band in 0..bands {
        for at in 0..around {
            let next = (at + 1) % around;
            let [a, b] = [at, next].map(|at| band * around + at);
            triangles.extend([[a, a + around, b + around], [a, b + around, b]]);
        }
    }
    (points, triangles)
}

/// Loads the test bench with `mesh` as the visual of its first link.
fn load(folder: &Path, mesh: &str) -> Meshes {
    let bench = SHIPPED
        .into_iter()
        .find(|robot| robot.name == "test-bench")
        .expect("it ships");
    let visual = format!(
        "<visual><origin xyz=\"0.1 0 0\" rpy=\"0 0 0\"/><geometry>{mesh}</geometry></visual>"
    );
    let at = bench.urdf.find("<visual").expect("it has a visual");
    let urdf = format!("{}{visual}{}", &bench.urdf[..at], &bench.urdf[at..]);
    let file = folder.join("robot.toml");
    fs::write(folder.join("robot.urdf"), urdf).unwrap();
    fs::write(&file, bench.robot_file.as_bytes()).unwrap();
    let files = RobotFiles::find(file.to_str().unwrap()).unwrap();
    Meshes::load(&files, &files.skeleton().unwrap())
}

fn only(meshes: &Meshes) -> &Mesh {
    let mut all = meshes.links.iter().flatten();
    let first = all.next().expect("one mesh is loaded");
    assert!(
        all.next().is_none() && meshes.remarks.is_empty(),
        "{:?}",
        meshes.remarks
    );
    first
}

/// Returns the volume that the triangles enclose; negative if they face inwards.
fn volume(mesh: &Mesh) -> f64 {
    let corner = |at: usize| nalgebra::Vector3::from(mesh.points_m[at]);
    let triangles = mesh.triangles.iter();
    triangles
        .map(|[a, b, c]| corner(*a).dot(&corner(*b).cross(&corner(*c))) / 6.0)
        .sum()
}

#[test]
fn formats_give_the_same_mesh() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("a.stl"), stl(&TETRAHEDRON, &OUTWARD)).unwrap();
    fs::write(folder.path().join("a.obj"), obj(&TETRAHEDRON, &OUTWARD)).unwrap();
    for name in ["a.stl", "a.obj"] {
        let loaded = load(
            folder.path(),
            &format!("<mesh filename=\"{name}\" scale=\"0.1 0.1 0.1\"/>"),
        );
        let mesh = only(&loaded);
        assert_eq!(mesh.triangles.len(), 4, "{name}");
        assert!(
            (volume(mesh) - 1e-3 / 6.0).abs() < 1e-9,
            "{name}: {}",
            volume(mesh)
        );
        let least_x_m = mesh
            .points_m
            .iter()
            .map(|point| point[0])
            .fold(f64::INFINITY, f64::min);
        assert!(
            (least_x_m - 0.1).abs() < 1e-9,
            "{name}: the origin counts, {least_x_m}"
        );
    }
}

#[test]
fn mirrored_mesh_faces_outwards() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("a.stl"), stl(&TETRAHEDRON, &OUTWARD)).unwrap();
    let loaded = load(folder.path(), "<mesh filename=\"a.stl\" scale=\"1 -1 1\"/>");
    assert!((volume(only(&loaded)) - 1.0 / 6.0).abs() < 1e-6);
}

#[test]
fn large_mesh_keeps_its_shape_with_few_triangles() {
    let folder = tempfile::tempdir().unwrap();
    let (points, triangles) = sphere(60);
    fs::write(folder.path().join("ball.obj"), obj(&points, &triangles)).unwrap();
    let loaded = load(folder.path(), "<mesh filename=\"ball.obj\"/>");
    let mesh = only(&loaded);
    assert!(mesh.triangles.len() <= TRIANGLES_MAX && mesh.triangles.len() > TRIANGLES_MAX / 3);
    let full = 4.0 / 3.0 * std::f64::consts::PI;
    assert!(
        (volume(mesh) / full - 1.0).abs() < 0.15,
        "{}",
        volume(mesh) / full
    );
}

#[test]
fn unusable_mesh_becomes_a_remark() {
    let folder = tempfile::tempdir().unwrap();
    let empty = stl(&TETRAHEDRON, &[]);
    let infinite = stl(
        &[[0.0; 3], [1e300, 0.0, 0.0], [0.0, 1.0, 0.0]],
        &[[0, 1, 2]],
    );
    for (name, content, cause) in [
        ("absent.stl", None, "was not found"),
        ("empty.stl", Some(empty.as_str()), "no triangles"),
        ("infinite.stl", Some(infinite.as_str()), ""),
        ("noise.stl", Some("no mesh at all"), ""),
        ("noise.dae", Some("<COLLADA"), ""),
        ("corner.obj", Some("v 0 0 0\nf 1 2 3\n"), ""),
        ("a.step", Some("ISO-10303-21;"), ""),
    ] {
        if let Some(content) = content {
            fs::write(folder.path().join(name), content).unwrap();
        }
        let loaded = load(folder.path(), &format!("<mesh filename=\"{name}\"/>"));
        assert!(loaded.links.iter().all(Vec::is_empty), "{name}");
        let [remark] = &loaded.remarks[..] else {
            panic!("{name}: {:?}", loaded.remarks);
        };
        assert!(remark.contains(name) && remark.contains(cause), "{remark}");
    }
}

#[test]
fn names_of_packages_and_files_are_found() {
    let folder = tempfile::tempdir().unwrap();
    let urdf = folder.path().join("ws/arm_description/urdf");
    let mesh = folder.path().join("ws/arm_description/meshes/a.stl");
    fs::create_dir_all(&urdf).unwrap();
    fs::create_dir_all(mesh.parent().unwrap()).unwrap();
    fs::write(&mesh, "").unwrap();
    let absolute = format!("file://{}", mesh.display());
    for (name, found) in [
        ("package://arm_description/meshes/a.stl", true),
        ("model://arm_description/meshes/a.stl", true),
        ("../meshes/a.stl", true),
        (absolute.as_str(), true),
        ("package://other/meshes/a.stl", false),
        (
            "package://arm_description/../arm_description/meshes/a.stl",
            false,
        ),
        ("package://", false),
        ("", false),
    ] {
        assert_eq!(find(&urdf, name).is_some(), found, "{name}");
    }
}
