//! The global optimum with a proof, for (leaky) ReLU networks.

use super::problem::{Outcome, Solution, SynthesisSettings, Target};
use crate::error::ControlError;
use pam_core::parallel;
use pam_core::units::MN_PER_N;
use pam_core::{ForceModel, JointModel, SealedMasses};
use pam_exact::{Certificate, InverseProblem, InverseSolver, ReluNetwork, Window};

/// Samples that are solved one after the other; among equal solutions the one nearest to the sample
/// before is taken.
const STRETCH: usize = 64;

/// As [`Synthesiser`](super::Synthesiser), by going through all polygons of the masses in which the force
/// is affine (see [`pam_exact::InverseSolver`]): slower, and every answer is the global optimum, with a
/// certificate.
#[derive(Debug, Clone)]
pub struct CertifiedSynthesiser {
    network: ReluNetwork,
    mass_kg: f64,
    damping_kg_s: f64,
    settings: SynthesisSettings,
}

impl CertifiedSynthesiser {
    /// For a model whose force is a (leaky) ReLU network.
    ///
    /// # Errors
    /// [`ControlError::Value`] if the settings are impossible, [`ControlError::Insufficient`] if the force
    /// is no such network.
    pub fn new<F: ForceModel<f64>>(
        model: &JointModel<f64, F>,
        settings: SynthesisSettings,
    ) -> Result<Self, ControlError> {
        settings.validate()?;
        let network = ReluNetwork::new(&model.force)
            .map_err(|e| ControlError::Insufficient(e.to_string()))?;
        Ok(Self {
            network,
            mass_kg: model.physical().mass_kg,
            damping_kg_s: model.auxiliary_damping_kg_s,
            settings,
        })
    }

    /// The air for each target, with its certificate. Does not depend on the number of threads.
    ///
    /// # Errors
    /// [`ControlError::Value`] naming the first number that is not finite or positive.
    pub fn solve(&self, targets: &[Target]) -> Result<Vec<(Solution, Certificate)>, ControlError> {
        targets.iter().try_for_each(Target::validate)?;
        let stretches: Vec<Vec<(Solution, Certificate)>> =
            parallel::map_each(targets.chunks(STRETCH).collect(), |targets| self.stretch(targets));
        Ok(stretches.into_iter().flatten().collect())
    }

    fn stretch(&self, targets: &[Target]) -> Vec<(Solution, Certificate)> {
        let mut solver = InverseSolver::default();
        let bounds = self.settings.bounds;
        let range = [bounds.least_g, bounds.most_g];
        let mut hint = [0.5 * (range[0] + range[1]); 2];
        let solve = |target: &Target| {
            let problem = InverseProblem {
                displacement_mm: target.displacement_mm,
                velocity_mm_s: target.velocity_mm_s,
                force_mn: target.load_mn
                    - self.mass_kg * target.acceleration_mm_s2
                    - self.damping_kg_s * target.velocity_mm_s,
                stiffness_mn_mm: target.stiffness_n_mm * MN_PER_N,
                step_mm: self.settings.stiffness_step_mm,
                bounds: Window { first: range, second: range },
            };
            let found = solver.solve(&self.network, &problem, hint);
            hint = found.masses_g;
            let stiffness_n_mm = found.stiffness_mn_mm / MN_PER_N;
            let miss = (stiffness_n_mm - target.stiffness_n_mm).abs();
            let outcome = match found.reachable_mn_mm {
                None => Outcome::MotionUnreachable,
                Some(_) if miss <= self.settings.stiffness_tolerance_n_mm => Outcome::Reached,
                Some(_) => Outcome::NearestStiffness,
            };
            let [flexor_g, extensor_g] = found.masses_g;
            let solution = Solution {
                masses: SealedMasses { flexor_g, extensor_g },
                stiffness_n_mm,
                residual_mn: found.residual_mn,
                outcome,
                reachable_n_mm: found.reachable_mn_mm.map(|r| r.map(|k| k / MN_PER_N)),
            };
            (solution, found.certificate)
        };
        targets.iter().map(solve).collect()
    }
}
