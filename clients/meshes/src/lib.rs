//! Meshes of a robot's links for viewers: read from the files that a URDF names, reduced to few
//! triangles.
//!
//! * **Inputs:** a robot, its skeleton. Formats: STL, OBJ, COLLADA. A `package://NAME/PATH` is
//!   looked up in the folders above the URDF. **Outputs:** triangles in the frame of each link, m.
//! * **Bad input:** a mesh that is missing, too large or damaged becomes a remark; the viewer then
//!   draws a line in place of the link. Control never reads meshes.

mod place;
mod reduce;

use std::path::Path;

use mesh_loader::Loader;
use nalgebra::{Point3, Vector3};
use robot_model::{MeshFile, RobotFiles, Skeleton};

pub use place::find;

/// Largest file, bytes. Design choice: public robots have meshes of up to 30 MB.
pub const FILE_BYTES_MAX: u64 = 64 << 20;
/// Largest number of triangles in a file. Design choice: reading them takes less than a second.
pub const FILE_TRIANGLES_MAX: usize = 2_000_000;
/// Largest number of triangles of a link's mesh after the reduction. Design choice: 30 links draw
/// in 10 ms.
pub const TRIANGLES_MAX: usize = 300;

/// Triangles of one mesh, with corners in the frame of its link.
#[derive(Clone, Debug, PartialEq)]
pub struct Mesh {
    /// Corners, link frame, m.
    pub points_m: Vec<[f64; 3]>,
    /// Indices of the corners, counter-clockwise from outside.
    pub triangles: Vec<[usize; 3]>,
    /// Red, green, blue, opacity, 0 to 1.
    pub rgba: [f64; 4],
}

/// Meshes of a robot.
#[derive(Clone, Debug, Default)]
pub struct Meshes {
    /// Meshes of each link, in the order of [`Skeleton::limbs`].
    pub links: Vec<Vec<Mesh>>,
    /// One sentence for each mesh that is not drawn.
    pub remarks: Vec<String>,
}

impl Meshes {
    /// Loads the meshes of a robot. A built-in robot has none.
    #[must_use]
    pub fn load(files: &RobotFiles, skeleton: &Skeleton) -> Self {
        let folder = files.urdf_path();
        let folder = folder.as_deref().and_then(Path::parent);
        let mut loaded = Self::default();
        for limb in skeleton.limbs() {
            let mut meshes = Vec::new();
            for file in &limb.meshes {
                match load(folder, file) {
                    Ok(mesh) => meshes.push(mesh),
                    Err(cause) => loaded.remarks.push(format!(
                        "mesh `{}` of link `{}` is not drawn: {cause}",
                        file.name, limb.name
                    )),
                }
            }
            loaded.links.push(meshes);
        }
        loaded
    }
}

/// Loads one mesh; the error is its cause.
fn load(folder: Option<&Path>, file: &MeshFile) -> Result<Mesh, String> {
    let folder = folder.ok_or("the robot has no folder")?;
    let path = find(folder, &file.name).ok_or("the file was not found beside the URDF")?;
    let shown = |error: std::io::Error| error.to_string();
    let bytes = std::fs::metadata(&path).map_err(shown)?.len();
    if bytes > FILE_BYTES_MAX {
        return Err(format!(
            "it has {bytes} bytes, at most {FILE_BYTES_MAX}; reduce it"
        ));
    }
    let scene = Loader::default().load(&path).map_err(shown)?;
    let link_from_mesh = file.origin.isometry();
    let place = |[x, y, z]: [f32; 3]| {
        let scaled_m =
            Vector3::new(x.into(), y.into(), z.into()).component_mul(&Vector3::from(file.scale));
        link_from_mesh * Point3::from(scaled_m)
    };
    let (mut points_m, mut triangles) = (Vec::new(), Vec::new());
    for mesh in &scene.meshes {
        let first = points_m.len();
        points_m.extend(mesh.vertices.iter().map(|vertex| place(*vertex)));
        let corners = |face: &[u32; 3]| face.map(|corner| first + corner as usize);
        triangles.extend(mesh.faces.iter().map(corners));
    }
    validate(&points_m, &triangles)?;
    // A negative scale mirrors the mesh, which reverses its faces.
    if file.scale.iter().product::<f64>() < 0.0 {
        triangles.iter_mut().for_each(|corners| corners.swap(1, 2));
    }
    let (points_m, triangles) = reduce::reduce(&points_m, triangles, TRIANGLES_MAX);
    Ok(Mesh {
        points_m: points_m.iter().map(|point| point.coords.into()).collect(),
        triangles,
        rgba: file.rgba,
    })
}

fn validate(points_m: &[Point3<f64>], triangles: &[[usize; 3]]) -> Result<(), String> {
    if triangles.is_empty() {
        return Err("it has no triangles".into());
    }
    if triangles.len() > FILE_TRIANGLES_MAX {
        return Err(format!(
            "it has {} triangles, at most {FILE_TRIANGLES_MAX}; reduce it",
            triangles.len()
        ));
    }
    if triangles
        .iter()
        .flatten()
        .any(|corner| *corner >= points_m.len())
    {
        return Err("a triangle names a corner that the file does not have".into());
    }
    if points_m
        .iter()
        .any(|point| !point.coords.iter().all(|x| x.is_finite()))
    {
        return Err("a corner is not finite".into());
    }
    Ok(())
}
