//! The truth of a joint with kinks.

use pam_bench::gradients::case::half_squares;
use pam_bench::gradients::problems::joint;
use pam_bench::gradients::truth::{relative_error, tight};
use pam_core::Activation;

/// Coarser grids give the same truth, and steps at a tolerance of 1e-12 come near it.
#[test]
fn truth_does_not_depend_on_the_grid() {
    let _alone = super::alone();
    let activation = Activation::LeakyRelu(Default::default());
    let case = joint::case(activation, 8, 0.5);
    let model = joint::model(activation, 8);
    let masses = joint::masses(0);
    let start = joint::start(&model, masses);
    let kinked = joint::kinked(&model, masses, start, &case.observations_s);
    let loss = half_squares(joint::target, [0.3, 4.0, 20.0, 20.0]);
    let fine = kinked.extrapolated(2000, &loss).unwrap();
    let coarse = kinked.extrapolated(600, &loss).unwrap();
    let off = |a: &[f64], b: &[f64]| relative_error(a, b);
    assert!(off(&fine.states, &coarse.states) < 1e-10);
    assert!(off(&fine.parameters, &coarse.parameters) < 1e-8);
    assert!(off(&fine.initial_state, &coarse.initial_state) < 1e-8);
    let mut by_steps = case;
    by_steps.closed_form = None;
    let steps = tight(&by_steps).unwrap();
    assert!(off(&steps.states, &fine.states) < 1e-9);
    let distance = off(&steps.parameters, &fine.parameters);
    assert!(distance < 1e-3, "{distance:e}");
}
