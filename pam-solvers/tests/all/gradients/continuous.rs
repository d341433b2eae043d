//! Continuous adjoints converge to the discrete one as tolerances shrink.

use super::case::{brief, gradients_apart, loss};
use super::fields::{AnyField, Linear, VanDerPol, owned, tanh_joint};
use super::inputs::{AnyInput, Sine};
use pam_autodiff::{ByDual, ByTape};
use pam_core::{NamedChoice, SealedMasses};
use pam_solvers::sensitivity::{
    Backsolve, DiscreteAdjoint, GradientMethod, InterpolatingAdjoint, Problem, QuadratureAdjoint,
};
use pam_solvers::{Integrator, Interpolation, NoInput, PidController, SampledInput, Tableau};

const TOLERANCES: [f64; 3] = [1e-5, 1e-7, 1e-9];
const OBSERVATIONS: [f64; 6] = [0.0, 0.21, 0.3, 0.75, 1.234, 1.5];

fn tsit5(tolerance: f64) -> Integrator<PidController> {
    Integrator::new(Tableau::tsit5(), PidController::new(tolerance, tolerance))
}

/// A continuous adjoint with a backward tolerance.
type Make<'a> = fn(f64) -> Box<dyn GradientMethod<AnyField<f64>, AnyInput<'a, f64>>>;

fn backsolves<'a>() -> [Make<'a>; 2] {
    [
        |tolerance| Box::new(Backsolve::new(ByTape).with_backward(tsit5(tolerance))),
        |tolerance| {
            let mut free = Backsolve::new(ByTape).with_backward(tsit5(tolerance));
            free.restart_at_observations = false;
            Box::new(free)
        },
    ]
}

fn others<'a>() -> [Make<'a>; 2] {
    [
        |tolerance| Box::new(InterpolatingAdjoint::new(ByTape).with_backward(tsit5(tolerance))),
        |tolerance| Box::new(QuadratureAdjoint::new(ByDual).with_backward(tsit5(tolerance))),
    ]
}

fn all<'a>() -> Vec<Make<'a>> {
    [backsolves(), others()].concat()
}

fn difference<'a>(
    method: Make<'a>,
    (field, input): (&AnyField<f64>, &AnyInput<'a, f64>),
    y0: &[f64],
    scales: &[f64],
    (tolerance, observations_s): (f64, &[f64]),
) -> f64 {
    // Steps end at samples, so that the quadrature meets no kink of a linear input inside one.
    let stops: Vec<f64> = (0..11).map(|k| f64::from(k) * 0.15).collect();
    let integrator = tsit5(tolerance).with_stops(&stops);
    let problem =
        Problem { field, input, t0: 0.0, t1: 1.5, y0, observations_s, integrator: &integrator };
    let discrete = DiscreteAdjoint::new(ByTape);
    let truth = discrete.value_and_gradient(&problem, &mut loss(scales)).unwrap();
    let gradient = method(tolerance).value_and_gradient(&problem, &mut loss(scales)).unwrap();
    assert_eq!(gradient.value, truth.value, "the same forward solve");
    assert_eq!(gradient.states, truth.states);
    assert!(gradient.statistics.backward_steps > 0 && gradient.statistics.vjps > 0);
    gradients_apart(&problem, &gradient, &truth)
}

fn converge<'a>(
    name: &str,
    parts: (&AnyField<f64>, &AnyInput<'a, f64>),
    (y0, scales): (&[f64], &[f64]),
    methods: &[Make<'a>],
    bound: f64,
) {
    for observations in [&OBSERVATIONS[..], &[1.1][..]] {
        for &method in methods {
            let off = TOLERANCES.map(|t| difference(method, parts, y0, scales, (t, observations)));
            let name = format!("{name}, {}", method(1.0).name());
            println!("{name}: {} at {TOLERANCES:?}", brief(&off));
            assert!(off[2] < bound, "{name}: {off:?}");
            assert!(off[2] < 0.1 * off[0], "{name}: {off:?}");
        }
    }
}

#[test]
fn continuous_adjoints_converge_to_the_discrete_one() {
    let of = (&[1.2, -0.4][..], &[1.0, 2.0][..]);
    let van_der_pol = |inputs| AnyField::from(VanDerPol { mu: 1.5, inputs });
    converge("van der pol", (&van_der_pol(0), &AnyInput::None(NoInput)), of, &all(), 1e-6);
    let sine = AnyInput::Sine(Sine { amplitude: 0.8, frequency: 5.0, phase: 0.3 });
    converge("van der pol, sine", (&van_der_pol(1), &sine), of, &all(), 1e-6);
    let times: Vec<f64> = (0..11).map(|k| f64::from(k) * 0.15).collect();
    let values: Vec<f64> = (0..22).map(|k| (1.7 * f64::from(k)).sin()).collect();
    for interpolation in [Interpolation::Hold, Interpolation::Linear] {
        let input = SampledInput::with_variables(&times, &values, 2, interpolation).unwrap();
        let input = AnyInput::Sampled(input);
        let name = format!("linear, {}", interpolation.name());
        let field = AnyField::from(Linear::with_inputs(2));
        converge(&name, (&field, &input), of, &all(), 1e-6);
    }
}

/// Run by `cargo test --release --workspace --tests -- --ignored long::`.
mod long {
    use super::*;

    /// The joint's damping makes it stiff enough that the state cannot be integrated back.
    #[test]
    #[ignore = "long"]
    fn on_the_joint_adjoints_converge_except_the_backsolve() {
        let model = tanh_joint();
        let masses = SealedMasses::new(0.06, 0.07).unwrap();
        let [pf, pe] = model.gas_law_pressures_kpa(0.3, masses);
        let times: Vec<f64> = (0..11).map(|k| f64::from(k) * 0.15).collect();
        let forces: Vec<f64> = (0..11).map(|k| 1.2e5 * (1.7 * f64::from(k)).sin()).collect();
        let input = SampledInput::new(&times, &forces, Interpolation::Hold).unwrap();
        let input = AnyInput::Sampled(input);
        let (y0, scales) = ([0.3, 2.0, pf, pe], [1.0, 10.0, 100.0, 100.0]);
        let joint = owned(&model.sealed(masses));
        converge("tanh joint, held", (&joint, &input), (&y0, &scales), &others(), 1e-5);

        let integrator = tsit5(1e-7);
        let problem = Problem {
            field: &joint,
            input: &input,
            t0: 0.0,
            t1: 1.5,
            y0: &y0,
            observations_s: &[1.5],
            integrator: &integrator,
        };
        let backsolve = Backsolve::new(ByTape).with_backward(tsit5(1e-7).with_max_steps(100_000));
        match backsolve.value_and_gradient(&problem, &mut loss(&scales)) {
            Err(e) => println!("tanh joint, backsolve: {e}"),
            Ok(wrong) => {
                let discrete = DiscreteAdjoint::new(ByTape);
                let right = discrete.value_and_gradient(&problem, &mut loss(&scales)).unwrap();
                let off = gradients_apart(&problem, &wrong, &right);
                println!("tanh joint, backsolve: off by {off:e}");
                assert!(off > 0.1);
            }
        }
    }
}
