//! The extension module `pam_ode._pam` of the Python package `pam-ode`.
//!
//! The module is thin: it converts between NumPy arrays and the types of the framework, releases the interpreter lock while
//! the framework works, and turns errors into exceptions. The classes that users see are written in Python, in
//! `python/pam_ode`.
//!
//! | file | holds |
//! |---|---|
//! | `arrays` | arrays in and out |
//! | `errors` | exceptions with file, line, recording and time |
//! | `watch` | long calls: no interpreter lock, Ctrl-C, progress |
//! | `options` | solver, gradient method, masses |
//! | `recording`, `model`, `problem` | recordings; models; values and gradients |
//! | `train`, `diagnose`, `control`, `rig`, `effects`, `compare` | the commands of these names |
//! | `cli` | the program `pam` |
#![cfg(feature = "extension")]
// Functions take the keyword arguments of those in Python, and return tuples that these unpack.
#![allow(clippy::too_many_arguments, clippy::type_complexity)]

mod arrays;
mod cli;
mod compare;
mod control;
mod diagnose;
mod effects;
mod errors;
mod loss;
mod model;
mod options;
mod problem;
mod recording;
mod rig;
mod train;
mod watch;

use pyo3::prelude::*;

#[pymodule]
mod _pam {
    #[pymodule_export]
    use super::cli::run_program;
    #[pymodule_export]
    use super::compare::{Comparison, compare};
    #[pymodule_export]
    use super::control::{Plan, plan_motion, plan_targets, reachable};
    #[pymodule_export]
    use super::diagnose::{Diagnosis, diagnose};
    #[pymodule_export]
    use super::effects::{define_effects, effect_list, hidden_effect_list};
    #[pymodule_export]
    use super::model::{Evaluation, Model};
    #[pymodule_export]
    use super::options::names;
    #[pymodule_export]
    use super::problem::Problem;
    #[pymodule_export]
    use super::recording::{Recording, read};
    #[pymodule_export]
    use super::rig::{Rig, rig_record};
    #[pymodule_export]
    use super::train::train;

    use pyo3::prelude::*;

    #[pymodule_init]
    fn init(module: &Bound<'_, PyModule>) -> PyResult<()> {
        module.add("__version__", env!("CARGO_PKG_VERSION"))?;
        module.add("made_by", pam_cli::run_record::made_by())
    }
}
