//! Forward and reverse sweep allocate nothing per step: the number of allocations of a gradient does not
//! depend on its number of steps once the workspace is warm.

use pam_autodiff::{At, ByTape, Cotangent, DifferentiableField, Differentiation, Tangent};
use pam_core::{ParametricField, Scalar, VectorField};
use pam_solvers::sensitivity::{AdjointWorkspace, Checkpointing, DiscreteAdjoint, Problem};
use pam_solvers::{
    ConstantStep, Integrator, Interpolation, PidController, SampledInput, StepController, Tableau,
};

/// `ẍ = −k x − c ẋ + u`
struct Oscillator<S> {
    k: S,
    c: S,
}

impl<S: Scalar> VectorField<S> for Oscillator<S> {
    fn state_len(&self) -> usize {
        2
    }
    fn input_len(&self) -> usize {
        1
    }
    fn eval_into(&self, _t: f64, y: &[S], u: &[S], dy: &mut [S], _work: &mut [S]) {
        dy[0] = y[1];
        dy[1] = u[0] - self.k * y[0] - self.c * y[1];
    }
}

impl ParametricField for Oscillator<f64> {
    type With<S: Scalar> = Oscillator<S>;
    fn parameters(&self) -> Vec<f64> {
        vec![self.k, self.c]
    }
    fn with_parameters<S: Scalar>(&self, p: &[S]) -> Oscillator<S> {
        Oscillator { k: p[0], c: p[1] }
    }
}

/// Its derivatives by hand.
#[derive(Clone, Copy)]
struct ByHand;

impl Differentiation<Oscillator<f64>> for ByHand {
    type Field<'a> = Slopes<'a>;
    fn name(&self) -> &'static str {
        "by hand"
    }
    fn of<'a>(&'a self, field: &'a Oscillator<f64>) -> Slopes<'a> {
        Slopes(field)
    }
}

struct Slopes<'a>(&'a Oscillator<f64>);

impl DifferentiableField for Slopes<'_> {
    type Workspace = ();
    fn state_len(&self) -> usize {
        2
    }
    fn input_len(&self) -> usize {
        1
    }
    fn parameter_len(&self) -> usize {
        2
    }
    fn workspace(&self) {}
    fn eval_into(&self, at: At<'_>, dy: &mut [f64], _work: &mut ()) {
        self.0.eval_into(at.t, at.y, at.u, dy, &mut []);
    }
    fn vjp_into(&self, at: At<'_>, w: &[f64], sums: Cotangent<'_>, _work: &mut ()) {
        sums.y[0] -= self.0.k * w[1];
        sums.y[1] += w[0] - self.0.c * w[1];
        sums.u[0] += w[1];
        sums.p[0] -= at.y[0] * w[1];
        sums.p[1] -= at.y[1] * w[1];
    }
    fn jvp_into(&self, at: At<'_>, v: Tangent<'_>, dy: &mut [f64], _work: &mut ()) {
        dy[0] = v.y[1];
        dy[1] = v.u[0] - self.0.k * v.y[0] - self.0.c * v.y[1];
        dy[1] -= v.p[0] * at.y[0] + v.p[1] * at.y[1];
    }
}

#[test]
fn a_step_and_its_adjoint_do_not_allocate() {
    check(ByHand);
    check(ByTape);
}

fn check<D: Differentiation<Oscillator<f64>> + Copy>(differentiation: D) {
    let field = Oscillator { k: 30.0, c: 0.5 };
    let times: Vec<f64> = (0..40).map(|k| f64::from(k) * 0.05).collect();
    let values: Vec<f64> = times.iter().map(|t| (9.0 * t).sin()).collect();
    let observations: Vec<f64> = (0..50).map(|k| f64::from(k) * 0.04).collect();
    let coarse = Integrator::new(Tableau::tsit5(), ConstantStep::new(0.05));
    let fine = Integrator::new(Tableau::tsit5(), ConstantStep::new(0.001));
    let loose = Integrator::new(Tableau::tsit5(), PidController::new(1e-3, 1e-3));
    let tight = Integrator::new(Tableau::tsit5(), PidController::new(1e-11, 1e-11));
    for interpolation in [Interpolation::Hold, Interpolation::Cubic] {
        let input = SampledInput::new(&times, &values, interpolation).unwrap();
        for checkpointing in [
            Checkpointing::AllSave,
            Checkpointing::Interval(9),
            Checkpointing::Binomial { snapshots: 6 },
        ] {
            let adjoint = DiscreteAdjoint::new(differentiation).with_checkpointing(checkpointing);
            let mut workspace = AdjointWorkspace::new();
            let mut allocations = |integrator: &Integrator<dyn StepController>| {
                let problem = Problem {
                    field: &field,
                    input: &input,
                    t0: 0.0,
                    t1: 2.0,
                    y0: &[1.0, 0.0],
                    observations_s: &observations,
                    integrator,
                };
                let mut loss = |_: &[f64], y: &[f64], w: &mut [f64]| {
                    w.copy_from_slice(y);
                    y.iter().map(|y| 0.5 * y * y).sum()
                };
                let before = crate::count();
                let gradient = adjoint.value_and_gradient_with(&problem, &mut loss, &mut workspace);
                let count = crate::count() - before;
                (count, gradient.unwrap().statistics.steps)
            };
            for [few, many] in
                [[&coarse as &Integrator<dyn StepController>, &fine], [&loose, &tight]]
            {
                let _warm_up = allocations(many);
                let ((short, few), (long, many)) = (allocations(few), allocations(many));
                assert!(many > 2 * few, "{many} steps against {few}");
                assert!(short > 0, "the counter counts");
                assert_eq!(
                    short,
                    long,
                    "{checkpointing:?}, {interpolation:?}, {}",
                    differentiation.name()
                );
            }
        }
    }
}
