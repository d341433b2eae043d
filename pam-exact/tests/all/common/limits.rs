//! Exact solutions and gradients compared with those of steps that end at every kink.

use super::landing::Landing;
use super::{Joint, excitation, masses, motion};
use pam_core::{NamedChoice, ParametricForce, SealedMasses};
use pam_exact::{ExactProblem, ExactSolver, ExactStatistics, ForceSignal};
use pam_solvers::Interpolation;
use rayon::prelude::*;

/// The motion from rest, observed at all samples.
pub(crate) fn problem<'a>(
    times: &'a [f64],
    force: &'a [f64],
    interpolation: Interpolation,
    masses: SealedMasses,
) -> ExactProblem<'a> {
    ExactProblem {
        masses,
        signal: ForceSignal { times_s: times, force_mn: force, interpolation },
        t0: times[0],
        t1: times[times.len() - 1],
        y0: [0.0, 0.0],
        observe_s: times,
    }
}

/// Largest difference in x (mm) between the exact solver and steps of at most `longest_s`, and the counts
/// of the former.
pub(crate) fn largest_difference_mm(
    model: &Joint,
    (times, force): (&[f64], &[f64]),
    interpolation: Interpolation,
    masses: SealedMasses,
    longest_s: f64,
) -> (f64, ExactStatistics) {
    let problem = problem(times, force, interpolation, masses);
    let mut solver = ExactSolver::new();
    assert_eq!(solver.solve(&motion(model), &[problem]), vec![]);
    let linear = interpolation == Interpolation::Linear;
    let reference = Landing::new(model, masses).solve(times, force, linear, longest_s);
    let exact = solver.observed(0).as_chunks::<2>().0;
    let off = exact.iter().zip(&reference).map(|(a, b)| (a[0] - b[0]).abs());
    (off.fold(0.0, f64::max), solver.statistics(0))
}

/// The sum of squares of all states.
pub(crate) fn squares(_: usize, states: &[f64], cotangents: &mut [f64]) -> f64 {
    for (c, s) in cotangents.iter_mut().zip(states) {
        *c = 2.0 * s;
    }
    states.iter().map(|s| s * s).sum()
}

/// The relative distance of the whole gradient from the discrete adjoint of Runge–Kutta steps that land
/// on every kink, and of that from the adjoint of steps twice as long.
pub(crate) fn distance_from_discrete_adjoint(
    model: &Joint,
    count: usize,
    from_s: f64,
    samples: usize,
    interpolation: Interpolation,
    longest_s: f64,
) -> [f64; 2] {
    let motion = motion(model);
    let (times, force) = excitation(from_s, samples);
    let masses = masses(count);
    let problems: Vec<_> =
        masses.iter().map(|&masses| problem(&times, &force, interpolation, masses)).collect();
    let exact = ExactSolver::new().value_and_gradient(&motion, &problems, &squares);
    assert!(exact.failures.is_empty());
    let linear = interpolation == Interpolation::Linear;
    let discrete = |longest_s: f64| -> Vec<Vec<f64>> {
        let one = |masses: &SealedMasses| {
            Landing::new(model, *masses).gradient(&times, &force, linear, longest_s)
        };
        masses.par_iter().map(one).collect()
    };
    let fine = discrete(longest_s);
    // Steps end at samples, so they are no longer than these are apart.
    let coarse = if longest_s > 5e-4 { fine.clone() } else { discrete(2.0 * longest_s) };
    // Shared parameters, then those of each recording; each derivative times its parameter, so that units
    // do not matter.
    let mut scales: Vec<f64> = ParametricForce::parameters(&model.force);
    scales.extend([motion.mass_kg, 1e3]);
    let len = scales.len();
    let shared = |parts: &[Vec<f64>], i: usize| parts.iter().map(|g| g[i]).sum::<f64>();
    let (mut off, mut step, mut size) = (0.0, 0.0, 0.0);
    let mut compare = |scale: f64, exact: f64, fine: f64, coarse: f64| {
        off += (scale * (exact - fine)).powi(2);
        step += (scale * (fine - coarse)).powi(2);
        size += (scale * fine).powi(2);
    };
    let parameters = exact.network.iter().chain([&exact.mass, &exact.damping]);
    for (i, (scale, exact)) in scales.iter().zip(parameters).enumerate() {
        compare(*scale, *exact, shared(&fine, i), shared(&coarse, i));
    }
    for (k, masses) in masses.iter().enumerate() {
        let own = exact.masses[k].into_iter().chain(exact.initial_states[k]);
        let scales = [masses.flexor_g, masses.extensor_g, 1.0, 10.0];
        for (i, (scale, exact)) in scales.into_iter().zip(own).enumerate() {
            // The first sample is the initial state itself, here zero.
            compare(scale, exact, fine[k][len + i], coarse[k][len + i]);
        }
    }
    let distances = [(off / size).sqrt(), (step / size).sqrt()];
    println!(
        "{count} recordings of {samples} samples, {}: {:.1e} from steps of {longest_s} s, which are \
         {:.1e} from steps twice as long",
        interpolation.name(),
        distances[0],
        distances[1]
    );
    distances
}
