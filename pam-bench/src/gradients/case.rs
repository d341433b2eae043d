//! The quantities that the study differentiates.

use pam_solvers::sensitivity::{Gradient, GradientMethod, Problem};
use pam_solvers::{Integrator, SolveError, StepController};

/// A loss of observed states, `(times, states, cotangents) -> value`; see
/// [`Loss`](pam_solvers::sensitivity::Loss).
pub type CaseLoss = Box<dyn Fn(&[f64], &[f64], &mut [f64]) -> f64>;

/// Loss and gradient in closed form.
#[derive(Debug, Clone, PartialEq)]
pub struct Exact {
    /// The loss.
    pub value: f64,
    /// Its gradient with respect to the parameters of the field.
    pub parameters: Vec<f64>,
    /// Its gradient with respect to the initial state.
    pub initial_state: Vec<f64>,
    /// The observed states, row-major `[times, states]`.
    pub states: Vec<f64>,
}

/// One problem over one horizon: a field with its input, where it starts and is observed, and a loss.
pub struct Case<F, I> {
    /// Name of the problem; cases of several horizons or widths share it.
    pub name: String,
    /// Activation of the network in it.
    pub activation: Option<String>,
    /// Width of the network in it.
    pub width: Option<usize>,
    /// The field.
    pub field: F,
    /// The input.
    pub input: I,
    /// Initial state.
    pub y0: Vec<f64>,
    /// The solve runs from 0 to here, s.
    pub horizon_s: f64,
    /// When the loss sees the state, s.
    pub observations_s: Vec<f64>,
    /// The loss.
    pub loss: CaseLoss,
    /// Numbers of parameters, in their order, whose gradients are judged apart because their scales
    /// have nothing to do with each other; what is left over is the last group.
    pub groups: Vec<usize>,
    /// The truth where it is known; otherwise it is computed.
    pub exact: Option<Exact>,
    /// How the truth is found from kink to kink in closed form, where it can be; `None` from it says that
    /// it cannot. Otherwise it is computed at a tight tolerance.
    pub closed_form: Option<Box<dyn Fn() -> Option<Exact>>>,
}

impl<F, I> Case<F, I> {
    /// A case without network, all parameters of one scale, truth to be computed.
    pub fn new(
        name: &str,
        (field, input): (F, I),
        y0: &[f64],
        observations_s: Vec<f64>,
        loss: impl Fn(&[f64], &[f64], &mut [f64]) -> f64 + 'static,
    ) -> Self {
        Self {
            name: name.into(),
            activation: None,
            width: None,
            field,
            input,
            y0: y0.to_vec(),
            horizon_s: observations_s.last().copied().unwrap_or(0.0),
            observations_s,
            loss: Box::new(loss),
            groups: Vec::new(),
            exact: None,
            closed_form: None,
        }
    }

    /// The same with a known truth.
    #[must_use]
    pub fn with_exact(mut self, exact: Exact) -> Self {
        self.exact = Some(exact);
        self
    }

    /// The gradient of the case by `method`, solved by `integrator`; `field` stands for the case's own.
    ///
    /// # Errors
    /// [`SolveError`] if a solve stops early.
    pub fn gradient_of<G>(
        &self,
        field: &G,
        method: &dyn GradientMethod<G, I>,
        integrator: &Integrator<dyn StepController>,
    ) -> Result<Gradient, Box<SolveError<f64>>> {
        let problem = Problem {
            field,
            input: &self.input,
            t0: 0.0,
            t1: self.horizon_s,
            y0: &self.y0,
            observations_s: &self.observations_s,
            integrator,
        };
        let mut loss =
            |times: &[f64], states: &[f64], out: &mut [f64]| (self.loss)(times, states, out);
        method.value_and_gradient(&problem, &mut loss)
    }
}

/// `count` evenly spaced times that end at `end_s`, s.
#[must_use]
pub fn evenly(count: usize, end_s: f64) -> Vec<f64> {
    (1..=count).map(|k| end_s * k as f64 / count as f64).collect()
}

/// Half the squared distance of every state from `target(t)`, each divided by its scale, averaged over
/// the observations.
pub fn half_squares<const N: usize>(
    target: fn(f64) -> [f64; N],
    scales: [f64; N],
) -> impl Fn(&[f64], &[f64], &mut [f64]) -> f64 {
    move |times, states, cotangents| {
        let share = 1.0 / times.len().max(1) as f64;
        let mut value = 0.0;
        let rows = states.chunks_exact(N).zip(cotangents.chunks_exact_mut(N));
        for (&t, (y, w)) in times.iter().zip(rows) {
            for (((y, w), target), scale) in y.iter().zip(w).zip(target(t)).zip(scales) {
                // An infinite scale leaves a state out.
                let off = (y - target) / scale;
                value += 0.5 * share * off * off;
                *w = share * off / scale;
            }
        }
        value
    }
}
