//! The published weights: exact solutions against Runge–Kutta steps that land on every kink, and exact
//! gradients against differences of exact values.

use crate::common;
use crate::common::limits::{
    distance_from_discrete_adjoint, largest_difference_mm, problem, squares,
};
use pam_core::{NamedChoice, ParametricForce, SealedMasses};
use pam_exact::{ExactDirection, ExactProblem, ExactSolver, forward_sensitivities};
use pam_solvers::Interpolation;

/// Largest difference in x (mm) between the exact solver and the reference.
fn worst(conditions: &[usize], samples: usize, longest_s: f64) -> f64 {
    worst_from(30.0, conditions, samples, longest_s)
}

/// The same from another time of the excitation on, s.
fn worst_from(from_s: f64, conditions: &[usize], samples: usize, longest_s: f64) -> f64 {
    let model = common::published();
    let (times, force) = common::excitation(from_s, samples);
    let masses = common::masses(29);
    let mut worst = 0.0_f64;
    for &condition in conditions {
        for interpolation in [Interpolation::Hold, Interpolation::Linear] {
            let signal = (&times[..], &force[..]);
            let (off, counts) =
                largest_difference_mm(&model, signal, interpolation, masses[condition], longest_s);
            println!("condition {condition} {}: {off:.2e} mm, {counts:?}", interpolation.name());
            worst = worst.max(off);
        }
    }
    worst
}

#[test]
fn equals_runge_kutta_that_lands_on_every_kink() {
    assert!(worst(&[0, 7, 25], 1500, 2.5e-4) < 1e-9);
}

#[test]
#[ignore = "minutes: a whole recording of 70 s"]
fn equals_runge_kutta_on_a_whole_recording() {
    assert!(worst_from(0.0, &[0], 70_000, 2.5e-4) < 1e-9);
}

#[test]
#[ignore = "minutes: all conditions, 12 s"]
fn equals_runge_kutta_on_all_conditions() {
    let all: Vec<usize> = (0..29).collect();
    assert!(worst(&all, 12_000, 1.25e-4) < 1e-9);
}

/// Additional samples of a held force make shorter steps, which find crossings at other places; the solution
/// stays.
#[test]
fn halving_the_steps_changes_nothing() {
    let motion = common::motion(&common::published());
    let (times, force) = common::excitation(36.0, 8000);
    for masses in [common::masses(29)[3], common::masses(29)[20]] {
        let solve = |parts: usize| {
            let part = |k: usize| (k % parts) as f64 / parts as f64;
            let samples = 0..parts * (times.len() - 1) + 1;
            let finer: Vec<f64> =
                samples.clone().map(|k| times[k / parts] + 1e-3 * part(k)).collect();
            let held: Vec<f64> = samples.map(|k| force[k / parts]).collect();
            let problem = problem(&finer, &held, Interpolation::Hold, masses);
            let mut solver = ExactSolver::new();
            let problem = ExactProblem { observe_s: &times, ..problem };
            assert!(solver.solve(&motion, &[problem]).is_empty());
            assert!(solver.statistics(0).segments > parts * times.len());
            solver.observed(0).to_vec()
        };
        let whole = solve(1);
        for parts in [2, 6] {
            let off = whole.iter().zip(solve(parts)).step_by(2).map(|(a, b)| (a - b).abs());
            let off = off.fold(0.0, f64::max);
            assert!(off < 1e-11, "{parts} parts: {off:e} mm");
        }
    }
}

/// Every kind of number against central differences of exact values: weights of all layers, m, B, air
/// masses and the initial state.
#[test]
fn gradient_is_that_of_the_exact_value() {
    let mut model = common::perturbed();
    model.auxiliary_damping_kg_s = 700.0;
    let (times, force) = common::excitation(38.0, 3000);
    for interpolation in [Interpolation::Hold, Interpolation::Linear, Interpolation::Ramp] {
        let start = problem(&times, &force, interpolation, common::masses(29)[5]);
        let start = ExactProblem { y0: [0.4, -3.0], ..start };
        let value = |model: &common::Joint, problem: &ExactProblem<'_>| {
            let motion = common::motion(model);
            let result = ExactSolver::new().evaluate(&motion, &[*problem], &squares, false);
            assert!(result.failures.is_empty());
            result.value
        };
        let motion = common::motion(&model);
        let gradient = ExactSolver::new().value_and_gradient(&motion, &[start], &squares);
        assert_eq!(gradient.value, value(&model, &start));
        let weights = ParametricForce::parameters(&model.force);
        assert_eq!(gradient.network.len(), weights.len());
        let scale =
            weights.iter().zip(&gradient.network).map(|(w, g)| (w * g).abs()).fold(0.0, f64::max);
        let check = |name: String, exact: f64, at: f64, difference: &dyn Fn(f64) -> f64| {
            let h = 1e-6 * at.abs().max(1e-3);
            let fd = (difference(h) - difference(-h)) / (2.0 * h);
            let off = (exact - fd).abs() * at.abs().max(1e-3);
            let size = scale.max((exact * at).abs());
            assert!(off < 2e-7 * size, "{name}: {exact} {fd}, off by {:e}", off / size);
        };
        for i in (0..weights.len()).step_by(331).chain(weights.len() - 3..weights.len()) {
            check(format!("weight {i}"), gradient.network[i], weights[i], &|h| {
                let mut moved = weights.clone();
                moved[i] += h;
                let force = model.force.with_parameters(&moved);
                value(&model.map(|v| v, |_| force.clone()), &start)
            });
        }
        let with = |mass_kg: f64, damping: f64| {
            let mut motion = common::motion(&model);
            motion.mass_kg += mass_kg;
            motion.auxiliary_damping_kg_s += damping;
            ExactSolver::new().evaluate(&motion, &[start], &squares, false).value
        };
        check("m".into(), gradient.mass, motion.mass_kg, &|h| with(h, 0.0));
        check("B".into(), gradient.damping, 700.0, &|h| with(0.0, h));
        for i in 0..2 {
            let masses = [start.masses.flexor_g, start.masses.extensor_g];
            check(format!("air {i}"), gradient.masses[0][i], masses[i], &|h| {
                let mut m = masses;
                m[i] += h;
                let masses = SealedMasses { flexor_g: m[0], extensor_g: m[1] };
                value(&model, &ExactProblem { masses, ..start })
            });
            check(format!("start {i}"), gradient.initial_states[0][i], start.y0[i], &|h| {
                let mut y0 = start.y0;
                y0[i] += h;
                value(&model, &ExactProblem { y0, ..start })
            });
        }
    }
}

