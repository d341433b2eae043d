//! Every gradient method by its name.

use super::fields::{AnyField, Decay};
use super::inputs::AnyInput;
use pam_solvers::sensitivity::{Direction, GradientChoice, MethodSetup, Problem};
use pam_solvers::{Integrator, NoInput, PidController, Tableau};

/// `y(1) = e^(−p)`: the derivative by p is `−e^(−p)`, that by y(0) is `e^(−p)`.
#[test]
fn every_name_is_a_method_that_is_right() {
    let integrator = Integrator::new(Tableau::tsit5(), PidController::new(1e-9, 1e-9));
    let problem = Problem {
        field: &AnyField::from(Decay { rate: 0.7 }),
        input: &AnyInput::None(NoInput),
        t0: 0.0,
        t1: 1.0,
        y0: &[1.0],
        observations_s: &[1.0],
        integrator: &integrator,
    };
    let mut last = |_: &[f64], states: &[f64], cotangents: &mut [f64]| {
        cotangents[0] = 1.0;
        states[0]
    };
    let exact = (-0.7_f64).exp();
    for &(name, choice) in GradientChoice::ALL {
        assert_eq!(GradientChoice::from_name(name).unwrap(), choice);
        assert_eq!(choice.name(), name);
        let setup =
            MethodSetup { integrator: integrator.clone(), directions: None, floors: [0.01; 3] };
        let method = choice.method::<AnyField<f64>, AnyInput<'_, f64>, _>(setup);
        let found = method.value_and_gradient(&problem, &mut last).unwrap();
        assert!((found.parameters[0] + exact).abs() < 1e-6, "{name}: {:?}", found.parameters);
        assert!((found.initial_state[0] - exact).abs() < 1e-6, "{name}");
        // One direction alone, where that saves anything.
        if choice.pays_by_direction::<PidController>() {
            let setup = MethodSetup {
                integrator: integrator.clone(),
                directions: Some(vec![Direction::InitialState(0)]),
                floors: [0.01; 3],
            };
            let method = choice.method::<AnyField<f64>, AnyInput<'_, f64>, _>(setup);
            let found = method.value_and_gradient(&problem, &mut last).unwrap();
            assert_eq!(found.parameters, [0.0], "{name}");
            assert!((found.initial_state[0] - exact).abs() < 1e-6, "{name}");
        }
    }
    let message = GradientChoice::from_name("guess").unwrap_err().to_string();
    assert!(message.contains("guess") && message.contains("quadrature"), "{message}");
}
