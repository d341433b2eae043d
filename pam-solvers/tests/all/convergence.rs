//! Orders of convergence of states and interpolants, measured on problems with known solutions.

use pam_core::{FieldFn, VectorField};
use pam_solvers::{ConstantStep, InputFn, Integrator, NoInput, SaveAt, Tableau, Term};
use std::f64::consts::TAU;

/// A nonlinear, non-autonomous problem: `y₁' = y₁ cos t + y₂ − e^{−t}, y₂' = −y₂ y₁ e^{−sin t}` from
/// (1, 1), solved by `y₁ = e^{sin t}, y₂ = e^{−t}`.
fn problem() -> impl VectorField<f64> {
    FieldFn::new(2, 0, |t: f64, y: &[f64], _u: &[f64], dy: &mut [f64]| {
        dy[0] = y[0] * t.cos() + y[1] - (-t).exp();
        dy[1] = -y[1] * y[0] * (-t.sin()).exp();
    })
}

fn exact(t: f64) -> [f64; 2] {
    [t.sin().exp(), (-t).exp()]
}

fn distance(y: &[f64], t: f64) -> f64 {
    let e = exact(t);
    (y[0] - e[0]).abs().max((y[1] - e[1]).abs())
}

/// Least-squares slope of log error over log step.
fn fitted_order(pairs: &[(f64, f64)]) -> f64 {
    let n = pairs.len() as f64;
    let logs: Vec<(f64, f64)> = pairs.iter().map(|(h, e)| (h.ln(), e.ln())).collect();
    let (mx, my) =
        (logs.iter().map(|p| p.0).sum::<f64>() / n, logs.iter().map(|p| p.1).sum::<f64>() / n);
    let sxy: f64 = logs.iter().map(|p| (p.0 - mx) * (p.1 - my)).sum();
    sxy / logs.iter().map(|p| (p.0 - mx).powi(2)).sum::<f64>()
}

/// A planet on an ellipse of eccentricity 0.3 returns to its perihelion after 2π.
#[test]
fn states_converge_with_the_order_of_the_method() {
    let kepler = FieldFn::new(4, 0, |_t, y: &[f64], _u: &[f64], dy: &mut [f64]| {
        let r3 = (y[0] * y[0] + y[1] * y[1]).powf(1.5);
        dy.copy_from_slice(&[y[2], y[3], -y[0] / r3, -y[1] / r3]);
    });
    let e = 0.3_f64;
    let perihelion = [1.0 - e, 0.0, 0.0, ((1.0 + e) / (1.0 - e)).sqrt()];
    for name in Tableau::NAMES {
        let tableau = Tableau::from_name(name).unwrap();
        let errors: Vec<(f64, f64)> = [300, 600, 1200]
            .iter()
            .map(|&steps| {
                let h = TAU / f64::from(steps);
                let s = Integrator::new(tableau.clone(), ConstantStep::new(h))
                    .solve(&Term::new(kepler, NoInput), 0.0, TAU, &perihelion, SaveAt::End)
                    .unwrap();
                let misses = s.state(0).iter().zip(perihelion).map(|(a, b)| (a - b).abs());
                (h, misses.fold(0.0, f64::max))
            })
            .collect();
        let order = fitted_order(&errors);
        let stated = tableau.order as f64;
        let close = (order - stated).abs() < 0.2;
        assert!(close, "{name}: measured {order:.2}, stated {stated}, {errors:?}");
    }
}

/// Inside one step that starts on the exact solution the interpolant's error is O(h^(q+1)).
#[test]
fn interpolants_converge_with_their_order() {
    for name in Tableau::NAMES {
        let tableau = Tableau::from_name(name).unwrap();
        let errors: Vec<(f64, f64)> = [0.4, 0.2, 0.1, 0.05]
            .iter()
            .map(|&h| {
                let t0 = 0.3;
                let s = Integrator::new(tableau.clone(), ConstantStep::new(h))
                    .solve(&Term::new(problem(), NoInput), t0, t0 + h, &exact(t0), SaveAt::Dense)
                    .unwrap();
                let dense = s.dense.unwrap();
                let worst = (1..20)
                    .map(|k| t0 + h * f64::from(k) / 20.0)
                    .map(|t| distance(&dense.at(t).unwrap(), t))
                    .fold(0.0, f64::max);
                (h, worst)
            })
            .collect();
        let order = fitted_order(&errors) - 1.0;
        let stated = tableau.interpolant_order as f64;
        assert!(
            (order - stated).abs() < 0.35,
            "{name}: measured {order:.2}, stated {stated}, {errors:?}"
        );
    }
}

/// Saved times between steps come from the interpolant and agree with the dense solution.
#[test]
fn saved_times_and_dense_output_agree() {
    let times: Vec<f64> = (0..=37).map(|k| 2.0 * f64::from(k) / 37.0).collect();
    let solver = Integrator::new(Tableau::tsit5(), ConstantStep::new(0.1));
    let term = Term::new(problem(), NoInput);
    let at_times = solver.solve(&term, 0.0, 2.0, &[1.0, 1.0], SaveAt::Times(&times)).unwrap();
    let dense = solver.solve(&term, 0.0, 2.0, &[1.0, 1.0], SaveAt::Dense).unwrap().dense.unwrap();
    assert_eq!(at_times.times_s(), times);
    for (i, &t) in times.iter().enumerate() {
        let d = dense.at(t).unwrap();
        assert!((at_times.state(i)[0] - d[0]).abs() < 1e-15);
        assert!(distance(at_times.state(i), t) < 1e-6);
    }
    assert!(dense.at(-0.1).is_none() && dense.at(2.1).is_none());
}

/// A time-dependent input is read at the stage times: `y' = u(t) = 6 t⁵` is integrated exactly by
/// fifth-order weights up to degree four and to order otherwise.
#[test]
fn inputs_are_read_at_the_nodes() {
    let field = || FieldFn::new(1, 1, |_t, _y: &[f64], u: &[f64], dy: &mut [f64]| dy[0] = u[0]);
    for (name, degree) in [("tsit5", 4), ("dp5", 4), ("rk4", 3), ("bs3", 2)] {
        let power = degree + 1;
        let input =
            InputFn::new(1, |t: f64, u: &mut [f64]| u[0] = f64::from(power) * t.powi(degree));
        let s = Integrator::new(Tableau::from_name(name).unwrap(), ConstantStep::new(0.5))
            .solve(&Term::new(field(), input), 0.0, 1.5, &[0.0], SaveAt::End)
            .unwrap();
        assert!((s.state(0)[0] - 1.5_f64.powi(power)).abs() < 1e-13, "{name}");
    }
}
