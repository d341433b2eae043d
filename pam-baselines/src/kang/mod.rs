//! The analytical muscle model of Kang, fitted to single muscles, and the joint that two of them make.
//!
//! The joint is simulated as published: semi-implicit Euler steps, reflected mass 304.65 kg, damping
//! 6500 kg/s, and the *measured* pressures of both muscles as inputs.
//!
//! ```text
//! m ẍ = F_e + T(p_f, x/L0) − T(p_e, −x/L0) − b ẋ
//! ```
//!
//! The net force of the joint is a small difference of large tensions, so that an error of some percent in
//! each, which is a good fit of a muscle, is a large one of the joint.

mod fit;
mod muscle;
mod samples;

pub use fit::{BraidAngle, Fit, FittedMuscle, fit};
pub use muscle::{KangMuscle, MuscleSize};
pub use samples::{MuscleSample, of_map, of_rig, of_surfaces};

use crate::error::BaselineError;
use crate::method::{
    FittedModel, Method, Needs, Run, Stopped, Structure, TrainingSet, Trajectory, diverged,
    out_of_range,
};
use pam_core::units::{ATMOSPHERE_KPA, MN_PER_N};
use pam_core::{ForceInput, MuscleGeometry, PhysicalParameters};
use pam_data::formats::npz::Array;
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};
use std::collections::BTreeMap;

/// Data of the fit.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Source {
    /// The measured surfaces of a single muscle, if the comparison has them, else the rig's muscle.
    Auto,
    /// The measured surfaces.
    Surfaces,
    /// A muscle of the virtual rig.
    Rig,
}

/// How the joint is made of two muscles.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Kang {
    /// Data of the fit.
    pub fit_to: Source,
    /// Initial braid angle in degrees, or `"fit"` for an effective one; published is 27.5.
    pub braid_angle_deg: BraidAngle,
    /// Stretch and contraction up to which the muscle is fitted, mm.
    pub reach_mm: f64,
    /// Reflected mass m, kg.
    pub mass_kg: f64,
    /// Damping of the joint b, kg/s.
    pub damping_kg_s: f64,
}

impl Default for Kang {
    fn default() -> Self {
        Self {
            fit_to: Source::Auto,
            braid_angle_deg: BraidAngle::Fitted(Fit::Fit),
            reach_mm: 6.0,
            mass_kg: 304.65,
            damping_kg_s: 6500.0,
        }
    }
}

/// Two fitted muscles on the joint.
#[derive(Debug, Clone, PartialEq)]
pub struct KangJoint {
    /// The muscle, twice.
    pub fitted: FittedMuscle,
    /// Data of the fit.
    pub source: Source,
    /// Reflected mass m, kg.
    pub mass_kg: f64,
    /// Damping of the joint b, kg/s.
    pub damping_kg_s: f64,
}

impl KangJoint {
    /// The restoring force of both muscles, mN, at pressures in kPa absolute.
    #[must_use]
    pub fn muscles_mn(&self, x_mm: f64, v_mm_s: f64, pressures_kpa: [f64; 2]) -> f64 {
        let m = &self.fitted.muscle;
        let (strain, rate) = (x_mm / m.size.length_mm, v_mm_s / m.size.length_mm);
        let direction = if v_mm_s == 0.0 { 0.0 } else { v_mm_s.signum() };
        let [pf, pe] = pressures_kpa.map(|p| p - ATMOSPHERE_KPA);
        let flexor = m.tension_n(pf, strain, rate, direction);
        let extensor = m.tension_n(pe, -strain, -rate, -direction);
        MN_PER_N * (extensor - flexor)
    }
}

impl FittedModel for KangJoint {
    fn simulate(&self, run: &Run<'_>) -> Result<Trajectory, Stopped> {
        let r = run.recording;
        let [mut x, mut v, ..] = run.state();
        let mut out = Trajectory { x: vec![x], v: vec![v], pf: Vec::new(), pe: Vec::new() };
        for k in run.start..r.len() - 1 {
            let step_s = r.time_s[k + 1] - r.time_s[k];
            let pressures = [r.pressure_flexor_kpa[k], r.pressure_extensor_kpa[k]];
            let force = r.force_mn[k] - self.muscles_mn(x, v, pressures) - self.damping_kg_s * v;
            v += step_s * force / self.mass_kg;
            x += step_s * v;
            if out_of_range(x) {
                return Err(diverged(run, k + 1 - run.start, x));
            }
            out.x.push(x);
            out.v.push(v);
        }
        Ok(out)
    }

