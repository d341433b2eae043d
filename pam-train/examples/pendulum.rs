//! A system without muscles, trained: a pendulum whose law of damping is learned by a network from angles
//! alone.
//!
//! ```text
//! φ̈ = −ω² sin φ − n_θ(φ̇)          two states, one network of one input
//! ```
//!
//! The truth has viscous and quadratic damping, `0.1 φ̇ + 0.15 φ̇ |φ̇|`; the network is not told.

use pam_autodiff::ByTape;
use pam_core::activation::Tanh;
use pam_core::force::Dense;
use pam_core::{FieldFn, Mlp, ParametricField, Scalar, VectorField};
use pam_solvers::sensitivity::DiscreteAdjoint;
use pam_solvers::{Integrator, NoInput, PidController, SaveAt, Tableau, Term};
use pam_train::field::{Experiment, FieldProblem, FieldTraining, Outputs, outputs_error};

const OMEGA_SQUARED: f64 = 9.81;

struct Pendulum<S> {
    damping: Mlp<S, Tanh>,
}

impl<S: Scalar> VectorField<S> for Pendulum<S> {
    fn state_len(&self) -> usize {
        2
    }
    fn input_len(&self) -> usize {
        0
    }
    fn work_len(&self) -> usize {
        self.damping.work_len()
    }
    fn eval_into(&self, _t: f64, y: &[S], _u: &[S], dy: &mut [S], work: &mut [S]) {
        let mut damping = [S::zero()];
        self.damping.forward_into(&[y[1]], &mut damping, work);
        dy[0] = y[1];
        dy[1] = -y[0].sin().scaled(OMEGA_SQUARED) - damping[0];
    }
}

impl ParametricField for Pendulum<f64> {
    type With<S: Scalar> = Pendulum<S>;
    fn parameters(&self) -> Vec<f64> {
        let mut numbers = Vec::new();
        self.damping.map(|weight| {
            numbers.push(weight);
            weight
        });
        numbers
    }
    fn with_parameters<S: Scalar>(&self, p: &[S]) -> Pendulum<S> {
        let mut next = p.iter();
        Pendulum { damping: self.damping.map(|_| *next.next().expect("a number for each weight")) }
    }
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let integrator = Integrator::new(Tableau::tsit5(), PidController::new(1e-6, 1e-6));
    let law = |v: f64| 0.1 * v + 0.15 * v * v.abs();
    let truth = FieldFn::new(2, 0, |_t, y: &[f64], _u: &[f64], dy: &mut [f64]| {
        dy[0] = y[1];
        dy[1] = -OMEGA_SQUARED * y[0].sin() - law(y[1]);
    });
    let swing = |angle: f64| -> Result<Experiment<NoInput>, Box<dyn std::error::Error>> {
        let times_s: Vec<f64> = (0..200).map(|k| 0.02 * f64::from(k)).collect();
        let end = times_s[times_s.len() - 1];
        let term = Term::new(&truth, NoInput);
        let run = integrator.solve(&term, 0.0, end, &[angle, 0.0], SaveAt::Times(&times_s))?;
        let measured = run.component(0).collect(); // the angle alone
        Ok(Experiment::new(&format!("from {angle} rad"), NoInput, times_s, measured)
            .starting_at(vec![angle, 0.0]))
    };
    let experiments = [swing(0.5)?, swing(1.2)?, swing(2.0)?];
    let held_out = [swing(1.6)?];

    // 1–6–1 with small, spread weights.
    let spread = |n: usize, size: f64| {
        (0..n).map(|i| size * (1.0 + 2.4 * i as f64).sin()).collect::<Vec<_>>()
    };
    let layers = vec![
        Dense::from_rows(&spread(6, 0.5), spread(6, 0.3))?,
        Dense::from_rows(&spread(6, 0.2), vec![0.0])?,
    ];
    let start = Pendulum { damping: Mlp::new(layers, Tanh)? };
    let outputs = Outputs::new([(0, 0.01)]); // state 0, in units of 0.01 rad
    let problem = FieldProblem::new(&start, &experiments, outputs.clone(), &integrator)
        .with_held_out(&held_out);
    let trained = problem.train(
        &outputs_error(2, outputs),
        &DiscreteAdjoint::new(ByTape),
        &FieldTraining { iterations: 600, ..FieldTraining::default() },
        |_step, _loss| true,
    )?;
    let (first, last) = (trained.losses[0], trained.losses[trained.losses.len() - 1]);
    println!("loss {first:.3} to {last:.5} in {} steps", trained.losses.len() - 1);
    assert!(last < 0.02, "the angle is reproduced to 1.4 mrad");
    let [_, unseen] = trained.held_out.expect("an experiment is held out");
    println!("held out: {unseen:.5}");
    assert!(unseen < 0.05, "so is one that was not seen, to 2.2 mrad");

    // The law itself was found, from angles alone.
    let found = start.with_parameters::<f64>(&trained.parameters);
    let mut work = vec![0.0; found.damping.work_len()];
    for v in [-4.0, -2.0, 1.0, 3.0] {
        let mut damping = [0.0];
        found.damping.forward_into(&[v], &mut damping, &mut work);
        println!("damping at {v:4.1} rad/s: {:.3}, true {:.3} rad/s²", damping[0], law(v));
        assert!((damping[0] - law(v)).abs() < 0.1);
    }
    Ok(())
}
