//! A few numbers of a field by Levenberg–Marquardt.

use super::normal::{Normal, Unknowns};
use super::problem::{FieldError, FieldProblem, HeldOutError};
use super::simulate::{Number, Numbers};
use pam_core::ParametricField;
use pam_core::parallel;
use pam_numerics::statistics::t_quantile_95;
use pam_solvers::Input;

/// Settings of a fit.
///
/// ```
/// use pam_train::field::LeastSquares;
///
/// // Only parameters 0 and 2, the first of them positive; a delay of the inputs is fitted along.
/// let settings = LeastSquares {
///     free: Some(vec![0, 2]),
///     logarithmic: vec![0],
///     delay_deviation_s: 0.01,
///     ..LeastSquares::default()
/// };
/// assert_eq!(settings.iterations, None);
/// ```
///
/// [`FieldProblem`] has an example of a whole fit.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct LeastSquares {
    /// Parameters (by index) that are fitted; all, if absent.
    pub free: Option<Vec<usize>>,
    /// The parameters to start from; those of the field, if absent.
    pub start: Option<Vec<f64>>,
    /// Possible values of each parameter of the field; any value, if absent.
    pub ranges: Option<Vec<[f64; 2]>>,
    /// Parameters (by index) that are positive and fitted by their logarithm: masses, times, stiffnesses. They stay
    /// positive, and their intervals are symmetric in the logarithm.
    pub logarithmic: Vec<usize>,
    /// Prior standard deviation of each initial state, which is fitted for each experiment then; zero for one that is known.
    /// If absent, all are known.
    pub initial_state_deviation: Option<Vec<f64>>,
    /// Prior standard deviation of a delay of the inputs that all experiments share, s; zero for none.
    pub delay_deviation_s: f64,
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
    /// Indices of those that were fitted by their logarithm.
    pub logarithmic: Vec<usize>,
    /// Their standard errors, of the logarithm for logarithmic ones; the covariance is clustered by blocks of a tenth
    /// of an experiment, since the residuals of a model that is not quite right are correlated.
    pub standard_errors: Vec<f64>,
    /// Half the width of their 95 % intervals over the standard error: the quantile of Student's t.
    pub quantile: f64,
    /// The delay of the inputs and its standard error, s, if it was fitted.
    pub delay_s: Option<[f64; 2]>,
    /// The initial state of each experiment, fitted where it is not known.
    pub initial_states: Vec<Vec<f64>>,
    /// Mean squared error of each output on the fitted rows, in its squared unit.
    pub mean_squares: Vec<f64>,
    /// Standard deviation of the noise of each output by which errors were weighed: as given, or learned from what the
    /// fit leaves.
    pub noise: Vec<f64>,
    /// Errors on the held-out experiments.
    pub held_out: Vec<HeldOutError>,
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
        let value = self.parameters[index];
        Some(if self.logarithmic.contains(&index) {
            [value * (-half).exp(), value * half.exp()]
        } else {
            [value - half, value + half]
        })
    }
}

/// Change of the cost (in units of the squared noise) below which a fit has arrived.
const ARRIVED: f64 = 1e-3;
/// Largest change of a logarithm in one step: a factor of three.
const LARGEST_LOG_STEP: f64 = 1.1;
/// Fits with a noise that is learned anew beside the last one, at most.
const NOISE_ROUNDS: usize = 10;
/// Relative change of the noise below which it has been learned.
const NOISE_LEARNED: f64 = 0.02;

/// Where a fit is.
#[derive(Clone)]
struct At {
    parameters: Vec<f64>,
    delay_s: f64,
    /// Deviations of the free initial states of each experiment from the given ones.
    starts: Vec<Vec<f64>>,
}

/// One fit in progress.
struct Fitting<'f, 'p, F, I> {
    problem: &'f FieldProblem<'p, F, I>,
    unknowns: Unknowns,
    free: Vec<usize>,
    logarithmic: Vec<usize>,
    ranges: Vec<[f64; 2]>,
    free_states: Vec<usize>,
    with_delay: bool,
    noise: Vec<f64>,
    until: f64,
}

