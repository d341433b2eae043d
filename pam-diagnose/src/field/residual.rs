//! What is wrong with a field, before any name.

use crate::residual::correlation_ratio;
use pam_core::ParametricField;
use pam_solvers::{ParametricInput, Side};
use pam_train::field::{FieldError, FieldProblem};
use serde::Serialize;

/// The residual of one output.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct OutputStory {
    /// Index of the state.
    pub state: usize,
    /// Root-mean-square error, in the output's unit.
    pub rmse: f64,
    /// The same in units of the noise.
    pub rmse_over_noise: f64,
    /// Mean error (predicted − measured), in the output's unit.
    pub bias: f64,
    /// Rows over which the residual is correlated: 1 + 2 Σ ρ_k up to the first ρ_k below zero.
    pub correlated_rows: f64,
    /// With what the residual goes: factor and the share of its variance (correlation ratio η²), strongest
    /// first. Factors are states, inputs, the signs of the states' derivatives, and time.
    pub goes_with: Vec<(String, f64)>,
}

/// Tells the residual of the field with `parameters`, and the largest number of correlated rows.
pub(super) fn describe<F, I>(
    problem: &FieldProblem<'_, F, I>,
    parameters: &[f64],
) -> Result<(Vec<OutputStory>, f64), FieldError>
where
    F: ParametricField + Sync,
    I: ParametricInput + Sync,
{
    let states = problem.predict(parameters)?;
    let outputs = problem.outputs.len();
    let (names, factors) = factors(problem, &states);
    let mut stories = Vec::new();
    for (c, (&state, &noise)) in
        problem.outputs.states.iter().zip(&problem.outputs.noise).enumerate()
    {
        let errors: Vec<Vec<f64>> = states
            .iter()
            .enumerate()
            .map(|(k, s)| problem.errors(k, s).into_iter().skip(c).step_by(outputs).collect())
            .collect();
        let all: Vec<f64> = errors.concat();
        let rows = all.len() as f64;
        let bias = all.iter().sum::<f64>() / rows;
        let rmse = (all.iter().map(|e| e * e).sum::<f64>() / rows).sqrt();
        let correlated_rows =
            errors.iter().map(|e| correlated_rows(e)).sum::<f64>() / errors.len() as f64;
        let mut goes_with: Vec<(String, f64)> = names
            .iter()
            .zip(&factors)
            .map(|(name, f)| (name.clone(), correlation_ratio(f, &all, correlated_rows).0))
            .collect();
        goes_with.sort_by(|a, b| b.1.total_cmp(&a.1));
        let rmse_over_noise = rmse / noise;
        stories.push(OutputStory {
            state,
            rmse,
            rmse_over_noise,
            bias,
            correlated_rows,
            goes_with,
        });
    }
    let longest = stories.iter().map(|s| s.correlated_rows).fold(1.0, f64::max);
    Ok((stories, longest))
}

fn factors<F, I>(
    problem: &FieldProblem<'_, F, I>,
    states: &[Vec<f64>],
) -> (Vec<String>, Vec<Vec<f64>>)
where
    F: ParametricField + Sync,
    I: ParametricInput + Sync,
{
    let (n, m) = (problem.field.state_len(), problem.field.input_len());
    let name = |what: &str, count: usize| (0..count).map(|i| format!("{what} {i}")).collect();
    let mut names: Vec<String> = name("state", n);
    names.extend::<Vec<String>>(name("direction of state", n));
    names.extend::<Vec<String>>(name("input", m));
    names.push("time".into());
    let mut columns = vec![Vec::new(); 2 * n + m + 1];
    let mut u = vec![0.0; m];
    for (experiment, states) in problem.experiments.iter().zip(states) {
        let rows: Vec<&[f64]> = states.chunks_exact(n).collect();
        for (k, y) in rows.iter().enumerate() {
            let (before, after) = (rows[k.saturating_sub(1)], rows[(k + 1).min(rows.len() - 1)]);
            for i in 0..n {
                columns[i].push(y[i]);
                columns[n + i].push((after[i] - before[i]).signum());
            }
            let t = experiment.times_s[k];
            experiment.input.value_into(t, Side::Right, &mut u);
            for (column, value) in columns[2 * n..].iter_mut().zip(&u) {
                column.push(*value);
            }
            columns[2 * n + m].push(t - experiment.times_s[0]);
        }
    }
    (names, columns)
}

fn correlated_rows(errors: &[f64]) -> f64 {
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
