//! A few parameters of a field by Levenberg–Marquardt.

use super::normal::Normal;
use super::problem::{FieldError, FieldProblem, failed};
use pam_autodiff::{ByDual, Differentiation};
use pam_core::ParametricField;
use pam_core::parallel;
use pam_numerics::statistics::t_quantile_95;
use pam_solvers::ParametricInput;
use pam_solvers::sensitivity::{Direction, ForwardSensitivity};

/// Settings of a fit.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct LeastSquares {
    /// Parameters (by index) that are fitted; all, if absent.
    pub free: Option<Vec<usize>>,
    /// The parameters to start from; those of the field, if absent.
    pub start: Option<Vec<f64>>,
    /// Possible values of each parameter of the field; any value, if absent.
    pub ranges: Option<Vec<[f64; 2]>>,
    /// Steps at most; 30, if absent.
    pub iterations: Option<usize>,
    /// Only rows before this share of each experiment count; all, if absent.
    pub until: Option<f64>,
}

/// A fit of some parameters.
#[derive(Debug, Clone, PartialEq)]
pub struct FieldFit {
    /// All parameters of the field.
    pub parameters: Vec<f64>,
    /// Indices of those that were fitted.
    pub free: Vec<usize>,
    /// Their standard errors; the covariance is clustered by blocks of a tenth of an experiment, since the
    /// residuals of a model that is not quite right are correlated.
    pub standard_errors: Vec<f64>,
    /// Half the width of their 95 % intervals over the standard error: the quantile of Student's t.
    pub quantile: f64,
    /// Mean squared error of each output on the fitted rows, in its squared unit.
    pub mean_squares: Vec<f64>,
    /// Number of fitted rows.
    pub rows: usize,
    /// Whether the last step was small.
    pub converged: bool,
}

impl FieldFit {
    /// The 95 % interval of parameter `index` of the field, if it was fitted.
    #[must_use]
    pub fn interval(&self, index: usize) -> Option<[f64; 2]> {
        let at = self.free.iter().position(|&k| k == index)?;
        let half = self.quantile * self.standard_errors[at];
        Some([self.parameters[index] - half, self.parameters[index] + half])
    }
}

/// Blocks of one experiment in the clustered covariance.
const BLOCKS: usize = 10;
/// Change of the cost (in units of the squared noise) below which a fit has arrived.
const ARRIVED: f64 = 1e-3;

