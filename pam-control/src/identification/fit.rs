use super::response::{Response, simulate};
use crate::error::ControlError;
use pam_autodiff::Chunk;
use pam_numerics::statistics::{root_mean_square, t_quantile_95};
use serde::Serialize;

/// Stiffnesses of the coarse grid, N/mm.
const STIFFNESSES: [f64; 10] = [20.0, 40.0, 60.0, 80.0, 100.0, 125.0, 150.0, 180.0, 230.0, 350.0];
/// Dampings of the coarse grid, kg/s.
const DAMPINGS: [f64; 7] = [300.0, 1000.0, 2500.0, 5000.0, 8000.0, 13e3, 25e3];

/// Stiffness and damping with their uncertainty.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Estimate {
    /// K, N/mm.
    pub stiffness_n_mm: f64,
    /// B, kg/s.
    pub damping_kg_s: f64,
    /// Interval that holds K with 95 % confidence, N/mm.
    pub stiffness_interval_n_mm: [f64; 2],
    /// Interval that holds B with 95 % confidence, kg/s.
    pub damping_interval_kg_s: [f64; 2],
    /// Root mean square of the residuals, mm.
    pub rmse_mm: f64,
    /// Largest displacement from the start, mm.
    pub peak_mm: f64,
}

/// Parameters in units of about their size: K in 100 N/mm, B in 5000 kg/s.
const UNITS: [f64; 2] = [100.0, 5000.0];

fn cost(response: &Response, p: [f64; 2]) -> f64 {
    let x = simulate(response, UNITS[0] * p[0], UNITS[1] * p[1]);
    let sum: f64 = x.iter().zip(&response.displacement_mm).map(|(a, b)| (a - b).powi(2)).sum();
    if sum.is_finite() { sum } else { f64::INFINITY }
}

/// Residuals and their slopes along both parameters.
fn linearised(response: &Response, p: [f64; 2]) -> (Vec<f64>, Vec<[f64; 2]>) {
    let k = Chunk::<2>::new(UNITS[0] * p[0], [UNITS[0], 0.0]);
    let b = Chunk::<2>::new(UNITS[1] * p[1], [0.0, UNITS[1]]);
    let x = simulate(response, k, b);
    let residual = |(x, m): (&Chunk<2>, &f64)| x.value - m;
    (
        x.iter().zip(&response.displacement_mm).map(residual).collect(),
        x.iter().map(|x| x.derivatives).collect(),
    )
}

/// Polls of the pattern search. From the grid of starting values it takes some tens; values that are none of a joint's could
/// lead it away without end.
const MOST_POLLS: usize = 400;

/// Poll of the four neighbours at a step that halves: the pattern search of Hooke and Jeeves (1961).
fn pattern_search(response: &Response, mut best: [f64; 2]) -> [f64; 2] {
    let mut value = cost(response, best);
    let mut step = 0.2;
    for _ in 0..MOST_POLLS {
        if step <= 1e-3 {
            break;
        }
        let tries = [[step, 0.0], [-step, 0.0], [0.0, step], [0.0, -step]].map(|d| {
            let p = [best[0] + d[0], (best[1] + d[1]).max(0.0)];
            (cost(response, p), p)
        });
        let (found, p) =
            tries.into_iter().fold((f64::INFINITY, best), |a, b| if b.0 < a.0 { b } else { a });
        if found < value {
            (value, best) = (found, p);
        } else {
            step *= 0.5;
        }
    }
    best
}

type Normal = ([[f64; 2]; 2], [f64; 2]);

fn normal_equations(residuals: &[f64], slopes: &[[f64; 2]]) -> Normal {
    let mut normal = ([[0.0; 2]; 2], [0.0; 2]);
    for (r, s) in residuals.iter().zip(slopes) {
        for i in 0..2 {
            normal.1[i] += s[i] * r;
            for j in 0..2 {
                normal.0[i][j] += s[i] * s[j];
            }
        }
    }
    normal
}

fn inverse([[a, b], [c, d]]: [[f64; 2]; 2]) -> [[f64; 2]; 2] {
    let determinant = a * d - b * c;
    [[d / determinant, -b / determinant], [-c / determinant, a / determinant]]
}

