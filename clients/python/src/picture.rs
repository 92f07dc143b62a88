//! Pictures of a scene as NumPy arrays.

use std::sync::Arc;

use atas_evaluation::drawing::{Links, SceneView};
use numpy::{PyArray1, PyArray3, PyArrayMethods};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use robot_model::RobotFiles;
use shm_schemas::WorldTruth;

use crate::compute;

/// Array of uint8 (height, width, 3): red, green, blue.
pub(crate) type Picture<'py> = Bound<'py, PyArray3<u8>>;

/// Loads the links of a robot for its views.
pub(crate) fn load_links(files: &RobotFiles) -> PyResult<Arc<Links>> {
    let links = Links::load(files).map_err(|why| PyValueError::new_err(why.to_string()))?;
    Ok(Arc::new(links))
}

/// Draws a scene at these joint positions, rad or m.
pub(crate) fn draw<'py>(
    py: Python<'py>,
    view: &SceneView,
    position: &[f64],
    truth: &WorldTruth,
    size_px: [u32; 2],
) -> PyResult<Picture<'py>> {
    let drawn = compute(py, || {
        let drawing = view.draw(position, truth, size_px)?;
        Ok(drawing.pixels())
    })?;
    let drawn: Result<_, atas_evaluation::drawing::PictureSizeError> = drawn;
    let (width, height, bytes) = drawn.map_err(|why| PyValueError::new_err(why.to_string()))?;
    PyArray1::from_vec(py, bytes).reshape([height, width, 3])
}
