/// Derivative of uniformly sampled values: central differences inside, one-sided at the ends (the
/// rule of `numpy.gradient`). `step` is the sample distance.
#[must_use]
pub fn gradient(values: &[f64], step: f64) -> Vec<f64> {
    let n = values.len();
    if n < 2 {
        return vec![0.0; n];
    }
    (0..n)
        .map(|i| match i {
            0 => (values[1] - values[0]) / step,
            i if i == n - 1 => (values[n - 1] - values[n - 2]) / step,
            i => (values[i + 1] - values[i - 1]) / (2.0 * step),
        })
        .collect()
}

/// Derivative of values at given times: the parabola's slope inside, one-sided at the ends (the rule
/// of `numpy.gradient` with coordinates).
#[must_use]
pub fn gradient_at_times(values: &[f64], times: &[f64]) -> Vec<f64> {
    let n = values.len();
    if n < 2 {
        return vec![0.0; n];
    }
    let secant = |i: usize| (values[i + 1] - values[i]) / (times[i + 1] - times[i]);
    (0..n)
        .map(|i| {
            if i == 0 {
                secant(0)
            } else if i == n - 1 {
                secant(n - 2)
            } else {
                let (before, after) = (times[i] - times[i - 1], times[i + 1] - times[i]);
                (after * secant(i - 1) + before * secant(i)) / (before + after)
            }
        })
        .collect()
}
