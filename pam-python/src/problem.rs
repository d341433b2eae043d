//! Value and gradient of a loss on recordings, again and again for changing parameters.

use crate::arrays::{rows, tensor, to_rows};
use crate::errors::{engine, raised, settings};
use crate::loss::Loss;
use crate::model::Model;
use crate::options::{StepOptions, mass_options};
use crate::recording::Recording;
use crate::watch::{Stop, brief, watched};
use numpy::{PyArray1, PyArray2, PyArrayDyn, PyReadonlyArray2, PyReadonlyArrayDyn};
use numpy::{PyUntypedArrayMethods, ndarray};
use pam_core::{AnyForce, JointModel, ParametricForce, RawParameters, SealedMasses};
use pam_data::SavedModel;
use pam_effects::ActiveEffect;
use pam_effects::engine::{EngineChoice, choose};
use pam_trajectory::engine::TrajectoryEngine;
use pam_trajectory::{TrajectoryGradient, TrajectoryRequest, Windows};
use pyo3::prelude::*;
use std::path::PathBuf;
use std::sync::{Mutex, PoisonError};

/// Samples up to which a call is too short to be watched for signals.
const BRIEF_SAMPLES: usize = 20_000;

/// An engine, with windows of its own if its masses are not those of the problem.
struct Work {
    engine: Box<dyn TrajectoryEngine<AnyForce<f64>>>,
    windows: Option<Windows>,
}

/// A model, recordings and a loss. Engines keep their memory from call to call; calls from several threads have one each.
#[pyclass(frozen, module = "pam_ode._pam")]
pub(crate) struct Problem {
    saved: SavedModel,
    effects: Vec<ActiveEffect>,
    windows: Windows,
    choice: EngineChoice,
    loss: Loss,
    free: Mutex<Vec<Work>>,
    samples: usize,
    tensors: Tensors,
}

/// How the tensors of a force, row-major one after another, lie among its parameters.
struct Tensors {
    names: Vec<String>,
    shapes: Vec<Vec<usize>>,
    /// The parameter of each number of the tensors.
    parameter: Vec<usize>,
}

impl Tensors {
    fn of(force: &AnyForce<f64>) -> Self {
        // The tensors of a force whose parameters are their own indices.
        let indices: Vec<f64> = (0..force.parameter_len()).map(|k| k as f64).collect();
        let parts = force.with_parameters(&indices).to_parts().tensors;
        Self {
            names: parts.iter().map(|(name, _)| name.clone()).collect(),
            shapes: parts.iter().map(|(_, t)| t.shape.clone()).collect(),
            parameter: parts.iter().flat_map(|(_, t)| &t.values).map(|v| *v as usize).collect(),
        }
    }

    /// The force with these tensors.
    fn force(
        &self,
        like: &AnyForce<f64>,
        arrays: &[PyReadonlyArrayDyn<'_, f64>],
    ) -> PyResult<AnyForce<f64>> {
        if arrays.len() != self.shapes.len() {
            return Err(settings(format!(
                "{} tensors; the force has {}",
                arrays.len(),
                self.shapes.len()
            )));
        }
        let mut parameters = vec![0.0; self.parameter.len()];
        let mut places = self.parameter.iter();
        for ((name, shape), array) in self.names.iter().zip(&self.shapes).zip(arrays) {
            if array.shape() != shape {
                return Err(settings(format!(
                    "parameter `{name}` has shape {:?}; the model's is {shape:?}",
                    array.shape()
                )));
            }
            // In logical order, whatever the layout; a slice is faster to go through.
            match array.as_array().as_slice() {
                Some(values) => {
                    values.iter().zip(&mut places).for_each(|(v, k)| parameters[*k] = *v);
                }
                None => {
                    array.as_array().iter().zip(&mut places).for_each(|(v, k)| parameters[*k] = *v);
                }
            }
        }
        if let Some(k) = self.parameter.iter().position(|k| !parameters[*k].is_finite()) {
            let mut first = 0;
            let name = self.names.iter().zip(&self.shapes).find_map(|(name, shape)| {
                first += shape.iter().product::<usize>();
                (k < first).then_some(name.as_str())
            });
            return Err(settings(format!(
                "parameter `{}` holds {}; the training has diverged, take a smaller rate",
                name.unwrap_or("?"),
                parameters[self.parameter[k]]
            )));
        }
        Ok(like.with_parameters(&parameters))
    }

    /// Parameters as tensors.
    fn arrays<'py>(
        &self,
        py: Python<'py>,
        parameters: &[f64],
    ) -> PyResult<Vec<Bound<'py, PyArrayDyn<f64>>>> {
        let mut places = &self.parameter[..];
        let one = |shape: &Vec<usize>| {
            let (own, rest) = places.split_at(shape.iter().product());
            places = rest;
            tensor(py, shape, own.iter().map(|k| parameters[*k]).collect())
        };
        self.shapes.iter().map(one).collect()
    }
}