impl<F, I> FieldProblem<'_, F, I>
where
    F: ParametricField + Sync,
    I: Input<f64> + Sync,
{
    /// Fits parameters, and where asked for initial states and a delay of the inputs, to the weighted squared error
    /// `Σ ((predicted − measured) / noise)² + Σ (deviation / prior deviation)²` by Levenberg–Marquardt with the
    /// exact sensitivities of the steps taken. A noise that is not known (NaN) is learned: the root mean square of what
    /// the fit leaves of its output, over a few fits.
    ///
    /// # Errors
    /// [`FieldError`] if shapes do not fit, or the field cannot be solved where it starts.
    pub fn least_squares(&self, settings: &LeastSquares) -> Result<FieldFit, FieldError> {
        self.check()?;
        let (mut fitting, mut at) = Fitting::new(self, settings)?;
        let iterations = settings.iterations.unwrap_or(30);
        let unknown: Vec<bool> = self.outputs.noise.iter().map(|n| n.is_nan()).collect();
        let mut converged = false;
        for round in 0..NOISE_ROUNDS {
            let changed = fitting.learn_noise(&unknown, &at)?;
            if round > 0 && !changed {
                break;
            }
            converged = fitting.fit(&mut at, iterations)?;
        }
        fitting.finished(at, converged)
    }
}

