//! Every method on every problem.

use super::case::check;
use super::fields::{AnyField, Linear, VanDerPol, WithCreep, leaky_relu_joint, owned, tanh_joint};
use super::inputs::{AnyInput, Sine};
use pam_core::{JointModel, NamedChoice, NetworkForce, ParametricField, SealedMasses};
use pam_solvers::sensitivity::Problem;
use pam_solvers::{
    Constant, ConstantStep, InputFn, Integrator, Interpolation, NoInput, ParametricInput,
    PidController, SampledInput, StepController, Tableau,
};

const T1: f64 = 1.5;

/// Times at the ends, between steps and on jumps of the samples below.
const SPARSE: [f64; 3] = [0.75, 0.9, T1];
const OBSERVATIONS: [f64; 9] = [0.0, 0.011, 0.2, 0.21, 0.3, 0.75, 0.9, 1.234, T1];
/// Step ends only, for the cells without dense output: these are stops.
const ENDS: [f64; 2] = [0.75, T1];

fn sample_times() -> Vec<f64> {
    (0..11).map(|k| f64::from(k) * 0.15).collect()
}

fn samples(amplitudes: &[f64]) -> Vec<f64> {
    let at = |k: usize, i: usize| (1.7 * k as f64 + i as f64 + 0.4).sin();
    (0..11).flat_map(|k| amplitudes.iter().enumerate().map(move |(i, a)| a * at(k, i))).collect()
}

fn integrators(
    names: &[&str],
    (step_s, tolerance): (f64, f64),
) -> Vec<(String, Box<Integrator<dyn StepController>>)> {
    let mut all: Vec<(String, Box<Integrator<dyn StepController>>)> = Vec::new();
    for name in names {
        let tableau = Tableau::from_name(name).unwrap();
        let constant = Integrator::new(tableau.clone(), ConstantStep::new(step_s));
        all.push((format!("{name} constant"), Box::new(constant.with_stops(&[0.75]))));
        if tableau.error.is_some() {
            let adaptive = Integrator::new(tableau, PidController::new(tolerance, tolerance));
            all.push((format!("{name} adaptive"), Box::new(adaptive.with_stops(&[0.75]))));
        }
    }
    all
}

/// The named methods, with constant and adaptive steps, and all sets of observations.
fn cells<I: ParametricInput>(
    name: &str,
    (field, input): (&AnyField<f64>, &I),
    y0: &[f64],
    scales: &[f64],
    (names, steps): (&[&str], (f64, f64)),
) {
    let all = [("dense", &OBSERVATIONS[..]), ("ends", &ENDS[..]), ("sparse", &SPARSE[..])];
    // Three hundred directions take their time; step ends and dense output are the cells that matter.
    let observations = if field.parameter_len() < 20 { &all[..] } else { &all[..2] };
    for (integrator_name, integrator) in integrators(names, steps) {
        for &(kind, observations_s) in observations {
            let problem = Problem {
                field,
                input,
                t0: 0.0,
                t1: T1,
                y0,
                observations_s,
                integrator: &*integrator,
            };
            check(&format!("{name}, {integrator_name}, {kind}"), &problem, scales);
        }
    }
}

/// A field that takes any number of inputs, without input and with all kinds of them.
fn any_input(name: &str, field: impl Fn(usize) -> AnyField<f64>) {
    let (y0, scales, steps) = (&[1.2, -0.4][..], &[1.0, 2.0][..], (Tableau::NAMES, (0.043, 1e-5)));
    cells(&format!("{name}, no input"), (&field(0), &AnyInput::None(NoInput)), y0, scales, steps);
    let times = sample_times();
    let (one, three) = (samples(&[1.0]), samples(&[0.5, 0.3, 0.2]));
    for interpolation in [Interpolation::Hold, Interpolation::Linear, Interpolation::Cubic] {
        let input = AnyInput::Sampled(SampledInput::new(&times, &one, interpolation).unwrap());
        let name = format!("{name}, {}", interpolation.name());
        cells(&name, (&field(1), &input), y0, scales, steps);
    }
    let input = SampledInput::with_variables(&times, &three, 3, Interpolation::Hold).unwrap();
    let input = AnyInput::Sampled(input);
    cells(&format!("{name}, three holds"), (&field(3), &input), y0, scales, steps);
    let sine = AnyInput::Sine(Sine { amplitude: 0.8, frequency: 5.0, phase: 0.3 });
    cells(&format!("{name}, sine"), (&field(1), &sine), y0, scales, steps);
    let constant = AnyInput::Constant(Constant(vec![0.4, -0.9]));
    cells(&format!("{name}, constant"), (&field(2), &constant), y0, scales, steps);
}

