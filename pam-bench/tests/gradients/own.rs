//! A field from a file of expressions.

use pam_autodiff::ByTape;
use pam_bench::gradients::{Solver, problems::own};
use pam_solvers::Tableau;
use pam_solvers::sensitivity::DiscreteAdjoint;

const DECAY: &str = "end_s = 1.0\nobservations = 4\nstart = { x = 2.0 }\nparameters = { k = 3.0 }\n\
    rates = { x = '-k * x + 0 * t' }";

/// ẋ = −k x: the loss is ½ mean x², x = x₀ e^(−k t).
#[test]
fn the_gradient_of_a_field_from_a_file_is_the_closed_form() {
    let case = own::parse(DECAY, "decay.toml").unwrap();
    let integrator = Solver::adaptive(Tableau::tsit5(), 1e-10).integrator();
    let found = case.gradient_of(&case.field, &DiscreteAdjoint::new(ByTape), &integrator).unwrap();
    let x = |t: f64| 2.0 * (-3.0 * t).exp();
    let mean =
        |of: &dyn Fn(f64) -> f64| case.observations_s.iter().map(|&t| of(t)).sum::<f64>() / 4.0;
    let close = |a: f64, b: f64| (a - b).abs() < 1e-8 * b.abs();
    assert!(close(found.value, 0.5 * mean(&|t| x(t) * x(t))));
    assert!(close(found.parameters[0], -mean(&|t| t * x(t) * x(t))));
    assert!(close(found.initial_state[0], mean(&|t| x(t) * x(t)) / 2.0));
}

#[test]
fn a_wrong_file_says_what_is_wrong() {
    for (from, to, words) in [
        ("-k * x", "-q * x", "rate of `x`: line 1, column 2"),
        ("{ x = 2.0 }", "{ y = 2.0 }", "same states"),
        ("{ k = 3.0 }", "{ x = 3.0 }", "`x` is named twice"),
        ("end_s = 1.0", "end_s = -1.0", "must be positive"),
        ("observations", "samples", "samples"),
    ] {
        let error = own::parse(&DECAY.replacen(from, to, 1), "decay.toml").err().unwrap();
        let error = error.to_string();
        assert!(error.contains(words) && error.contains("decay.toml"), "{words}: {error}");
    }
}
