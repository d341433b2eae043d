//! Mass and force from accelerations.

use super::squared_residuals::SquaredResiduals;
use crate::coordinates::Coordinates;
use crate::optimiser::{Adam, AdamSettings};
use pam_data::Subject;
use pam_data::preprocess::{LowPass, gradient};
use pam_data::recording::median_step_s;
use rand::SeedableRng;
use rand::rngs::ChaCha8Rng;
use rand::seq::SliceRandom;
use serde::{Deserialize, Serialize};

/// Derivative matching: `m ẍ + B ẋ + f_θ(x, ẋ, m_f, m_e) = F` is regressed on smoothed data, with the
/// network and m free, by Adam over shuffled batches with a rate that falls as a cosine.
///
/// With `mass_steps` m is corrected afterwards ([`run`](Self::run)), and the force regressed again.
///
/// Displacement and force are smoothed alike, so that what is linear in the equation is not biased.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct DerivativeMatching {
    /// Cutoff of the smoothing, Hz: a first-order low-pass, forward and back, twice.
    pub cutoff_hz: f64,
    /// Distance of the points that are regressed on, s.
    pub spacing_s: f64,
    /// Points in a batch.
    pub batch: usize,
    /// Steps of the optimiser.
    pub steps: usize,
    /// Rate at the start.
    pub rate: f64,
    /// Steps of the regression of the acceleration by which m is corrected, and of that of the force with
    /// the corrected m that follows; see [`own_acceleration`](super::own_acceleration). Zero leaves m as
    /// the joint regression finds it.
    pub mass_steps: usize,
}

impl Default for DerivativeMatching {
    fn default() -> Self {
        Self {
            cutoff_hz: 20.0,
            spacing_s: 0.01,
            batch: 2048,
            steps: 3000,
            rate: 3e-3,
            mass_steps: 0,
        }
    }
}

/// The result of derivative matching.
#[derive(Debug, Clone)]
pub struct Matched {
    /// The coordinates.
    pub at: Vec<f64>,
    /// Root mean square of the residual force, N.
    pub rms_n: f64,
    /// Points that were regressed on.
    pub points: usize,
}

/// One point of the regression.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Point {
    /// `(m_f, m_e, x, ẋ)` in g, g, mm, mm/s.
    pub input: [f64; 4],
    /// ẍ, mm/s².
    pub acceleration: f64,
    /// F, mN.
    pub force_mn: f64,
}

impl DerivativeMatching {
    /// Checks the settings.
    ///
    /// # Errors
    /// The name of the setting that is impossible, and what it must be.
    pub fn check(&self) -> Result<(), String> {
        let positive = |name: &str, value: f64| match value.is_finite() && value > 0.0 {
            true => Ok(()),
            false => Err(format!("{name} must be positive and finite, got {value}")),
        };
        if !(self.cutoff_hz.is_finite() && self.cutoff_hz >= 0.0) {
            return Err(format!(
                "cutoff_hz must be finite and not negative, got {}",
                self.cutoff_hz
            ));
        }
        positive("spacing_s", self.spacing_s)?;
        positive("rate", self.rate)?;
        if self.batch == 0 {
            return Err("batch must be at least one".into());
        }
        Ok(())
    }

    /// Regresses m and the network on points, from the coordinates `start`.
    #[must_use]
    pub fn regress(
        &self,
        coordinates: &Coordinates,
        start: &[f64],
        mut points: Vec<Point>,
        seed: u64,
    ) -> Matched {
        let scale = {
            let square = points.iter().map(|p| p.force_mn * p.force_mn).sum::<f64>();
            let mean = square / points.len().max(1) as f64;
            // Recordings of a free joint have no force: residuals then count in mN.
            if mean > 0.0 { mean } else { 1.0 }
        };
        let mut at = start.to_vec();
        let mut adam = Adam::new(AdamSettings::default(), at.len());
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let batch = self.batch.clamp(1, points.len().max(1));
        let mut residuals = SquaredResiduals::over(scale);
        let mut next = points.len();
        let mut recent = 0.0;
        for step in 0..if points.is_empty() { 0 } else { self.steps } {
            if next + batch > points.len() {
                points.shuffle(&mut random);
                next = 0;
            }
            let part = &points[next..next + batch];
            next += batch;
            let model = coordinates.model(&at);
            let (loss, gradient) = residuals.value_and_gradient(coordinates, &model, part);
            let done = step as f64 / self.steps as f64;
            let rate = 0.5 * self.rate * (1.0 + (std::f64::consts::PI * done).cos());
            adam.step(&mut at, &gradient, rate);
            // A running mean over about fifty batches.
            recent = if step == 0 { loss } else { recent + 0.02 * (loss - recent) };
        }
        let rms_n = 1e-3 * (scale * recent).sqrt();
        Matched { at, rms_n, points: points.len() }
    }

    /// The points of a recording: smoothed, differentiated, thinned out.
    #[must_use]
    pub fn points(&self, subject: &Subject) -> Vec<Point> {
        let r = &subject.recording;
        let step = median_step_s(&r.time_s);
        let smooth = |values: &[f64]| match LowPass::new(self.cutoff_hz, 1.0 / step) {
            Some(filter) if values.len() >= LowPass::shortest() => {
                filter.forward_backward(&filter.forward_backward(values))
            }
            _ => values.to_vec(),
        };
        let x = smooth(&r.displacement_mm);
        let force = smooth(&r.force_mn);
        let v = gradient(&x, step);
        let a = gradient(&v, step);
        let stride = ((self.spacing_s / step).round() as usize).max(1);
        // The ends of a filtered column are made up.
        let edge = (2.0 / (self.cutoff_hz.max(0.1) * step)).ceil() as usize;
        (edge..r.len().saturating_sub(edge))
            .step_by(stride)
            .map(|k| Point {
                input: [subject.masses.flexor_g, subject.masses.extensor_g, x[k], v[k]],
                acceleration: a[k],
                force_mn: force[k],
            })
            .collect()
    }
}
