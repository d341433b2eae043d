//! Features of states and inputs, for the flexible model, and the correlation length of a residual.

/// Powers, directions, inputs and products of states and inputs, each by itself and growing with time.
pub(super) fn features(states: &[Vec<f64>], inputs: &[Vec<f64>]) -> Vec<Vec<f64>> {
    let rows = states.first().map_or(0, Vec::len);
    let scaled = |series: &Vec<f64>| -> Vec<f64> {
        let size = pam_numerics::statistics::root_mean_square(series).max(1e-12);
        series.iter().map(|v| v / size).collect()
    };
    let states: Vec<Vec<f64>> = states.iter().map(scaled).collect();
    let inputs: Vec<Vec<f64>> = inputs.iter().map(scaled).collect();
    let map = |y: &[f64], f: fn(f64) -> f64| y.iter().map(|&v| f(v)).collect::<Vec<f64>>();
    let product = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).collect::<Vec<f64>>();
    let mut all = vec![vec![1.0; rows]];
    for (i, y) in states.iter().enumerate() {
        all.extend([y.clone(), map(y, |v| v.powi(3)), map(y, |v| (20.0 * v).tanh())]);
        all.push(map(y, |v| v * v.abs()));
        all.extend(states[i..].iter().chain(&inputs).map(|other| product(y, other)));
    }
    for u in &inputs {
        all.extend([u.clone(), map(u, |v| v.powi(3))]);
    }
    let time: Vec<f64> = (0..rows).map(|k| k as f64 / rows as f64).collect();
    let growing: Vec<Vec<f64>> = all.iter().map(|f| product(f, &time)).collect();
    all.extend(growing);
    all
}

/// Rows over which a residual is correlated, `1 + 2 Σ ρ_k` up to the first `ρ_k` below zero (Sokal 1997), at most a
/// tenth of the rows.
pub(super) fn correlated_rows(errors: &[f64]) -> f64 {
    let n = errors.len();
    let mean = errors.iter().sum::<f64>() / n as f64;
    let at_lag = |k: usize| -> f64 {
        errors.iter().zip(&errors[k..]).map(|(a, b)| (a - mean) * (b - mean)).sum()
    };
    let variance = at_lag(0);
    if variance <= 0.0 {
        return 1.0;
    }
    let sum: f64 = (1..n / 4).map(|k| at_lag(k) / variance).take_while(|r| *r > 0.0).sum();
    (1.0 + 2.0 * sum).min(n as f64 / 10.0).max(1.0)
}

#[cfg(test)]
mod tests {
    use super::correlated_rows;

    /// White noise is independent. The correlation of a rectangular wave of half period 20 falls linearly to
    /// zero at lag 10: 1 + 2 Σ (1 − k/10) = 10.
    #[test]
    fn correlation_is_counted_in_rows() {
        let mut x = 1u32;
        let white: Vec<f64> = (0..4000)
            .map(|_| {
                x = x.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                f64::from(x >> 8) / f64::from(1 << 24) - 0.5
            })
            .collect();
        assert!(correlated_rows(&white) < 1.2);
        let wave: Vec<f64> = (0..4000).map(|k| if k / 20 % 2 == 0 { 1.0 } else { -1.0 }).collect();
        assert!((correlated_rows(&wave) - 10.0).abs() < 0.5, "{}", correlated_rows(&wave));
    }
}
