//! Decay of predictions without input.

use super::KoopmanModel;
use pam_numerics::eigenvalues;
use serde::Serialize;

/// One mode of a linear map from sample to sample.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Mode {
    /// Size of the eigenvalue; growing modes are above one.
    pub magnitude: f64,
    /// Time in which the mode falls by e, s; negative for a growing one. Unknown without a sampling time.
    pub time_constant_s: Option<f64>,
    /// Frequency, Hz.
    pub frequency_hz: Option<f64>,
}

/// Modes that grow by less than this a step count as constant.
const GROWTH: f64 = 1e-6;

/// Eigenvalues of the maps that predictions follow.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub struct Stability {
    /// Modes of the re-lifted map linearised where it is least stable among the starts of the training
    /// recordings, largest first.
    pub relifted: Vec<Mode>,
    /// Spectral radius of that map over the starts: smallest and largest.
    pub relifted_radius: [f64; 2],
    /// Spectral radius of the lifted map A without its input, if it was fitted.
    pub lifted_radius: Option<f64>,
    /// Number of modes of A that grow.
    pub lifted_growing: Option<usize>,
}

impl Stability {
    /// The stability of a model around these states.
    #[must_use]
    pub fn of(model: &KoopmanModel, states: &[[f64; 4]]) -> Self {
        let mut modes: Vec<Vec<Mode>> =
            states.iter().map(|s| modes_of(4, &jacobian(model, s), model.step_s)).collect();
        modes.sort_by(|a, b| b[0].magnitude.total_cmp(&a[0].magnitude));
        let radius = |m: Option<&Vec<Mode>>| m.map_or(f64::NAN, |m| m[0].magnitude);
        let lifted = model.lifted_map.as_ref().map(|map| {
            let n = model.dictionary.len();
            let square: Vec<f64> =
                map.chunks_exact(n + 1).flat_map(|row| row[..n].iter().copied()).collect();
            modes_of(n, &square, model.step_s)
        });
        // The constant maps to itself up to the ridge: its mode is one and does not grow.
        let grows = |m: &&Mode| m.magnitude > 1.0 + GROWTH;
        Self {
            relifted_radius: [radius(modes.last()), radius(modes.first())],
            relifted: modes.into_iter().next().unwrap_or_default(),
            lifted_radius: lifted.as_ref().map(|m| m[0].magnitude),
            lifted_growing: lifted.as_ref().map(|m| m.iter().filter(grows).count()),
        }
    }
}

/// Jacobian of the standardised re-lifted map at a state, by central differences of polynomials of low
/// degree, whose error is of the order of the step squared.
fn jacobian(model: &KoopmanModel, state: &[f64; 4]) -> Vec<f64> {
    let h = 1e-4;
    let at = model.state.apply(state);
    let mut lifted = vec![0.0; model.dictionary.len()];
    let mut by = vec![0.0; 16];
    for j in 0..4 {
        let mut shifted = |by: f64| {
            let mut x = at;
            x[j] += by;
            model.step_standardised(&x, 0.0, &mut lifted)
        };
        let (up, down) = (shifted(h), shifted(-h));
        for i in 0..4 {
            by[i * 4 + j] = (up[i] - down[i]) / (2.0 * h);
        }
    }
    by
}

/// Modes of a square matrix, row by row, largest first; one that is not a number if it has none.
fn modes_of(n: usize, matrix: &[f64], step_s: Option<f64>) -> Vec<Mode> {
    let Some(values) = eigenvalues(n, matrix) else {
        return vec![Mode { magnitude: f64::NAN, time_constant_s: None, frequency_hz: None }];
    };
    let mut modes: Vec<Mode> = values
        .iter()
        .map(|[re, im]| {
            let magnitude = re.hypot(*im);
            Mode {
                magnitude,
                time_constant_s: step_s.map(|h| -h / magnitude.ln()).filter(|t| t.is_finite()),
                frequency_hz: step_s.map(|h| im.atan2(*re).abs() / (std::f64::consts::TAU * h)),
            }
        })
        .collect();
    modes.sort_by(|a, b| b.magnitude.total_cmp(&a.magnitude));
    modes
}
