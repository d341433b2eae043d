//! Models: loaded, built, predicted with, evaluated.

use crate::arrays::{rows, tensor};
use crate::errors::{predict, raised, settings};
use crate::options::{StepOptions, mass_options};
use crate::recording::Recording;
use crate::watch::{brief, watched};
use numpy::{PyArray1, PyArray2, PyArrayDyn, PyReadonlyArray1, PyReadonlyArrayDyn};
use numpy::{PyReadonlyArray2, PyUntypedArrayMethods};
use pam_autodiff::linearise;
use pam_cli::options::describe_model;
use pam_cli::options::{DEFAULT_MODEL, SPRING_DAMPER, built_in_spring_damper, default_model};
use pam_core::force::{Dense, ForceParts, Tensor};
use pam_core::units::MN_PER_N;
use pam_core::{
    Activation, AnyForce, ForceInput, JointModel, Mlp, MuscleGeometry, NetworkForce,
    PhysicalParameters, RawParameters, Scalar, SealedMasses,
};
use pam_data::models::{load_model, save_model};
use pam_data::{MassOptions, ModelInfo, RigFile, SavedModel, Subject};
use pam_effects::{EffectRecord, ExtendedModel};
use pam_report::{EvaluationContext, evaluation_report};
use pam_trajectory::Predictor;
use pyo3::prelude::*;
use std::path::PathBuf;
use std::sync::atomic::{AtomicUsize, Ordering};

type Column<'py> = Bound<'py, PyArray1<f64>>;

/// A model with its effects.
#[pyclass(frozen, module = "pam_ode._pam")]
pub(crate) struct Model {
    pub(crate) saved: SavedModel,
    pub(crate) extended: ExtendedModel,
}

impl Model {
    pub(crate) fn of(saved: SavedModel) -> PyResult<Self> {
        saved.model.validate().map_err(raised)?;
        let extended = ExtendedModel::from_saved(saved.clone()).map_err(raised)?;
        Ok(Self { saved, extended })
    }

