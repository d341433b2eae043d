//! Solver, gradient method, masses, by their names.

use crate::errors::{raised, settings};
use pam_core::{Activation, NamedChoice};
use pam_data::{MassChoice, MassOptions, MuscleSurfaces, PressureReference, SavedModel};
use pam_effects::engine::{AUTO, EXACT, EngineChoice, SURROGATE};
use pam_solvers::{Interpolation, Tableau};
use pam_trajectory::engine::Precision;
use pam_trajectory::{AnyLoss, GradientChoice, SolverSettings, StepChoice};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::path::PathBuf;

/// Tolerances that are not given.
const TOLERANCE: f64 = 1e-6;

/// Steps, and how the measured force is read between samples.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub(crate) struct StepOptions {
    /// Constant steps, ms.
    step_ms: Option<f64>,
    /// Relative tolerance.
    rtol: Option<f64>,
    /// Absolute tolerance.
    atol: Option<f64>,
    /// `zoh`, `linear`, `ramp` or `cubic`.
    input: String,
}

impl StepOptions {
    fn are_given(&self) -> bool {
        self.step_ms.is_some() || self.rtol.is_some() || self.atol.is_some()
    }

    /// The settings for a Runge–Kutta method.
    fn settings(&self, method: &str) -> PyResult<SolverSettings> {
        let positive = |name: &str, value: f64| {
            if value.is_finite() && value > 0.0 {
                Ok(value)
            } else {
                Err(settings(format!("`{name}` must be positive, got {value}")))
            }
        };
        let tableau = Tableau::from_name(method).map_err(raised)?;
        let step = match self.step_ms {
            Some(_) if self.rtol.is_some() || self.atol.is_some() => {
                return Err(settings("give either `step_ms` or tolerances, not both"));
            }
            Some(ms) => StepChoice::Constant { step_s: positive("step_ms", ms)? * 1e-3 },
            None if tableau.error.is_none() => {
                return Err(settings(format!("{method} has no error estimate; give `step_ms`")));
            }
            None => StepChoice::Adaptive {
                rtol: positive("rtol", self.rtol.unwrap_or(TOLERANCE))?,
                atol: positive("atol", self.atol.unwrap_or(TOLERANCE))?,
            },
        };
        let interpolation = Interpolation::from_name(&self.input).map_err(raised)?;
        Ok(SolverSettings { tableau, step, interpolation })
    }

    /// The settings for a model and a method: `auto`, `exact`, `surrogate` or a Runge–Kutta method.
    pub(crate) fn settings_for(
        &self,
        method: &str,
        saved: &SavedModel,
    ) -> PyResult<SolverSettings> {
        if method == SURROGATE {
            return self.surrogate(saved);
        }
        let named = [AUTO, EXACT].contains(&method);
        let general = self.settings(if named { "tsit5" } else { method })?;
        if !named || (method == AUTO && self.are_given()) {
            return Ok(general);
        }
        let choice = EngineChoice { automatic: true, ..EngineChoice::new(general) };
        let found = choice.settings_for(&saved.model.force, !saved.info.effects.is_empty());
        if method == EXACT && self.are_given() {
            return Err(settings("method `exact` takes no steps: drop step_ms, rtol and atol"));
        }
        if method == EXACT && found.step != StepChoice::Exact {
            return Err(settings(format!(
                "method `exact` is for networks of leaky_relu or relu without effects, with the input read as zoh, linear or \
                 ramp; this model is a {}{}",
                saved.model.force.describe(),
                if saved.info.effects.is_empty() { "" } else { " with effects" }
            )));
        }
        Ok(found)
    }

    /// As [`settings_for`](Self::settings_for), for predictions: `auto` takes a surrogate of a smooth network as well, where it holds its
    /// error bound.
    pub(crate) fn for_predictions(
        &self,
        method: &str,
        saved: &SavedModel,
    ) -> PyResult<SolverSettings> {
        let settings = self.settings_for(method, saved)?;
        let automatic = method == AUTO && !self.are_given();
        Ok(if automatic && saved.info.effects.is_empty() {
            settings.for_prediction_of(&saved.model.force)
        } else {
            settings
        })
    }