impl<'f, 'p, F, I> Fitting<'f, 'p, F, I>
where
    F: ParametricField + Sync,
    I: Input<f64> + Sync,
{
    fn new(
        problem: &'f FieldProblem<'p, F, I>,
        settings: &LeastSquares,
    ) -> Result<(Self, At), FieldError> {
        let start = settings.start.clone().unwrap_or_else(|| problem.field.parameters());
        let (len, states) = (start.len(), problem.field.state_len());
        let free = settings.free.clone().unwrap_or_else(|| (0..len).collect());
        let ranges = settings
            .ranges
            .clone()
            .unwrap_or_else(|| vec![[f64::NEG_INFINITY, f64::INFINITY]; len]);
        let logarithmic = settings.logarithmic.clone();
        let fail = |message: String| Err(FieldError::Shape(message));
        if len != problem.field.parameter_len()
            || ranges.len() != len
            || free.iter().chain(&logarithmic).any(|&k| k >= len)
        {
            return fail(format!(
                "{len} starting values, {} ranges, free parameters {free:?} and logarithmic ones {logarithmic:?} do \
                 not fit a field of {} parameters",
                ranges.len(),
                problem.field.parameter_len()
            ));
        }
        let names = problem.field.names();
        if let Some(&k) = logarithmic
            .iter()
            .find(|&&k| start[k].partial_cmp(&0.0) != Some(std::cmp::Ordering::Greater))
        {
            return fail(format!(
                "`{}` starts at {} and cannot be fitted by its logarithm; start above zero",
                names.parameter(k),
                start[k]
            ));
        }
        let deviations = settings.initial_state_deviation.clone();
        let deviations = deviations.unwrap_or_else(|| vec![0.0; states]);
        let delay = settings.delay_deviation_s;
        let valid = |d: &f64| d.is_finite() && *d >= 0.0;
        if deviations.len() != states || !deviations.iter().chain([&delay]).all(valid) {
            return fail(format!(
                "the prior standard deviations {deviations:?} of {states} initial states and {delay} s of the delay \
                 must be finite and at least 0"
            ));
        }
        let free_states: Vec<usize> = (0..states).filter(|&s| deviations[s] > 0.0).collect();
        let precision = |deviation: f64| deviation.powi(-2);
        let with_delay = delay > 0.0;
        let mut common = vec![0.0; free.len()];
        common.extend(with_delay.then(|| precision(delay)));
        let unknowns = Unknowns {
            common,
            own: free_states.iter().map(|&s| precision(deviations[s])).collect(),
            experiments: problem.experiments.len(),
        };
        let at = At {
            parameters: start,
            delay_s: 0.0,
            starts: vec![vec![0.0; free_states.len()]; problem.experiments.len()],
        };
        let until = settings.until.unwrap_or(1.0);
        let noise = problem.outputs.units();
        let fitting = Self {
            problem,
            unknowns,
            free,
            logarithmic,
            ranges,
            free_states,
            with_delay,
            noise,
            until,
        };
        Ok((fitting, at))
    }

    /// Takes what the fit leaves for the noise of outputs where that is not known; whether it has changed.
    fn learn_noise(&mut self, unknown: &[bool], at: &At) -> Result<bool, FieldError> {
        if !unknown.contains(&true) {
            return Ok(false);
        }
        let mean = self.squares(at)?.mean();
        let mut changed = false;
        for ((noise, mean), unknown) in self.noise.iter_mut().zip(mean).zip(unknown) {
            if *unknown {
                let learned = mean.sqrt().max(f64::MIN_POSITIVE.sqrt());
                changed |= (learned / *noise - 1.0).abs() > NOISE_LEARNED;
                *noise = learned;
            }
        }
        Ok(changed)
    }

    /// Moves to the best fit; whether it arrived.
    fn fit(&self, at: &mut At, iterations: usize) -> Result<bool, FieldError> {
        let mut cost = self.cost(at)?;
        let mut damping = 1e-3;
        for _ in 0..iterations {
            let normal = self.normal(at)?;
            let right = [normal.right()];
            let mut gained = 0.0;
            for _ in 0..6 {
                if let Some(steps) = normal.solve(damping, &right) {
                    let next = self.moved(at, &steps[0]);
                    if let Ok(c) = self.cost(&next)
                        && c < cost
                    {
                        gained = cost - c;
                        (*at, cost) = (next, c);
                        damping = (damping * 0.2).max(1e-10);
                        break;
                    }
                }
                damping *= 8.0;
            }
            if gained < ARRIVED {
                return Ok(true);
            }
        }
        Ok(false)
    }

    /// The place after a step back along `step`.
    fn moved(&self, at: &At, step: &[f64]) -> At {
        let mut next = at.clone();
        let (common, own) = step.split_at(self.unknowns.common.len());
        for (&k, step) in self.free.iter().zip(common) {
            let moved = if self.logarithmic.contains(&k) {
                at.parameters[k] * (-step.clamp(-LARGEST_LOG_STEP, LARGEST_LOG_STEP)).exp()
            } else {
                at.parameters[k] - step
            };
            next.parameters[k] = moved.clamp(self.ranges[k][0], self.ranges[k][1]);
        }
        if self.with_delay {
            next.delay_s -= common[self.free.len()];
        }
        let each = own.chunks_exact(self.free_states.len().max(1));
        for (starts, steps) in next.starts.iter_mut().zip(each) {
            starts.iter_mut().zip(steps).for_each(|(s, step)| *s -= step);
        }
        next
    }

    /// The numbers of an experiment.
    fn numbers(&self, at: &At, experiment: usize) -> Numbers<f64> {
        let mut y0 = self.problem.initial_state(&self.problem.experiments[experiment]);
        let starts = &at.starts[experiment];
        self.free_states.iter().zip(starts).for_each(|(&s, d)| y0[s] += d);
        Numbers { parameters: at.parameters.clone(), initial_state: y0, delay_s: at.delay_s }
    }

    /// Rows of an experiment that count.
    fn counted(&self, experiment: usize) -> usize {
        let rows = self.problem.experiments[experiment].times_s.len();
        ((rows as f64 * self.until).ceil() as usize).clamp(1, rows)
    }

    /// Sums of squared errors of each output over the rows that count.
    fn squares(&self, at: &At) -> Result<Squares, FieldError> {
        let problem = self.problem;
        let outputs = problem.outputs.len();
        let each: Result<Vec<Vec<f64>>, FieldError> =
            parallel::map(problem.experiments.len(), |k| {
                let e = &problem.experiments[k];
                let signals = problem.simulate(e, &self.numbers(at, k))?;
                let mut sums = vec![0.0; outputs];
                let errors = problem.errors(e, &signals);
                for error in errors.chunks_exact(outputs).take(self.counted(k)) {
                    sums.iter_mut().zip(error).for_each(|(s, e)| *s += e * e);
                }
                Ok(sums)
            })
            .into_iter()
            .collect();
        let mut all = Squares { sums: vec![0.0; outputs], rows: 0 };
        for (k, sums) in each?.into_iter().enumerate() {
            all.sums.iter_mut().zip(sums).for_each(|(all, own)| *all += own);
            all.rows += self.counted(k);
        }
        Ok(all)
    }

    fn cost(&self, at: &At) -> Result<f64, FieldError> {
        let squares = self.squares(at)?;
        let data: f64 = squares.sums.iter().zip(&self.noise).map(|(s, n)| s / (n * n)).sum();
        let cost = data + self.unknowns.prior_cost(&self.deviations(at));
        Ok(if cost.is_finite() { cost } else { f64::INFINITY })
    }

    /// Deviations of all unknowns from their prior means; zero for parameters, which have no prior.
    fn deviations(&self, at: &At) -> Vec<f64> {
        let mut all = vec![0.0; self.free.len()];
        all.extend(self.with_delay.then_some(at.delay_s));
        all.extend(at.starts.iter().flatten());
        all
    }

    fn normal(&self, at: &At) -> Result<Normal, FieldError> {
        let problem = self.problem;
        let mut by: Vec<Number> = self.free.iter().map(|&k| Number::Parameter(k)).collect();
        by.extend(self.with_delay.then_some(Number::Delay));
        by.extend(self.free_states.iter().map(|&s| Number::InitialState(s)));
        let scales: Vec<f64> = by
            .iter()
            .map(|n| match n {
                Number::Parameter(k) if self.logarithmic.contains(k) => at.parameters[*k],
                _ => 1.0,
            })
            .collect();
        let parts: Result<Vec<_>, FieldError> = parallel::map(problem.experiments.len(), |k| {
            let e = &problem.experiments[k];
            let found = problem.sensitivities(e, &self.numbers(at, k), &by)?;
            let errors = problem.errors(e, &found.signals);
            Ok((errors, found.by))
        })
        .into_iter()
        .collect();
        let mut normal = Normal::new(&self.unknowns, &self.deviations(at));
        let (width, outputs) = (problem.signal_len(), &problem.outputs.signals);
        for (k, (errors, columns)) in parts?.iter().enumerate() {
            let slope =
                |row: usize, c: usize, i: usize| scales[i] * columns[i][row * width + outputs[c]];
            normal.add(&self.unknowns, k, self.counted(k), &self.noise, errors, slope);
        }
        Ok(normal)
    }

    fn finished(self, at: At, converged: bool) -> Result<FieldFit, FieldError> {
        let normal = self.normal(&at)?;
        let squares = self.squares(&at)?;
        let freedom = (normal.blocks.len() as f64 - 1.0 - self.free.len() as f64).max(1.0);
        let mut standard_errors = normal.standard_errors(&self.unknowns);
        standard_errors.truncate(self.unknowns.common.len());
        let delay_s =
            self.with_delay.then(|| [at.delay_s, standard_errors.pop().unwrap_or(f64::INFINITY)]);
        let experiments = 0..self.problem.experiments.len();
        Ok(FieldFit {
            standard_errors,
            quantile: t_quantile_95(freedom),
            delay_s,
            initial_states: experiments.map(|k| self.numbers(&at, k).initial_state).collect(),
            mean_squares: squares.mean(),
            held_out: self.problem.held_out_errors(&at.parameters, at.delay_s)?,
            rows: squares.rows,
            noise: self.noise,
            parameters: at.parameters,
            logarithmic: self.logarithmic,
            free: self.free,
            converged,
        })
    }
}

struct Squares {
    sums: Vec<f64>,
    rows: usize,
}

impl Squares {
    fn mean(&self) -> Vec<f64> {
        self.sums.iter().map(|s| s / self.rows.max(1) as f64).collect()
    }
}
