//! The force that a model lacks on the measured motion.
//!
//! On the measured `x` and `ẋ` the model's equation of motion leaves `r = F_e − f_θ − B ẋ − m ẍ`
//! over: the force, opposing the motion where it has the sign of `ẋ`, that is in the data and not in
//! the model. Dry friction shows as a part that flips sign with the velocity. This needs no
//! simulation, so it says where an error enters, which a free-run error does not.

use pam_core::units::MN_PER_N;
use pam_core::{ForceModel, JointModel, SealedMasses};
use pam_data::Recording;
use pam_data::preprocess::gradient_at_times;
use pam_numerics::statistics::root_mean_square;
use pam_surrogate::PointForces;
use serde::Serialize;

/// Velocities below this share of their root mean square count as standstill.
const STANDSTILL: f64 = 0.25;

/// Summary of the missing force of one recording.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ForceBalance {
    /// Root mean square of the missing force, N.
    pub rms_n: f64,
    /// Mean missing force while x rises, N.
    pub rising_n: f64,
    /// Mean missing force while x falls, N.
    pub falling_n: f64,
    /// Half the difference of the two: the part that flips with the direction of motion, N.
    pub direction_n: f64,
    /// Half the sum of the two: the part that does not depend on the direction, N.
    pub offset_n: f64,
    /// Share of the missing force's variance that the direction alone explains while the joint
    /// moves, 0 to 1.
    pub direction_share: f64,
    /// Share of the time in which the measured velocity is near zero.
    pub standstill_share: f64,
    /// The missing force at every sample, N.
    #[serde(skip)]
    pub missing_n: Vec<f64>,
}

impl ForceBalance {
    /// Computes the balance of a recording.
    pub fn of<F: ForceModel<f64>>(
        model: &JointModel<f64, F>,
        recording: &Recording,
        masses: SealedMasses,
    ) -> Self {
        let mass_kg = model.physical().mass_kg;
        let damping = model.auxiliary_damping_kg_s;
        let acceleration = gradient_at_times(&recording.velocity_mm_s, &recording.time_s);
        let forces = PointForces::new(&model.force);
        let states = recording.displacement_mm.iter().zip(&recording.velocity_mm_s);
        let points: Vec<[f64; 2]> = states.map(|(&x, &v)| [x, v]).collect();
        let mut restoring_mn = vec![0.0; points.len()];
        forces.values_into(masses, &points, &mut restoring_mn, &mut forces.memory());
        let missing_n: Vec<f64> = (0..points.len())
            .map(|i| {
                let others = restoring_mn[i] + damping * points[i][1] + mass_kg * acceleration[i];
                (recording.force_mn[i] - others) / MN_PER_N
            })
            .collect();
        Self::summarise(missing_n, &recording.velocity_mm_s)
    }

    fn summarise(missing_n: Vec<f64>, velocity: &[f64]) -> Self {
        let n = missing_n.len() as f64;
        let threshold = STANDSTILL * root_mean_square(velocity);
        let (mut up, mut down) = (Vec::new(), Vec::new());
        for (&r, &v) in missing_n.iter().zip(velocity) {
            if v > threshold {
                up.push(r);
            } else if v < -threshold {
                down.push(r);
            }
        }
        let mean = |v: &[f64]| if v.is_empty() { 0.0 } else { pam_numerics::statistics::mean(v) };
        let (rising_n, falling_n) = (mean(&up), mean(&down));
        let spread = |v: &[f64], about: f64| v.iter().map(|r| (r - about).powi(2)).sum::<f64>();
        let moving = (up.len() + down.len()) as f64;
        let overall = (up.iter().sum::<f64>() + down.iter().sum::<f64>()) / moving.max(1.0);
        let total = spread(&up, overall) + spread(&down, overall);
        let within = spread(&up, rising_n) + spread(&down, falling_n);
        Self {
            rms_n: root_mean_square(&missing_n),
            rising_n,
            falling_n,
            direction_n: 0.5 * (rising_n - falling_n),
            offset_n: 0.5 * (rising_n + falling_n),
            direction_share: if total > 0.0 { 1.0 - within / total } else { 0.0 },
            standstill_share: 1.0 - moving / n,
            missing_n,
        }
    }
}