    /// Steps on a piecewise polynomial of a smooth force.
    fn surrogate(&self, saved: &SavedModel) -> PyResult<SolverSettings> {
        if self.are_given() {
            return Err(settings("method `surrogate` takes no steps: drop step_ms, rtol and atol"));
        }
        let input = Interpolation::from_name(&self.input).map_err(raised)?;
        if !saved.info.effects.is_empty() || input == Interpolation::Cubic {
            return Err(settings(
                "method `surrogate` is for smooth networks without effects, with the input read as zoh, linear or ramp",
            ));
        }
        Ok(SolverSettings::surrogate(input))
    }

    /// Steps and gradient method: `auto`, `exact`, `surrogate`, or the name of a gradient method, with a Runge–Kutta method.
    pub(crate) fn engine_choice(
        &self,
        method: &str,
        solver: Option<&str>,
        precision: &str,
        saved: &SavedModel,
    ) -> PyResult<EngineChoice> {
        let precision = Precision::from_name(precision).map_err(raised)?;
        let single = precision == Precision::F32;
        let solver = solver.filter(|s| *s != AUTO);
        // Methods that solve in their own way, with the adjoints of their own steps.
        let own = match (method, solver) {
            (EXACT | SURROGATE, Some(other)) if other != method => {
                return Err(settings(format!(
                    "method `{method}` solves in its own way; drop `solver`"
                )));
            }
            (EXACT | SURROGATE, _) => Some(method),
            (AUTO, Some(name @ (EXACT | SURROGATE))) => Some(name),
            _ => None,
        };
        if let Some(name) = own {
            if single {
                return Err(settings(format!("method `{name}` runs in doubles; drop `precision`")));
            }
            return Ok(EngineChoice::new(self.settings_for(name, saved)?));
        }
        let (found, gradient) = match (method, solver) {
            (AUTO, None) if !single => (self.settings_for(AUTO, saved), GradientChoice::Adjoint),
            (AUTO, _) => (self.settings(solver.unwrap_or("tsit5")), GradientChoice::Adjoint),
            (name, _) => {
                let known = || {
                    let names = GradientChoice::ALL.iter().map(|(n, _)| *n);
                    [AUTO, EXACT, SURROGATE].into_iter().chain(names).collect::<Vec<_>>().join(", ")
                };
                let choice = GradientChoice::from_name(name).map_err(|_| {
                    settings(format!("unknown method `{name}`; known: {}", known()))
                })?;
                (self.settings(solver.unwrap_or("tsit5")), choice)
            }
        };
        Ok(EngineChoice { settings: found?, automatic: false, gradient, precision })
    }
}

/// How sealed masses are found.
pub(crate) fn mass_options(choice: &str, surfaces: Option<PathBuf>) -> PyResult<MassOptions> {
    let choice = MassChoice::from_name(&choice.replace('_', "-")).map_err(raised)?;
    let surfaces = surfaces.map(MuscleSurfaces::read).transpose().map_err(raised)?;
    Ok(MassOptions { choice, surfaces })
}

/// Every name that an argument may have, with one line on each: `{kind: {name: description}}`.
#[pyfunction]
pub(crate) fn names(py: Python<'_>) -> PyResult<Bound<'_, PyDict>> {
    let all = PyDict::new(py);
    let put = |kind: &str, names: Vec<(&str, String)>| {
        let table = PyDict::new(py);
        for (name, description) in names {
            table.set_item(name, description)?;
        }
        all.set_item(kind, table)
    };
    fn of<T: NamedChoice>() -> Vec<(&'static str, String)> {
        T::ALL.iter().map(|(name, _, text)| (*name, (*text).to_owned())).collect()
    }
    put("input", of::<Interpolation>())?;
    put("masses", of::<MassChoice>())?;
    put("precision", of::<Precision>())?;
    put("pressure", of::<PressureReference>())?;
    put("loss", AnyLoss::all().into_iter().map(|(n, d)| (n, d.to_owned())).collect())?;
    put("activation", Activation::names().into_iter().map(|n| (n, String::new())).collect())?;
    put("solver", Tableau::NAMES.iter().map(|n| (*n, String::new())).collect())?;
    let own = [
        (AUTO, "exact where it applies, else adjoint"),
        (EXACT, "closed form, for networks of leaky_relu or relu"),
        (SURROGATE, "steps on a piecewise polynomial of a smooth network"),
    ];
    let methods = GradientChoice::ALL.iter().map(|(n, c)| (*n, c.describe().to_string()));
    put("method", own.map(|(n, d)| (n, d.to_owned())).into_iter().chain(methods).collect())?;
    Ok(all)
}