/// The numbers at which a problem is evaluated.
struct At {
    model: JointModel<f64, AnyForce<f64>>,
    effects: Vec<f64>,
    masses: Option<Vec<[f64; 2]>>,
    starts: Option<Vec<[f64; 4]>>,
}

/// Parameters as Python passes them: tensors of the force in their order, raw, damping, effects, masses, starts.
type Numbers<'py> = (
    Vec<PyReadonlyArrayDyn<'py, f64>>,
    [f64; 3],
    f64,
    Vec<f64>,
    Option<PyReadonlyArray2<'py, f64>>,
    Option<PyReadonlyArray2<'py, f64>>,
);

/// Gradients in the same order.
type Gradients<'py> = (
    Vec<Bound<'py, PyArrayDyn<f64>>>,
    Bound<'py, PyArray1<f64>>,
    f64,
    Bound<'py, PyArray1<f64>>,
    Bound<'py, PyArray2<f64>>,
    Bound<'py, PyArray2<f64>>,
);

/// Recordings that stopped early: index, time (s), why.
type Failures = Vec<(usize, f64, String)>;

impl Problem {
    fn at(&self, numbers: Numbers<'_>) -> PyResult<At> {
        let (tensors, [mass, gas_coefficient, deformation], damping, effects, masses, starts) =
            numbers;
        if effects.len() != self.effects.iter().map(|e| e.parameters().len()).sum::<usize>() {
            return Err(settings("`effects` must hold one number for each parameter of an effect"));
        }
        let count = self.windows.subjects().len();
        let masses = masses.map(|m| to_rows::<2>("masses_g", &m)).transpose()?;
        let starts = starts.map(|s| to_rows::<4>("initial_states", &s)).transpose()?;
        let lengths = [
            ("masses_g", masses.as_ref().map(Vec::len)),
            ("initial_states", starts.as_ref().map(Vec::len)),
        ];
        for (what, len) in lengths {
            if len.is_some_and(|n| n != count) {
                return Err(settings(format!("`{what}` must have one row per recording, {count}")));
            }
        }
        let known = self.windows.subjects().iter();
        let same = |m: &Vec<[f64; 2]>| {
            known.zip(m).all(|(s, m)| [s.masses.flexor_g, s.masses.extensor_g] == *m)
        };
        let masses = masses.filter(|m| !same(m));
        for [flexor, extensor] in masses.iter().flatten() {
            SealedMasses::new(*flexor, *extensor).map_err(raised)?;
        }
        let model = JointModel {
            raw: RawParameters { mass, gas_coefficient, deformation },
            geometry: self.saved.model.geometry,
            auxiliary_damping_kg_s: damping,
            force: self.tensors.force(&self.saved.model.force, &tensors)?,
        };
        Ok(At { model, effects, masses, starts })
    }

    fn take(&self) -> Option<Work> {
        self.free.lock().unwrap_or_else(PoisonError::into_inner).pop()
    }

    fn give_back(&self, work: Work) {
        self.free.lock().unwrap_or_else(PoisonError::into_inner).push(work);
    }

