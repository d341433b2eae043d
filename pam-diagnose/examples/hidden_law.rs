//! A cause that nobody listed: from an unexplained error to a law, as an effect file and as a part of the model.
//!
//! The plant has a drag that grows with the square of the speed. The list of candidates does not hold it, and neither does the model.

use pam_core::{AnyForce, JointModel, Scalar, SpringDamper, units::MN_PER_N};
use pam_data::{ModelInfo, Recording, load_model, models::save_model, subjects};
use pam_diagnose::remainder::RemainderOutcome;
use pam_diagnose::{DiagnoseOptions, RecordingSets, Verdict, diagnose};
use pam_effects::effects::{DataScales, Effect, EffectInfo, Group, ParameterInfo, Point, by_id};
use pam_effects::{ActiveEffect, ExtendedModel, expression};
use pam_trajectory::{Predictor, SolverSettings};
use std::f64::consts::TAU;

const INFO: EffectInfo = EffectInfo::new(
    "drag_of_the_plant",
    Group::Mechanics,
    "drag that grows with the square of the speed",
    &[ParameterInfo::linear("drag_n_s2_mm2", [0.0, 10.0])],
);
const DRAG_N_S2_MM2: f64 = 0.3;

/// Force `−drag v |v|`.
struct Drag;

impl Effect for Drag {
    fn info(&self) -> &'static EffectInfo {
        &INFO
    }

    fn starts(&self, _scales: &DataScales) -> Vec<Vec<f64>> {
        vec![vec![0.05]]
    }

    fn force_mn<S: Scalar>(&self, p: &[S], at: &Point<'_, S>, _memory: &[S]) -> S {
        let v = at.velocity_mm_s;
        -(p[0] * v * v.abs()).scaled(MN_PER_N)
    }
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let joint = JointModel::datasheet(AnyForce::from(SpringDamper::published()));
    let masses = joint.gas_law_masses(0.0, [412.0, 412.0]); // kPa absolute, sealed at x = 0
    let model = ExtendedModel { joint, info: ModelInfo::default(), effects: Vec::new() };
    let plant = model.with([ActiveEffect { effect: &Drag, values: vec![DRAG_N_S2_MM2] }]);
    let command = |hz: f64, newton: f64| {
        let time_s: Vec<f64> = (0..2000).map(|k| 4e-3 * f64::from(k)).collect();
        Recording::at_rest("made up", time_s, [412.0, 412.0])
            .with_force(|t| 1e3 * newton * (TAU * hz * t).sin())
    };
    let mut recordings = Vec::new();
    for (hz, newton) in [(0.5, 90.0), (2.0, 120.0), (1.0, 150.0)] {
        let command = command(hz, newton);
        let run = plant.predict(&command, masses, &SolverSettings::default())?;
        recordings.push(run.to_recording(&command, masses));
    }
    let data = subjects(recordings, &model.joint)?;

    // The listed causes do not explain the error.
    let listed = ["constant_load", "stiffness_scale", "force_gain", "actuation_delay"];
    let candidates = listed.iter().filter_map(|id| by_id(id)).map(|e| e as _).collect();
    let options = DiagnoseOptions { candidates, ..DiagnoseOptions::default() };
    let sets = RecordingSets { data: &data, test: None, baseline: None };
    let found = diagnose(&model, &sets, &options, &|_, _| {})?;
    println!("{}: {:?}", found.verdict, found.named());

    // What they leave becomes a law: `law` of the options is on.
    let remainder = found.remainder.as_ref().ok_or("an adequate model")?;
    println!("{}", remainder.sentence);
    assert_eq!(remainder.outcome, RemainderOutcome::Law);
    assert!(!matches!(found.verdict, Verdict::Explained | Verdict::NothingFound));
    let law = remainder.law.as_ref().ok_or("a law")?;
    let (name, drag) = &law.parameters[0];
    println!("{name} = {:.4} [{:.4}, {:.4}]", drag.value, drag.ci95[0], drag.ci95[1]);
    assert_eq!(law.variables, ["v"]);
    assert!((drag.value + DRAG_N_S2_MM2).abs() < 0.01, "{drag:?}");

    // Its file is a file of effects; the extended model holds it, predicts with it and is loaded again.
    assert_eq!(expression::parse(&law.file)?.len(), 1);
    let folder = std::env::temp_dir().join(format!("pam-hidden-law-{}", std::process::id()));
    let path = folder.join("model.safetensors");
    save_model(&path, &found.model.extended.to_saved())?;
    let loaded = ExtendedModel::from_saved(load_model(&path)?)?;
    std::fs::remove_dir_all(&folder)?;
    let unseen = command(1.4, 100.0);
    let x = |model: &ExtendedModel| -> Result<Vec<f64>, Box<dyn std::error::Error>> {
        let run = model.predict(&unseen, masses, &SolverSettings::default())?;
        Ok(run.to_recording(&unseen, masses).displacement_mm)
    };
    let (truth, with_law, without) = (x(&plant)?, x(&loaded)?, x(&model)?);
    let rms = |a: &[f64]| {
        let sum: f64 = a.iter().zip(&truth).map(|(a, t)| (a - t).powi(2)).sum();
        (sum / truth.len() as f64).sqrt()
    };
    println!("unseen run: {:.4} mm -> {:.4} mm", rms(&without), rms(&with_law));
    assert!(rms(&with_law) < 0.05 * rms(&without));
    Ok(())
}
