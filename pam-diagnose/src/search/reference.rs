//! A flexible reference: how much of the residual any correction could remove.

use super::split::Split;
use crate::fit::{CHANNELS, ChannelErrors, Floors, Hypothesis, POINTS_PER_ROW, Problem};
use faer::linalg::solvers::Solve;
use faer::{Mat, Side};
use pam_effects::simulation::Trial;

/// A learned residual: what a linear combination of many features of the measured motion leaves on
/// held-out rows.
///
/// Each channel's residual is regressed, with a ridge, on forces that might be missing (powers of position
/// and velocity, direction, the command, plays of three widths, three relaxations, time) as the joint would
/// answer them (through the second-order system that the model is near its middle), and on the same features
/// as a sensor would add them. It has no names; it says how much of the error there is to explain.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Reference {
    /// Errors that the learned residual leaves on held-out rows.
    pub held: ChannelErrors,
}

/// Ridge, relative to unit columns.
const RIDGE: f64 = 1e-3;

impl Reference {
    /// Learns the residual of a hypothesis on the training rows and judges it on the held-out ones.
    #[must_use]
    pub fn learn(split: &Split<'_>, hypothesis: &Hypothesis<'_>, floors: &Floors) -> Option<Self> {
        let train = Rows::gather(&split.train, hypothesis)?;
        let held = Rows::gather(&split.held, &split.for_held(hypothesis))?;
        let scale: Vec<f64> = train
            .features
            .iter()
            .map(|f| (f.iter().map(|v| v * v).sum::<f64>() / f.len() as f64).sqrt().max(1e-12))
            .collect();
        let n = scale.len();
        let gram = Mat::from_fn(n, n, |i, j| {
            let dot: f64 =
                train.features[i].iter().zip(&train.features[j]).map(|(a, b)| a * b).sum();
            let ridge = if i == j { RIDGE } else { 0.0 };
            dot / (scale[i] * scale[j] * train.len() as f64) + ridge
        });
        let factor = gram.llt(Side::Lower).ok()?;
        let mut errors = ChannelErrors { sums: [0.0; 3], rows: held.len() };
        for c in 0..3 {
            let right = Mat::from_fn(n, 1, |i, _| {
                let dot: f64 =
                    train.features[i].iter().zip(&train.residuals[c]).map(|(a, b)| a * b).sum();
                dot / (scale[i] * train.len() as f64)
            });
            let weights = factor.solve(&right);
            let mut left = held.residuals[c].clone();
            for (i, feature) in held.features.iter().enumerate() {
                let w = weights[(i, 0)] / scale[i];
                left.iter_mut().zip(feature).for_each(|(l, f)| *l -= w * f);
            }
            let learned: f64 = left.iter().map(|v| v * v).sum();
            let plain: f64 = held.residuals[c].iter().map(|v| v * v).sum();
            // A channel at its floor has nothing to learn.
            let floor = floors.0[c] * floors.0[c] * held.len() as f64;
            errors.sums[c] = learned.min(plain).max(floor.min(plain));
        }
        Some(Self { held: errors })
    }
}

/// Residuals and features of all rows of a problem.
struct Rows {
    residuals: [Vec<f64>; 3],
    features: Vec<Vec<f64>>,
}

impl Rows {
    fn gather(problem: &Problem<'_>, hypothesis: &Hypothesis<'_>) -> Option<Self> {
        let mut residuals = CHANNELS.map(|_| Vec::new());
        let mut features: Vec<Vec<f64>> = Vec::new();
        for i in 0..problem.len() {
            let r = problem.residuals(hypothesis, i).ok()?;
            let t = problem.trials[i];
            let window = problem.windows[i].clone();
            let rows = |series: &[f64]| -> Vec<f64> {
                series[window.clone()]
                    .chunks_exact(POINTS_PER_ROW)
                    .map(|c| c.iter().sum::<f64>() / POINTS_PER_ROW as f64)
                    .collect()
            };
            let all = features_of(t, problem.base.mass_kg);
            features.resize(all.len(), Vec::new());
            for (feature, series) in features.iter_mut().zip(&all) {
                feature.extend(rows(series));
            }
            for (all, own) in residuals.iter_mut().zip(r) {
                all.extend(own);
            }
        }
        Some(Self { residuals, features })
    }

