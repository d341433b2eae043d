//! What a fit finds where nothing is hidden.

use super::published::{exact_run, weights};
use pam_diagnose::fit::{Hypothesis, Problem};
use pam_diagnose::search::noise_floors;
use pam_effects::effects::{AnyEffect, by_id};
use pam_effects::simulation::{Base, Trial};
use rayon::prelude::*;

/// Largest value (in the parameter's unit) that may be found in runs of the model itself, solved exactly. A
/// rig's hidden effect of medium strength is 30 to 300 times as large.
const NOTHING: [(&str, f64); 10] = [
    ("viscous_damping", 5.0),
    ("coulomb_friction", 0.05),
    ("constant_load", 0.05),
    ("added_inertia", 0.5),
    ("stiffness_scale", 1e-3),
    ("stiffness_drift", 2e-3),
    ("force_gain", 1e-3),
    ("actuation_delay", 0.1),
    ("position_gain", 1e-3),
    ("pressure_delay", 0.1),
];

#[test]
fn nothing_is_found_where_nothing_is_hidden() {
    let model = weights();
    let trials: Vec<Trial> = [[45.0, 45.0], [30.0, 60.0], [60.0, 30.0]]
        .into_par_iter()
        .map(|psi| Trial::new(&model, &exact_run(&model, psi, 0.25)))
        .collect();
    let floors = noise_floors(&trials.iter().collect::<Vec<_>>());
    let problem = Problem::new(&trials, Base::of(&model), 0.5, floors);
    let found: Vec<(&str, f64, f64)> = NOTHING
        .par_iter()
        .map(|&(id, most)| {
            let effect: &dyn AnyEffect = by_id(id).expect("an id");
            let info = effect.info().parameters[0];
            let off = info.off.expect("one that can be switched off");
            // What cannot be negative has no derivative where it is off.
            let start = if info.range[0] == off { off + 2.0 } else { off };
            let from = Hypothesis::base(&[], trials.len()).with(effect, &[start]);
            let fit = problem.fit(from, 15).expect("in range");
            (id, fit.hypothesis.values[0], most)
        })
        .collect();
    for (id, value, _) in &found {
        println!("{id}: {value:.5}");
    }
    for (id, value, most) in found {
        assert!(value.abs() < most, "{id}: {value}, at most {most}");
    }
}
