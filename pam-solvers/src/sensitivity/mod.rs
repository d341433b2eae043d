//! Gradients of losses of a solution.
//!
//! A [`Problem`] defines the solve and its observations, a [`Loss`] maps the observed states to a number,
//! and a [`GradientMethod`] returns value and [`Gradient`] with respect to the parameters of the field, the
//! initial state and the parameters of the input. Methods that need derivatives of the field take any
//! [`Differentiation`](pam_autodiff::Differentiation). [`GradientChoice`] lists the methods that files and
//! commands choose by name.
//!
//! | method | differentiates | cost, in products or solves | use it |
//! |---|---|---|---|
//! | [`DiscreteAdjoint`] | the accepted steps, backwards | `s` vector–Jacobian products a step | by default |
//! | [`ForwardSensitivity`] | the accepted steps, forwards | `s` Jacobian–vector products a step and direction | few directions; whole trajectories' derivatives |
//! | [`InterpolatingAdjoint`] | the equation, backwards | those of a backward solve | to compare |
//! | [`QuadratureAdjoint`] | the equation, backwards | those of a backward solve | to compare; very many parameters |
//! | [`Backsolve`] | the equation, backwards, state recovered | those of a backward solve | constant memory, never when stiff |
//! | [`TapeThroughSolver`] | the accepted steps, by a tape | a recorded solve | to check |
//! | [`DualThroughSolver`] | the accepted steps, by dual numbers | a solve for every 8 directions | to check |
//! | [`FiniteDifference`] | nothing | two solves a direction | to check |
//!
//! ```
//! use pam_autodiff::ByTape;
//! use pam_core::{Chambers, JointField, JointModel, SealedMasses, SpringDamper};
//! use pam_solvers::sensitivity::{DiscreteAdjoint, GradientMethod, Problem};
//! use pam_solvers::{Constant, Integrator, PidController, Tableau};
//!
//! let model = JointModel::datasheet(SpringDamper::constant(150e3, 6500.0));
//! let masses = SealedMasses::new(0.06, 0.07)?;
//! let [pf, pe] = model.gas_law_pressures_kpa(0.0, masses);
//! let joint = JointField::new(model, Chambers::Sealed(masses));
//! let integrator = Integrator::new(Tableau::tsit5(), PidController::new(1e-9, 1e-9));
//! let problem = Problem {
//!     field: &joint,
//!     input: &Constant(vec![100e3]), // mN
//!     t0: 0.0,
//!     t1: 3.0,
//!     y0: &[0.0, 0.0, pf, pe],
//!     observations_s: &[3.0],
//!     integrator: &integrator,
//! };
//! // The displacement at rest is F / K, so its derivative by the force is 1 / K.
//! let mut displacement = |_times_s: &[f64], states: &[f64], cotangents: &mut [f64]| {
//!     cotangents[0] = 1.0;
//!     states[0]
//! };
//! let gradient = DiscreteAdjoint::new(ByTape).value_and_gradient(&problem, &mut displacement)?;
//! assert!((gradient.value - 100.0 / 150.0).abs() < 1e-6);
//! assert!((gradient.input[0] * 150e3 - 1.0).abs() < 1e-6);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! All methods take each other's place. Several of them in one list are boxed with [`GradientMethod::boxed`]:
//!
//! ```
//! use pam_autodiff::ByTape;
//! use pam_core::field_fn;
//! use pam_solvers::sensitivity::{
//!     Backsolve, DiscreteAdjoint, DualThroughSolver, FiniteDifference, ForwardSensitivity, GradientMethod,
//!     InterpolatingAdjoint, Problem, QuadratureAdjoint, TapeThroughSolver,
//! };
//! use pam_solvers::{Integrator, PidController, Tableau};
//!
//! // ẏ = −p y: the derivative of y(2) by p is −2 e^(−2 p).
//! let field = field_fn!([0.7], 0 => 1, |_t, y, _u, p, dy| dy[0] = -p[0] * y[0]);
//! let integrator = Integrator::new(Tableau::tsit5(), PidController::new(1e-9, 1e-9));
//! let problem = Problem::new(&field, &[1.0], &[2.0], &integrator);
//! let methods = [
//!     DiscreteAdjoint::new(ByTape).boxed(),
//!     ForwardSensitivity::new(ByTape).boxed(),
//!     InterpolatingAdjoint::new(ByTape).boxed(),
//!     QuadratureAdjoint::new(ByTape).boxed(),
//!     Backsolve::new(ByTape).boxed(),
//!     TapeThroughSolver.boxed(),
//!     DualThroughSolver.boxed(),
//!     FiniteDifference::default().boxed(),
//! ];
//! for method in methods {
//!     let gradient = problem.gradient(&method, |_times_s, y, cotangents| {
//!         cotangents[0] = 1.0;
//!         y[0]
//!     })?;
//!     let slope = gradient.parameters[0];
//!     assert!((slope + 2.0 * (-1.4_f64).exp()).abs() < 1e-6, "{slope}");
//! }
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # What the exact gradient is
//!
//! Discrete methods return the gradient of the *computed* solution with its accepted steps frozen:
//! [`replay`](crate::replay()) is the map that they differentiate, and on it they agree to rounding,
//! at any tolerance. (An adaptive solve that may choose other steps is not differentiable: steps and
//! rejections change discontinuously.) Continuous methods discretise the derivative of the exact solution
//! and agree with it, and with each other, up to tolerances only.
//!
//! That gradient is exact for the steps taken, but the steps were chosen for the states. Where these are
//! too long for the sensitivities, the gradient is far from that of the exact solution;
//! [`tolerance_halving`] shows it in most cases.
//!
//! # Jumps
//!
//! Where the input jumps, a step ends, and the next one restarts; both sides of
//! the jump are differentiated with their own value of the input. Times of jumps, of steps and of
//! observations are not differentiated by.

mod continuous;
mod direction;
mod discrete_adjoint;
mod finite_difference;
mod forward;
mod gradient;
mod loss;
mod named;
mod problem;
mod through_solver;
mod tolerance_halving;

pub use direction::Direction;
pub use discrete_adjoint::{AdjointWorkspace, Checkpointing};
pub use forward::Sensitivities;
pub use gradient::{AnyGradientMethod, Gradient, GradientMethod, GradientStatistics};
pub use loss::Loss;
pub use named::*;
pub use problem::Problem;
pub use through_solver::DualsThroughSolver;
pub use tolerance_halving::{ToleranceHalving, tolerance_halving};