#[test]
fn gradient_is_the_limit_of_discrete_adjoints() {
    let model = common::perturbed();
    for interpolation in [Interpolation::Hold, Interpolation::Linear] {
        let [off, step] =
            distance_from_discrete_adjoint(&model, 2, 38.0, 1200, interpolation, 5e-4);
        assert!(off < 1e-9, "{off:e}");
        assert!(step < 1e-6, "the adjoint itself has not converged: {step:e}");
    }
}

#[test]
#[ignore = "minutes: whole recordings of 70 s"]
fn gradient_is_the_limit_of_discrete_adjoints_on_3_whole_recordings() {
    let model = common::perturbed();
    let [off, step] =
        distance_from_discrete_adjoint(&model, 3, 0.0, 70_000, Interpolation::Hold, 5e-4);
    assert!(off < 1e-6 && step < 1e-6, "{off:e} {step:e}");
}

#[test]
#[ignore = "many minutes: 29 recordings of 70 s"]
fn gradient_is_the_limit_of_discrete_adjoints_on_29_whole_recordings() {
    let model = common::perturbed();
    // The steps of 1 ms are converged: the other tests halve them.
    let [off, _] =
        distance_from_discrete_adjoint(&model, 29, 0.0, 70_000, Interpolation::Linear, 1e-3);
    assert!(off < 1e-6, "{off:e}");
}

/// The same bits at one thread and at three.
#[test]
fn results_do_not_depend_on_threads() {
    let motion = common::motion(&common::perturbed());
    let (times, force) = common::excitation(0.0, 1000);
    let problems: Vec<_> = common::masses(7)
        .into_iter()
        .map(|masses| problem(&times, &force, Interpolation::Hold, masses))
        .collect();
    let run = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let mut solver = ExactSolver::new();
            solver.value_and_gradient(&motion, &problems, &squares);
            // Again, in memory that holds other recordings' patterns.
            solver.value_and_gradient(&motion, &problems, &squares)
        })
    };
    assert_eq!(run(1), run(3));
}

/// Forward sensitivities and the gradient are two ways to the same number: the derivative of the sum of
/// squares along a direction of everything.
#[test]
fn sensitivities_and_gradient_agree() {
    let mut model = common::perturbed();
    model.auxiliary_damping_kg_s = 300.0;
    let motion = common::motion(&model);
    let (times, force) = common::excitation(41.0, 2500);
    for interpolation in [Interpolation::Hold, Interpolation::Ramp] {
        let problem = problem(&times, &force, interpolation, common::masses(29)[9]);
        let problem = ExactProblem { y0: [0.1, 2.0], ..problem };
        let mut solver = ExactSolver::new();
        let gradient = solver.value_and_gradient(&motion, &[problem], &squares);
        let states = solver.observed(0).to_vec();
        let len = motion.network.parameter_count();
        let directions = [
            ExactDirection {
                network: (0..len).map(|k| (0.1 * k as f64).sin()).collect(),
                ..ExactDirection::default()
            },
            ExactDirection {
                mass_kg: 1.0,
                damping_kg_s: -30.0,
                masses_g: [1e-4, 3e-4],
                start: [0.01, -0.2],
                ..ExactDirection::default()
            },
        ];
        let found = forward_sensitivities(&motion, &problem, &directions).unwrap();
        for (direction, tangents) in directions.iter().zip(&found) {
            let forward: f64 = states
                .as_chunks::<2>()
                .0
                .iter()
                .zip(tangents)
                .map(|(y, d)| 2.0 * (y[0] * d[0] + y[1] * d[1]))
                .sum();
            let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
            let backward = dot(&gradient.network, &direction.network)
                + gradient.mass * direction.mass_kg
                + gradient.damping * direction.damping_kg_s
                + dot(&gradient.masses[0], &direction.masses_g)
                + dot(&gradient.initial_states[0], &direction.start);
            assert!((forward - backward).abs() < 1e-9 * backward.abs(), "{forward} {backward}");
        }
    }
}
