//! Least squares of the muscle's parameters.

use super::muscle::KangMuscle;
use super::samples::MuscleSample;
use pam_numerics::ScaledCholesky;
use pam_trajectory::metrics::r2;
use serde::{Deserialize, Serialize};

/// Treatment of the braid angle α₀.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum BraidAngle {
    /// It is held at this angle, degrees.
    Held(f64),
    /// It is fitted: an effective angle. Written as `"fit"`.
    Fitted(Fit),
}

/// The word `fit`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Fit {
    /// `fit`.
    #[serde(rename = "fit")]
    Fit,
}

/// A fitted muscle.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct FittedMuscle {
    /// Its parameters.
    pub muscle: KangMuscle,
    /// R² of the tension over the samples.
    pub r2: f64,
    /// Root mean square error, N.
    pub rmse_n: f64,
    /// Number of samples.
    pub samples: usize,
    /// Number of fitted parameters.
    pub parameters: usize,
}

/// Steps of a fit at most.
const STEPS: usize = 200;

/// Fits c_q1, c_q2 and, as far as the samples show them, c_v (rates that are not zero), c_c (both
/// directions) and α0 by Levenberg–Marquardt from several starts; what the samples do not show stays as in
/// `guess`, except that dry friction is zero where no direction is known.
#[must_use]
pub fn fit(guess: &KangMuscle, angle: BraidAngle, samples: &[MuscleSample]) -> FittedMuscle {
    let mut guess = *guess;
    let mut free = vec![Parameter::Correction, Parameter::Rate];
    if samples.iter().any(|s| s.rate_per_s != 0.0) {
        free.push(Parameter::Viscous);
    }
    if samples.iter().any(|s| s.direction != 0.0) {
        free.push(Parameter::Dry);
    } else {
        guess.dry_n = 0.0;
    }
    match angle {
        BraidAngle::Held(degrees) => guess.braid_angle_deg = degrees,
        BraidAngle::Fitted(_) => free.push(Parameter::Angle),
    }
    let mut best: Option<(f64, KangMuscle)> = None;
    for correction in [guess.correction, 10.0, 40.0] {
        for rate in [guess.correction_rate_per_kpa, -1e-3] {
            let start = KangMuscle { correction, correction_rate_per_kpa: rate, ..guess };
            let found = descend(start, &free, samples);
            if best.is_none_or(|(square, _)| found.0 < square) {
                best = Some(found);
            }
        }
    }
    let (square, muscle) = best.expect("there are several starts");
    let measured: Vec<f64> = samples.iter().map(|s| s.force_n).collect();
    let own: Vec<f64> = samples.iter().map(|s| tension(&muscle, s)).collect();
    FittedMuscle {
        muscle,
        r2: r2(&measured, &own),
        rmse_n: (square / samples.len().max(1) as f64).sqrt(),
        samples: samples.len(),
        parameters: free.len(),
    }
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum Parameter {
    Correction,
    Rate,
    Viscous,
    Dry,
    Angle,
}

impl Parameter {
    /// The parameter, and the size of its natural change.
    fn of(self, m: &mut KangMuscle) -> (&mut f64, f64) {
        match self {
            Self::Correction => (&mut m.correction, 1.0),
            Self::Rate => (&mut m.correction_rate_per_kpa, 1e-3),
            Self::Viscous => (&mut m.viscous_ns, 100.0),
            Self::Dry => (&mut m.dry_n, 10.0),
            Self::Angle => (&mut m.braid_angle_deg, 1.0),
        }
    }
}

fn tension(m: &KangMuscle, s: &MuscleSample) -> f64 {
    m.tension_n(s.gauge_kpa, s.contraction, s.rate_per_s, s.direction)
}

/// Levenberg–Marquardt with differences; returns the sum of squares.
fn descend(start: KangMuscle, free: &[Parameter], samples: &[MuscleSample]) -> (f64, KangMuscle) {
    let n = free.len();
    let square = |m: &KangMuscle| -> f64 {
        let sum: f64 = samples.iter().map(|s| (tension(m, s) - s.force_n).powi(2)).sum();
        if sum.is_finite() { sum } else { f64::INFINITY }
    };
    let mut at = start;
    let mut value = square(&at);
    let mut damping = 1e-3;
    for _ in 0..STEPS {
        let shifted: Vec<KangMuscle> = free
            .iter()
            .map(|p| {
                let mut m = at;
                let (value, size) = p.of(&mut m);
                *value += 1e-5 * size;
                m
            })
            .collect();
        let mut gram = vec![0.0; n * n];
        let mut right = vec![0.0; n];
        let mut row = vec![0.0; n];
        for s in samples {
            let own = tension(&at, s);
            for (r, m) in row.iter_mut().zip(&shifted) {
                *r = (tension(m, s) - own) / 1e-5;
            }
            for i in 0..n {
                for j in 0..n {
                    gram[i * n + j] += row[i] * row[j];
                }
                right[i] -= row[i] * (own - s.force_n);
            }
        }
        let mut better = false;
        for _ in 0..12 {
            let factor = ScaledCholesky::new(n, |i, j| gram[i * n + j], damping);
            let Some(step) = factor.and_then(|f| f.solve(&right)) else {
                damping *= 10.0;
                continue;
            };
            let mut next = at;
            for (i, p) in free.iter().enumerate() {
                let (value, size) = p.of(&mut next);
                *value += step[i] * size;
            }
            let inside = (5.0..54.0).contains(&next.braid_angle_deg) && next.correction > -1.0;
            let new = if inside { square(&next) } else { f64::INFINITY };
            if new < value {
                better = value - new > 1e-12 * value;
                (at, value) = (next, new);
                damping = (0.2 * damping).max(1e-12);
                break;
            }
            damping *= 10.0;
        }
        if !better {
            break;
        }
    }
    (value, at)
}