    fn len(&self) -> usize {
        self.residuals[0].len()
    }
}

/// Features of a trial on its grid.
fn features_of(t: &Trial, mass_kg: f64) -> Vec<Vec<f64>> {
    let (x, v) = (&t.record.measured[0], &t.record.measured[1]);
    let n = x.len();
    let rms = |s: &[f64]| (s.iter().map(|a| a * a).sum::<f64>() / n as f64).sqrt().max(1e-9);
    let (sx, sv) = (rms(x), rms(v));
    let map = |f: &dyn Fn(usize) -> f64| (0..n).map(f).collect::<Vec<f64>>();
    let pressure = (t.record.rest.sealed_kpa[0] + t.record.rest.sealed_kpa[1]) / 1000.0;
    let difference = (t.record.rest.sealed_kpa[0] - t.record.rest.sealed_kpa[1]) / 500.0;
    let play = |half: f64| {
        let mut at = x[0];
        map_mut(x, |x| {
            at = at.clamp(x - half, x + half);
            x - at
        })
    };
    let relaxed = |time_s: f64| {
        let share = -(-t.record.step_s / time_s).exp_m1();
        let mut at = x[0];
        map_mut(x, |x| {
            at += share * (x - at);
            x - at
        })
    };
    let force = t.record.force.values_mn();
    let mut causes: Vec<Vec<f64>> = vec![
        vec![1.0; n],
        vec![pressure; n],
        vec![difference; n],
        map(&|k| x[k] / sx),
        map(&|k| (x[k] / sx).powi(2)),
        map(&|k| (x[k] / sx).powi(3)),
        map(&|k| pressure * x[k] / sx),
        map(&|k| difference * x[k] / sx),
        map(&|k| v[k] / sv),
        map(&|k| pressure * v[k] / sv),
        map(&|k| v[k] * v[k].abs() / (sv * sv)),
        map(&|k| (v[k] / (0.05 * sv)).tanh()),
        map(&|k| x[k] * v[k] / (sx * sv)),
        map(&|k| force[2 * k] / rms(force)),
        map(&|k| (force[2 * k] / rms(force)).powi(3)),
        map(&|k| k as f64 / n as f64),
        map(&|k| x[k] / sx * k as f64 / n as f64),
    ];
    causes.extend([0.05, 0.2, 0.6].map(|w| play(w * sx)));
    causes.extend([0.1, 1.0, 10.0].map(relaxed));
    // The model near the middle of the motion.
    let middle = x.iter().sum::<f64>() / n as f64;
    let f = |x: f64, v: f64| t.table.force_mn(x, v, [0.0; 2]);
    let stiffness = (f(middle + 0.5 * sx, 0.0) - f(middle - 0.5 * sx, 0.0)) / sx;
    let damping = ((f(middle, 0.5 * sv) - f(middle, -0.5 * sv)) / sv).max(0.0);
    let answers: Vec<Vec<f64>> = causes
        .iter()
        .map(|cause| {
            let (mut y, mut w) = (0.0, 0.0);
            map_mut(cause, |c| {
                // Semi-implicit, and implicit in the damping: stable at any step of interest.
                let free = w + t.record.step_s / mass_kg * (c * 1e3 - stiffness * y);
                w = free / (1.0 + t.record.step_s * damping / mass_kg);
                y += t.record.step_s * w;
                y
            })
        })
        .collect();
    causes.extend(answers);
    causes
}

fn map_mut(values: &[f64], mut f: impl FnMut(f64) -> f64) -> Vec<f64> {
    values.iter().map(|&v| f(v)).collect()
}
