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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn agrees_with_numpy() {
        // numpy.gradient([1, 4, 9, 16, 30], 0.5) and with coordinates [0, 1, 1.5, 3.5, 4].
        assert_eq!(gradient(&[1.0, 4.0, 9.0, 16.0, 30.0], 0.5), [6.0, 8.0, 12.0, 21.0, 28.0]);
        let g = gradient_at_times(&[1.0, 4.0, 9.0, 16.0, 30.0], &[0.0, 1.0, 1.5, 3.5, 4.0]);
        let expected = [3.0, 7.666_666_666_666_667, 8.7, 23.1, 28.0];
        for (a, b) in g.iter().zip(expected) {
            assert!((a - b).abs() < 1e-12);
        }
    }
}
