use super::{Input, ParametricInput, Side};
use pam_core::{NamedChoice, Scalar};
use std::borrow::Cow;
use thiserror::Error;

/// How a sampled signal is read between its samples. There is no default: the choice changes the
/// model.
///
/// ```
/// use pam_solvers::{Input, Interpolation, SampledInput, Side};
///
/// let (time_s, force) = ([0.0, 1.0, 2.0], [0.0, 10.0, 0.0]);
/// let mut u = [0.0];
/// for (interpolation, at_half) in [(Interpolation::Hold, 0.0), (Interpolation::Linear, 5.0)] {
///     let input = SampledInput::new(&time_s, &force, interpolation)?;
///     input.value_into(0.5, Side::Right, &mut u);
///     assert_eq!(u, [at_half]);
/// }
/// # Ok::<(), pam_solvers::InputError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Interpolation {
    /// Zero-order hold: each sample's value until the next sample. Jumps at every sample, where the
    /// solver ends its steps; exact.
    Hold,
    /// Straight lines between samples.
    Linear,
    /// Straight lines between the middles of the hold intervals: a held signal made continuous. The
    /// motion it drives follows that of the hold without lag, to second order in the sample time,
    /// while steps need not end at samples. (Plain linear reading leads a held signal by half a
    /// sample.)
    Ramp,
    /// Cubic Hermite pieces with the slopes of the parabola through each sample and its neighbours;
    /// continuously differentiable.
    Cubic,
}

impl NamedChoice for Interpolation {
    const KIND: &'static str = "interpolation of the input";
    const ALL: &'static [(&'static str, Self, &'static str)] = &[
        ("zoh", Self::Hold, "zero-order hold, as in the published code"),
        (
            "linear",
            Self::Linear,
            "straight lines between samples; leads a held force by half a sample",
        ),
        (
            "ramp",
            Self::Ramp,
            "straight lines between the middles of the hold intervals; no lead, long steps",
        ),
        ("cubic", Self::Cubic, "cubic Hermite pieces"),
    ];
}

/// A sampled signal that cannot be an input.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum InputError {
    /// There are no samples, or the numbers of times and values do not fit.
    #[error("{times} sample times and {values} values do not make {variables} input variable(s)")]
    Lengths {
        /// Number of times.
        times: usize,
        /// Number of values.
        values: usize,
        /// Number of variables.
        variables: usize,
    },
    /// Sample times do not increase.
    #[error("sample times must increase: t[{index}] = {time_s} s does not exceed its predecessor")]
    NotIncreasing {
        /// Index of the offending time.
        index: usize,
        /// The offending time, s.
        time_s: f64,
    },
}

/// A signal known at sample times, such as a measured force. Before the first and after the last
/// sample it keeps the end values.
///
/// It borrows its samples ([`new`](Self::new), [`with_variables`](Self::with_variables)) or owns them
/// ([`owned`](Self::owned)), so that it can be returned from a function that reads a file.
///
/// ```
/// use pam_solvers::{Input, InputError, Interpolation, SampledInput, Side};
///
/// fn ramp() -> Result<SampledInput<'static, f64>, InputError> {
///     SampledInput::owned(vec![0.0, 1.0, 2.0], vec![0.0, 5.0, 10.0], 1, Interpolation::Linear)
/// }
/// let mut u = [0.0];
/// ramp()?.value_into(1.5, Side::Right, &mut u);
/// assert_eq!(u, [7.5]);
/// # Ok::<(), InputError>(())
/// ```
#[derive(Debug, Clone)]
pub struct SampledInput<'a, S: Clone> {
    times_s: Cow<'a, [f64]>,
    /// Sample by sample, `variables` values each.
    values: Cow<'a, [S]>,
    variables: usize,
    interpolation: Interpolation,
    /// Samples per second if the grid is uniform, for constant-time lookup.
    uniform_rate: Option<f64>,
}

impl<'a, S: Scalar> SampledInput<'a, S> {
    /// One variable with a value at each of `times_s` (s, increasing).
    ///
    /// # Errors
    /// [`InputError`] if there is no sample, the lengths differ, or times do not increase.
    pub fn new(
        times_s: &'a [f64],
        values: &'a [S],
        interpolation: Interpolation,
    ) -> Result<Self, InputError> {
        Self::with_variables(times_s, values, 1, interpolation)
    }

    /// Several variables; `values` holds `variables` numbers for each sample time.
    ///
    /// # Errors
    /// [`InputError`] if there is no sample, the lengths differ, or times do not increase.
    pub fn with_variables(
        times_s: &'a [f64],
        values: &'a [S],
        variables: usize,
        interpolation: Interpolation,
    ) -> Result<Self, InputError> {
        Self::of(Cow::Borrowed(times_s), Cow::Borrowed(values), variables, interpolation)
    }

