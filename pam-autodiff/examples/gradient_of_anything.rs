//! Derivatives of whatever is written in scalars: closures, functions over any scalar, loops and branches.

use num_dual::DualNum;
use pam_autodiff::{
    Function, Var, derivative, gradient_of, hessian, hessian_vector, jacobian_forward,
    jacobian_reverse, jvp, vjp,
};
use pam_core::Scalar;

/// The end `(x, y)` of a planar arm with two links of 0.3 m and 0.2 m.
struct Arm;

impl Function for Arm {
    fn output_len(&self) -> usize {
        2
    }
    fn eval<S: Scalar>(&self, q: &[S], out: &mut [S]) {
        let elbow = q[0] + q[1];
        out[0] = q[0].cos().scaled(0.3) + elbow.cos().scaled(0.2);
        out[1] = q[0].sin().scaled(0.3) + elbow.sin().scaled(0.2);
    }
}

/// Its height alone.
struct Height;

impl Function for Height {
    fn eval<S: Scalar>(&self, q: &[S], out: &mut [S]) {
        let mut end = [S::zero(); 2];
        Arm.eval(q, &mut end);
        out[0] = end[1];
    }
}

fn main() {
    // One number: dual numbers. d/dx (x ln x) = ln x + 1.
    assert!((derivative(|x| x * x.ln(), 3.0) - (3.0_f64.ln() + 1.0)).abs() < 1e-15);

    // Many numbers, one result: a closure on the reverse-mode tape. Newton's root of the mean square, by a
    // loop; ∂ sqrt(s/n) / ∂x_i = x_i / (n sqrt(s/n)).
    let root_mean_square = |x: &[Var]| {
        let mean =
            x.iter().fold(Var::constant(0.0), |s, &x| s + x * x).scaled(1.0 / x.len() as f64);
        let mut root = Var::constant(1.0);
        for _ in 0..20 {
            root = (root + mean / root).scaled(0.5);
        }
        root
    };
    let x: Vec<f64> = (1..=100).map(f64::from).collect();
    let rms = (x.iter().map(|x| x * x).sum::<f64>() / 100.0).sqrt();
    for (g, x) in gradient_of(root_mean_square, &x).iter().zip(&x) {
        assert!((g - x / (100.0 * rms)).abs() < 1e-12);
    }

    // Jacobians forward and reverse, and products with them.
    let q = [0.4, 1.1];
    let j = jacobian_forward(&Arm, &q);
    assert!(j.iter().zip(jacobian_reverse(&Arm, &q)).all(|(a, b)| (a - b).abs() < 1e-15));
    let end_velocity = jvp(&Arm, &q, &[1.0, -0.5]); // m/s for joint speeds of 1 and −0.5 rad/s
    let torques = vjp(&Arm, &q, &[0.0, 9.81]); // N·m that hold 1 kg at the end
    println!("J = {j:.4?}, end velocity {end_velocity:.4?} m/s, torques {torques:.4?} N·m");
    assert!((end_velocity[0] - (j[0] - 0.5 * j[1])).abs() < 1e-15);
    assert!((torques[0] - 9.81 * j[2]).abs() < 1e-14);

    // Second derivatives: ∂²y/∂q₁² = −0.2 sin(q₀ + q₁); a product with the Hessian costs two passes.
    let h = hessian(&Height, &q);
    assert!((h[3] + 0.2 * (q[0] + q[1]).sin()).abs() < 1e-15);
    let (_, hv) = hessian_vector(&Height, &q, &[1.0, 2.0]);
    assert!((hv[0] - (h[0] + 2.0 * h[1])).abs() < 1e-14);
}
