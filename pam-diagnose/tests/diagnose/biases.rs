//! What a fit finds where nothing is hidden.

use crate::support::published::{exact_run, weights};
use pam_diagnose::DiagnosisSettings;
use pam_diagnose::data::OpenPart;
use pam_diagnose::fit::Problem;
use pam_diagnose::joint::JointSystem;
use pam_diagnose::noise::{Noise, estimated_noise};
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
    ("stiffness_scale", 1e-4),
    ("stiffness_drift", 1e-3),
    ("force_gain", 1e-4),
    ("actuation_delay", 0.35),
    ("position_gain", 1e-4),
    ("pressure_delay", 0.1),
];

#[test]
fn nothing_is_found_where_nothing_is_hidden() {
    let model = weights();
    let trials: Vec<Trial> = [[45.0, 45.0], [30.0, 60.0], [60.0, 30.0]]
        .into_par_iter()
        .map(|psi| Trial::new(&model, &exact_run(&model, psi, 0.25)))
        .collect();
    let settings = DiagnosisSettings::default();
    let effects: Vec<&dyn AnyEffect> =
        NOTHING.iter().map(|(id, ..)| by_id(id).expect("an id") as &dyn AnyEffect).collect();
    let all = OpenPart::whole(trials.len());
    let of_trials = trials.iter().collect();
    let system = JointSystem::new(of_trials, &all, Base::of(&model), &[], effects, &settings);
    let noise = Noise::white(&estimated_noise(&system, &all, &settings.noise));
    let problem = Problem::new(&system, (0..trials.len()).collect(), noise, &settings);
    let found: Vec<(&str, f64, f64)> = NOTHING
        .par_iter()
        .enumerate()
        .map(|(candidate, &(id, most))| {
            let info = by_id(id).expect("an id").info().parameters[0];
            let off = info.off.expect("one that can be switched off");
            // What cannot be negative has no derivative where it is off.
            let start = if info.range[0] == off { off + 2.0 } else { off };
            let from = problem.base().with(candidate, &[start]);
            let fit = problem.fit(from, 15).expect("in range");
            (id, fit.hypothesis.members[0].values[0], most)
        })
        .collect();
    for (id, value, _) in &found {
        println!("{id}: {value:.5}");
    }
    for (id, value, most) in found {
        assert!(value.abs() < most, "{id}: {value}, at most {most}");
    }
}

/// An actuation delay and a lead of the force within a sample both shift the force in time, so only the prior of the lead separates them:
/// the fitted lead is near its prior mean, wherever the fit starts. The interval of the delay holds the delays of all leads within their
/// limits (closer than 1.96 standard deviations of the prior) and no others.
#[test]
fn a_delay_is_as_uncertain_as_the_timing_of_the_force() {
    let model = weights();
    let run = exact_run(&model, [45.0, 45.0], 0.25);
    let sample_ms = 1e3 * (run.recording.time_s[1] - run.recording.time_s[0]);
    let trials = [Trial::new(&model, &run)];
    let settings = DiagnosisSettings::default();
    let effects = [by_id("actuation_delay").expect("an id") as &dyn AnyEffect];
    let all = OpenPart::whole(1);
    let of_trials = trials.iter().collect();
    let system =
        JointSystem::new(of_trials, &all, Base::of(&model), &[], effects.to_vec(), &settings);
    let noise = Noise::white(&estimated_noise(&system, &all, &settings.noise));
    let problem = Problem::new(&system, vec![0], noise, &settings);
    // Third of the nuisances that all recordings share.
    const LEAD: usize = 2;
    for (lead, delay_ms) in [(-settings.fit.lag_limit_samples, 5.0), (0.4, 3.0)] {
        let mut from = problem.base().with(0, &[delay_ms]);
        from.shared[LEAD] = lead;
        let fit = problem.fit(from, 15).expect("in range");
        let found = fit.hypothesis.shared[LEAD];
        assert!(found.abs() < 0.03, "from {lead}: {found}");
        let interval = problem.intervals(&fit).expect("can be simulated")[0];
        let [lag, lead] = [settings.fit.lag_limit_samples, settings.fit.lead_limit_samples];
        assert!(lead < 1.96 * settings.fit.lead_deviation_samples);
        // A lag of the force stands for a smaller delay, a lead for a larger one.
        let expected = [(-lag - found) * sample_ms, (lead - found) * sample_ms];
        let [below, above] = interval.ci95.map(|end| end - interval.value);
        for (end, expected) in [(below, expected[0]), (above, expected[1])] {
            let wider = end.abs() - expected.abs();
            assert!(
                (0.0..0.02 * sample_ms).contains(&wider),
                "{end} ms, the limits give {expected}"
            );
        }
    }
}
