//! Plans and reachable stiffness.

use crate::arrays::rows;
use crate::errors::{raised, settings};
use crate::model::Model;
use crate::watch::watched;
use numpy::{PyArray1, PyArray2, PyReadonlyArray1, PyReadonlyArray2};
use pam_control::export::{c_header, table_bytes, table_csv};
use pam_control::motion::{MotionSpec, StiffnessProfile};
use pam_control::report::plan_report;
use pam_control::synthesis::{MassBounds, Outcome, SynthesisSettings, Target, plan::targets};
use pam_core::units::MN_PER_N;
use pyo3::prelude::*;
use std::borrow::Cow;

/// A planned trajectory.
#[pyclass(frozen, module = "pam_ode._pam")]
pub(crate) struct Plan {
    plan: pam_control::synthesis::Plan,
    certified: Option<Vec<bool>>,
    lead: String,
}

/// Bounds from masses (g), or those of the model's rig, or those of the training conditions.
fn synthesis(model: &Model, bounds: Option<[f64; 2]>, step_mm: f64) -> PyResult<SynthesisSettings> {
    let joint = &model.saved.model;
    let limits = model.saved.info.rig.as_ref().and_then(|rig| rig.limits.pressure_kpa);
    let bounds = match (bounds, limits) {
        (Some([least, most]), _) => MassBounds::new(least, most).map_err(raised)?,
        (None, Some(limits)) => MassBounds::of_pressures(joint, limits),
        (None, None) => MassBounds::trained(joint),
    };
    let found =
        SynthesisSettings { stiffness_step_mm: step_mm, ..SynthesisSettings::published(bounds) };
    found.validate().map_err(raised)?;
    Ok(found)
}

fn planned(
    py: Python<'_>,
    model: &Model,
    targets: Vec<Target>,
    exact: bool,
    bounds: Option<[f64; 2]>,
    step_mm: f64,
) -> PyResult<Plan> {
    if !model.extended.effects.is_empty() {
        return Err(settings("plans are for models without effects: take model.without_effects()"));
    }
    let synthesis = synthesis(model, bounds, step_mm)?;
    let joint = &model.saved.model;
    let (plan, certified) = watched(py, |_| {
        if !exact {
            return Ok((pam_control::synthesis::Plan::new(joint, targets, synthesis)?, None));
        }
        let (plan, certificates) =
            pam_control::synthesis::Plan::certified(joint, targets, synthesis)?;
        Ok((plan, Some(certificates.iter().map(pam_exact_complete).collect())))
    })?
    .map_err(|e: pam_control::ControlError| raised(e))?;
    let lead =
        format!("{} {}", model.saved.info.name, pam_cli::options::describe_model(&model.saved));
    Ok(Plan { plan, certified, lead })
}

fn pam_exact_complete(certificate: &pam_exact::Certificate) -> bool {
    certificate.is_complete()
}

/// Plans a motion in words or of a CSV file.
#[pyfunction]
#[pyo3(signature = (model, motion, stiffness, *, load_n, rate_hz, exact, mass_bounds_g, stiffness_step_mm))]
pub(crate) fn plan_motion(
    py: Python<'_>,
    model: &Model,
    motion: &str,
    stiffness: Option<&str>,
    load_n: f64,
    rate_hz: f64,
    exact: bool,
    mass_bounds_g: Option<[f64; 2]>,
    stiffness_step_mm: f64,
) -> PyResult<Plan> {
    let spec = MotionSpec::parse(motion).map_err(raised)?;
    let profile = stiffness.map(StiffnessProfile::parse).transpose().map_err(raised)?;
    let targets = targets(&spec, profile.as_ref(), load_n, rate_hz).map_err(raised)?;
    planned(py, model, targets, exact, mass_bounds_g, stiffness_step_mm)
}

/// Plans targets `[samples, 6]`: time (s), displacement (mm), velocity, acceleration, stiffness (N/mm), load (N).
#[pyfunction]
#[pyo3(signature = (model, targets, *, exact, mass_bounds_g, stiffness_step_mm))]
pub(crate) fn plan_targets(
    py: Python<'_>,
    model: &Model,
    targets: PyReadonlyArray2<'_, f64>,
    exact: bool,
    mass_bounds_g: Option<[f64; 2]>,
    stiffness_step_mm: f64,
) -> PyResult<Plan> {
    let rows = crate::arrays::to_rows::<6>("targets", &targets)?;
    let target = |r: [f64; 6]| Target {
        time_s: r[0],
        displacement_mm: r[1],
        velocity_mm_s: r[2],
        acceleration_mm_s2: r[3],
        stiffness_n_mm: r[4],
        load_mn: r[5] * MN_PER_N,
    };
    let targets = rows.into_iter().map(target).collect();
    planned(py, model, targets, exact, mass_bounds_g, stiffness_step_mm)
}

