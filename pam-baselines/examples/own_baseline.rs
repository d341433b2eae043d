//! A baseline of one's own: the joint without dynamics, `x = F / K`, its stiffness fitted by least squares.
//!
//! To have it in comparisons by name, put it into
//! `pam-baselines/src/static_joint.rs` and add two lines: `pub mod static_joint;` in `lib.rs` and
//! `"static_joint" => StaticJoint(crate::static_joint::StaticJoint),` in `registry.rs`.

use pam_baselines::method::{Run, Stopped, Structure, Trajectory};
use pam_baselines::{BaselineError, FittedModel, FreeRun, Method, TrainingSet};
use pam_core::{ForceInput, JointModel, SpringDamper};
use pam_data::Subject;
use pam_data::formats::npz::Array;
use pam_data::{MassOrigin, Recording};
use pam_train::evaluate_with;
use pam_trajectory::{Predictor, SolverSettings};
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::f64::consts::TAU;

/// The method: no settings.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct StaticJoint;

/// What it finds.
struct Fitted {
    stiffness_mn_mm: f64,
}

impl Method for StaticJoint {
    fn title(&self) -> String {
        "Static joint".into()
    }

    fn fit(
        &self,
        training: &TrainingSet<'_>,
        _progress: &(dyn Fn(f64) -> bool + Sync),
    ) -> Result<Box<dyn FittedModel>, BaselineError> {
        // K = Σ F x / Σ x²
        let (mut fx, mut xx) = (0.0, 0.0);
        for subject in training.subjects {
            let r = &subject.recording;
            for (f, x) in r.force_mn.iter().zip(&r.displacement_mm) {
                (fx, xx) = (fx + f * x, xx + x * x);
            }
        }
        Ok(Box::new(Fitted { stiffness_mn_mm: fx / xx }))
    }
}

impl FittedModel for Fitted {
    fn simulate(&self, run: &Run<'_>) -> Result<Trajectory, Stopped> {
        let r = run.recording;
        let mut x: Vec<f64> =
            r.force_mn[run.start..].iter().map(|f| f / self.stiffness_mn_mm).collect();
        // Every model starts from the measured state.
        x[0] = r.displacement_mm[run.start];
        let time = &r.time_s[run.start..];
        let last = x.len() - 1;
        let v = (0..x.len())
            .map(|k| (k.saturating_sub(1), (k + 1).min(last)))
            .map(|(a, b)| (x[b] - x[a]) / (time[b] - time[a]))
            .collect();
        Ok(Trajectory { x, v, ..Trajectory::default() }) // no pressures of its own
    }

    fn parameter_count(&self) -> usize {
        1
    }

    fn structure(&self) -> Structure {
        Structure::Physical
    }

    fn stiffness_n_mm(&self, _at: &ForceInput<f64>, _pressures_kpa: [f64; 2]) -> Option<f64> {
        Some(self.stiffness_mn_mm / 1e3)
    }

    fn details(&self) -> Value {
        json!({ "stiffness_mn_mm": self.stiffness_mn_mm })
    }

    fn arrays(&self) -> BTreeMap<String, Array> {
        BTreeMap::from([("static_joint".into(), Array::vector(vec![self.stiffness_mn_mm]))])
    }
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    // Slow and fast recordings of a spring and damper of 150 N/mm.
    let plant = JointModel::datasheet(SpringDamper::constant(150e3, 6500.0));
    let masses = plant.gas_law_masses(0.0, [412.0, 412.0]);
    let record = |hz: f64| -> Result<Subject, Box<dyn std::error::Error>> {
        let time_s: Vec<f64> = (0..2000).map(|k| 2e-3 * f64::from(k)).collect();
        let command = Recording::at_rest("made up", time_s, [412.0, 412.0])
            .with_force(|t| 100e3 * (TAU * hz * t).sin());
        let run = plant.predict(&command, masses, &SolverSettings::default())?;
        let recording = run.to_recording(&command, masses);
        Ok(Subject { recording, masses, origin: MassOrigin::Given })
    };
    let training = [record(0.5)?];
    let set = TrainingSet { subjects: &training, surfaces: None, seed: 0 };
    let fitted = StaticJoint.fit(&set, &|_share| true)?;
    println!("{}: {}", StaticJoint.title(), fitted.details());
    // A slow sine is answered like by K − m ω².
    let expected = 150e3 - plant.physical().mass_kg * (TAU * 0.5).powi(2);
    let found = fitted.details()["stiffness_mn_mm"].as_f64().ok_or("a number")?;
    assert!((found - expected).abs() < 500.0, "{found} {expected}");

    // It is judged as every other model is: good where the motion is slow, poor where it is fast.
    let r2 = |hz: f64| -> Result<f64, Box<dyn std::error::Error>> {
        let free = FreeRun(fitted.as_ref());
        let subjects = vec![record(hz)?];
        let evaluation = evaluate_with(&free, &plant, subjects, &SolverSettings::default(), &|| ());
        Ok(evaluation.recordings[0].scores.r2.x)
    };
    let (slow, fast) = (r2(0.5)?, r2(5.0)?);
    println!("R² of the displacement: {slow:.3} at 0.5 Hz, {fast:.3} at 5 Hz");
    assert!(slow > 0.95 && fast < slow);
    Ok(())
}
