//! Explicit Runge–Kutta solvers for vector fields with measured inputs, and gradients through them.
//!
//! The parts are separate types, one module each, and combine freely:
//!
//! | module | type | role |
//! |---|---|---|
//! | [`term`] | [`Term`] | the right-hand side: a vector field and its input |
//! | [`tableau`] | [`Tableau`] | the Runge–Kutta method: Tsit5, RK4, Bogacki–Shampine 3(2), Dormand–Prince 5(4) |
//! | [`controller`] | [`StepController`] | the step sizes: constant, or PI/PID control of an error estimate |
//! | [`save_at`] | [`SaveAt`] | the saved points: the end, every step, given times, a dense solution |
//! | [`input`] | [`Input`] | the input between its samples: zero-order hold, linear, cubic |
//! | `sticking` | [`Integrator::solve_sticking`] | fields with set-valued dry friction |
//! | [`grid`] | [`Grid`] | the accepted steps; [`replay`](replay()) takes them again with any scalar |
//! | [`batched`] | [`BatchedIntegrator`] | many trajectories at once, with gradients |
//! | [`sensitivity`] | [`GradientMethod`](sensitivity::GradientMethod) | the gradient of a loss of the solution: discrete and continuous adjoints, forward sensitivities, differences |
//! | [`fixed_step`] | [`rk4_step`] | a single step of a small system |
//!
//! [`Integrator`] joins them:
//!
//! ```
//! use pam_core::FieldFn;
//! use pam_solvers::{Integrator, NoInput, PidController, SaveAt, Tableau, Term};
//!
//! let oscillator = FieldFn::new(2, 0, |_t, y: &[f64], _u: &[f64], dy: &mut [f64]| {
//!     dy[0] = y[1];
//!     dy[1] = -y[0];
//! });
//! let times = [0.0, 1.0, 2.0];
//! let solution = Integrator::new(Tableau::tsit5(), PidController::new(1e-9, 1e-9))
//!     .solve(&Term::new(oscillator, NoInput), 0.0, 2.0, &[1.0, 0.0], SaveAt::Times(&times))?;
//! assert!((solution.state(1)[0] - 1.0_f64.cos()).abs() < 1e-8);
//! # Ok::<(), Box<pam_solvers::SolveError<f64>>>(())
//! ```
//!
//! # Zero-order holds are exact
//!
//! A zero-order hold jumps at its samples. The solver ends a step at every jump, evaluates the last
//! stage of that step with the value *before* the jump, and restarts: the first stage of the next step
//! is evaluated with the value after it. Looking the input up at the stage times instead, as is often
//! done, lets the last stage of a step see the next sample: the force then leads by a fraction of the
//! sample time.

pub mod batched;
pub mod controller;
pub mod error;
pub mod fixed_step;
pub mod grid;
pub mod input;
pub mod integrator;
mod observations;
mod observer;
mod recorder;
pub mod replay;
mod request;
mod run;
pub mod save_at;
pub mod sensitivity;
pub mod solution;
mod step;
pub mod step_budget;
mod step_control;
mod sticking;
pub mod tableau;
pub mod term;

pub use batched::{
    BatchGradient, BatchWorkspace, BatchedIntegrator, TrajectoryFailure, TrajectoryProblem,
};
pub use controller::{ConstantStep, Decision, PidController, StepController, Tolerances};
pub use error::{FailureKind, SolveError};
pub use fixed_step::rk4_step;
pub use grid::Grid;
pub use input::{
    Constant, Fixed, ForceSignal, Input, InputError, InputFn, Interpolation, NoInput,
    ParametricInput, SampledInput, Side,
};
pub use integrator::Integrator;
pub use replay::replay;
pub use save_at::SaveAt;
pub use solution::{DenseSolution, Solution, Statistics};
pub use step_budget::StepBudget;
pub use tableau::Tableau;
pub use term::Term;
