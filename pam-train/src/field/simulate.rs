//! The signals of an experiment under other numbers, and their derivatives.

use super::driven::Driven;
use super::experiment::Experiment;
use super::problem::{FieldError, FieldProblem, failed};
use pam_autodiff::Chunk;
use pam_core::{ParametricField, Scalar, VectorField};
use pam_solvers::{Input, SaveAt, Side, Term};

/// The numbers under which an experiment is simulated.
#[derive(Debug, Clone, PartialEq)]
pub struct Numbers<S> {
    /// The parameters of the field.
    pub parameters: Vec<S>,
    /// The state at the first time.
    pub initial_state: Vec<S>,
    /// Delay of the input, s: the field sees `u(t − delay)`.
    pub delay_s: S,
}

/// One of these numbers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Number {
    /// A parameter of the field.
    Parameter(usize),
    /// An initial state.
    InitialState(usize),
    /// The delay of the input.
    Delay,
}

/// Signals of an experiment and their derivatives.
#[derive(Debug, Clone, PartialEq)]
pub struct SignalSensitivities {
    /// Signals, row-major `[times, signals]`.
    pub signals: Vec<f64>,
    /// Their derivatives by each number, row-major `[times, signals]`.
    pub by: Vec<Vec<f64>>,
}

/// Numbers that one run differentiates by, where there are few of them and where there are many.
const FEW: usize = 4;
const MANY: usize = 8;

impl<F, I> FieldProblem<'_, F, I>
where
    F: ParametricField + Sync,
    I: Input<f64> + Sync,
{
    /// Number of signals of the field: states, then outputs.
    #[must_use]
    pub fn signal_len(&self) -> usize {
        self.field.state_len() + self.field.output_len()
    }

    /// The present parameters of the field, the given start of an experiment, no delay.
    #[must_use]
    pub fn numbers(&self, experiment: &Experiment<I>) -> Numbers<f64> {
        Numbers {
            parameters: self.field.parameters(),
            initial_state: self.initial_state(experiment),
            delay_s: 0.0,
        }
    }

    /// The signals of an experiment at its times, row-major `[times, signals]`, over any scalar. A field with
    /// [`dry_friction`](ParametricField::dry_friction) sticks and slips.
    ///
    /// # Errors
    /// [`FieldError::Solve`] if the solve stops early or a signal is not finite.
    pub fn simulate<S: Scalar>(
        &self,
        experiment: &Experiment<I>,
        numbers: &Numbers<S>,
    ) -> Result<Vec<S>, FieldError> {
        let e = experiment;
        let field = self.field.with_parameters::<S>(&numbers.parameters);
        let width_s = e.sample_s().max(f64::MIN_POSITIVE);
        let input = Driven { input: &e.input, delay_s: numbers.delay_s, width_s };
        let term = Term::new(&field, input);
        let (times, y0) = (&e.times_s, &numbers.initial_state);
        let friction = self.field.dry_friction();
        let solved = match friction {
            Some(friction) => self.integrator.solve_sticking(&term, friction, y0, times),
            None => {
                let (t0, t1) = (times[0], times[times.len() - 1]);
                self.integrator.solve(&term, t0, t1, y0, SaveAt::Times(times))
            }
        };
        let solution = solved.map_err(|error| failed(e, &error))?;
        let states = solution.states();
        let (n, h) = (self.field.state_len(), self.field.output_len());
        let signals = if h == 0 {
            states.to_vec()
        } else {
            let mut signals = vec![S::zero(); times.len() * (n + h)];
            let mut u = vec![S::zero(); self.field.input_len()];
            for (k, row) in signals.chunks_exact_mut(n + h).enumerate() {
                let y = &states[k * n..(k + 1) * n];
                term.input.value_into(times[k], Side::Right, &mut u[..e.input.input_len()]);
                if let Some(friction) = friction {
                    // The direction stands among the inputs of the field.
                    u[friction.direction..].rotate_right(1);
                    let v = y[friction.velocity].real();
                    u[friction.direction] = S::constant(if v == 0.0 { 0.0 } else { v.signum() });
                }
                row[..n].copy_from_slice(y);
                field.outputs_into(times[k], y, &u, &mut row[n..]);
            }
            signals
        };
        match signals.iter().position(|v| !v.real().is_finite()) {
            None => Ok(signals),
            Some(at) => {
                let what = format!(
                    "signal `{}` is not finite at t = {} s",
                    self.field.names().signal(at % (n + h), n),
                    times[at / (n + h)]
                );
                Err(failed(e, &what))
            }
        }
    }

    /// The signals of an experiment and their derivatives by some of its numbers, exact for the steps taken.
    ///
    /// # Errors
    /// [`FieldError::Solve`] if the solve stops early, or a signal or derivative is not finite.
    pub fn sensitivities(
        &self,
        experiment: &Experiment<I>,
        at: &Numbers<f64>,
        by: &[Number],
    ) -> Result<SignalSensitivities, FieldError> {
        if by.is_empty() {
            let signals = self.simulate(experiment, at)?;
            return Ok(SignalSensitivities { signals, by: Vec::new() });
        }
        if by.len() > FEW {
            self.derivatives::<MANY>(experiment, at, by)
        } else {
            self.derivatives::<FEW>(experiment, at, by)
        }
    }

    /// The signals and their derivatives, by `N` numbers in each run.
    fn derivatives<const N: usize>(
        &self,
        experiment: &Experiment<I>,
        at: &Numbers<f64>,
        by: &[Number],
    ) -> Result<SignalSensitivities, FieldError> {
        let mut found = SignalSensitivities { signals: Vec::new(), by: Vec::new() };
        for some in by.chunks(N) {
            let seeded = |value: f64, number: Number| match some.iter().position(|n| *n == number) {
                Some(k) => Chunk::<N>::variable(value, k),
                None => Chunk::constant(value),
            };
            let all = |values: &[f64], number: fn(usize) -> Number| {
                values.iter().enumerate().map(|(k, &v)| seeded(v, number(k))).collect()
            };
            let numbers = Numbers {
                parameters: all(&at.parameters, Number::Parameter),
                initial_state: all(&at.initial_state, Number::InitialState),
                delay_s: seeded(at.delay_s, Number::Delay),
            };
            let signals = self.simulate(experiment, &numbers)?;
            for k in 0..some.len() {
                let column: Vec<f64> = signals.iter().map(|s| s.derivatives[k]).collect();
                if column.iter().any(|d| !d.is_finite()) {
                    let why = "the derivative of its signals by a parameter is not finite; look for overflow in the \
                               field (sinh, cosh, exp of large numbers)";
                    return Err(failed(experiment, &why));
                }
                found.by.push(column);
            }
            if found.signals.is_empty() {
                found.signals = signals.iter().map(|s| s.value).collect();
            }
        }
        Ok(found)
    }
}
