//! Tape, duals, chunks, complex steps and differences give the same derivatives.

use num_dual::HyperDual64;
use pam_autodiff::{
    ComplexDifference, Function, Richardson, gradient, hessian, hessian_vector, jacobian_forward,
    jacobian_reverse, jvp, scaled_gradient_by_difference, vjp,
};
use pam_core::{Activation, ForceInput, ForceModel, NetworkForce, ParametricForce, Scalar, scalar};
use proptest::prelude::*;

use crate::support::network;

/// `Σ (1 − x_k)² + 100 (x_{k+1} − x_k²)²`
struct Rosenbrock;

impl Function for Rosenbrock {
    fn eval<S: Scalar>(&self, x: &[S], out: &mut [S]) {
        let one = S::constant(1.0);
        out[0] = x
            .windows(2)
            .map(|pair| {
                let (a, b) = (one - pair[0], pair[1] - pair[0] * pair[0]);
                a * a + (b * b).scaled(100.0)
            })
            .sum();
    }
}

fn rosenbrock_gradient(x: &[f64]) -> Vec<f64> {
    let mut gradient = vec![0.0; x.len()];
    for k in 0..x.len() - 1 {
        let b = x[k + 1] - x[k] * x[k];
        gradient[k] += -2.0 * (1.0 - x[k]) - 400.0 * x[k] * b;
        gradient[k + 1] += 200.0 * b;
    }
    gradient
}

/// The force of a network as a function of its four inputs and all of its parameters.
struct Force(NetworkForce<f64>);

impl Force {
    fn arguments(&self, inputs: [f64; 4]) -> Vec<f64> {
        inputs.into_iter().chain(ParametricForce::parameters(&self.0)).collect()
    }
}

impl Function for Force {
    fn eval<S: Scalar>(&self, x: &[S], out: &mut [S]) {
        let (inputs, parameters) = x.split_at(4);
        let force = self.0.with_parameters(parameters);
        let [displacement_mm, velocity_mm_s, mass_flexor_g, mass_extensor_g] =
            inputs.try_into().unwrap();
        let input = ForceInput { displacement_mm, velocity_mm_s, mass_flexor_g, mass_extensor_g };
        out[0] = force.restoring_force_mn(&input, &mut scalar::zeros(force.work_len()));
    }
}

/// Three outputs of five inputs with everything that a scalar can do.
struct Everything;

impl Function for Everything {
    fn output_len(&self) -> usize {
        3
    }
    fn eval<S: Scalar>(&self, x: &[S], out: &mut [S]) {
        let [a, b, c, d, e] = x.try_into().unwrap();
        out[0] = (a * b).sin() / (c.exp() + d.softplus()) + e.powi(3) * a.tanh();
        out[1] = (a * a + b * b).sqrt().atan2(c) - d.sigmoid().ln() * e.cos().exp_m1();
        out[2] = (c.abs() + S::constant(1.0)).powd(d) + (a.sinh() - b.asinh()).maximum(e).cbrt();
    }
}

fn close(a: &[f64], b: &[f64], tolerance: f64, what: &str) {
    assert_eq!(a.len(), b.len(), "{what}");
    let size = a.iter().fold(0.0_f64, |size, x| size.max(x.abs()));
    for (k, (x, y)) in a.iter().zip(b).enumerate() {
        let scale = x.abs().max(1e-3 * size);
        assert!((x - y).abs() <= tolerance * scale, "{what}, entry {k}: {x} {y}");
    }
}

fn value(f: &impl Function, x: &[f64]) -> f64 {
    let mut out = [0.0];
    f.eval(x, &mut out);
    out[0]
}

fn all_gradients_agree(f: &impl Function, x: &[f64], what: &str) -> Vec<f64> {
    let by_tape = gradient(f, x);
    close(&by_tape, &jacobian_forward(f, x), 1e-12, what);
    let by_complex_step = ComplexDifference::default().jacobian(f, x);
    close(&by_tape, &by_complex_step, 1e-12, what);
    let sizes: Vec<f64> = x.iter().map(|x| x.abs().max(0.1)).collect();
    let scheme = Richardson { h: 1e-3, levels: 3 };
    let by_difference = scaled_gradient_by_difference(&scheme, |x| value(f, x), x, &sizes);
    close(&by_tape, &by_difference, 1e-6, what);
    by_tape
}

