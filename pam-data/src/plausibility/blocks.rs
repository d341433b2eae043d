//! Columns averaged over short blocks, and the regressions on them.

use super::settings::PlausibilitySettings;
use crate::recording::{Recording, median_step_s};
use pam_core::units::MN_PER_N;
use pam_numerics::{ScaledCholesky, dot};

/// The columns of a recording, averaged over blocks of equal numbers of samples.
pub(super) struct Blocks {
    /// Time between blocks in the unit of the file.
    pub(super) step: f64,
    /// Displacement in the unit of the file.
    pub(super) x: Vec<f64>,
    /// Integral of the velocity over time, in the units of the file.
    pub(super) travel: Vec<f64>,
    /// Pressures of flexor and extensor as the format states them, kPa.
    pub(super) pressures: [Vec<f64>; 2],
    /// Force, N.
    pub(super) force_n: Vec<f64>,
}

/// Fewest blocks on which a regression rests.
pub(super) const FEWEST: usize = 40;

impl Blocks {
    /// The averages, or `None` if the recording is too short for regressions. `time_scale` converts the file's
    /// time to seconds.
    pub(super) fn new(r: &Recording, time_scale: f64, s: &PlausibilitySettings) -> Option<Self> {
        let sample = median_step_s(&r.time_s);
        let per = (s.block_s / (sample * time_scale)).round().max(1.0) as usize;
        let averaged = |v: &[f64], factor: f64| -> Vec<f64> {
            v.chunks_exact(per).map(|c| c.iter().sum::<f64>() * factor / per as f64).collect()
        };
        let mut travel = Vec::with_capacity(r.len());
        let mut sum = 0.0;
        for (i, v) in r.velocity_mm_s.iter().enumerate() {
            let before = i.saturating_sub(1);
            sum += 0.5 * (v + r.velocity_mm_s[before]) * (r.time_s[i] - r.time_s[before]);
            travel.push(sum);
        }
        let blocks = Self {
            step: sample * per as f64,
            x: averaged(&r.displacement_mm, 1.0),
            travel: averaged(&travel, 1.0),
            pressures: [
                averaged(&r.pressure_flexor_kpa, 1.0),
                averaged(&r.pressure_extensor_kpa, 1.0),
            ],
            force_n: averaged(&r.force_mn, 1.0 / MN_PER_N),
        };
        (blocks.x.len() >= FEWEST).then_some(blocks)
    }
}

/// Central differences per block; the ends repeat their neighbours.
pub(super) fn differences(values: &[f64]) -> Vec<f64> {
    let mut out: Vec<f64> = values.windows(3).map(|w| 0.5 * (w[2] - w[0])).collect();
    if let (Some(&first), Some(&last)) = (out.first(), out.last()) {
        out.insert(0, first);
        out.push(last);
    }
    out
}

/// Residual of values after a cubic in time: slow drifts of leaks, warming and creep.
pub(super) fn without_drift(values: &[f64]) -> Vec<f64> {
    let n = values.len();
    let basis: Vec<[f64; 4]> = (0..n)
        .map(|i| {
            let t = 2.0 * i as f64 / (n.max(2) - 1) as f64 - 1.0;
            [1.0, t, 1.5 * t * t - 0.5, (2.5 * t * t - 1.5) * t]
        })
        .collect();
    let columns: [Vec<f64>; 4] = std::array::from_fn(|j| basis.iter().map(|b| b[j]).collect());
    let features: Vec<&[f64]> = columns.iter().map(Vec::as_slice).collect();
    let Some(fit) = Regression::new(values, &features) else { return values.to_vec() };
    let trend = |b: &[f64; 4]| b.iter().zip(&fit.coefficients).map(|(b, c)| b * c).sum::<f64>();
    values.iter().zip(&basis).map(|(v, b)| v - trend(b)).collect()
}

/// Sum of squares.
pub(super) fn squares(values: &[f64]) -> f64 {
    dot(values, values)
}

/// A least-squares fit.
pub(crate) struct Regression {
    pub(crate) coefficients: Vec<f64>,
    /// Share of the sum of squares of the target that the fit explains.
    pub(crate) r2: f64,
}

impl Regression {
    /// The fit of `target` by the features, without intercept; `None` if the features are dependent.
    pub(crate) fn new(target: &[f64], features: &[&[f64]]) -> Option<Self> {
        if features.iter().any(|f| squares(f) <= 0.0) || squares(target) <= 0.0 {
            return None;
        }
        let factor =
            ScaledCholesky::new(features.len(), |i, j| dot(features[i], features[j]), 1e-12)?;
        let right: Vec<f64> = features.iter().map(|f| dot(f, target)).collect();
        let coefficients = factor.solve(&right)?;
        let explained = dot(&coefficients, &right);
        Some(Self { coefficients, r2: (explained / squares(target)).clamp(0.0, 1.0) })
    }
}
