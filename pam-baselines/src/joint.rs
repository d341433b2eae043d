//! Any joint model as a fitted baseline.
//!
//! The gas is that of the framework's joint: sealed air masses by the gas law at rest, pressures by the
//! volumes. What differs from model to model is the restoring force.

use crate::method::{FittedModel, Run, Stopped, Structure, Trajectory};
use num_dual::Dual64;
use pam_autodiff::linearise;
use pam_core::{
    ForceInput, ForceModel, JointModel, MuscleGeometry, PhysicalParameters, SealedMasses,
};
use pam_data::formats::npz::Array;
use pam_data::{MassChoice, Recording, Subject, resolve_masses};
use pam_train::curriculum::SolverChoice;
use pam_train::warm_start::fit_deformation;
use pam_trajectory::SolverSettings;
use serde_json::Value;
use std::collections::BTreeMap;

/// A restoring force that can be evaluated and differentiated.
pub trait JointForce: ForceModel<f64> + Send + Sync {
    /// The force with dual numbers.
    type Dual: ForceModel<Dual64>;

    /// The force with dual numbers, all constant.
    fn dual(&self) -> Self::Dual;
    /// Number of fitted numbers of the force.
    fn parameter_count(&self) -> usize;
    /// Kind of equations.
    fn structure(&self) -> Structure;
    /// Results of the fit.
    fn details(&self) -> Value;
    /// The fitted numbers.
    fn arrays(&self) -> BTreeMap<String, Array>;
}

/// A joint model with such a force.
#[derive(Debug, Clone)]
pub struct JointBaseline<F> {
    /// Mass, gas and geometry.
    pub physical: PhysicalParameters,
    /// The force.
    pub force: F,
    settings: SolverSettings,
}

impl<F: JointForce> JointBaseline<F> {
    /// A joint with this mass, gas and force, solved as in training.
    ///
    /// # Errors
    /// Never with the default solver; [`pam_core::ModelError`] if it did not exist.
    pub fn new(physical: PhysicalParameters, force: F) -> Result<Self, pam_core::ModelError> {
        Ok(Self { physical, force, settings: SolverChoice::default().settings()? })
    }

    fn model(&self) -> JointModel<f64, &F> {
        let mut model = JointModel::datasheet(&self.force);
        model.raw = self.physical.to_raw();
        model
    }

    /// Sealed masses of a recording by the gas law of this joint; those that its file gives win.
    fn sealed_masses(&self, recording: &Recording) -> Result<SealedMasses, Stopped> {
        resolve_masses(recording, &self.model(), true, MassChoice::GasLaw, None)
            .map(|(masses, _)| masses)
            .map_err(|e| Stopped { why: e.to_string() })
    }
}

impl<F: JointForce> FittedModel for JointBaseline<F> {
    fn simulate(&self, run: &Run<'_>) -> Result<Trajectory, Stopped> {
        let masses = self.sealed_masses(run.recording)?;
        let part;
        let recording = if run.start == 0 {
            run.recording
        } else {
            part = run.recording.slice(run.start..run.recording.len());
            &part
        };
        match pam_trajectory::predict(&self.model(), recording, masses, &self.settings) {
            Ok(prediction) => Ok(prediction.channels),
            Err(e) => Err(Stopped { why: e.why }),
        }
    }

    fn parameter_count(&self) -> usize {
        // m and ν; C is tied to the masses.
        self.force.parameter_count() + 2
    }

    fn structure(&self) -> Structure {
        self.force.structure()
    }

    fn restoring_force_mn(&self, at: &ForceInput<f64>, _pressures_kpa: [f64; 2]) -> Option<f64> {
        let mut work = vec![0.0; self.force.work_len()];
        Some(self.force.restoring_force_mn(at, &mut work))
    }

    fn stiffness_n_mm(&self, at: &ForceInput<f64>, _pressures_kpa: [f64; 2]) -> Option<f64> {
        Some(linearise(&self.force.dual(), at).stiffness_n_mm)
    }

    fn masses(&self, recording: &Recording) -> Option<SealedMasses> {
        self.sealed_masses(recording).ok()
    }

    fn mass_kg(&self) -> Option<f64> {
        Some(self.physical.mass_kg)
    }

    fn details(&self) -> Value {
        let mut details = self.force.details();
        details["mass_kg"] = self.physical.mass_kg.into();
        details["deformation"] = self.physical.deformation.into();
        details
    }

    fn arrays(&self) -> BTreeMap<String, Array> {
        let mut arrays = self.force.arrays();
        for (name, value) in [
            ("mass_kg", self.physical.mass_kg),
            ("gas_coefficient_kpa_mm3_per_g", self.physical.gas_coefficient),
            ("deformation", self.physical.deformation),
        ] {
            arrays.insert(name.into(), Array::scalar(value));
        }
        arrays
    }
}

/// Mass and gas before the force is known: the datasheet's, with ν fitted to the pressures along the
/// measured displacements.
#[must_use]
pub fn gas_of(subjects: &[Subject]) -> PhysicalParameters {
    let datasheet = PhysicalParameters::datasheet();
    let fitted = fit_deformation(subjects, &MuscleGeometry::default(), datasheet.deformation);
    PhysicalParameters { deformation: fitted.deformation, ..datasheet }
}

/// Masses of a recording by the gas law of these parameters; those that its file gives win.
#[must_use]
pub fn masses_of(recording: &Recording, physical: &PhysicalParameters) -> SealedMasses {
    if let Some(masses) = recording.given_masses {
        return masses;
    }
    let mut model = JointModel::datasheet(());
    model.raw = physical.to_raw();
    let rest = recording.reading_at_rest();
    let pressures = [rest.pressure_flexor_kpa, rest.pressure_extensor_kpa];
    let masses: SealedMasses = {
        let p = model.physical();
        let v = model.geometry.volumes(rest.displacement_mm, p.deformation);
        SealedMasses {
            flexor_g: pressures[0] * v.flexor_mm3 / p.gas_coefficient,
            extensor_g: pressures[1] * v.extensor_mm3 / p.gas_coefficient,
        }
    };
    masses
}
