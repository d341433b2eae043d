//! A gradient method of one's own: the complex step through the accepted steps.
//!
//! Every parameter in turn gets a tiny imaginary part; the imaginary part of the replayed states is the
//! derivative, without cancellation (W. Squire and G. Trapp 1998). To ship it, put the type into
//! `pam-solvers/src/sensitivity/complex_step.rs` and add two lines: `mod complex_step;` in `mod.rs` there, and
//! `"complex_step" => ComplexStep(complex_step::ComplexStepThroughSolver),`, with a line of what it is, in the
//! list of `named.rs`. `pam gradient --method complex_step` then knows it.

use pam_autodiff::{ByTape, ComplexStep};
use pam_core::{ParametricField, Scalar, VectorField};
use pam_solvers::sensitivity::{
    DiscreteAdjoint, Gradient, GradientMethod, GradientStatistics, Loss, MethodSetup, NamedMethod,
    Problem,
};
use pam_solvers::{
    Grid, Integrator, NoInput, ParametricInput, PidController, SaveAt, SolveError, Tableau, Term,
    replay,
};

/// The complex step, with this imaginary part.
pub struct ComplexStepThroughSolver {
    /// The imaginary part.
    pub h: f64,
}

/// How it is made where only its name is given.
impl<C> NamedMethod<C> for ComplexStepThroughSolver {
    fn from_setup(_: MethodSetup<C>) -> Self {
        Self { h: 1e-40 }
    }
}

impl<F: ParametricField, I: ParametricInput> GradientMethod<F, I> for ComplexStepThroughSolver {
    fn name(&self) -> String {
        "complex step through the solver".into()
    }

    fn value_and_gradient(
        &self,
        problem: &Problem<'_, F, I>,
        loss: &mut dyn Loss,
    ) -> Result<Gradient, Box<SolveError<f64>>> {
        let save_at = SaveAt::Times(problem.observations_s);
        let mut grid = Grid::new();
        let plain = problem.integrator.solve_with_grid(
            &problem.term(),
            problem.t0,
            problem.t1,
            problem.y0,
            save_at,
            &mut grid,
        )?;
        let mut cotangents = vec![0.0; plain.states().len()];
        let value =
            loss.value_and_cotangents(problem.observations_s, plain.states(), &mut cotangents);

        let numbers =
            [&problem.field.parameters(), problem.y0, &problem.input.parameters()].concat();
        let (p, n) = (problem.field.parameter_len(), problem.y0.len());
        let mut slopes = Vec::with_capacity(numbers.len());
        for i in 0..numbers.len() {
            let mut z: Vec<ComplexStep> =
                numbers.iter().map(|&v| ComplexStep::new(v, 0.0)).collect();
            z[i].im = self.h;
            let field = problem.field.with_parameters(&z[..p]);
            let term = Term::new(field, problem.input.with_parameters(&z[p + n..]));
            let states = replay(problem.integrator.tableau(), &term, &grid, &z[p..p + n], save_at)
                .map_err(|e| SolveError {
                    kind: e.kind,
                    time_s: e.time_s,
                    state: Vec::new(),
                    partial: plain.clone(),
                })?;
            let change = states.states().iter().zip(&cotangents).map(|(y, w)| w * y.im / self.h);
            slopes.push(change.sum::<f64>());
        }
        let input = slopes.split_off(p + n);
        let initial_state = slopes.split_off(p);
        let statistics =
            GradientStatistics { steps: plain.statistics.accepted, ..Default::default() };
        let states = plain.states().to_vec();
        Ok(Gradient { value, parameters: slopes, initial_state, input, states, grid, statistics })
    }
}

/// `ẍ = μ (1 − x²) ẋ − x` (van der Pol).
struct VanDerPol<S> {
    mu: S,
}

impl<S: Scalar> VectorField<S> for VanDerPol<S> {
    fn state_len(&self) -> usize {
        2
    }
    fn input_len(&self) -> usize {
        0
    }
    fn eval_into(&self, _t: f64, y: &[S], _u: &[S], dy: &mut [S], _work: &mut [S]) {
        dy[0] = y[1];
        dy[1] = self.mu * (S::constant(1.0) - y[0] * y[0]) * y[1] - y[0];
    }
}

impl ParametricField for VanDerPol<f64> {
    type With<S: Scalar> = VanDerPol<S>;
    fn parameters(&self) -> Vec<f64> {
        vec![self.mu]
    }
    fn with_parameters<S: Scalar>(&self, p: &[S]) -> VanDerPol<S> {
        VanDerPol { mu: p[0] }
    }
}

fn main() -> Result<(), Box<SolveError<f64>>> {
    let integrator = Integrator::new(Tableau::dormand_prince5(), PidController::new(1e-6, 1e-6));
    let problem = Problem {
        field: &VanDerPol { mu: 2.0 },
        input: &NoInput,
        t0: 0.0,
        t1: 10.0,
        y0: &[2.0, 0.0],
        observations_s: &[2.5, 5.0, 10.0],
        integrator: &integrator,
    };
    let mut loss = |_: &[f64], states: &[f64], cotangents: &mut [f64]| {
        cotangents.copy_from_slice(states);
        states.iter().map(|y| 0.5 * y * y).sum::<f64>()
    };
    let own = ComplexStepThroughSolver { h: 1e-40 }.value_and_gradient(&problem, &mut loss)?;
    let adjoint = DiscreteAdjoint::new(ByTape).value_and_gradient(&problem, &mut loss)?;
    println!(
        "dL/dμ: complex step {:.12}, adjoint {:.12}",
        own.parameters[0], adjoint.parameters[0]
    );
    // Both differentiate the same steps: they agree to rounding.
    let scale = adjoint.parameters[0].abs();
    assert!((own.parameters[0] - adjoint.parameters[0]).abs() < 1e-9 * scale);
    assert!(
        own.initial_state
            .iter()
            .zip(&adjoint.initial_state)
            .all(|(a, b)| (a - b).abs() < 1e-9 * scale)
    );
    Ok(())
}