    fn parameter_count(&self) -> usize {
        self.fitted.parameters
    }

    fn structure(&self) -> Structure {
        Structure::Physical
    }

    fn needs(&self) -> Needs {
        Needs::Pressures
    }

    fn restoring_force_mn(&self, at: &ForceInput<f64>, pressures_kpa: [f64; 2]) -> Option<f64> {
        let (x, v) = (at.displacement_mm, at.velocity_mm_s);
        Some(self.muscles_mn(x, v, pressures_kpa) + self.damping_kg_s * v)
    }

    /// With the air sealed, so that pressures follow the volumes (`P V = const`, datasheet geometry).
    fn stiffness_n_mm(&self, at: &ForceInput<f64>, pressures_kpa: [f64; 2]) -> Option<f64> {
        let nu = PhysicalParameters::datasheet().deformation;
        let geometry = MuscleGeometry::default();
        let here = geometry.volumes(at.displacement_mm, nu);
        let force = |x: f64| {
            let there = geometry.volumes(x, nu);
            let pressures = [
                pressures_kpa[0] * here.flexor_mm3 / there.flexor_mm3,
                pressures_kpa[1] * here.extensor_mm3 / there.extensor_mm3,
            ];
            self.muscles_mn(x, 0.0, pressures)
        };
        let h = 1e-3;
        let slope = (force(at.displacement_mm + h) - force(at.displacement_mm - h)) / (2.0 * h);
        Some(slope / MN_PER_N)
    }

    fn mass_kg(&self) -> Option<f64> {
        Some(self.mass_kg)
    }

    fn details(&self) -> Value {
        json!({
            "fitted_to": self.source,
            "single_muscle": self.fitted,
            "single_muscle_r2": self.fitted.r2,
            "mass_kg": self.mass_kg,
            "damping_kg_s": self.damping_kg_s,
        })
    }

    fn arrays(&self) -> BTreeMap<String, Array> {
        let m = &self.fitted.muscle;
        [
            ("braid_angle_deg", m.braid_angle_deg),
            ("c_q1", m.correction),
            ("c_q2_per_kpa", m.correction_rate_per_kpa),
            ("c_v_ns", m.viscous_ns),
            ("c_c_n", m.dry_n),
            ("mass_kg", self.mass_kg),
            ("damping_kg_s", self.damping_kg_s),
        ]
        .into_iter()
        .map(|(name, value)| (name.to_owned(), Array::scalar(value)))
        .collect()
    }
}

impl Method for Kang {
    fn title(&self) -> String {
        "Kang analytical".into()
    }

    fn check(&self) -> Result<(), String> {
        for (name, value) in [("reach_mm", self.reach_mm), ("mass_kg", self.mass_kg)] {
            if !(value.is_finite() && value > 0.0) {
                return Err(format!("{name} = {value} must be positive and finite"));
            }
        }
        match self.braid_angle_deg {
            BraidAngle::Held(a) if !(5.0..54.0).contains(&a) => {
                Err(format!("braid_angle_deg = {a} must be \"fit\" or an angle from 5 to 54"))
            }
            _ => Ok(()),
        }
    }

    fn fit(
        &self,
        training: &TrainingSet<'_>,
        _progress: &(dyn Fn(f64) -> bool + Sync),
    ) -> Result<Box<dyn FittedModel>, BaselineError> {
        let size = MuscleSize::JOINT;
        let (source, samples) = match (self.fit_to, training.surfaces) {
            (Source::Auto | Source::Surfaces, Some(surfaces)) => {
                (Source::Surfaces, of_surfaces(surfaces, self.reach_mm, size.length_mm))
            }
            (Source::Surfaces, None) => {
                return Err(BaselineError::unfit(
                    "Kang",
                    "fit_to = \"surfaces\" needs data.surfaces (poly44_all_fits.mat)",
                ));
            }
            _ => (Source::Rig, of_rig(self.reach_mm, size.length_mm)),
        };
        let fitted = fit(&KangMuscle::published_guess(size), self.braid_angle_deg, &samples);
        let Self { mass_kg, damping_kg_s, .. } = *self;
        Ok(Box::new(KangJoint { fitted, source, mass_kg, damping_kg_s }))
    }
}