    /// Evaluates with an engine of its own; `then` reads what the engine has predicted.
    fn evaluate<T: Send>(
        &self,
        py: Python<'_>,
        at: &At,
        cotangents: Option<&[Vec<[f64; 4]>]>,
        backward: bool,
        then: impl FnOnce(&mut dyn TrajectoryEngine<AnyForce<f64>>, TrajectoryGradient) -> T + Send,
    ) -> PyResult<T> {
        let run = |stop: &Stop| {
            let mut work = match self.take() {
                Some(work) => work,
                None => {
                    let engine = choose(&self.saved.model.force, &self.effects, &self.choice)?;
                    Work { engine, windows: None }
                }
            };
            if let Some(masses) = &at.masses {
                let windows = work.windows.get_or_insert_with(|| self.windows.clone());
                for (subject, m) in windows.subjects_mut().iter_mut().zip(masses) {
                    subject.masses = SealedMasses { flexor_g: m[0], extensor_g: m[1] };
                }
            }
            let windows = match (&at.masses, &work.windows) {
                (Some(_), Some(own)) => own,
                _ => &self.windows,
            };
            let request = TrajectoryRequest {
                effects: &at.effects,
                starts: at.starts.as_deref(),
                ..TrajectoryRequest::new(&at.model, windows)
            };
            let loss = |k: usize,
                        measured: &pam_data::Recording,
                        predicted: &[[f64; 4]],
                        slopes: &mut [[f64; 4]]| {
                stop.check();
                let Some(given) = cotangents else {
                    return self.loss.value_and_cotangents(measured, predicted, slopes, stop);
                };
                slopes.copy_from_slice(&given[k]);
                let products = predicted.iter().flatten().zip(given[k].iter().flatten());
                products.map(|(y, w)| y * w).sum()
            };
            let gradient = work.engine.evaluate(&request, &loss, backward)?;
            let result = then(&mut *work.engine, gradient);
            self.give_back(work);
            Ok(result)
        };
        let short = self.samples <= BRIEF_SAMPLES;
        let result = if short { brief(py, run) } else { watched(py, run) };
        result?.map_err(|e| engine(&e))
    }

    fn failures(&self, gradient: &TrajectoryGradient) -> Failures {
        gradient.failures.iter().map(|f| (f.problem, f.time_s, f.kind.describe(f.time_s))).collect()
    }

    fn gradients<'py>(&self, py: Python<'py>, g: &TrajectoryGradient) -> PyResult<Gradients<'py>> {
        let masses: Vec<[f64; 2]> = g.masses.iter().map(|m| [m.flexor_g, m.extensor_g]).collect();
        Ok((
            self.tensors.arrays(py, &g.force)?,
            PyArray1::from_vec(py, vec![g.raw.mass, g.raw.gas_coefficient, g.raw.deformation]),
            g.auxiliary_damping,
            PyArray1::from_slice(py, &g.effects),
            rows(py, &masses),
            rows(py, &g.initial_states),
        ))
    }
}

#[pymethods]
impl Problem {
    #[new]
    #[pyo3(signature = (model, recordings, loss, *, method, solver, precision, steps, masses, surfaces, horizon_s))]
    fn new(
        model: &Model,
        recordings: Vec<PyRef<'_, Recording>>,
        loss: &Bound<'_, PyAny>,
        method: &str,
        solver: Option<&str>,
        precision: &str,
        steps: StepOptions,
        masses: &str,
        surfaces: Option<PathBuf>,
        horizon_s: Option<f64>,
    ) -> PyResult<Self> {
        if recordings.is_empty() {
            return Err(settings("there is no recording"));
        }
        if horizon_s.is_some_and(|h| !(h.is_finite() && h > 0.0)) {
            return Err(settings("`horizon_s` must be positive"));
        }
        let choice = steps.engine_choice(method, solver, precision, &model.saved)?;
        let subjects = model.subjects(&recordings, &mass_options(masses, surfaces)?)?;
        let windows = Windows::of(subjects, horizon_s);
        let first = choose(&model.saved.model.force, &model.extended.effects, &choice);
        let first = first.map_err(|e| engine(&e))?;
        if choice.precision != first.precision() {
            return Err(settings(
                "precision `f32` is for the adjoint of a network; all else runs in doubles",
            ));
        }
        Ok(Self {
            samples: windows.subjects().iter().map(|s| s.recording.len()).sum(),
            tensors: Tensors::of(&model.saved.model.force),
            saved: model.saved.clone(),
            effects: model.extended.effects.clone(),
            windows,
            choice,
            loss: Loss::of(loss)?,
            free: Mutex::new(vec![Work { engine: first, windows: None }]),
        })
    }

    /// Names of the windows, in their order.
    fn names(&self) -> Vec<String> {
        self.windows.subjects().iter().map(|s| s.recording.name.clone()).collect()
    }

    /// Numbers of samples of the windows.
    fn lengths(&self) -> Vec<usize> {
        self.windows.subjects().iter().map(|s| s.recording.len()).collect()
    }

    /// The masses (g) of the windows, `[windows, 2]`.
    fn masses_g<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray2<f64>> {
        let of = |m: SealedMasses| [m.flexor_g, m.extensor_g];
        rows(py, &self.windows.subjects().iter().map(|s| of(s.masses)).collect::<Vec<_>>())
    }