#[test]
fn a_closure_as_input() {
    let closure = InputFn::new(1, |t: f64, u: &mut [f64]| u[0] = (4.0 * t).cos());
    let field = AnyField::from(VanDerPol { mu: 2.5, inputs: 1 });
    let steps = (Tableau::NAMES, (0.043, 1e-5));
    cells("van der pol, closure", (&field, &closure), &[1.2, -0.4], &[1.0, 2.0], steps);
}

#[test]
fn linear() {
    any_input("linear", |inputs| Linear::with_inputs(inputs).into());
}

#[test]
fn van_der_pol() {
    any_input("van der pol", |inputs| VanDerPol { mu: 2.5, inputs }.into());
}

#[test]
fn a_further_state() {
    let field = Box::new(VanDerPol { mu: 1.5, inputs: 1 }.into());
    let field = AnyField::from(WithCreep { field, rate: 0.7, coupling: -0.4 });
    let times = sample_times();
    let values = samples(&[1.0]);
    let input = SampledInput::new(&times, &values, Interpolation::Hold).unwrap();
    let input = AnyInput::Sampled(input);
    let (y0, scales) = ([1.2, -0.4, 0.1], [1.0, 2.0, 0.5]);
    cells(
        "van der pol with creep, held",
        (&field, &input),
        &y0,
        &scales,
        (Tableau::NAMES, (0.043, 1e-5)),
    );
}

/// The joint, with valves closed and open, alone and with a creep state, with held and smooth input.
fn joint(name: &str, model: &JointModel<f64, NetworkForce<f64>>) {
    let masses = SealedMasses::new(0.06, 0.07).unwrap();
    let [pf, pe] = model.gas_law_pressures_kpa(0.3, masses);
    let steps = (&["tsit5"][..], (0.05, 1e-5));
    let times = sample_times();
    let forces = samples(&[1.2e5]);
    let held = AnyInput::Sampled(SampledInput::new(&times, &forces, Interpolation::Hold).unwrap());
    let sine = AnyInput::Sine(Sine { amplitude: 1.2e5, frequency: 7.0, phase: 0.3 });
    let (y0, scales) = ([0.3, 2.0, pf, pe], [1.0, 10.0, 100.0, 100.0]);
    let sealed = owned(&model.sealed(masses));
    let name = |what: &str| format!("{name}, {what}");
    cells(&name("sealed, held"), (&sealed, &held), &y0, &scales, steps);
    cells(&name("sealed, sine"), (&sealed, &sine), &y0, &scales, steps);
    let steady = AnyInput::Constant(Constant(vec![3e4]));
    cells(&name("sealed, constant"), (&sealed, &steady), &y0, &scales, steps);

    let flows = samples(&[1.2e5, 0.01, 0.008]);
    let valves = SampledInput::with_variables(&times, &flows, 3, Interpolation::Hold).unwrap();
    let valves = AnyInput::Sampled(valves);
    let (y0, scales) = ([0.3, 2.0, pf, pe, 0.06, 0.07], [1.0, 10.0, 100.0, 100.0, 0.02, 0.02]);
    let open = owned(&model.with_open_valves());
    cells(&name("open valves, held flows"), (&open, &valves), &y0, &scales, steps);

    let creep = AnyField::from(WithCreep { field: Box::new(open), rate: 0.8, coupling: -50.0 });
    let y0 = [&y0[..], &[0.1]].concat();
    let scales = [&scales[..], &[0.5]].concat();
    cells(&name("open valves and creep"), (&creep, &valves), &y0, &scales, steps);
}

#[test]
fn joint_with_leaky_relu() {
    joint("leaky relu joint", &leaky_relu_joint());
}

/// Run by `cargo test --release --workspace --tests -- --ignored long::`.
mod long {
    use super::*;

    #[test]
    #[ignore = "long"]
    fn joint_with_tanh() {
        joint("tanh joint", &tanh_joint());
    }
}