/// Least and largest stiffness (N/mm) at each displacement (mm) at a velocity (mm/s), `[points, 2]`; NaN where no masses hold
/// it.
#[pyfunction]
pub(crate) fn reachable<'py>(
    py: Python<'py>,
    model: &Model,
    displacements_mm: PyReadonlyArray1<'py, f64>,
    velocity_mm_s: f64,
    mass_bounds_g: Option<[f64; 2]>,
    stiffness_step_mm: f64,
) -> PyResult<Bound<'py, PyArray2<f64>>> {
    let synthesis = synthesis(model, mass_bounds_g, stiffness_step_mm)?;
    let places = displacements_mm.as_array().to_vec();
    let joint = &model.saved.model;
    let ranges = watched(py, |_| {
        pam_control::stiffness::reachable(joint, &places, &[velocity_mm_s], synthesis)
    })?
    .map_err(raised)?;
    let found: Vec<[f64; 2]> =
        ranges.iter().map(|r| r.stiffness_n_mm.unwrap_or([f64::NAN; 2])).collect();
    Ok(rows(py, &found))
}

#[pymethods]
impl Plan {
    /// The plan in a few numbers, as JSON.
    fn summary(&self) -> String {
        serde_json::to_string(&self.plan.summary()).unwrap_or_default()
    }

    /// Time, displacement, velocity, acceleration, stiffness and load (N) that were wanted, `[samples, 6]`.
    fn targets<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray2<f64>> {
        let row = |t: &Target| {
            [
                t.time_s,
                t.displacement_mm,
                t.velocity_mm_s,
                t.acceleration_mm_s2,
                t.stiffness_n_mm,
                t.load_mn / MN_PER_N,
            ]
        };
        rows(py, &self.plan.targets.iter().map(row).collect::<Vec<_>>())
    }

    /// Masses (g), `[samples, 2]`.
    fn masses_g<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray2<f64>> {
        let masses = self.plan.solutions.iter().map(|s| [s.masses.flexor_g, s.masses.extensor_g]);
        rows(py, &masses.collect::<Vec<_>>())
    }

    /// Pressures (kPa absolute), `[samples, 2]`.
    fn pressures_kpa<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray2<f64>> {
        rows(py, &self.plan.pressures_kpa)
    }

    /// Stiffness (N/mm) that the masses have, `[samples]`.
    fn stiffness_n_mm<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        PyArray1::from_iter(py, self.plan.solutions.iter().map(|s| s.stiffness_n_mm))
    }

    /// Whether the wanted stiffness is reached, `[samples]`.
    fn reached<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<bool>> {
        let reached = self.plan.solutions.iter().map(|s| s.outcome == Outcome::Reached);
        PyArray1::from_iter(py, reached)
    }

    /// Whether the masses lie outside those that the model was trained on, `[samples]`.
    fn extrapolates<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<bool>> {
        let samples = 0..self.plan.targets.len();
        PyArray1::from_iter(py, samples.map(|k| self.plan.extrapolates(k)))
    }

    /// Whether each sample is proven to be the global optimum; `None` for plans without certificates.
    fn certified<'py>(&self, py: Python<'py>) -> Option<Bound<'py, PyArray1<bool>>> {
        self.certified.as_ref().map(|c| PyArray1::from_slice(py, c))
    }

    /// The lookup table as CSV.
    fn csv(&self) -> String {
        table_csv(&self.plan)
    }

    /// The lookup table as a C header.
    fn c_header(&self) -> String {
        c_header(&self.plan)
    }

    /// The lookup table in the binary format for microcontrollers.
    fn table_bytes(&self) -> Cow<'_, [u8]> {
        Cow::Owned(table_bytes(&self.plan))
    }

    /// The page `report.html`.
    fn report(&self, title: &str) -> String {
        plan_report(&self.plan, title, &self.lead, &pam_cli::run_record::made_by())
    }
}
