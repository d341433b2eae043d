//! Cells of the study that share a problem and a solver.

use super::case::{Case, Exact};
use super::measure::{Measured, measure};
use super::method::Method;
use super::result::Row;
use super::solver::{Solver, Steps};
use super::truth::{Replayed, tight};
use pam_core::ParametricField;
use pam_solvers::sensitivity::Gradient;
use pam_solvers::{ParametricInput, SolveError};

/// Some cells of the study, run one after the other.
pub trait Cells {
    /// The names of the cells that make one row each: problem and method.
    fn names(&self) -> Vec<(String, String)>;

    /// Runs the cells that `wanted` names, each timed up to `repeat` times, and hands over their rows.
    fn run(&self, repeat: usize, wanted: &dyn Fn(&str, &str) -> bool, found: &mut dyn FnMut(Row));
}

/// Cells whose problem is chosen at run time.
impl Cells for Box<dyn Cells> {
    fn names(&self) -> Vec<(String, String)> {
        (**self).names()
    }
    fn run(&self, repeat: usize, wanted: &dyn Fn(&str, &str) -> bool, found: &mut dyn FnMut(Row)) {
        (**self).run(repeat, wanted, found);
    }
}

/// Every method with every solver on one case.
pub struct Grid<F, I> {
    /// Part of the study.
    pub part: String,
    /// The case.
    pub case: Case<F, I>,
    /// The methods.
    pub methods: Vec<Method<F, I>>,
    /// The solvers.
    pub solvers: Vec<Solver>,
}

/// Why there is no gradient, in words.
fn failure(e: &SolveError<f64>) -> String {
    e.kind.describe(e.time_s)
}

impl<F: ParametricField, I: ParametricInput> Cells for Grid<F, I> {
    fn names(&self) -> Vec<(String, String)> {
        let once = self.methods.iter().map(|m| (self.case.name.clone(), m.name.clone()));
        self.solvers.iter().flat_map(|_| once.clone()).collect()
    }

    fn run(&self, repeat: usize, wanted: &dyn Fn(&str, &str) -> bool, found: &mut dyn FnMut(Row)) {
        let wanted = |m: &&Method<F, I>| wanted(&self.case.name, &m.name);
        if !self.methods.iter().any(|m| wanted(&m)) {
            return;
        }
        let truth = tight(&self.case);
        for solver in &self.solvers {
            let integrator = solver.integrator();
            let replayed = Replayed::new(&self.case, &integrator);
            for method in self.methods.iter().filter(wanted) {
                let built = method.build(solver);
                let (gradient, measured) = measure(repeat, || {
                    self.case.gradient_of(&self.case.field, &*built, &integrator)
                });
                let mut row = self.blank(method, solver);
                match (gradient, &truth, &replayed) {
                    (Ok(gradient), Ok(truth), Ok(replayed)) => {
                        self.fill(&mut row, &gradient, measured, truth, replayed);
                    }
                    (Err(e), _, _) => row.failure = Some(failure(&e)),
                    (_, Err(e), _) => row.failure = Some(format!("no truth: {}", failure(e))),
                    (_, _, Err(e)) => row.failure = Some(format!("no replay: {}", failure(e))),
                }
                found(row);
            }
        }
    }
}

impl<F: ParametricField, I: ParametricInput> Grid<F, I> {
    fn blank(&self, method: &Method<F, I>, solver: &Solver) -> Row {
        let case = &self.case;
        Row {
            part: self.part.clone(),
            problem: case.name.clone(),
            activation: case.activation.clone(),
            width: case.width,
            parameters: case.field.parameter_len(),
            trajectories: 1,
            horizon_s: case.horizon_s,
            method: method.name.clone(),
            differentiation: method.differentiation.clone(),
            kind: method.kind,
            ..blank(solver)
        }
    }

    fn fill(
        &self,
        row: &mut Row,
        gradient: &Gradient,
        measured: Measured,
        truth: &Exact,
        replayed: &Replayed,
    ) {
        let numbers = [&gradient.parameters, &gradient.initial_state, &gradient.input];
        let s = &gradient.statistics;
        row.seconds = Some(measured.seconds);
        row.peak_bytes = measured.peak_bytes;
        row.checkpoint_bytes = s.checkpoint_bytes;
        row.evaluations = s.evaluations;
        row.vjps = s.vjps;
        row.jvps = s.jvps;
        row.steps = s.steps;
        row.rejected = s.rejected;
        row.replayed = s.replayed;
        row.backward_steps = s.backward_steps;
        row.backward_rejected = s.backward_rejected;
        row.value = finite(gradient.value);
        row.value_error = finite(truth.value_error(gradient.value));
        row.state_error = finite(truth.state_error(&gradient.states, self.case.y0.len()));
        if numbers.into_iter().flatten().any(|g| !g.is_finite()) {
            row.failure = Some("the gradient is not finite".into());
            return;
        }
        row.replay_error = finite(replayed.error_of(&self.case, gradient));
        row.gradient_error = finite(truth.error_of(&self.case, gradient));
    }
}

/// A row of `solver` with nothing in it yet.
pub(super) fn blank(solver: &Solver) -> Row {
    let (rtol, atol, step_s) = match solver.steps {
        Steps::Adaptive { rtol, atol } => (Some(rtol), Some(atol), None),
        Steps::Constant { step_s } => (None, None, Some(step_s)),
    };
    Row {
        part: String::new(),
        problem: String::new(),
        activation: None,
        width: None,
        parameters: 0,
        trajectories: 1,
        horizon_s: 0.0,
        method: String::new(),
        differentiation: String::new(),
        kind: super::method::Kind::Exact,
        solver: solver.tableau.name.into(),
        rtol,
        atol,
        step_s,
        value: None,
        value_error: None,
        state_error: None,
        replay_error: None,
        gradient_error: None,
        seconds: None,
        peak_bytes: None,
        checkpoint_bytes: 0,
        evaluations: 0,
        vjps: 0,
        jvps: 0,
        steps: 0,
        rejected: 0,
        replayed: 0,
        backward_steps: 0,
        backward_rejected: 0,
        failure: None,
    }
}

/// A number that a file can hold.
pub(super) fn finite(value: f64) -> Option<f64> {
    value.is_finite().then_some(value)
}
