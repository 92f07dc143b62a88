//! Forces of a fingertip: wrench and elements.

use atas_client::contact;
use shm_schemas::{HandFrame, Layout};

use crate::wire::standard::{Header, PointCloud, PointField, Vector3, Wrench, WrenchStamped};

/// Fields of a point, 4-byte floats: position, m; force, N; normal force, N.
const FIELDS: [&str; 7] = ["x", "y", "z", "fx", "fy", "fz", "force"];
const FLOAT32: u8 = 7;
const FLOAT_BYTES: u32 = 4;
const POINT_BYTES: u32 = FIELDS.len() as u32 * FLOAT_BYTES;

/// Returns force and torque of the object on a fingertip, tip frame.
pub(super) fn wrench(
    header: Header,
    frame: &HandFrame,
    finger: usize,
    layout: &Layout,
) -> WrenchStamped {
    let (valid, force_n) = (frame.valid_mask[finger], &frame.force_n[finger]);
    let [force, torque] = contact::wrench(layout, valid, force_n);
    let vector = |[x, y, z]: [f64; 3]| Vector3 { x, y, z };
    WrenchStamped {
        header,
        wrench: Wrench {
            force: vector(force),
            torque: vector(torque),
        },
    }
}

/// Returns position and force of each valid element, tip frame.
pub(super) fn cloud(
    header: Header,
    frame: &HandFrame,
    finger: usize,
    layout: &Layout,
) -> PointCloud {
    let (valid, force_n) = (frame.valid_mask[finger], &frame.force_n[finger]);
    let points = contact::points(layout, valid, force_n);
    let data: Vec<u8> = points.flatten().flat_map(f32::to_le_bytes).collect();
    let width = data.len() as u32 / POINT_BYTES;
    let field = |(index, name): (u32, &str)| PointField {
        name: name.to_owned(),
        offset: index * FLOAT_BYTES,
        datatype: FLOAT32,
        count: 1,
    };
    PointCloud {
        header,
        height: 1,
        width,
        fields: (0..).zip(FIELDS).map(field).collect(),
        is_bigendian: false,
        point_step: POINT_BYTES,
        row_step: POINT_BYTES * width,
        data,
        is_dense: true,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cloud_has_a_point_per_valid_element() {
        let layout = Layout::dome_41();
        let mut frame: Box<HandFrame> = Box::default();
        (frame.valid_mask[1], frame.force_n[1][2]) = (0b1100, [1.5, 0.0, 0.0]);
        let cloud = cloud(Header::default(), &frame, 1, &layout);
        assert_eq!((cloud.width, cloud.row_step), (2, 2 * POINT_BYTES));
        let number = |index: usize| {
            let bytes = &cloud.data[4 * index..][..4];
            f32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]])
        };
        assert!((number(2) - layout.position_m[2][2] as f32).abs() < 1e-9);
        assert!((number(6) - 1.5).abs() < f32::EPSILON, "normal force");
        let wrench = wrench(Header::default(), &frame, 1, &layout).wrench;
        assert!((wrench.force.z + 1.5 * layout.normal[2][2]).abs() < 1e-6);
    }
}
