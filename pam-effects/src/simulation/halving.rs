//! Steps for forces with kinks, by trial.
//!
//! What [stability and accuracy](super::steps) ask of a step is right for a smooth force. Where the slopes of a force jump, as those of a
//! network of leaky ReLUs, the error of a step depends on where in it they do: a periodic motion then has lines between the multiples of
//! its frequency, which no joint has. The harmonic that steps of `h` turn into such a line is the `1/(h f)`-th, and harmonics by jumps of
//! slopes fall with the square of their number, so fast motions show them. No local number tells how large they are: the motion
//! itself is compared with one of half the step.

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

/// Least mean frequency of a motion for which kinks are looked for, Hz.
const FAST_HZ: f64 = 3.0;
/// Largest change of the displacement by steps of half the length, as root mean square relative to its deviation: what a diagnosis grants
/// any model (`noise.discrepancy`).
const LARGEST_CHANGE: f64 = 2e-4;
/// Most substeps for the kinks of a force; where the mechanics needs as many, steps are short enough.
const MOST_FOR_KINKS: usize = 4;

/// Substeps of each step of the grid for a fast motion, from which on twice as many change the displacement of the base model by less
/// than [`LARGEST_CHANGE`]; 1 for a slow one.
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
