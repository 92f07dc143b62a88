//! Payloads as NumPy arrays.
//!
//! A payload on the bus is a structure of plain numbers without padding, and has the same bytes as
//! a row of a structured NumPy array. The array type is derived from the schema, so the layout is
//! defined only once.

use numpy::{Element, PyArray1, PyArrayDescr, PyUntypedArrayMethods};
use pyo3::exceptions::{PyKeyError, PyValueError};
use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;
use pyo3::types::{PyDict, PyList, PyString, PyTuple};
use shm_schemas::catalogue::{CODES, PAYLOADS};
use shm_schemas::schema::{PayloadType, Type};
use shm_schemas::{Payload, ReasonRecord};
use zerocopy::FromBytes;

/// A payload as an array element.
#[repr(transparent)]
#[derive(Clone, Copy)]
pub(crate) struct Row<T: Payload>(pub(crate) T);

// SAFETY: `get_dtype` describes exactly the bytes of `T`: it is derived from the schema, which
// contains the compiler's size and offsets of `T`. A payload has no padding and no pointers, and
// every bit pattern is valid (zerocopy).
unsafe impl<T: Payload + Send + Sync> Element for Row<T> {
    const IS_COPY: bool = true;

    fn get_dtype(py: Python<'_>) -> Bound<'_, PyArrayDescr> {
        numpy_type(py, T::SCHEMA).expect("numpy accepts a type from the schema")
    }

    fn clone_ref(&self, _py: Python<'_>) -> Self {
        *self
    }
}

/// Moves rows into an array without copying.
pub(crate) fn array<T: Payload + Send + Sync>(
    py: Python<'_>,
    mut rows: Vec<Row<T>>,
) -> Bound<'_, PyAny> {
    // Releases reserved space in place.
    rows.shrink_to_fit();
    PyArray1::from_vec(py, rows).into_any()
}

/// Returns one payload as a NumPy record.
pub(crate) fn row<'py, T: Payload + Send + Sync>(
    py: Python<'py>,
    payload: &T,
) -> PyResult<Bound<'py, PyAny>> {
    array(py, vec![Row(*payload)]).get_item(0)
}

/// Returns the NumPy type of a payload.
pub(crate) fn numpy_type<'py>(
    py: Python<'py>,
    payload: &'static PayloadType,
) -> PyResult<Bound<'py, PyArrayDescr>> {
    static KNOWN: PyOnceLock<Py<PyDict>> = PyOnceLock::new();
    let known = KNOWN.get_or_init(py, || PyDict::new(py).unbind()).bind(py);
    if let Some(found) = known.get_item(payload.wire)? {
        return Ok(found.cast_into()?);
    }
    let formats: PyResult<Vec<_>> = payload
        .fields
        .iter()
        .map(|field| format(py, &field.kind))
        .collect();
    let names: Vec<&str> = payload.fields.iter().map(|field| field.name).collect();
    let offsets: Vec<usize> = payload.fields.iter().map(|field| field.offset).collect();
    let description = PyDict::new(py);
    description.set_item("names", names)?;
    description.set_item("formats", PyList::new(py, formats?)?)?;
    description.set_item("offsets", offsets)?;
    description.set_item("itemsize", payload.size)?;
    let made = PyArrayDescr::new(py, description)?;
    known.set_item(payload.wire, &made)?;
    Ok(made)
}

fn format<'py>(py: Python<'py>, kind: &'static Type) -> PyResult<Bound<'py, PyAny>> {
    let text =
        |text: &str| -> PyResult<Bound<'py, PyAny>> { Ok(PyString::new(py, text).into_any()) };
    let (mut kind, mut shape) = (kind, Vec::new());
    while let Type::Array(of, count) = kind {
        shape.push(*count);
        kind = of;
    }
    let base = match kind {
        Type::F32 => text("<f4"),
        Type::F64 => text("<f8"),
        Type::U32 | Type::Code(_) => text("<u4"),
        Type::U64 => text("<u8"),
        Type::Text(bytes) => text(&format!("S{bytes}")),
        Type::Payload(part) => Ok(numpy_type(py, part)?.into_any()),
        Type::Array(..) => unreachable!("handled above"),
    }?;
    if shape.is_empty() {
        return Ok(base);
    }
    let shape = PyTuple::new(py, shape)?;
    Ok((base, shape).into_pyobject(py)?.into_any())
}

/// Returns the array type of a payload by name, for example `dtype("HandFrame")`.
#[pyfunction]
pub(crate) fn dtype<'py>(py: Python<'py>, payload: &str) -> PyResult<Bound<'py, PyArrayDescr>> {
    let found = PAYLOADS.iter().find(|known| known.name == payload);
    let unknown = || PyKeyError::new_err(format!("unknown payload {payload:?}"));
    numpy_type(py, found.ok_or_else(unknown)?)
}

/// Value of a code: name, number, name in logs.
type Value = (&'static str, u32, &'static str);

/// Returns all codes with their values and names in logs; source of `atas.codes`.
#[pyfunction]
pub(crate) fn codes() -> Vec<(&'static str, String, Vec<Value>)> {
    let each = CODES.iter().map(|code| {
        let values = code
            .values
            .iter()
            .map(|value| (value.name, value.number, value.text));
        (
            code.name,
            code.doc.join(" ").trim().to_owned(),
            values.collect(),
        )
    });
    each.collect()
}

/// Returns the text of a `reason` field: of a goal update, an event or a status.
#[pyfunction]
pub(crate) fn reason(reason: &Bound<'_, PyAny>) -> PyResult<String> {
    let bytes: Vec<u8> = reason.call_method0("tobytes")?.extract()?;
    let read = ReasonRecord::read_from_bytes(&bytes).map_err(|_| {
        PyValueError::new_err(format!(
            "invalid reason: {} bytes needed, {} given",
            size_of::<ReasonRecord>(),
            bytes.len()
        ))
    })?;
    Ok(if read.is_some() {
        read.to_string()
    } else {
        String::new()
    })
}

/// Checks that an array has `count` finite values.
pub(crate) fn finite(what: &str, values: &[f64], count: usize) -> PyResult<()> {
    if values.len() != count {
        return Err(PyValueError::new_err(format!(
            "{what} has {} numbers, needs {count}",
            values.len()
        )));
    }
    match values.iter().position(|value| !value.is_finite()) {
        None => Ok(()),
        Some(index) => {
            let value = values[index];
            Err(PyValueError::new_err(format!(
                "{what}[{index}] is {value}, needs a finite number; nothing was sent"
            )))
        }
    }
}

/// Returns the values of an array in row-major order.
pub(crate) fn numbers<T: Element + Copy, D: numpy::ndarray::Dimension>(
    array: &numpy::PyReadonlyArray<'_, T, D>,
) -> Vec<T> {
    match array.as_slice() {
        Ok(values) => values.to_vec(),
        Err(_) => array.as_array().iter().copied().collect(),
    }
}

/// Returns the shape of an array in Python notation.
pub(crate) fn shape_of<T, D>(array: &numpy::PyReadonlyArray<'_, T, D>) -> String
where
    T: Element,
    D: numpy::ndarray::Dimension,
{
    format!("{:?}", array.shape())
}
