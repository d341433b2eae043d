//! Explicit Runge–Kutta solvers for vector fields with measured inputs, and gradients through them.
//!
//! The parts are separate types, each in the file of its name, and combine freely:
//!
//! | part | type | says |
//! |---|---|---|
//! | [`term`] | [`Term`] | what is integrated: a vector field and its input |
//! | [`tableau`] | [`Tableau`] | with which method: Tsit5, RK4, Bogacki–Shampine 3(2), Dormand–Prince 5(4) |
//! | [`controller`] | [`StepController`] | how steps are chosen: constant, or PI/PID on an error estimate |
//! | [`save_at`] | [`SaveAt`] | what is kept: the end, every step, given times, a dense solution |
//! | [`input`] | [`Input`] | how a sampled signal is read between samples: held, linear, cubic |
//! | [`grid`] | [`Grid`] | which steps were accepted; [`replay`](replay()) takes them again with any scalar |
//! | [`sensitivity`] | [`GradientMethod`](sensitivity::GradientMethod) | how a loss of the solution is differentiated: discrete and continuous adjoints, forward sensitivities, differences |
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
//! # Held inputs are exact
//!
//! A zero-order hold jumps at its samples. The solver ends a step at every jump, evaluates the last
//! stage of that step with the value *before* the jump, and starts the next step with a fresh first
//! stage. Looking the input up at the stage times instead, as is often done, lets the last stage of
//! a step see the next sample: the force then leads by a fraction of the sample time.

pub mod batched;
pub mod controller;
pub mod error;
pub mod grid;
pub mod input;
pub mod integrator;
mod observer;
mod recorder;
pub mod replay;
mod request;
mod run;
pub mod save_at;
pub mod sensitivity;
pub mod solution;
mod step;
mod stepping;
pub mod tableau;
pub mod term;

pub use batched::{
    BatchGradient, BatchWorkspace, BatchedIntegrator, TrajectoryFailure, TrajectoryProblem,
};
pub use controller::{ConstantStep, Decision, PidController, StepController, Tolerances};
pub use error::{FailureKind, SolveError};
pub use grid::Grid;
pub use input::{
    Constant, Fixed, Input, InputFn, Interpolation, NoInput, ParametricInput, SampledInput, Side,
};
pub use integrator::Integrator;
pub use replay::replay;
pub use save_at::SaveAt;
pub use solution::{DenseSolution, Solution, Statistics};
pub use tableau::Tableau;
pub use term::Term;
