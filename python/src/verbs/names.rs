//! Which missions there are, and what the numbers of one amount to.

use pyo3::prelude::*;
use samara::config::shipped::{MISSIONS, names_in};
use samara::study::checking::checked;
use samara::study::checking::{checked_json, checked_text, odd};

use crate::given::Given;
use crate::work::work;

/// Names of the missions that samara brings along.
#[pyfunction]
pub fn missions() -> Vec<&'static str> {
    names_in(MISSIONS).collect()
}

/// What the numbers of a mission amount to: the object of `samara check --json`, the text, and whether
/// nothing is odd.
#[pyfunction]
pub fn check(py: Python<'_>, given: Given) -> PyResult<(String, String, bool)> {
    work(py, move |_| {
        let mission = given.mission()?;
        let checked = checked(&mission);
        let sound = odd(&mission, &checked).is_empty();
        Ok((checked_json(&mission, &checked), checked_text(&mission, &checked), sound))
    })
}
