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

/// The slope of the modelled over the recorded force is estimated below this many levels, each this fraction of the one above: down to a
/// twentieth of the peak.
const LEVEL_FACTOR: f64 = 0.8;
const LEVELS: i32 = 14;

/// The actuator saturates if the slope below some level exceeds this multiple of the slope over all forces by this many standard errors.
/// Unmodelled dry friction of half the amplitude also raises it by a factor of 1.5.
const STEEPER: f64 = 1.5;
const STANDARD_ERRORS: f64 = 3.0;

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

    /// Returns true if the actuator saturates: the slope of the modelled over the recorded force is significantly larger at small forces than
    /// over the full range. A wrong unit scales the force by the same factor at every amplitude.
    pub(super) fn saturates(&self) -> bool {
        let peak = self.recorded_n.iter().fold(0.0, |most: f64, f| most.max(f.abs()));
        let Some([whole, _]) = self.slope_below(peak) else { return false };
        let steeper = |[slope, error]: [f64; 2]| slope - STANDARD_ERRORS * error > STEEPER * whole;
        let levels = (1..LEVELS).map(|k| peak * LEVEL_FACTOR.powi(k));
        levels.filter_map(|level| self.slope_below(level)).any(steeper)
    }

    /// Slope of the modelled over the recorded force, with its standard error, from the points whose recorded force is within `±level_n`.
    fn slope_below(&self, level_n: f64) -> Option<[f64; 2]> {
        let pairs = self.recorded_n.iter().zip(&self.modelled_n);
        let [recorded, modelled]: [Vec<f64>; 2] =
            pairs.filter(|(f, _)| f.abs() <= level_n).unzip().into();
        let fit = Regression::new(&modelled, &[&recorded])?;
        let left = (1.0 - fit.r2) * squares(&modelled);
        let error = (left / (recorded.len() - 1) as f64 / squares(&recorded)).sqrt();
        error.is_finite().then_some([fit.coefficients[0], error])
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
