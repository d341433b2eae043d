//! A user-defined effect: drag that grows with the square of the speed.
//!
//! The diagnosis takes the type as a further candidate; `templates/own-pam` gives such a type to the whole command. To ship it, put it into
//! `pam-effects/src/effects/mechanics/quadratic_drag.rs` and add two lines: `pub(super) mod quadratic_drag;`
//! in `mechanics/mod.rs` and `mechanics::quadratic_drag::QuadraticDrag,` in the list of `effects/mod.rs`.

use pam_core::{Scalar, units::MN_PER_N};
use pam_effects::effects::{DataScales, Effect, EffectInfo, Group, ParameterInfo, Point};

const INFO: EffectInfo = EffectInfo::new(
    "quadratic_drag",
    Group::Mechanics,
    "drag that grows with the square of the speed",
    &[ParameterInfo::linear("drag_n_s2_mm2", [0.0, 10.0])],
)
.excited_by("fast motion");

/// Force `−drag v |v|`.
#[derive(Debug, Clone, Copy)]
pub struct QuadraticDrag;

impl Effect for QuadraticDrag {
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
    use pam_core::{AnyForce, JointModel, SpringDamper};
    use pam_data::{ModelInfo, Recording, subjects};
    use pam_diagnose::{DiagnoseOptions, RecordingSets, Verdict, diagnose};
    use pam_effects::effects::{AnyEffect, by_id};
    use pam_effects::{ActiveEffect, ExtendedModel};
    use pam_trajectory::{Predictor, SolverSettings};
    use std::f64::consts::TAU;

    let joint = JointModel::datasheet(AnyForce::from(SpringDamper::published()));
    let masses = joint.gas_law_masses(0.0, [412.0, 412.0]); // kPa absolute, sealed at x = 0
    let model = ExtendedModel { joint, info: ModelInfo::default(), effects: Vec::new() };

    // The plant has the drag, the model does not know of it.
    let plant = model.with([ActiveEffect { effect: &QuadraticDrag, values: vec![0.3] }]);
    let mut recordings = Vec::new();
    for (hz, newton) in [(0.5, 90.0), (2.0, 120.0), (1.0, 150.0)] {
        let time_s: Vec<f64> = (0..2000).map(|k| 4e-3 * f64::from(k)).collect();
        let command = Recording::at_rest("made up", time_s, [412.0, 412.0])
            .with_force(|t| 1e3 * newton * (TAU * hz * t).sin());
        let run = plant.predict(&command, masses, &SolverSettings::default())?;
        recordings.push(run.to_recording(&command, masses));
    }
    let data = subjects(recordings, &model.joint)?;

    let listed = ["coulomb_friction", "viscous_damping", "constant_load", "stiffness_scale"];
    let mut candidates: Vec<&dyn AnyEffect> =
        listed.iter().filter_map(|id| by_id(id)).map(|e| e as _).collect();
    candidates.push(&QuadraticDrag);
    let options = DiagnoseOptions { candidates, ..DiagnoseOptions::default() };
    let found = diagnose(
        &model,
        &RecordingSets { data: &data, test: None, baseline: None },
        &options,
        &|_, _| {},
    )?;
    println!("{}: {:?}", found.verdict, found.named());
    assert_eq!(found.verdict, Verdict::Explained);
    assert_eq!(found.named(), ["quadratic_drag"]);
    let (name, drag) = found.causes[0].parameters[0];
    println!("{name} = {:.4} [{:.4}, {:.4}]", drag.value, drag.ci95[0], drag.ci95[1]);
    assert!((drag.value - 0.3).abs() < 0.01);
    Ok(())
}