    /// The measured states at the starts, `[windows, 4]`.
    fn initial_states<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray2<f64>> {
        rows(py, &self.windows.measured_starts())
    }

    /// The mean loss, the loss of each window, and the windows that stopped early.
    fn value<'py>(
        &self,
        py: Python<'py>,
        numbers: Numbers<'py>,
    ) -> PyResult<(f64, Bound<'py, PyArray1<f64>>, Failures)> {
        let at = self.at(numbers)?;
        let g = self.evaluate(py, &at, None, false, |_, g| g)?;
        Ok((g.value, PyArray1::from_slice(py, &g.values), self.failures(&g)))
    }

    /// The mean loss, the loss of each window, the gradients, the windows that stopped early, and counts of work
    /// (accepted, rejected, evaluations, pullbacks, stored bytes).
    fn value_and_gradient<'py>(
        &self,
        py: Python<'py>,
        numbers: Numbers<'py>,
    ) -> PyResult<(f64, Bound<'py, PyArray1<f64>>, Gradients<'py>, Failures, [usize; 5])> {
        let at = self.at(numbers)?;
        let g = self.evaluate(py, &at, None, true, |_, g| g)?;
        let s = g.statistics;
        let work = [s.accepted, s.rejected, s.evaluations, s.pullbacks, s.stored_bytes];
        let values = PyArray1::from_slice(py, &g.values);
        Ok((g.value, values, self.gradients(py, &g)?, self.failures(&g), work))
    }

    /// The states `[samples, 4]` of each window, and the windows that stopped early.
    fn simulate<'py>(
        &self,
        py: Python<'py>,
        numbers: Numbers<'py>,
    ) -> PyResult<(Vec<Bound<'py, PyArray2<f64>>>, Failures)> {
        let at = self.at(numbers)?;
        let none: Vec<Vec<[f64; 4]>> =
            self.windows.subjects().iter().map(|s| vec![[0.0; 4]; s.recording.len()]).collect();
        let count = none.len();
        let (states, g) = self.evaluate(py, &at, Some(&none), false, move |engine, g| {
            let states: Vec<Vec<[f64; 4]>> =
                (0..count).map(|k| engine.predicted(k).to_vec()).collect();
            (states, g)
        })?;
        Ok((states.iter().map(|s| rows(py, s)).collect(), self.failures(&g)))
    }

    /// Products of cotangents `[samples, 4]` of each window's states with the derivative of the states by the numbers.
    fn pullback<'py>(
        &self,
        py: Python<'py>,
        numbers: Numbers<'py>,
        cotangents: Vec<PyReadonlyArray2<'py, f64>>,
    ) -> PyResult<(Gradients<'py>, Failures)> {
        let at = self.at(numbers)?;
        let subjects = self.windows.subjects();
        if cotangents.len() != subjects.len() {
            return Err(settings(format!(
                "{} arrays of cotangents for {} recordings",
                cotangents.len(),
                subjects.len()
            )));
        }
        // The engine averages over the windows that reached their end; a product is a sum.
        let mut given = Vec::with_capacity(cotangents.len());
        for (array, subject) in cotangents.iter().zip(subjects) {
            if array.shape() != [subject.recording.len(), 4] {
                return Err(settings(format!(
                    "cotangents of {} have shape {:?}; its states have [{}, 4]",
                    subject.recording.name,
                    array.shape(),
                    subject.recording.len()
                )));
            }
            let row = |r: ndarray::ArrayView1<'_, f64>| std::array::from_fn(|i| r[i]);
            given.push(array.as_array().outer_iter().map(row).collect::<Vec<[f64; 4]>>());
        }
        let mut g = self.evaluate(py, &at, Some(&given), true, |_, g| g)?;
        let averaged = (subjects.len() - g.failures.len()).max(1);
        scale(&mut g, averaged as f64);
        Ok((self.gradients(py, &g)?, self.failures(&g)))
    }
}

/// Multiplies a gradient.
fn scale(g: &mut TrajectoryGradient, factor: f64) {
    g.force.iter_mut().chain(&mut g.effects).for_each(|v| *v *= factor);
    let raw = &mut g.raw;
    for v in [&mut raw.mass, &mut raw.gas_coefficient, &mut raw.deformation] {
        *v *= factor;
    }
    g.auxiliary_damping *= factor;
    for m in &mut g.masses {
        m.flexor_g *= factor;
        m.extensor_g *= factor;
    }
    g.initial_states.iter_mut().flatten().for_each(|v| *v *= factor);
}