impl<F, I> FieldProblem<'_, F, I>
where
    F: ParametricField + Sync,
    F::With<f64>: ParametricField,
    ByDual: Differentiation<F::With<f64>>,
    I: ParametricInput + Sync,
{
    /// Fits parameters to the weighted squared error `Σ ((predicted − measured) / noise)²` by
    /// Levenberg–Marquardt with the exact sensitivities of the steps taken.
    ///
    /// # Errors
    /// [`FieldError`] if shapes do not fit, or the field cannot be solved where it starts.
    pub fn least_squares(&self, settings: &LeastSquares) -> Result<FieldFit, FieldError> {
        self.check()?;
        let start = settings.start.clone().unwrap_or_else(|| self.field.parameters());
        let len = start.len();
        let free = settings.free.clone().unwrap_or_else(|| (0..len).collect());
        let ranges = settings
            .ranges
            .clone()
            .unwrap_or_else(|| vec![[f64::NEG_INFINITY, f64::INFINITY]; len]);
        if len != self.field.parameter_len()
            || ranges.len() != len
            || free.iter().any(|&k| k >= len)
        {
            return Err(FieldError::Shape(format!(
                "{len} starting values, {} ranges and free parameters {free:?} do not fit a field of {} \
                 parameters",
                ranges.len(),
                self.field.parameter_len()
            )));
        }
        let until = settings.until.unwrap_or(1.0);
        let mut at = start;
        let mut squares = self.squares(&at, until)?;
        let mut cost = self.cost(&squares);
        let mut damping = 1e-3;
        let mut converged = false;
        for _ in 0..settings.iterations.unwrap_or(30) {
            let normal = self.normal(&at, &free, until)?;
            let right = [normal.right()];
            let mut gained = 0.0;
            for _ in 0..6 {
                let mut next = at.clone();
                if let Some(steps) = normal.solve(damping, &right) {
                    for (&k, step) in free.iter().zip(&steps[0]) {
                        next[k] = (at[k] - step).clamp(ranges[k][0], ranges[k][1]);
                    }
                    if let Ok(s) = self.squares(&next, until) {
                        let c = self.cost(&s);
                        if c < cost {
                            gained = cost - c;
                            (at, squares, cost) = (next, s, c);
                            damping = (damping * 0.2).max(1e-10);
                            break;
                        }
                    }
                }
                damping *= 8.0;
            }
            if gained < ARRIVED {
                converged = true;
                break;
            }
        }
        let normal = self.normal(&at, &free, until)?;
        let freedom = (normal.blocks.len() as f64 - 1.0 - free.len() as f64).max(1.0);
        Ok(FieldFit {
            standard_errors: normal.standard_errors(),
            quantile: t_quantile_95(freedom),
            mean_squares: squares.sums.iter().map(|s| s / squares.rows as f64).collect(),
            rows: squares.rows,
            parameters: at,
            free,
            converged,
        })
    }

    /// Sums of squared errors of each output over the rows that count.
    fn squares(&self, parameters: &[f64], until: f64) -> Result<Squares, FieldError> {
        let outputs = self.outputs.len();
        let mut sums = vec![0.0; outputs];
        let mut rows = 0;
        for (k, states) in self.predict(parameters)?.iter().enumerate() {
            let counted = self.counted(k, until);
            rows += counted;
            for error in self.errors(k, states).chunks_exact(outputs).take(counted) {
                sums.iter_mut().zip(error).for_each(|(s, e)| *s += e * e);
            }
        }
        Ok(Squares { sums, rows })
    }

    fn cost(&self, squares: &Squares) -> f64 {
        let cost: f64 =
            squares.sums.iter().zip(&self.outputs.noise).map(|(s, n)| s / (n * n)).sum();
        if cost.is_finite() { cost } else { f64::INFINITY }
    }

    fn counted(&self, experiment: usize, until: f64) -> usize {
        let rows = self.experiments[experiment].times_s.len();
        ((rows as f64 * until).ceil() as usize).clamp(1, rows)
    }

    fn normal(&self, at: &[f64], free: &[usize], until: f64) -> Result<Normal, FieldError> {
        let directions: Vec<Direction> = free.iter().map(|&k| Direction::Parameter(k)).collect();
        let method = ForwardSensitivity::new(ByDual).with_directions(directions);
        let parts: Result<Vec<Normal>, FieldError> = parallel::map(self.experiments.len(), |k| {
                let field = self.field.with_parameters::<f64>(at);
                let s = method
                    .sensitivities(&self.of(&field, k))
                    .map_err(|error| failed(&self.experiments[k], &error))?;
                if s.tangents.iter().any(|t| !t.is_finite()) {
                    let why = "the derivative of its states by a parameter is not finite; look for overflow in \
                               the field (sinh, cosh, exp of large numbers)";
                    return Err(failed(&self.experiments[k], &why));
                }
                let errors = self.errors(k, &s.states);
                Ok(self.part(&errors, &s.tangents, free.len(), self.counted(k, until)))
            })
            .into_iter()
            .collect();
        let mut sum = Normal::zeros(free.len());
        parts?.into_iter().for_each(|part| sum.add(part));
        Ok(sum)
    }

    fn part(&self, errors: &[f64], tangents: &[f64], free: usize, counted: usize) -> Normal {
        let (n, m) = (self.field.state_len(), self.outputs.len());
        let mut part = Normal::zeros(free);
        let block = counted.div_ceil(BLOCKS).max(1);
        part.blocks = vec![vec![0.0; free]; counted.div_ceil(block)];
        for row in 0..counted {
            for (c, (&state, noise)) in
                self.outputs.states.iter().zip(&self.outputs.noise).enumerate()
            {
                let weight = 1.0 / (noise * noise);
                let slope = |k: usize| tangents[(row * free + k) * n + state];
                for i in 0..free {
                    part.blocks[row / block][i] += weight * slope(i) * errors[row * m + c];
                    for j in 0..free {
                        part.gram[(i, j)] += weight * slope(i) * slope(j);
                    }
                }
            }
        }
        part
    }
}

struct Squares {
    sums: Vec<f64>,
    rows: usize,
}
