//! Gradients converge with the order of the method.

use super::case::brief;
use super::fields::{AnyField, Logistic};
use super::inputs::AnyInput;
use num_dual::Dual64;
use pam_autodiff::ByTape;
use pam_core::Scalar;
use pam_solvers::sensitivity::{
    DiscreteAdjoint, ForwardSensitivity, Gradient, GradientMethod, Problem,
};
use pam_solvers::{ConstantStep, Integrator, NoInput, Tableau};

const R: f64 = 1.3;
const K: f64 = 2.0;
const Y0: f64 = 0.3;
const T1: f64 = 2.0;

/// `y(t) = K / (1 + (K / y0 − 1) e^(−r t))`
fn exact<S: Scalar>(t: f64, [r, k, y0]: [S; 3]) -> S {
    k / (S::constant(1.0) + (k / y0 - S::constant(1.0)) * (-r).scaled(t).exp())
}

/// Gradient of the sum of `y²/2` at `times` with respect to r, K, y0.
fn exact_gradient(times: &[f64]) -> [f64; 3] {
    std::array::from_fn(|i| {
        let mut numbers = [R, K, Y0].map(Dual64::from);
        numbers[i].eps = 1.0;
        times.iter().map(|&t| exact(t, numbers)).map(|y| y.re * y.eps).sum()
    })
}

fn error(
    method: &dyn GradientMethod<AnyField<f64>, AnyInput<'static, f64>>,
    tableau: &Tableau,
    steps: u32,
    times: &[f64],
) -> f64 {
    let field = AnyField::from(Logistic { rate: R, capacity: K });
    let integrator = Integrator::new(tableau.clone(), ConstantStep::new(T1 / f64::from(steps)));
    let problem = Problem {
        field: &field,
        input: &AnyInput::None(NoInput),
        t0: 0.0,
        t1: T1,
        y0: &[Y0],
        observations_s: times,
        integrator: &integrator,
    };
    let mut loss = |_: &[f64], y: &[f64], w: &mut [f64]| {
        w.copy_from_slice(y);
        y.iter().map(|y| 0.5 * y * y).sum()
    };
    let Gradient { parameters, initial_state, .. } =
        method.value_and_gradient(&problem, &mut loss).unwrap();
    let truth = exact_gradient(times);
    let found = [parameters[0], parameters[1], initial_state[0]];
    found.iter().zip(truth).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

/// Slope of the error over the step in doubly logarithmic scale, over four halvings.
#[test]
fn gradients_converge_with_the_order_of_the_method() {
    for (name, order, coarse) in
        [("tsit5", 5.0, 8), ("dp5", 5.0, 8), ("rk4", 4.0, 16), ("bs3", 3.0, 32)]
    {
        let tableau = Tableau::from_name(name).unwrap();
        // At the end; and a third and two thirds into a step, which four halvings leave where they are.
        for times in [&[T1][..], &[T1 / 3.0, 2.0 * T1 / 3.0][..]] {
            let methods: [&dyn GradientMethod<_, _>; 2] =
                [&DiscreteAdjoint::new(ByTape), &ForwardSensitivity::new(ByTape)];
            for method in methods {
                let errors: Vec<f64> =
                    (0..5).map(|k| error(method, &tableau, coarse << k, times)).collect();
                let measured = (errors[0] / errors[4]).log2() / 4.0;
                let name = method.name();
                println!(
                    "{} {times:.2?}, {name}: order {measured:.2}, {}",
                    tableau.name,
                    brief(&errors)
                );
                assert!((measured - order).abs() < 0.3, "{name}: order {measured}, {errors:?}");
            }
        }
    }
}