fn levenberg_marquardt(response: &Response, mut p: [f64; 2]) -> [f64; 2] {
    let mut damping = 1e-4;
    let mut value = cost(response, p);
    for _ in 0..60 {
        let (residuals, slopes) = linearised(response, p);
        let (mut matrix, gradient) = normal_equations(&residuals, &slopes);
        (0..2).for_each(|i| matrix[i][i] *= 1.0 + damping);
        let m = inverse(matrix);
        let step = [0, 1].map(|i| -(m[i][0] * gradient[0] + m[i][1] * gradient[1]));
        let tried = [p[0] + step[0], (p[1] + step[1]).max(0.0)];
        let found = cost(response, tried);
        if found < value {
            let small = step.iter().all(|s| s.abs() < 1e-11);
            (p, value) = (tried, found);
            damping = (damping * 0.1).max(1e-12);
            if small {
                break;
            }
        } else {
            damping *= 10.0;
            if damping > 1e8 {
                break;
            }
        }
    }
    p
}

/// Covariance of the parameters: `(JᵀJ)⁻¹ S (JᵀJ)⁻¹` with the residuals' products summed over lags up to
/// `lags` under falling weights.
fn covariance(residuals: &[f64], slopes: &[[f64; 2]], lags: usize) -> [[f64; 2]; 2] {
    let bread = inverse(normal_equations(residuals, slopes).0);
    let score = |k: usize| slopes[k].map(|s| s * residuals[k]);
    let mut meat = [[0.0; 2]; 2];
    for lag in 0..=lags {
        let weight = 1.0 - lag as f64 / (lags as f64 + 1.0);
        let weight = if lag == 0 { 0.5 } else { weight };
        for k in lag..residuals.len() {
            let (a, b) = (score(k), score(k - lag));
            for i in 0..2 {
                for j in 0..2 {
                    meat[i][j] += weight * (a[i] * b[j] + a[j] * b[i]);
                }
            }
        }
    }
    let product = |a: [[f64; 2]; 2], b: [[f64; 2]; 2]| {
        [0, 1].map(|i| [0, 1].map(|j| a[i][0] * b[0][j] + a[i][1] * b[1][j]))
    };
    product(product(bread, meat), bread)
}

/// Stiffness and damping of a response.
///
/// # Errors
/// [`ControlError::Insufficient`] if there are fewer than ten samples, no force, or numbers that are not
/// finite.
pub fn identify(response: &Response) -> Result<Estimate, ControlError> {
    let n = response.displacement_mm.len();
    if n < 10 || response.force_n.len() != n {
        return Err(ControlError::Insufficient(format!(
            "a response of {n} displacements and {} forces: at least ten of each are needed",
            response.force_n.len()
        )));
    }
    ControlError::require_positive("mass (kg)", response.mass_kg)?;
    ControlError::require_positive("time between samples (s)", response.sample_s)?;
    if response.displacement_mm.iter().chain(&response.force_n).any(|v| !v.is_finite()) {
        return Err(ControlError::Insufficient("a displacement or force is not finite".into()));
    }
    if response.force_n.iter().all(|f| *f == 0.0) {
        return Err(ControlError::Insufficient("no force acts in the response".into()));
    }
    let grid = STIFFNESSES.iter().flat_map(|k| DAMPINGS.map(|b| [k / UNITS[0], b / UNITS[1]]));
    let start = grid
        .map(|p| (cost(response, p), p))
        .fold((f64::INFINITY, [1.5, 1.0]), |a, b| if b.0 < a.0 { b } else { a });
    let p = levenberg_marquardt(response, pattern_search(response, start.1));
    let (residuals, slopes) = linearised(response, p);
    let c = covariance(&residuals, &slopes, n / 15);
    let t = t_quantile_95((n - 2) as f64);
    let interval = |i: usize| {
        let half = t * c[i][i].max(0.0).sqrt() * UNITS[i];
        [UNITS[i] * p[i] - half, UNITS[i] * p[i] + half]
    };
    let from = response.displacement_mm[0];
    Ok(Estimate {
        stiffness_n_mm: UNITS[0] * p[0],
        damping_kg_s: UNITS[1] * p[1],
        stiffness_interval_n_mm: interval(0),
        damping_interval_kg_s: interval(1),
        rmse_mm: root_mean_square(&residuals),
        peak_mm: response.displacement_mm.iter().fold(0.0, |m, x| m.max((x - from).abs())),
    })
}
