//! Which missions there are, the text of one, and what its numbers amount to.

use std::path::PathBuf;

use pyo3::prelude::*;
use samara::config::shipped::{MISSIONS, names_in};
use samara::config::{mission_path, mission_text as text_of};
use samara::study::checking::checked;
use samara::study::checking::{checked_json, checked_text, odd};

use crate::fault::OrGiven as _;
use crate::given::Given;
use crate::work::work;

/// Names of the missions that samara brings along.
#[pyfunction]
pub fn missions() -> Vec<&'static str> {
    names_in(MISSIONS).collect()
}

/// The path and the text of a mission's file.
#[pyfunction]
pub fn mission_text(py: Python<'_>, name: PathBuf) -> PyResult<(PathBuf, String)> {
    work(py, move |_| {
        let path = mission_path(&name).or_given()?;
        let text = text_of(&path).or_given()?;
        Ok((path, text))
    })
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
