//! One cell of the gradient matrix: every method against every other.

use super::fields::AnyField;
use super::one_by_one::OneByOne;
use num_dual::Dual64;
use pam_autodiff::{ByDual, ByTape, Central};
use pam_core::ParametricField;
use pam_solvers::sensitivity::{
    Checkpointing, DiscreteAdjoint, DualThroughSolver, FiniteDifference, ForwardSensitivity,
    Gradient, GradientMethod, Problem, TapeThroughSolver,
};
use pam_solvers::{ParametricInput, SaveAt, Term, replay};

/// A loss without symmetry: each state in its own scale, each observation with its own weight.
pub(crate) fn loss(scales: &[f64]) -> impl FnMut(&[f64], &[f64], &mut [f64]) -> f64 + '_ {
    |times: &[f64], states: &[f64], cotangents: &mut [f64]| {
        let (n, mut value) = (scales.len(), 0.0);
        for (o, t) in times.iter().enumerate() {
            let weight = 1.0 + 0.5 * (3.0 * t).sin();
            for (i, scale) in scales.iter().enumerate() {
                let z = states[o * n + i] / scale;
                value += weight * (0.5 * z * z + (z + i as f64).sin());
                cotangents[o * n + i] = weight * (z + (z + i as f64).cos()) / scale;
            }
        }
        value
    }
}

/// Numbers for a test's output.
pub(crate) fn brief(numbers: &[f64]) -> String {
    numbers.iter().map(|x| format!("{x:.1e} ")).collect()
}

/// `‖a − b‖ / ‖b‖`.
pub(crate) fn apart(a: &[f64], b: &[f64]) -> f64 {
    assert_eq!(a.len(), b.len());
    let norm = |v: &mut dyn Iterator<Item = f64>| v.map(|x| x * x).sum::<f64>().sqrt();
    let size = norm(&mut b.iter().copied());
    let difference = norm(&mut a.iter().zip(b).map(|(a, b)| a - b));
    if difference == 0.0 { 0.0 } else { difference / size }
}

/// The largest relative difference of two gradients over their blocks, of the plain gradient and of that
/// with respect to logarithms, in which large and small parameters weigh alike.
pub(crate) fn gradients_apart<I: ParametricInput>(
    problem: &Problem<'_, AnyField<f64>, I>,
    a: &Gradient,
    b: &Gradient,
) -> f64 {
    let scaled =
        |g: &[f64], x: &[f64]| -> Vec<f64> { g.iter().zip(x).map(|(g, x)| g * x).collect() };
    let block =
        |a: &[f64], b: &[f64], x: &[f64]| apart(a, b).max(apart(&scaled(a, x), &scaled(b, x)));
    block(&a.parameters, &b.parameters, &problem.field.parameters())
        .max(block(&a.initial_state, &b.initial_state, problem.y0))
        .max(block(&a.input, &b.input, &problem.input.parameters()))
}

/// The replayed solve differentiated by one dual number after the other.
pub(crate) fn reference<I: ParametricInput>(
    problem: &Problem<'_, AnyField<f64>, I>,
    of: &Gradient,
    scales: &[f64],
) -> Gradient {
    let (p, q) = (problem.field.parameters(), problem.input.parameters());
    let all: Vec<f64> = [&p[..], problem.y0, &q[..]].concat();
    let n = problem.y0.len();
    let mut cotangents = vec![0.0; of.states.len()];
    let value = loss(scales)(problem.observations_s, &of.states, &mut cotangents);
    let mut sums = Vec::new();
    for k in 0..all.len() {
        let numbers: Vec<Dual64> = all
            .iter()
            .enumerate()
            .map(|(i, &x)| Dual64::new(x, if i == k { 1.0 } else { 0.0 }))
            .collect();
        let field = problem.field.with_parameters(&numbers[..p.len()]);
        let input = problem.input.with_parameters(&numbers[p.len() + n..]);
        let y0 = &numbers[p.len()..p.len() + n];
        let save_at = SaveAt::Times(problem.observations_s);
        let tableau = problem.integrator.tableau();
        let solution = replay(tableau, &Term::new(field, input), &of.grid, y0, save_at).unwrap();
        sums.push(solution.states().iter().zip(&cotangents).map(|(y, w)| y.eps * w).sum());
    }
    let input = sums.split_off(p.len() + n);
    let initial_state = sums.split_off(p.len());
    Gradient { value, parameters: sums, initial_state, input, ..of.clone() }
}

/// Checks all exact methods against dual numbers through the solver, and differences against them.
/// Prints the worst relative difference of both kinds.
pub(crate) fn check<I: ParametricInput>(
    name: &str,
    problem: &Problem<'_, AnyField<f64>, I>,
    scales: &[f64],
) {
    let gradient = |method: &dyn GradientMethod<AnyField<f64>, I>| {
        method.value_and_gradient(problem, &mut loss(scales)).unwrap()
    };
    let adjoint = DiscreteAdjoint::new(ByTape);
    let all_save = gradient(&adjoint);
    for checkpointing in [
        Checkpointing::Interval(1),
        Checkpointing::Interval(7),
        Checkpointing::Binomial { snapshots: 1 },
        Checkpointing::Binomial { snapshots: 4 },
        Checkpointing::Binomial { snapshots: 1000 },
    ] {
        let other = gradient(&adjoint.with_checkpointing(checkpointing));
        assert_eq!(other.parameters, all_save.parameters, "{name}, {checkpointing:?}");
        assert_eq!(other.initial_state, all_save.initial_state, "{name}, {checkpointing:?}");
        assert_eq!(other.input, all_save.input, "{name}, {checkpointing:?}");
        assert_eq!(other.states, all_save.states);
    }
    let truth = gradient(&DualThroughSolver);
    let mut worst = gradients_apart(problem, &all_save, &truth);
    let mut compare = |method: &str, other: &Gradient| {
        assert_eq!((other.value, &other.grid), (truth.value, &truth.grid), "{name}, {method}");
        let off = gradients_apart(problem, other, &truth);
        assert!(off < 1e-12, "{name}, {method}: {off:e}");
        worst = worst.max(off);
    };
    let methods: [&dyn GradientMethod<AnyField<f64>, I>; 4] = [
        &DiscreteAdjoint::new(ByDual),
        &ForwardSensitivity::new(ByTape),
        &ForwardSensitivity::new(ByDual),
        &TapeThroughSolver,
    ];
    compare("discrete adjoint by tape", &all_save);
    for method in methods {
        compare(&method.name(), &gradient(method));
    }
    if problem.field.parameter_len() < 20 {
        // The slow ways, that share no code with any of the above.
        compare("one by one", &gradient(&DiscreteAdjoint::new(OneByOne)));
        compare("replays one by one", &reference(problem, &all_save, scales));
    }
    // The best step lies between truncation and rounding, and a difference across a kink of the network
    // is none of its derivatives; so there are three to choose from.
    let mut off = f64::INFINITY;
    for h in [1e-5, 2e-6, 5e-5] {
        if off > 3e-8 {
            let differences = FiniteDifference::new(Central { h }).with_floors([1e-3, 1e-2, 1e-3]);
            off = off.min(gradients_apart(problem, &gradient(&differences), &truth));
        }
    }
    println!("{name:60} {:4} steps  {worst:.1e}  {off:.1e}", all_save.statistics.steps);
    assert!(off < 1e-7, "{name}: differences {off:e}");
}
