//! The extension module `samara_tpf._samara`: the library's verbs for Python. Not for users: its other half,
//! `samara_tpf`, has the types, the documentation and the arrays.
//!
//! | file | holds |
//! |---|---|
//! | `fault` | why there is no answer, as an exception of Python |
//! | `documents` | missions, vehicles and gains as documents |
//! | `given` | the mission as Python gives it, with its choices |
//! | `work` | work beside the interpreter, which Ctrl-C ends |
//! | `pool` | threads for many flights |
//! | `arrays` | columns of numbers as buffers |
//! | `inside` | loops, rotor, wind and sensors of a mission, alone |
//! | `program` | the program, for who asks for that |
//! | `numbers` | numbers that come from Python, and memory of NumPy's that is filled anew |
//! | `own_controller` | a controller that is written in Python |
//! | `vehicle`, `flights` | a drop in steps; many flights from t = 0 in steps |
//! | `verbs` | plan, check, drop, assess, study, tune, judge, design |

use pyo3::prelude::*;

mod arrays;
mod documents;
mod fault;
mod flights;
mod given;
mod inside;
mod numbers;
mod own_controller;
mod pool;
mod program;
mod vehicle;
mod verbs;
mod work;

/// The verbs, and what they come to.
#[pymodule]
mod _samara {
    #[pymodule_export]
    use crate::documents::{Reader, document_text};
    #[pymodule_export]
    use crate::flights::Flights;
    #[pymodule_export]
    use crate::inside::{loops, rotor, sensors, wind};
    #[pymodule_export]
    use crate::program::program;
    #[pymodule_export]
    use crate::vehicle::Stepped;
    #[pymodule_export]
    use crate::verbs::assess::{Assessed, assess};
    #[pymodule_export]
    use crate::verbs::design::{Designed, design};
    #[pymodule_export]
    use crate::verbs::drop::{Dropped, drop};
    #[pymodule_export]
    use crate::verbs::judge::Judge;
    #[pymodule_export]
    use crate::verbs::names::{check, missions};
    #[pymodule_export]
    use crate::verbs::plan::{Planned, plan};
    #[pymodule_export]
    use crate::verbs::study::{Studied, studies, study};
    #[pymodule_export]
    use crate::verbs::tune::{Tuned, tune};

    /// The version of the library.
    #[pymodule_export]
    const VERSION: &str = env!("CARGO_PKG_VERSION");
}