    fn of(
        times_s: Cow<'a, [f64]>,
        values: Cow<'a, [S]>,
        variables: usize,
        interpolation: Interpolation,
    ) -> Result<Self, InputError> {
        if times_s.is_empty() || values.len() != times_s.len() * variables {
            return Err(InputError::Lengths {
                times: times_s.len(),
                values: values.len(),
                variables,
            });
        }
        if !times_s[0].is_finite() {
            return Err(InputError::NotIncreasing { index: 0, time_s: times_s[0] });
        }
        // `partial_cmp` so that a NaN counts as not increasing.
        let increasing = |w: &[f64]| {
            w[0].partial_cmp(&w[1]) == Some(std::cmp::Ordering::Less) && w[1].is_finite()
        };
        if let Some(i) = times_s.windows(2).position(|w| !increasing(w)) {
            return Err(InputError::NotIncreasing { index: i + 1, time_s: times_s[i + 1] });
        }
        let (first, last) = (times_s[0], times_s[times_s.len() - 1]);
        let step = (last - first) / (times_s.len() - 1).max(1) as f64;
        let uniform = times_s.len() > 1
            && times_s
                .iter()
                .enumerate()
                .all(|(k, t)| (t - (first + step * k as f64)).abs() < 0.01 * step);
        Ok(Self {
            uniform_rate: uniform.then(|| 1.0 / step),
            times_s,
            values,
            variables,
            interpolation,
        })
    }

    /// Index of the last sample at or before `t`; 0 before the first sample.
    #[inline]
    fn index_at(&self, t: f64) -> usize {
        let last = self.times_s.len() - 1;
        match self.uniform_rate {
            Some(rate) => {
                let guess = ((t - self.times_s[0]) * rate).max(0.0) as usize;
                let mut k = guess.min(last);
                while k < last && self.times_s[k + 1] <= t {
                    k += 1;
                }
                while k > 0 && self.times_s[k] > t {
                    k -= 1;
                }
                k
            }
            None => self.times_s.partition_point(|&s| s <= t).saturating_sub(1),
        }
    }

    #[inline]
    fn sample(&self, k: usize) -> &[S] {
        &self.values[k * self.variables..(k + 1) * self.variables]
    }

    /// Slope at sample `k` of the parabola through it and its neighbours, of the line at the ends.
    fn slope(&self, k: usize, variable: usize) -> S {
        let secant = |i: usize| {
            (self.sample(i + 1)[variable] - self.sample(i)[variable])
                .scaled(1.0 / (self.times_s[i + 1] - self.times_s[i]))
        };
        match self.secant_weights(k) {
            [(i, _), (_, 0.0)] => secant(i),
            [(i, a), (j, b)] => secant(i).scaled(a) + secant(j).scaled(b),
        }
    }

    /// The secants, by the sample they start at, and their weights in the slope at sample `k`.
    fn secant_weights(&self, k: usize) -> [(usize, f64); 2] {
        let (t, last) = (&self.times_s, self.times_s.len() - 1);
        if k == 0 {
            [(0, 1.0), (0, 0.0)]
        } else if k == last {
            [(last - 1, 1.0), (last - 1, 0.0)]
        } else {
            let (before, after) = (t[k] - t[k - 1], t[k + 1] - t[k]);
            let total = before + after;
            [(k - 1, after / total), (k, before / total)]
        }
    }

    /// Where a ramp is at `t`: between the middles of two hold intervals, by their samples, and how far.
    /// The last sample is held as long as the one before it.
    #[inline]
    fn ramp(&self, t: f64) -> (usize, usize, f64) {
        let (times, last) = (&self.times_s, self.times_s.len() - 1);
        let middle = |k: usize| {
            let length = if k < last { times[k + 1] - times[k] } else { times[k] - times[k - 1] };
            times[k] + 0.5 * length
        };
        if last == 0 {
            return (0, 0, 0.0);
        }
        let k = self.index_at(t);
        let here = middle(k);
        let (from, to) = if t >= here { (k, (k + 1).min(last)) } else { (k.max(1) - 1, k) };
        if from == to {
            return (k, k, 0.0);
        }
        let start = middle(from);
        (from, to, (t - start) / (middle(to) - start))
    }

    /// Calls `visit(k, weight)` for the samples that make `u(t)`, `u = Σ weight · sample_k`; a sample
    /// may come more than once.
    fn each_weight(&self, t: f64, side: Side, mut visit: impl FnMut(usize, f64)) {
        let k = self.index_at(t);
        let last = self.times_s.len() - 1;
        if self.interpolation == Interpolation::Hold {
            let before_jump = side == Side::Left && k > 0 && self.times_s[k] == t;
            return visit(if before_jump { k - 1 } else { k }, 1.0);
        }
        if self.interpolation == Interpolation::Ramp {
            let (from, to, theta) = self.ramp(t);
            visit(from, 1.0 - theta);
            return visit(to, theta);
        }
        if k == last || t <= self.times_s[0] {
            return visit(k, 1.0);
        }
        let h = self.times_s[k + 1] - self.times_s[k];
        let theta = (t - self.times_s[k]) / h;
        if self.interpolation == Interpolation::Linear {
            visit(k, 1.0 - theta);
            return visit(k + 1, theta);
        }
        let s2 = theta * theta * (3.0 - 2.0 * theta);
        let rise = h * theta * (1.0 - theta);
        visit(k, 1.0 - s2);
        visit(k + 1, s2);
        for (at, factor) in [(k, rise * (1.0 - theta)), (k + 1, -rise * theta)] {
            for (i, weight) in self.secant_weights(at) {
                let weight = factor * weight / (self.times_s[i + 1] - self.times_s[i]);
                visit(i, -weight);
                visit(i + 1, weight);
            }
        }
    }
}