#[test]
fn rosenbrock() {
    let x = [-1.2, 1.0, 0.3, 2.0, -0.7, 1.1, 0.2, -0.4, 0.9, 1.5, -2.0];
    let found = all_gradients_agree(&Rosenbrock, &x, "Rosenbrock");
    close(&found, &rosenbrock_gradient(&x), 1e-14, "Rosenbrock by hand");
    assert_eq!(gradient(&Rosenbrock, &[1.0; 7]), [0.0; 7]);
}

#[test]
fn networks_of_every_activation() {
    for name in Activation::NAMES {
        let force = Force(network(name, &[6, 5]));
        let x = force.arguments([0.7, -1.3, 0.06, 0.08]);
        all_gradients_agree(&force, &x, name);
    }
}

#[test]
fn jacobians_and_their_products() {
    let x = [0.3, -0.8, 1.2, 0.4, -0.6];
    let jacobian = jacobian_forward(&Everything, &x);
    close(&jacobian, &jacobian_reverse(&Everything, &x), 1e-13, "reverse");
    close(&jacobian, &ComplexDifference::default().jacobian(&Everything, &x), 1e-13, "complex");
    let (v, w) = ([1.0, -0.5, 0.2, 2.0, 0.7], [0.3, -1.0, 0.6]);
    let rows = jacobian.chunks(5).map(|row| row.iter().zip(v).map(|(j, v)| j * v).sum());
    close(&rows.collect::<Vec<f64>>(), &jvp(&Everything, &x, &v), 1e-13, "jvp");
    let columns = (0..5).map(|j| (0..3).map(|i| w[i] * jacobian[5 * i + j]).sum());
    close(&columns.collect::<Vec<f64>>(), &vjp(&Everything, &x, &w), 1e-13, "vjp");
}

#[test]
fn hessian_products_equal_hyper_dual_hessians() {
    fn check(f: &impl Function, x: &[f64], what: &str) {
        let n = x.len();
        let v: Vec<f64> = (0..n).map(|k| (k as f64 * 0.9 + 0.2).sin()).collect();
        let full = hessian(f, x);
        let expected: Vec<f64> =
            full.chunks(n).map(|row| row.iter().zip(&v).map(|(h, v)| h * v).sum()).collect();
        let (by_hessian_vector, product) = hessian_vector(f, x, &v);
        close(&expected, &product, 1e-10, what);
        close(&gradient(f, x), &by_hessian_vector, 1e-12, what);
    }
    check(&Rosenbrock, &[-1.2, 1.0, 0.3, 2.0, -0.7], "Rosenbrock");
    for name in Activation::NAMES {
        let force = Force(network(name, &[4, 3]));
        check(&force, &force.arguments([0.7, -1.3, 0.06, 0.08]), name);
    }
    let mut out = [HyperDual64::constant(0.0)];
    Rosenbrock.eval(&[HyperDual64::constant(1.0); 3], &mut out);
    assert_eq!(out[0].re, 0.0);
}

/// A smooth function by the complex step to fourteen digits.
#[test]
fn the_complex_step_is_exact() {
    use num_dual::DualNum;
    // Squire and Trapp's example: eˣ / (sin³x + cos³x) at 1.5.
    let found = ComplexDifference::default()
        .derivative(|x| x.exp() / (x.sin().powi(3) + x.cos().powi(3)), 1.5);
    let (s, c) = 1.5_f64.sin_cos();
    let d = s.powi(3) + c.powi(3);
    let exact = 1.5_f64.exp() * (d - 3.0 * s * s * c + 3.0 * c * c * s) / (d * d);
    assert!((found / exact - 1.0).abs() < 1e-14, "{found} {exact}");
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn products_from_both_sides_agree(
        x in proptest::array::uniform5(-2.0..2.0_f64),
        v in proptest::array::uniform5(-1.0..1.0_f64),
        w in proptest::array::uniform3(-1.0..1.0_f64),
    ) {
        let jv = jvp(&Everything, &x, &v);
        let wj = vjp(&Everything, &x, &w);
        let left: f64 = w.iter().zip(&jv).map(|(w, j)| w * j).sum();
        let right: f64 = wj.iter().zip(&v).map(|(j, v)| j * v).sum();
        let scale = 1.0 + w.iter().zip(&jv).map(|(w, j)| (w * j).abs()).sum::<f64>()
            + wj.iter().zip(&v).map(|(j, v)| (j * v).abs()).sum::<f64>();
        prop_assert!((left - right).abs() < 1e-13 * scale, "{left} {right}");
    }
}
