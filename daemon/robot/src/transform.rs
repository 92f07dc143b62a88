//! Rigid transform: a rotation matrix and a translation.

use nalgebra::{Matrix3, Vector3};

/// Rigid transform `a_from_b`: converts coordinates in frame b to coordinates in frame a.
///
/// ```
/// use nalgebra::Vector3;
/// use robot_model::Transform;
///
/// let shifted = Transform { translation_m: Vector3::x(), ..Transform::IDENTITY };
/// let twice = shifted.then(&shifted);
/// assert_eq!(twice.point(&Vector3::zeros()), Vector3::new(2.0, 0.0, 0.0));
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Transform {
    /// Rotation matrix, orthonormal and right-handed.
    pub rotation: Matrix3<f64>,
    /// Translation, metres.
    pub translation_m: Vector3<f64>,
}

impl Transform {
    /// Identity.
    pub const IDENTITY: Transform = Transform {
        rotation: Matrix3::new(1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0),
        translation_m: Vector3::new(0.0, 0.0, 0.0),
    };

    /// Composes: `a_from_b.then(&b_from_c)` is `a_from_c`.
    #[must_use]
    #[inline]
    pub fn then(&self, next: &Transform) -> Transform {
        Transform {
            rotation: self.rotation * next.rotation,
            translation_m: self.point(&next.translation_m),
        }
    }

    /// Converts a point of frame b to frame a, metres.
    #[must_use]
    pub fn point(&self, point_m: &Vector3<f64>) -> Vector3<f64> {
        self.rotation * point_m + self.translation_m
    }

    /// Returns the transform with frame b turned by `angle_rad` about its z axis.
    #[must_use]
    #[inline]
    pub(crate) fn turned_about_z(&self, angle_rad: f64) -> Transform {
        let (sin, cos) = libm::sincos(angle_rad);
        let (x, y) = (self.x_axis(), self.y_axis());
        Transform {
            rotation: Matrix3::from_columns(&[x * cos + y * sin, y * cos - x * sin, self.z_axis()]),
            translation_m: self.translation_m,
        }
    }

    /// Returns the transform with frame b moved along its z axis.
    #[must_use]
    pub(crate) fn moved_along_z(&self, by_m: f64) -> Transform {
        Transform {
            rotation: self.rotation,
            translation_m: self.translation_m + self.z_axis() * by_m,
        }
    }

    /// x axis of frame b seen from frame a.
    #[must_use]
    pub fn x_axis(&self) -> Vector3<f64> {
        self.rotation.column(0).into_owned()
    }

    /// y axis of frame b seen from frame a.
    #[must_use]
    pub fn y_axis(&self) -> Vector3<f64> {
        self.rotation.column(1).into_owned()
    }

    /// z axis of frame b seen from frame a.
    #[must_use]
    pub fn z_axis(&self) -> Vector3<f64> {
        self.rotation.column(2).into_owned()
    }
}
