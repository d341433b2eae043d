//! The balance of forces: `F = m ẍ + f(x, ẋ, m_f, m_e)` against the recorded force.

use super::blocks::{Regression, differences, squares};
use super::sample::Sample;
use super::weigh::{Reading, Weights};
use pam_core::units::MN_PER_N;
use pam_core::{ForceInput, ForceModel};

/// Most points of a recording at which the force is evaluated.
const MOST_POINTS: usize = 800;

/// Speed at which a joint counts as sliding, mm/s; below it dry friction is anywhere between its limits.
const SLIDING_MM_S: f64 = 0.5;

/// Levels at which the recorded force is clipped to see whether it saturates, each this part of the one before: down to a hundredth
/// of the peak.
const CLIP_FACTOR: f64 = 0.8;
const CLIPS: i32 = 22;

/// A force saturates if so much or less of the unexplained share of the modelled force is left once it is clipped: half, and something
/// for the edges of the clipped force, which averages and differences smooth.
const SATURATED_SHARE: f64 = 0.6;

/// Recorded and modelled force of one recording, without their means.
pub(super) struct Balance {
    recorded_n: Vec<f64>,
    modelled_n: Vec<f64>,
    inertial_n: Vec<f64>,
    velocity_mm_s: Vec<f64>,
}

impl Balance {
    /// The balance under a reading, or `None` without motion or masses. Files' masses win over the gas law.
    pub(super) fn new<F: ForceModel<f64>>(
        weights: &Weights<'_, F>,
        sample: &Sample<'_>,
        reading: Reading,
    ) -> Option<Self> {
        let blocks = sample.blocks.as_ref()?;
        let masses = match sample.given {
            Some(given) if reading == Reading::STATED => given,
            _ => weights.gas_masses(sample, reading)?,
        };
        let dt = blocks.step * sample.time_scale;
        let x: Vec<f64> = blocks.x.iter().map(|x| x * reading.mm()).collect();
        let v: Vec<f64> = differences(&x).iter().map(|d| d / dt).collect();
        let a: Vec<f64> = differences(&v).iter().map(|d| d / dt).collect();
        // Enough points to tell a force from another; a network costs microseconds each.
        let every = x.len().div_ceil(MOST_POINTS);
        let thin = |v: &[f64]| v.iter().copied().step_by(every).collect::<Vec<f64>>();
        let (x, v, a) = (thin(&x), thin(&v), thin(&a));
        let force = &weights.model.force;
        let mut work = vec![0.0; force.work_len()];
        let mut restoring = |x: f64, v: f64| {
            let at = ForceInput {
                displacement_mm: x,
                velocity_mm_s: v,
                mass_flexor_g: masses.flexor_g,
                mass_extensor_g: masses.extensor_g,
            };
            force.restoring_force_mn(&at, &mut work) / MN_PER_N
        };
        let mass = weights.model.physical().mass_kg;
        let inertial_n: Vec<f64> = a.iter().map(|a| mass * a / MN_PER_N).collect();
        let modelled_n =
            (0..x.len()).map(|i| inertial_n[i] + restoring(x[i], v[i])).collect::<Vec<_>>();
        Some(Self {
            recorded_n: centred(&thin(&blocks.force_n)),
            modelled_n: centred(&modelled_n),
            inertial_n: centred(&inertial_n),
            velocity_mm_s: v,
        })
    }

    /// Correlation of recorded and modelled force.
    pub(super) fn correlation(&self) -> f64 {
        let dot: f64 = self.recorded_n.iter().zip(&self.modelled_n).map(|(a, b)| a * b).sum();
        let norm = (squares(&self.recorded_n) * squares(&self.modelled_n)).sqrt();
        if norm > 0.0 { dot / norm } else { 0.0 }
    }

    /// Size of the recorded force over that of the modelled one.
    pub(super) fn ratio(&self) -> f64 {
        (squares(&self.recorded_n) / squares(&self.modelled_n)).sqrt()
    }

    /// Whether the recorded force, clipped at some level, goes clearly better with the modelled one and is as large, within this factor. A
    /// wrong unit keeps the shape of the force; a saturated actuator does not.
    pub(super) fn saturates(&self, factor: f64) -> bool {
        let peak = self.recorded_n.iter().fold(0.0, |most: f64, f| most.max(f.abs()));
        let of_model = squares(&self.modelled_n);
        let unexplained = |recorded: &[f64]| {
            let dot: f64 = recorded.iter().zip(&self.modelled_n).map(|(a, b)| a * b).sum();
            1.0 - dot * dot / (squares(recorded) * of_model)
        };
        let most = SATURATED_SHARE * unexplained(&self.recorded_n);
        (1..CLIPS).any(|k| {
            let level = peak * CLIP_FACTOR.powi(k);
            let clip = |f: &f64| f.clamp(-level, level);
            let clipped = centred(&self.recorded_n.iter().map(clip).collect::<Vec<_>>());
            let ratio = (squares(&clipped) / of_model).sqrt();
            ratio.max(1.0 / ratio) < factor && unexplained(&clipped) < most
        })
    }

    /// Share of inertia in the modelled force. Where it dominates, a wrong mass can turn its sign.
    pub(super) fn inertia_share(&self) -> f64 {
        (squares(&self.inertial_n) / squares(&self.modelled_n)).sqrt()
    }

    /// Root mean square of the difference over that of the recorded force, less dry and viscous friction that the model
    /// may lack: in a loop, friction looks like stiffness.
    fn error(&self) -> f64 {
        let left: Vec<f64> =
            self.recorded_n.iter().zip(&self.modelled_n).map(|(a, b)| a - b).collect();
        let dry: Vec<f64> = self.velocity_mm_s.iter().map(|v| (v / SLIDING_MM_S).tanh()).collect();
        let friction = Regression::new(&left, &[&centred(&dry), &centred(&self.velocity_mm_s)]);
        let rest = friction.map_or(1.0, |fit| 1.0 - fit.r2);
        (rest * squares(&left) / squares(&self.recorded_n)).sqrt()
    }
}

/// Relative error of the model's force under a reading.
pub(super) fn model_error<F: ForceModel<f64>>(
    weights: &Weights<'_, F>,
    sample: &Sample<'_>,
    reading: Reading,
) -> Option<f64> {
    Balance::new(weights, sample, reading).map(|b| b.error()).filter(|e| e.is_finite())
}

fn centred(values: &[f64]) -> Vec<f64> {
    let mean = values.iter().sum::<f64>() / values.len() as f64;
    values.iter().map(|v| v - mean).collect()
}
