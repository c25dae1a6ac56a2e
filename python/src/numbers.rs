//! Numbers that come from Python, one for each rotor, and memory of NumPy's that is filled anew.

use pyo3::buffer::PyBuffer;
use pyo3::prelude::*;
use pyo3::types::{PyList, PyTuple};
use samara::model::{MAX_ROTORS, PerRotor};

/// A number for each of so many rotors, out of a tuple, a list, an array or whatever goes through its
/// numbers; in words what is wrong with them, after "found".
pub fn per_rotor(given: &Bound<'_, PyAny>, rotors: usize) -> Result<PerRotor, String> {
    let mut numbers = [0.0; MAX_ROTORS];
    let mut found = 0;
    let mut take = |number: f64| {
        if let Some(place) = numbers.get_mut(found) {
            *place = number;
        }
        found += 1;
    };
    let of = |item: &Bound<'_, PyAny>| item.extract::<f64>().map_err(|_| shown(given));
    if let Ok(tuple) = given.cast_exact::<PyTuple>() {
        for item in tuple.iter_borrowed() {
            take(of(&item)?);
        }
    } else if let Ok(list) = given.cast_exact::<PyList>() {
        for item in list {
            take(of(&item)?);
        }
    } else if let Ok(buffer) = PyBuffer::<f64>::get(given)
        && buffer.dimensions() == 1
        && buffer.item_count() <= MAX_ROTORS
    {
        found = buffer.item_count();
        buffer.copy_to_slice(given.py(), &mut numbers[..found]).map_err(|_| shown(given))?;
    } else {
        for item in given.try_iter().map_err(|_| shown(given))? {
            take(of(&item.map_err(|_| shown(given))?)?);
        }
    }
    if found != rotors {
        return Err(format!("{found} numbers"));
    }
    match numbers[..rotors].iter().position(|number| !number.is_finite()) {
        Some(place) => Err(format!("{} for rotor {}", numbers[place], place + 1)),
        None => Ok(numbers),
    }
}

/// A value of Python's as a message has it: type, and as much of it as fits a line.
pub fn shown(given: &Bound<'_, PyAny>) -> String {
    let text = given.repr().map_or_else(|_| String::new(), |text| text.to_string());
    let line: String = text.chars().map(|c| if c.is_control() { ' ' } else { c }).take(60).collect();
    match given.get_type().name() {
        Ok(name) if !given.is_none() => format!("{name} {line}"),
        _ => line,
    }
}

/// Memory of an array of NumPy's that Python looks at through views, and that is filled anew.
#[derive(Debug)]
pub struct Filled(PyBuffer<f64>);

impl<'py> FromPyObject<'_, 'py> for Filled {
    type Error = PyErr;

    fn extract(array: Borrowed<'_, 'py, PyAny>) -> PyResult<Self> {
        array.extract().map(Self)
    }
}

impl Filled {
    /// Fills the memory with as many numbers as it has.
    pub fn fill(&self, py: Python<'_>, numbers: &[f64]) {
        // The other half of this module made the memory: it has the length.
        let _ = self.0.copy_from_slice(py, numbers);
    }
}
