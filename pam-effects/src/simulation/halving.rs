//! Step sizes for forces with kinks, by step halving.
//!
//! The [criteria of stability and accuracy](super::steps) assume a smooth force. If its slope jumps, as in a leaky ReLU network, the error of a
//! step depends on where in the step the kink lies, and the simulation of a periodic motion has spectral lines between the harmonics.
//! They are aliases: with steps of `h`, harmonics of the order `1/(h f)` and above fold back. As a jump of the slope makes harmonics that
//! decay with the square of their order, only fast motions show them. No local criterion predicts their amplitude, so the motion
//! is compared with that of half the step.

use super::base::Base;
use super::integrator::JointIntegrator;
use super::measured::Measured;
use super::nuisances::Nuisances;
use super::parts::Parts;
use super::run::Running;
use super::steps::substeps;
use super::trial::Trial;
use pam_core::simd::arch;
use pam_numerics::statistics::{root_mean_square, standard_deviation};

/// Mean frequency of a motion from which the step is tested by halving, Hz.
const FAST_HZ: f64 = 3.0;
/// Tolerance of the displacement when the step is halved: root-mean-square difference over standard deviation. It equals the model
/// discrepancy that a diagnosis assumes at least (`noise.discrepancy`).
const LARGEST_CHANGE: f64 = 2e-4;
/// Most substeps for the kinks of a force; where the mechanics needs as many, steps are short enough.
const MOST_FOR_KINKS: usize = 4;

/// Substeps per grid step at which halving the substep changes the displacement of the base model by less than [`LARGEST_CHANGE`], at most
/// [`MOST_FOR_KINKS`]; 1 for a slow motion.
pub(super) fn substeps_by_halving(trial: &Trial, base: &Base<f64>) -> usize {
    let (record, measured) = (&trial.record, Measured::of(&trial.record));
    if record.spectrum.mean_hz() < FAST_HZ {
        return 1;
    }
    let (parts, none) = (Parts::new(&[], &[]), Nuisances::none());
    let joint = |substeps| {
        JointIntegrator::new(record, base, &trial.table, &parts, &measured, &none, substeps)
    };
    let motion = |substeps| {
        let mut channels = <[Vec<f64>; 4]>::default();
        let (joint, points) = (&mut joint(substeps), record.points());
        arch().dispatch(Running { joint, points, channels: &mut channels }).ok()?;
        let [x, ..] = channels;
        Some(x)
    };
    let least = substeps(&mut joint(1));
    let mut now = least;
    let Some(mut coarse) = motion(now) else { return least };
    while now < MOST_FOR_KINKS {
        let Some(fine) = motion(2 * now) else { break };
        let change: Vec<f64> = coarse.iter().zip(&fine).map(|(a, b)| a - b).collect();
        let is_changed = root_mean_square(&change) > LARGEST_CHANGE * standard_deviation(&fine);
        if !is_changed {
            break;
        }
        (now, coarse) = (2 * now, fine);
    }
    now
}