    /// Recordings with their masses.
    pub(crate) fn subjects(
        &self,
        recordings: &[PyRef<'_, Recording>],
        options: &MassOptions,
    ) -> PyResult<Vec<Subject>> {
        let recordings = recordings.iter().map(|r| (*r.inner).clone()).collect();
        Subject::resolve(recordings, &self.saved, options).map_err(raised)
    }
}

/// The force of a model with other tensors, in the order of its parts.
fn with_tensors(
    force: &AnyForce<f64>,
    values: &[PyReadonlyArrayDyn<'_, f64>],
) -> PyResult<AnyForce<f64>> {
    let mut parts = force.to_parts();
    for ((name, tensor), array) in parts.tensors.iter_mut().zip(values) {
        if array.shape() != tensor.shape {
            return Err(settings(format!(
                "parameter `{name}` has shape {:?}; the model's is {:?}",
                array.shape(),
                tensor.shape
            )));
        }
        tensor.values = array.as_array().iter().copied().collect();
    }
    AnyForce::from_parts(force.kind(), &parts).map_err(raised)
}

#[pymethods]
impl Model {
    /// Loads a model file, `default` or `spring-damper`.
    #[staticmethod]
    #[pyo3(signature = (path, activation, rig_file))]
    fn load(path: PathBuf, activation: Option<&str>, rig_file: Option<PathBuf>) -> PyResult<Self> {
        let mut saved = match path.to_str() {
            Some(SPRING_DAMPER) => {
                let rig = rig_file.map(RigFile::read).transpose().map_err(raised)?;
                built_in_spring_damper(rig.as_ref())
            }
            Some(DEFAULT_MODEL) => default_model().map_err(raised)?,
            _ => load_model(&path).map_err(raised)?,
        };
        if let Some(name) = activation {
            let AnyForce::Network(force) = &saved.model.force else {
                return Err(settings("`activation` is for networks"));
            };
            let activation = Activation::from_name(name).map_err(raised)?;
            let mlp = Mlp::new(force.mlp().layers().to_vec(), activation).map_err(raised)?;
            saved.model.force = AnyForce::Network(NetworkForce::new(mlp).map_err(raised)?);
        }
        Self::of(saved)
    }

    /// A network model from layers (weight `[outputs, inputs]`, bias `[outputs]`) and physical parameters.
    #[staticmethod]
    #[pyo3(signature = (layers, activation, *, activation_parameters, mass_kg, gas_coefficient, deformation, damping_kg_s, radius_mm, length_mm, name, trained))]
    fn from_layers(
        layers: Vec<(PyReadonlyArray2<'_, f64>, PyReadonlyArray1<'_, f64>)>,
        activation: &str,
        activation_parameters: Option<&str>,
        mass_kg: Option<f64>,
        gas_coefficient: Option<f64>,
        deformation: Option<f64>,
        damping_kg_s: f64,
        radius_mm: Option<f64>,
        length_mm: Option<f64>,
        name: String,
        trained: bool,
    ) -> PyResult<Self> {
        let dense = layers.iter().enumerate().map(|(k, (weight, bias))| {
            if weight.shape()[0] != bias.len() {
                return Err(settings(format!(
                    "layer {k}: a weight of shape {:?} needs a bias of {} numbers, not {}; weights are [outputs, inputs]",
                    weight.shape(),
                    weight.shape()[0],
                    bias.len()
                )));
            }
            let values: Vec<f64> = weight.as_array().iter().copied().collect();
            Dense::from_rows(&values, bias.as_array().to_vec()).map_err(raised)
        });
        let activation = match activation_parameters {
            Some(json) => Activation::from_name_and_json(activation, json),
            None => Activation::from_name(activation),
        };
        let mlp = Mlp::new(dense.collect::<PyResult<Vec<_>>>()?, activation.map_err(raised)?);
        let force = NetworkForce::new(mlp.map_err(raised)?).map_err(raised)?;
        let sheet = PhysicalParameters::datasheet();
        let physical = PhysicalParameters {
            mass_kg: mass_kg.unwrap_or(sheet.mass_kg),
            gas_coefficient: gas_coefficient.unwrap_or(sheet.gas_coefficient),
            deformation: deformation.unwrap_or(sheet.deformation),
        };
        physical.validate().map_err(raised)?;
        let usual = MuscleGeometry::default();
        let model = JointModel {
            raw: physical.to_raw(),
            geometry: MuscleGeometry {
                radius_mm: radius_mm.unwrap_or(usual.radius_mm),
                length_mm: length_mm.unwrap_or(usual.length_mm),
            },
            auxiliary_damping_kg_s: damping_kg_s,
            force: AnyForce::Network(force),
        };
        let info = ModelInfo {
            name,
            provenance: "built in Python".into(),
            trained,
            ..ModelInfo::default()
        };
        Self::of(SavedModel { model, info })
    }

    /// Writes `.safetensors` or `.eqx`.
    fn save(&self, py: Python<'_>, path: PathBuf) -> PyResult<()> {
        brief(py, |_| save_model(&path, &self.saved))?.map_err(raised)
    }

    #[getter]
    fn name(&self) -> &str {
        &self.saved.info.name
    }

    #[getter]
    fn provenance(&self) -> &str {
        &self.saved.info.provenance
    }

    #[getter]
    fn trained(&self) -> bool {
        self.saved.info.trained
    }

    #[getter]
    fn trained_on(&self) -> Vec<String> {
        self.saved.info.trained_on.clone()
    }

    /// `mlp` or `spring_damper`.
    #[getter]
    fn force_kind(&self) -> &'static str {
        self.saved.model.force.kind()
    }

    fn describe(&self) -> String {
        describe_model(&self.saved)
    }

    /// Name and values of the effects, as JSON.
    fn effects(&self) -> String {
        serde_json::Value::Array(self.saved.info.effects.clone()).to_string()
    }

    /// Mass (kg), gas coefficient (kPa mm³/g), deformation coefficient, auxiliary damping (kg/s), radius and length (mm).
    fn physical(&self) -> [f64; 6] {
        let (m, p) = (&self.saved.model, self.saved.model.physical());
        let g = m.geometry;
        let [damping, radius, length] = [m.auxiliary_damping_kg_s, g.radius_mm, g.length_mm];
        [p.mass_kg, p.gas_coefficient, p.deformation, damping, radius, length]
    }

    /// Mass, gas coefficient and deformation coefficient before softplus.
    fn raw(&self) -> [f64; 3] {
        let raw = self.saved.model.raw;
        [raw.mass, raw.gas_coefficient, raw.deformation]
    }

    /// The tensors of the force: name and array.
    fn tensors<'py>(
        &self,
        py: Python<'py>,
    ) -> PyResult<Vec<(String, Bound<'py, PyArrayDyn<f64>>)>> {
        let ForceParts { tensors, .. } = self.saved.model.force.to_parts();
        let array = |(name, t): (String, Tensor)| Ok((name, tensor(py, &t.shape, t.values)?));
        tensors.into_iter().map(array).collect()
    }

    /// Settings of the force: the activation with its parameters.
    fn settings(&self) -> Vec<(String, String)> {
        self.saved.model.force.to_parts().settings
    }

