//! Reference gradients.

use super::case::{Case, Exact};
use super::solver::Solver;
use pam_autodiff::ByTape;
use pam_core::{ParametricField, Scalar, VectorField};
use pam_solvers::sensitivity::{DiscreteAdjoint, DualThroughSolver, Gradient};
use pam_solvers::{Integrator, ParametricInput, SolveError, StepController, Tableau};

/// Tolerance of the computed truth.
pub const TIGHT: f64 = 1e-12;
/// Most parameters that the frozen steps are differentiated by.
const MOST_SAMPLED: usize = 128;
/// Last parameters that are always among them: mass, gas, damping and air of a joint.
const ALWAYS: usize = 6;

/// The truth of a case: in closed form, of the whole solution or from kink to kink, or by the exact adjoint
/// of steps at a tight tolerance that end at every observation.
///
/// # Errors
/// [`SolveError`] if the tight solve stops early.
pub fn tight<F, I>(case: &Case<F, I>) -> Result<Exact, Box<SolveError<f64>>>
where
    F: ParametricField,
    I: ParametricInput,
{
    if let Some(exact) = &case.exact {
        return Ok(exact.clone());
    }
    if let Some(exact) = case.closed_form.as_ref().and_then(|find| find()) {
        return Ok(exact);
    }
    let mut solver = Solver::adaptive(Tableau::dormand_prince5(), TIGHT);
    solver.max_steps = 10_000_000;
    solver.stops_s.clone_from(&case.observations_s);
    let adjoint = DiscreteAdjoint::new(ByTape);
    let integrator = solver.integrator();
    let g = case.gradient_of(&case.field, &adjoint, &integrator)?;
    Ok(Exact {
        value: g.value,
        parameters: g.parameters,
        initial_state: g.initial_state,
        states: g.states,
    })
}

/// The gradient of the frozen steps by dual numbers, on all parameters or a sample of them.
#[derive(Debug, Clone)]
pub struct Replayed {
    indices: Vec<usize>,
    gradient: Gradient,
}

impl Replayed {
    /// The gradient of `case` with the steps that `integrator` takes.
    ///
    /// # Errors
    /// [`SolveError`] if the solve stops early.
    pub fn new<F, I>(
        case: &Case<F, I>,
        integrator: &Integrator<dyn StepController>,
    ) -> Result<Self, Box<SolveError<f64>>>
    where
        F: ParametricField,
        I: ParametricInput,
    {
        let sampled = Sampled::new(&case.field);
        let method = DualThroughSolver;
        let gradient = case.gradient_of(&sampled, &method, integrator)?;
        Ok(Self { indices: sampled.indices, gradient })
    }

    /// Relative error of a gradient against this one, the largest over the groups.
    #[must_use]
    pub fn error_of<F, I>(&self, case: &Case<F, I>, gradient: &Gradient) -> f64 {
        let found: Vec<f64> = self.indices.iter().map(|&i| gradient.parameters[i]).collect();
        let groups = groups(case, gradient.parameters.len());
        let of_parameters = groups
            .iter()
            .map(|group| {
                let first = self.indices.partition_point(|i| *i < group.start);
                let end = self.indices.partition_point(|i| *i < group.end);
                relative_error(&found[first..end], &self.gradient.parameters[first..end])
            })
            .fold(0.0, f64::max);
        of_parameters
            .max(relative_error(&gradient.initial_state, &self.gradient.initial_state))
            .max(relative_error(&gradient.input, &self.gradient.input))
    }
}

impl Exact {
    /// Relative error of a gradient against this one, the largest over the groups.
    #[must_use]
    pub fn error_of<F, I>(&self, case: &Case<F, I>, gradient: &Gradient) -> f64 {
        groups(case, gradient.parameters.len())
            .into_iter()
            .map(|group| {
                relative_error(&gradient.parameters[group.clone()], &self.parameters[group])
            })
            .fold(relative_error(&gradient.initial_state, &self.initial_state), f64::max)
    }

    /// Relative error of a loss.
    #[must_use]
    pub fn value_error(&self, value: f64) -> f64 {
        relative_error(&[value], &[self.value])
    }

    /// Largest error of the first of `states` states.
    #[must_use]
    pub fn state_error(&self, found: &[f64], states: usize) -> f64 {
        let first = |rows: &[f64]| rows.iter().step_by(states).copied().collect::<Vec<f64>>();
        let pairs = first(found).into_iter().zip(first(&self.states));
        pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
    }
}

/// The groups of parameters of a case as ranges.
fn groups<F, I>(case: &Case<F, I>, parameters: usize) -> Vec<std::ops::Range<usize>> {
    let mut start = 0;
    let mut out = Vec::new();
    for &len in &case.groups {
        out.push(start..start + len);
        start += len;
    }
    out.push(start..parameters);
    out
}

/// `‖a − b‖ / ‖b‖`; 0 where both vanish.
#[must_use]
pub fn relative_error(a: &[f64], b: &[f64]) -> f64 {
    // Scaled, so that a gradient that is wrong by hundreds of orders of magnitude does not overflow.
    let scale = a.iter().chain(b).fold(0.0_f64, |m, v| m.max(v.abs()));
    if scale == 0.0 {
        return 0.0;
    }
    let norm = |values: &mut dyn Iterator<Item = f64>| {
        values.map(|v| (v / scale) * (v / scale)).sum::<f64>().sqrt()
    };
    let off = norm(&mut a.iter().zip(b).map(|(a, b)| a - b));
    let size = norm(&mut b.iter().copied());
    if off == 0.0 { 0.0 } else { off / size }
}

/// A field of which only some parameters count as such.
struct Sampled<'a, F> {
    field: &'a F,
    all: Vec<f64>,
    indices: Vec<usize>,
}

impl<'a, F: ParametricField> Sampled<'a, F> {
    fn new(field: &'a F) -> Self {
        let all = field.parameters();
        let indices = if all.len() <= MOST_SAMPLED {
            (0..all.len()).collect()
        } else {
            let spread = all.len() - ALWAYS;
            let most = MOST_SAMPLED - ALWAYS;
            (0..most).map(|k| k * spread / most).chain(spread..all.len()).collect()
        };
        Self { field, all, indices }
    }
}

impl<F: ParametricField> VectorField<f64> for Sampled<'_, F> {
    fn state_len(&self) -> usize {
        self.field.state_len()
    }
    fn input_len(&self) -> usize {
        self.field.input_len()
    }
    fn work_len(&self) -> usize {
        self.field.work_len()
    }
    fn eval_into(&self, t: f64, y: &[f64], u: &[f64], dy: &mut [f64], work: &mut [f64]) {
        self.field.eval_into(t, y, u, dy, work);
    }
}

impl<F: ParametricField> ParametricField for Sampled<'_, F> {
    type With<S: Scalar> = F::With<S>;

    fn parameters(&self) -> Vec<f64> {
        self.indices.iter().map(|&i| self.all[i]).collect()
    }

    fn with_parameters<S: Scalar>(&self, parameters: &[S]) -> Self::With<S> {
        let mut all: Vec<S> = self.all.iter().map(|&p| S::constant(p)).collect();
        for (&i, &p) in self.indices.iter().zip(parameters) {
            all[i] = p;
        }
        self.field.with_parameters(&all)
    }
}