impl<S: Scalar> SampledInput<'static, S> {
    /// A signal that owns its samples; `values` holds `variables` numbers for each of `times_s` (s, increasing).
    ///
    /// # Errors
    /// [`InputError`] if there is no sample, the lengths do not fit, or times do not increase.
    pub fn owned(
        times_s: Vec<f64>,
        values: Vec<S>,
        variables: usize,
        interpolation: Interpolation,
    ) -> Result<Self, InputError> {
        Self::of(Cow::Owned(times_s), Cow::Owned(values), variables, interpolation)
    }

    /// The same samples, read otherwise.
    #[must_use]
    pub fn read_by(self, interpolation: Interpolation) -> Self {
        Self { interpolation, ..self }
    }
}

/// Parameters: the sample values, sample by sample. The input is linear in them.
impl<'a> ParametricInput for SampledInput<'a, f64> {
    type With<S: Scalar> = SampledInput<'a, S>;

    fn parameters(&self) -> Vec<f64> {
        self.values.to_vec()
    }

    fn parameter_len(&self) -> usize {
        self.values.len()
    }

    fn with_parameters<S: Scalar>(&self, parameters: &[S]) -> SampledInput<'a, S> {
        assert_eq!(parameters.len(), self.values.len(), "one number for each parameter");
        SampledInput {
            times_s: self.times_s.clone(),
            values: Cow::Owned(parameters.to_vec()),
            variables: self.variables,
            interpolation: self.interpolation,
            uniform_rate: self.uniform_rate,
        }
    }

    fn vjp_into(&self, t: f64, side: Side, u_cotangent: &[f64], p_sum: &mut [f64]) {
        self.each_weight(t, side, |k, weight| {
            let sums = &mut p_sum[k * self.variables..(k + 1) * self.variables];
            for (sum, u) in sums.iter_mut().zip(u_cotangent) {
                *sum += weight * u;
            }
        });
    }

    fn jvp_into(&self, t: f64, side: Side, p_tangent: &[f64], u_tangent: &mut [f64]) {
        u_tangent.fill(0.0);
        self.each_weight(t, side, |k, weight| {
            let tangents = &p_tangent[k * self.variables..(k + 1) * self.variables];
            for (u, p) in u_tangent.iter_mut().zip(tangents) {
                *u += weight * p;
            }
        });
    }
}

impl<S: Scalar> Input<S> for SampledInput<'_, S> {
    fn input_len(&self) -> usize {
        self.variables
    }

    #[inline]
    fn value_into(&self, t: f64, side: Side, out: &mut [S]) {
        if self.interpolation == Interpolation::Ramp {
            let (from, to, theta) = self.ramp(t);
            for ((o, &a), &b) in out.iter_mut().zip(self.sample(from)).zip(self.sample(to)) {
                *o = a + (b - a).scaled(theta);
            }
            return;
        }
        let k = self.index_at(t);
        let last = self.times_s.len() - 1;
        if self.interpolation == Interpolation::Hold {
            let before_jump = side == Side::Left && k > 0 && self.times_s[k] == t;
            out.copy_from_slice(self.sample(if before_jump { k - 1 } else { k }));
            return;
        }
        if k == last || t <= self.times_s[0] {
            out.copy_from_slice(self.sample(k));
            return;
        }
        let h = self.times_s[k + 1] - self.times_s[k];
        let theta = (t - self.times_s[k]) / h;
        for (i, o) in out.iter_mut().enumerate() {
            let (a, b) = (self.sample(k)[i], self.sample(k + 1)[i]);
            *o = match self.interpolation {
                Interpolation::Cubic => {
                    let s2 = theta * theta * (3.0 - 2.0 * theta);
                    let rise = h * theta * (1.0 - theta);
                    a + (b - a).scaled(s2) + self.slope(k, i).scaled(rise * (1.0 - theta))
                        - self.slope(k + 1, i).scaled(rise * theta)
                }
                _ => a + (b - a).scaled(theta),
            };
        }
    }

    fn next_jump(&self, t: f64) -> Option<f64> {
        if self.interpolation != Interpolation::Hold {
            return None;
        }
        let k = self.index_at(t);
        // Before the first sample the end value holds already, so that sample is no jump.
        let next = if t < self.times_s[0] { 1 } else { k + 1 };
        self.times_s.get(next).copied()
    }
}