    /// The model with other numbers.
    #[pyo3(signature = (tensors, raw, damping_kg_s, effects))]
    fn with_numbers(
        &self,
        tensors: Vec<PyReadonlyArrayDyn<'_, f64>>,
        raw: [f64; 3],
        damping_kg_s: f64,
        effects: Vec<f64>,
    ) -> PyResult<Self> {
        let mut saved = self.saved.clone();
        let [mass, gas_coefficient, deformation] = raw;
        saved.model.raw = RawParameters { mass, gas_coefficient, deformation };
        saved.model.auxiliary_damping_kg_s = damping_kg_s;
        saved.model.force = with_tensors(&self.saved.model.force, &tensors)?;
        saved.info.source = None;
        let own = self.extended.parameters().len();
        if effects.len() != own {
            return Err(settings(format!(
                "{} effect parameters; the model has {own}",
                effects.len()
            )));
        }
        let mut extended = self.extended.clone();
        extended.effects =
            pam_effects::ActiveEffect::with_parameters(&self.extended.effects, &effects);
        saved.info.effects = extended.to_saved().info.effects;
        Self::of(saved)
    }

    /// The parameters of the effects, in turn.
    fn effect_parameters<'py>(&self, py: Python<'py>) -> Column<'py> {
        PyArray1::from_vec(py, self.extended.parameters())
    }

    /// The model with these effects (`ID:NAME=VALUE,…`) in place of its own.
    fn with_effects(&self, effects: Vec<String>) -> PyResult<Self> {
        let active = effects.iter().map(|text| {
            text.parse::<EffectRecord>().and_then(|record| record.resolve(&[])).map_err(raised)
        });
        let extended = ExtendedModel {
            effects: active.collect::<PyResult<Vec<_>>>()?,
            ..self.extended.clone()
        };
        Self::of(extended.to_saved())
    }

    /// The plain model that comes nearest, and what became of the effects.
    fn without_effects(&self) -> PyResult<(Self, Option<String>)> {
        let plain = self.extended.without_effects();
        let sentence = plain.sentence();
        Ok((Self::of(plain.saved)?, sentence))
    }

    /// The masses (g) that hold these pressures (kPa absolute) at a displacement (mm).
    fn gas_law_masses(&self, displacement_mm: f64, pressures_kpa: [f64; 2]) -> [f64; 2] {
        let m = self.saved.model.gas_law_masses(displacement_mm, pressures_kpa);
        [m.flexor_g, m.extensor_g]
    }

    /// The pressures (kPa absolute) of sealed masses (g) at a displacement (mm).
    fn gas_law_pressures(&self, displacement_mm: f64, masses_g: [f64; 2]) -> [f64; 2] {
        let masses = SealedMasses { flexor_g: masses_g[0], extensor_g: masses_g[1] };
        self.saved.model.gas_law_pressures_kpa(displacement_mm, masses)
    }

    /// Force (N), stiffness (N/mm) and damping (kg/s) at points of equal number, and the published estimate of the stiffness
    /// with the step `h_mm`.
    fn linearise<'py>(
        &self,
        py: Python<'py>,
        displacement_mm: PyReadonlyArray1<'py, f64>,
        velocity_mm_s: PyReadonlyArray1<'py, f64>,
        mass_flexor_g: PyReadonlyArray1<'py, f64>,
        mass_extensor_g: PyReadonlyArray1<'py, f64>,
        h_mm: f64,
    ) -> PyResult<[Column<'py>; 4]> {
        let [x, v, f, e] = [&displacement_mm, &velocity_mm_s, &mass_flexor_g, &mass_extensor_g]
            .map(|a| a.as_array());
        let force = &self.saved.model.force;
        let columns = {
            let dual = force.map(num_dual_constant);
            let mut columns: [Vec<f64>; 4] = Default::default();
            for k in 0..x.len() {
                let at = ForceInput {
                    displacement_mm: x[k],
                    velocity_mm_s: v[k],
                    mass_flexor_g: f[k],
                    mass_extensor_g: e[k],
                };
                let exact = linearise(&dual, &at);
                let scheme = pam_autodiff::FourPointSmoothed { h: h_mm };
                let estimate = pam_autodiff::stiffness_by_difference_n_mm(force, &at, &scheme);
                let row =
                    [exact.force_mn / MN_PER_N, exact.stiffness_n_mm, exact.damping_kg_s, estimate];
                columns.iter_mut().zip(row).for_each(|(c, value)| c.push(value));
            }
            columns
        };
        Ok(columns.map(|c| PyArray1::from_vec(py, c)))
    }

    /// Predicts recordings: the states `[samples, 4]`, the masses, and (accepted, rejected, evaluations) of each.
    #[pyo3(signature = (recordings, masses_g, method, steps, masses, surfaces))]
    fn predict<'py>(
        &self,
        py: Python<'py>,
        recordings: Vec<PyRef<'_, Recording>>,
        masses_g: Option<[f64; 2]>,
        method: &str,
        steps: StepOptions,
        masses: &str,
        surfaces: Option<PathBuf>,
    ) -> PyResult<Vec<(Bound<'py, PyArray2<f64>>, [f64; 2], [usize; 3])>> {
        let solver = steps.for_predictions(method, &self.saved)?;
        let options = mass_options(masses, surfaces)?;
        let mut subjects = self.subjects(&recordings, &options)?;
        if let Some([flexor, extensor]) = masses_g {
            let given = SealedMasses::new(flexor, extensor).map_err(raised)?;
            subjects.iter_mut().for_each(|s| s.masses = given);
        }
        let extended = &self.extended;
        let predictions = watched(py, |stop| {
            pam_core::parallel::map(subjects.len(), |k| {
                stop.check();
                extended.predict(&subjects[k].recording, subjects[k].masses, &solver)
            })
        })?;
        let mut all = Vec::with_capacity(predictions.len());
        for (predicted, subject) in predictions.into_iter().zip(&subjects) {
            let p = predicted.map_err(|e| predict(&e, &subject.recording.time_s))?;
            let c = &p.channels;
            let states: Vec<[f64; 4]> =
                (0..p.len()).map(|k| [c.x[k], c.v[k], c.pf[k], c.pe[k]]).collect();
            let s = p.statistics;
            let masses = [subject.masses.flexor_g, subject.masses.extensor_g];
            all.push((rows(py, &states), masses, [s.accepted, s.rejected, s.evaluations]));
        }
        Ok(all)
    }

    /// Predicts recordings and scores the predictions.
    #[pyo3(signature = (recordings, method, steps, masses, surfaces, progress))]
    fn evaluate(
        &self,
        py: Python<'_>,
        recordings: Vec<PyRef<'_, Recording>>,
        method: &str,
        steps: StepOptions,
        masses: &str,
        surfaces: Option<PathBuf>,
        progress: Option<Py<PyAny>>,
    ) -> PyResult<Evaluation> {
        let solver = steps.for_predictions(method, &self.saved)?;
        let subjects = self.subjects(&recordings, &mass_options(masses, surfaces)?)?;
        let (total, done) = (subjects.len() as f64, AtomicUsize::new(0));
        let evaluation = watched(py, |stop| {
            pam_train::evaluate_joint(
                &self.extended,
                &self.saved.model,
                subjects,
                &solver,
                &|r| r,
                &|| {
                    stop.check();
                    let k = done.fetch_add(1, Ordering::Relaxed) + 1;
                    stop.call(progress.as_ref(), ("predicting", k as f64 / total, ""));
                },
            )
        })?;
        let context = EvaluationContext {
            model: self.saved.info.clone(),
            model_line: describe_model(&self.saved),
            solver_line: solver.describe(),
            trained_on: self.saved.info.trained_on.clone(),
            made_by: pam_cli::run_record::made_by(),
        };
        Ok(Evaluation { evaluation, model: self.saved.model.clone(), context })
    }
}

