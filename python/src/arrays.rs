//! Columns of numbers as buffers that NumPy takes without another copy.

use pyo3::prelude::*;
use pyo3::types::{PyByteArray, PyDict};

/// The columns by name, in order, each a `bytearray` of doubles in the machine's byte order.
pub fn columns<'py, N: AsRef<str>>(
    py: Python<'py>,
    columns: &[(N, Vec<f64>)],
) -> PyResult<Bound<'py, PyDict>> {
    let dict = PyDict::new(py);
    for (name, values) in columns {
        let fill = |bytes: &mut [u8]| {
            bytes.chunks_exact_mut(8).zip(values).for_each(|(to, x)| to.copy_from_slice(&x.to_ne_bytes()));
            Ok(())
        };
        dict.set_item(name.as_ref(), PyByteArray::new_with(py, 8 * values.len(), fill)?)?;
    }
    Ok(dict)
}
