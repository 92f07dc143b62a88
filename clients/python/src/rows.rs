//! Payloads as NumPy arrays.
//!
//! A payload on the bus is a structure of plain numbers without gaps, and so is a row of a structured NumPy array: one and the
//! same bytes. The array's type is made from the schema, so that no layout is written down a second time.

use numpy::{Element, PyArray1, PyArrayDescr, PyUntypedArrayMethods};
use pyo3::exceptions::{PyKeyError, PyValueError};
use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;
use pyo3::types::{PyDict, PyList, PyString, PyTuple};
use shm_schemas::catalogue::{CODES, PAYLOADS};
use shm_schemas::schema::{PayloadType, Type};
use shm_schemas::{Payload, Reason};
use zerocopy::FromBytes;

/// A payload as an element of an array.
#[repr(transparent)]
#[derive(Clone, Copy)]
pub(crate) struct Row<T: Payload>(pub(crate) T);

// SAFETY: `get_dtype` describes exactly the bytes of `T`: it is made from the schema that the compiler fills with the size
// and the offsets of `T`, and a payload has no padding, no pointer, and a value for every pattern of bits (zerocopy).
unsafe impl<T: Payload + Send + Sync> Element for Row<T> {
    const IS_COPY: bool = true;

    fn get_dtype(py: Python<'_>) -> Bound<'_, PyArrayDescr> {
        described(py, T::SCHEMA).expect("numpy takes a type that is made from the schema")
    }

    fn clone_ref(&self, _py: Python<'_>) -> Self {
        *self
    }
}

/// Rows that Python owns from now on; they are not copied.
pub(crate) fn array<T: Payload + Send + Sync>(
    py: Python<'_>,
    mut rows: Vec<Row<T>>,
) -> Bound<'_, PyAny> {
    // In place: what was reserved for more rows goes back.
    rows.shrink_to_fit();
    PyArray1::from_vec(py, rows).into_any()
}

/// One row, as NumPy's record.
pub(crate) fn row<'py, T: Payload + Send + Sync>(
    py: Python<'py>,
    payload: &T,
) -> PyResult<Bound<'py, PyAny>> {
    array(py, vec![Row(*payload)]).get_item(0)
}

/// NumPy's type of a payload.
pub(crate) fn described<'py>(
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
        Type::Payload(part) => Ok(described(py, part)?.into_any()),
        Type::Array(..) => unreachable!("taken apart above"),
    }?;
    if shape.is_empty() {
        return Ok(base);
    }
    let shape = PyTuple::new(py, shape)?;
    Ok((base, shape).into_pyobject(py)?.into_any())
}

/// The type of the arrays that hold a payload, by its name, for example `dtype("HandFrame")`.
#[pyfunction]
pub(crate) fn dtype<'py>(py: Python<'py>, payload: &str) -> PyResult<Bound<'py, PyArrayDescr>> {
    let found = PAYLOADS.iter().find(|known| known.name == payload);
    let unknown = || PyKeyError::new_err(format!("no payload is called {payload:?}"));
    described(py, found.ok_or_else(unknown)?)
}

/// A value of a code: its name, its number, its name in logs.
type Value = (&'static str, u32, &'static str);

/// Every code with its values and their names in logs: what `atas.codes` is made from.
#[pyfunction]
pub(crate) fn codes() -> Vec<(&'static str, String, Vec<Value>)> {
    let each = CODES.iter().map(|code| {
        let values = code
            .values
            .iter()
            .map(|value| (value.name, value.number, value.text));
        (
            code.name,
            code.about.join(" ").trim().to_owned(),
            values.collect(),
        )
    });
    each.collect()
}

/// The sentence of a reason: of an update of a goal, of an event, of a status (their field `reason`).
#[pyfunction]
pub(crate) fn reason(reason: &Bound<'_, PyAny>) -> PyResult<String> {
    let bytes: Vec<u8> = reason.call_method0("tobytes")?.extract()?;
    let read = Reason::read_from_bytes(&bytes).map_err(|_| {
        PyValueError::new_err(format!(
            "a reason has {} bytes, this has {}",
            size_of::<Reason>(),
            bytes.len()
        ))
    })?;
    Ok(if read.is_some() {
        read.to_string()
    } else {
        String::new()
    })
}

/// Numbers of an array-like of `count` values, finite, or why not.
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
                "{what}[{index}] was {value}, needs a finite number; nothing was sent"
            )))
        }
    }
}

/// The numbers of an array, row by row, as they lie in memory if they lie so.
pub(crate) fn numbers<T: Element + Copy, D: numpy::ndarray::Dimension>(
    array: &numpy::PyReadonlyArray<'_, T, D>,
) -> Vec<T> {
    match array.as_slice() {
        Ok(values) => values.to_vec(),
        Err(_) => array.as_array().iter().copied().collect(),
    }
}

/// The shape of an array as Python writes it.
pub(crate) fn shape_of<T, D>(array: &numpy::PyReadonlyArray<'_, T, D>) -> String
where
    T: Element,
    D: numpy::ndarray::Dimension,
{
    format!("{:?}", array.shape())
}
