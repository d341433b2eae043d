//! The methods that are compared.

use super::solver::Solver;
use pam_autodiff::{ByDual, ByHand, ByTape, Differentiation};
use pam_core::{JointField, NetworkForce, ParametricField};
use pam_solvers::ParametricInput;
use pam_solvers::sensitivity::{
    Backsolve, Checkpointing, DiscreteAdjoint, DualThroughSolver, FiniteDifference,
    ForwardSensitivity, GradientMethod, InterpolatingAdjoint, QuadratureAdjoint, TapeThroughSolver,
};
use serde::{Deserialize, Serialize};

/// The gradient that a method is expected to return.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Kind {
    /// The gradient of the steps taken, to rounding.
    Exact,
    /// The gradient of the steps taken, to the rounding of single precision.
    SinglePrecision,
    /// The gradient of the exact solution, to tolerances.
    Continuous,
    /// The gradient of the steps taken, to the error of a difference.
    Difference,
    /// No gradient, the solve alone.
    Value,
}

type Boxed<F, I> = Box<dyn GradientMethod<F, I>>;
type Build<F, I> = Box<dyn Fn(&Solver) -> Boxed<F, I>>;

/// A method with one differentiation of the field.
pub struct Method<F, I> {
    /// Name, by which it is chosen.
    pub name: String,
    /// How the field is differentiated.
    pub differentiation: String,
    /// The gradient that it is expected to return.
    pub kind: Kind,
    build: Build<F, I>,
}

impl<F, I> Method<F, I> {
    /// A method that is built for a solver; a continuous adjoint takes its backward solve from it.
    pub fn new(
        name: &str,
        differentiation: &str,
        kind: Kind,
        build: impl Fn(&Solver) -> Box<dyn GradientMethod<F, I>> + 'static,
    ) -> Self {
        Self {
            name: name.into(),
            differentiation: differentiation.into(),
            kind,
            build: Box::new(build),
        }
    }

    /// The method for one solver.
    #[must_use]
    pub fn build(&self, solver: &Solver) -> Box<dyn GradientMethod<F, I>> {
        (self.build)(solver)
    }
}

/// Snapshots of the binomial checkpointing on the list, and its interval.
const SNAPSHOTS: usize = 8;
const INTERVAL: usize = 16;

/// Every method with every differentiation of the field.
#[must_use]
pub fn all<F, I>() -> Vec<Method<F, I>>
where
    F: ParametricField + 'static,
    I: ParametricInput + 'static,
{
    let mut methods = by(ByTape);
    methods.extend(by(ByDual));
    methods.push(Method::new("tape", "solver", Kind::Exact, |_| Box::new(TapeThroughSolver)));
    methods.push(Method::new("dual", "solver", Kind::Exact, |_| Box::new(DualThroughSolver)));
    methods.push(Method::new("fd", "none", Kind::Difference, |_| {
        Box::new(FiniteDifference::default())
    }));
    methods
}

/// Every method for a joint with a network, which is also differentiated by hand.
#[must_use]
pub fn of_joint<I>() -> Vec<Method<JointField<f64, NetworkForce<f64>>, I>>
where
    I: ParametricInput + 'static,
{
    let mut methods = by(ByHand);
    methods.extend(all());
    methods
}

/// The methods that cost does not forbid where there are thousands of parameters: the field is not
/// differentiated by dual numbers.
#[must_use]
pub fn for_many_parameters<F, I>(methods: Vec<Method<F, I>>) -> Vec<Method<F, I>> {
    methods.into_iter().filter(|method| method.differentiation != "dual").collect()
}

/// The exact adjoint with several checkpointings.
#[must_use]
pub fn checkpointings<F, I>(choices: &[Checkpointing]) -> Vec<Method<F, I>>
where
    F: ParametricField + 'static,
    I: ParametricInput + 'static,
{
    choices
        .iter()
        .map(|&choice| {
            let name = format!("adjoint, {}", choice.name());
            Method::new(&name, "tape", Kind::Exact, move |_| {
                Box::new(DiscreteAdjoint::new(ByTape).with_checkpointing(choice))
            })
        })
        .collect()
}

/// Every method that differentiates the field, by `how`.
#[must_use]
pub fn by<F, I, D>(how: D) -> Vec<Method<F, I>>
where
    F: ParametricField + 'static,
    I: ParametricInput + 'static,
    D: Differentiation<F> + Copy + 'static,
{
    let adjoint = move |name: &str, checkpointing: Checkpointing| {
        Method::new(name, how.name(), Kind::Exact, move |_| {
            Box::new(DiscreteAdjoint::new(how).with_checkpointing(checkpointing))
        })
    };
    let continuous = |name: &str, build: fn(D, &Solver) -> Boxed<F, I>| {
        Method::new(name, how.name(), Kind::Continuous, move |solver| build(how, solver))
    };
    vec![
        adjoint("adjoint", Checkpointing::AllSave),
        adjoint("adjoint-interval", Checkpointing::Interval(INTERVAL)),
        adjoint("adjoint-binomial", Checkpointing::Binomial { snapshots: SNAPSHOTS }),
        Method::new("forward", how.name(), Kind::Exact, move |_| {
            Box::new(ForwardSensitivity::new(how))
        }),
        continuous("backsolve", |how, solver| {
            Box::new(Backsolve::new(how).with_backward(solver.integrator()))
        }),
        continuous("backsolve-free", |how, solver| {
            let mut free = Backsolve::new(how).with_backward(solver.integrator());
            free.restart_at_observations = false;
            Box::new(free)
        }),
        continuous("interpolating", |how, solver| {
            Box::new(InterpolatingAdjoint::new(how).with_backward(solver.integrator()))
        }),
        continuous("quadrature", |how, solver| {
            Box::new(QuadratureAdjoint::new(how).with_backward(solver.integrator()))
        }),
    ]
}