fn num_dual_constant(value: f64) -> num_dual::Dual64 {
    Scalar::constant(value)
}

/// An evaluation of a model on recordings.
#[pyclass(frozen, module = "pam_ode._pam")]
pub(crate) struct Evaluation {
    evaluation: pam_train::Evaluation,
    model: JointModel<f64, AnyForce<f64>>,
    context: EvaluationContext,
}

#[pymethods]
impl Evaluation {
    /// All results as JSON, as in `evaluation.json`.
    fn json(&self) -> String {
        self.evaluation.to_json().to_string()
    }

    /// Name, measured and predicted states `[samples, 4]` and time of the `index`-th recording.
    fn trajectory<'py>(
        &self,
        py: Python<'py>,
        index: usize,
    ) -> PyResult<(Bound<'py, PyAny>, Bound<'py, PyArray2<f64>>)> {
        let r =
            self.evaluation.recordings.get(index).ok_or_else(|| {
                settings(format!("there is no recording {index} in this evaluation"))
            })?;
        let c = &r.prediction.channels;
        let states: Vec<[f64; 4]> =
            (0..r.prediction.len()).map(|k| [c.x[k], c.v[k], c.pf[k], c.pe[k]]).collect();
        let recording = Recording::wrapped(py, std::sync::Arc::new(r.recording.clone()))?;
        Ok((recording, rows(py, &states)))
    }

    /// The page `report.html`.
    fn report(&self, py: Python<'_>) -> PyResult<String> {
        brief(py, |_| evaluation_report(&self.evaluation, &self.model, &self.context))
    }
}
