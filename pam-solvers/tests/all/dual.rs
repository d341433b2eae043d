//! The same field and solver with dual numbers: exact derivatives of the solution, and the same
//! steps.

use num_dual::Dual64;
use pam_core::{JointModel, PhysicalParameters, Scalar, SealedMasses, SpringDamper};
use pam_solvers::{
    Constant, Input, Integrator, Interpolation, PidController, SampledInput, SaveAt, Solution,
    Tableau, Term,
};

const DAMPING: f64 = 6500.0;
const FORCE: f64 = 80e3;

fn solve<S: Scalar, I: Input<S>>(stiffness: S, input: I, t1: f64) -> Solution<S> {
    let force = SpringDamper::constant(stiffness, S::constant(DAMPING));
    let model = JointModel::datasheet(force);
    let masses = SealedMasses { flexor_g: S::constant(0.06), extensor_g: S::constant(0.07) };
    let [pf, pe] = model.gas_law_pressures_kpa(S::zero(), masses);
    Integrator::new(Tableau::tsit5(), PidController::new(1e-9, 1e-9))
        .solve(
            &Term::new(model.sealed(masses), input),
            0.0,
            t1,
            &[S::zero(), S::zero(), pf, pe],
            SaveAt::Steps,
        )
        .unwrap()
}

/// Step response `x = F/K (1 − e^{−δt} (cos ωt + δ/ω sin ωt))`, any number type.
fn step_response<S: Scalar>(k: S, t: f64) -> S {
    let mass = PhysicalParameters::datasheet().mass_kg;
    let decay = DAMPING / (2.0 * mass);
    let omega = (k.scaled(1.0 / mass) - S::constant(decay * decay)).sqrt();
    let (sin, cos) = omega.scaled(t).sin_cos();
    let ring = (cos + sin * omega.recip().scaled(decay)).scaled((-decay * t).exp());
    (S::constant(1.0) - ring) * k.recip().scaled(FORCE)
}

#[test]
fn the_derivative_by_the_stiffness_is_the_analytic_one() {
    let k = Dual64::new(150e3, 1.0);
    for t in [0.05, 0.2, 0.7] {
        let s = solve(k, Constant(vec![Dual64::constant(FORCE)]), t);
        let (x, exact) = (s.last().unwrap()[0], step_response(k, t));
        assert!((x.re - exact.re).abs() < 1e-8);
        assert!((x.eps / exact.eps - 1.0).abs() < 1e-6, "{} and {}", x.eps, exact.eps);
    }
}

/// The controller looks at real parts, so derivatives do not change the steps. (Dual numbers divide by
/// multiplying with a reciprocal: real parts agree to rounding, not to the bit.)
#[test]
fn dual_and_plain_runs_take_the_same_steps() {
    let times: Vec<f64> = (0..500).map(|k| f64::from(k) * 2e-3).collect();
    let values: Vec<f64> = times.iter().map(|t| FORCE * (20.0 * t).sin()).collect();
    let lifted: Vec<Dual64> = values.iter().map(|&v| Dual64::constant(v)).collect();
    let plain = SampledInput::new(&times, &values, Interpolation::Hold).unwrap();
    let dual = SampledInput::new(&times, &lifted, Interpolation::Hold).unwrap();
    let a = solve(150e3, plain, 0.99);
    let b = solve(Dual64::new(150e3, 1.0), dual, 0.99);
    assert_eq!(a.statistics, b.statistics);
    let apart = a.times_s().iter().zip(b.times_s()).map(|(s, t)| (s - t).abs()).fold(0.0, f64::max);
    assert!(apart < 1e-9, "steps end up to {apart:e} s apart");
}
