//! Continuous adjoints converge to the discrete one as tolerances shrink.

use crate::case::{brief, gradients_apart, loss};
use crate::fields::{Linear, VanDerPol, tanh_joint};
use crate::inputs::Sine;
use pam_autodiff::ByTape;
use pam_core::{ParametricField, SealedMasses};
use pam_solvers::sensitivity::{
    Backsolve, DiscreteAdjoint, GradientMethod, InterpolatingAdjoint, Problem, QuadratureAdjoint,
};
use pam_solvers::{
    Integrator, Interpolation, NoInput, ParametricInput, PidController, SampledInput, Tableau,
};

const OBSERVATIONS: [f64; 6] = [0.0, 0.21, 0.3, 0.75, 1.234, 1.5];

fn tsit5(tolerance: f64) -> Integrator<PidController> {
    Integrator::new(Tableau::tsit5(), PidController::new(tolerance, tolerance))
}

fn differences<F: ParametricField, I: ParametricInput>(
    (field, input): (&F, &I),
    y0: &[f64],
    scales: &[f64],
    (tolerance, observations_s): (f64, &[f64]),
) -> Vec<(String, f64)> {
    // Steps end at samples, so that the quadrature meets no kink of a linear input inside one.
    let stops: Vec<f64> = (0..11).map(|k| f64::from(k) * 0.15).collect();
    let integrator = tsit5(tolerance).with_stops(&stops);
    let problem =
        Problem { field, input, t0: 0.0, t1: 1.5, y0, observations_s, integrator: &integrator };
    let discrete = DiscreteAdjoint::new(ByTape);
    let truth = discrete.value_and_gradient(&problem, &mut loss(scales)).unwrap();
    let mut free = Backsolve::new(ByTape, tsit5(tolerance));
    free.restart_at_observations = false;
    let methods: [Box<dyn GradientMethod<F, I>>; 4] = [
        Box::new(Backsolve::new(ByTape, tsit5(tolerance))),
        Box::new(free),
        Box::new(InterpolatingAdjoint::new(ByTape, tsit5(tolerance))),
        Box::new(QuadratureAdjoint::new(ByTape, tsit5(tolerance))),
    ];
    let one = |method: &dyn GradientMethod<F, I>| {
        let gradient = method.value_and_gradient(&problem, &mut loss(scales)).unwrap();
        assert_eq!(gradient.value, truth.value, "the same forward solve");
        assert_eq!(gradient.states, truth.states);
        assert!(gradient.statistics.backward_steps > 0 && gradient.statistics.vjps > 0);
        (method.name(), gradients_apart(&problem, &gradient, &truth))
    };
    methods.iter().map(|m| one(&**m)).collect()
}

fn converge<F: ParametricField, I: ParametricInput>(
    name: &str,
    parts: (&F, &I),
    y0: &[f64],
    scales: &[f64],
    tolerances: [f64; 3],
    bound: f64,
) {
    for observations in [&OBSERVATIONS[..], &[1.1][..]] {
        let tables = tolerances.map(|t| differences(parts, y0, scales, (t, observations)));
        for i in 0..tables[0].len() {
            let off: Vec<f64> = tables.iter().map(|t| t[i].1).collect();
            println!("{name}, {}: {} at {tolerances:?}", tables[0][i].0, brief(&off));
            assert!(off[2] < bound, "{name}, {}: {off:?}", tables[0][i].0);
            assert!(off[2] < 0.1 * off[0], "{name}, {}: {off:?}", tables[0][i].0);
        }
    }
}

#[test]
fn continuous_adjoints_converge_to_the_discrete_one() {
    let tolerances = [1e-5, 1e-7, 1e-9];
    let (y0, scales) = ([1.2, -0.4], [1.0, 2.0]);
    let van_der_pol = |inputs| VanDerPol { mu: 1.5, inputs };
    converge("van der pol", (&van_der_pol(0), &NoInput), &y0, &scales, tolerances, 1e-6);
    let sine = Sine { amplitude: 0.8, frequency: 5.0, phase: 0.3 };
    converge("van der pol, sine", (&van_der_pol(1), &sine), &y0, &scales, tolerances, 1e-6);
    let times: Vec<f64> = (0..11).map(|k| f64::from(k) * 0.15).collect();
    let values: Vec<f64> = (0..22).map(|k| (1.7 * f64::from(k)).sin()).collect();
    for interpolation in [Interpolation::Hold, Interpolation::Linear] {
        let input = SampledInput::with_variables(&times, &values, 2, interpolation).unwrap();
        let name = format!("linear, {}", interpolation.name());
        converge(&name, (&Linear::with_inputs(2), &input), &y0, &scales, tolerances, 1e-6);
    }

    let model = tanh_joint();
    let masses = SealedMasses::new(0.06, 0.07).unwrap();
    let [pf, pe] = model.gas_law_pressures_kpa(0.3, masses);
    let forces: Vec<f64> = values[..11].iter().map(|v| 1.2e5 * v).collect();
    let input = SampledInput::new(&times, &forces, Interpolation::Hold).unwrap();
    let (y0, scales) = ([0.3, 2.0, pf, pe], [1.0, 10.0, 100.0, 100.0]);
    let joint = model.sealed(masses);
    converge("tanh joint, held", (&joint, &input), &y0, &scales, tolerances, 1e-5);
}
