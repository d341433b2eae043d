//! Training of any vector field on anything that is measured of it.
//!
//! The rest of this crate knows recordings of a joint; this module knows a
//! [`ParametricField`](pam_core::ParametricField) of any number of states, its inputs, and what was
//! measured of it ([`Experiment`], from arrays by [`Experiment::sampled`]): states, or outputs `h(t, y, u)` that the field
//! declares ([`Outputs`]). Two ways to fit it:
//!
//! - [`FieldProblem::train`]: any loss, any [`GradientMethod`](pam_solvers::sensitivity::GradientMethod),
//!   L-BFGS; for many parameters, such as the weights of a network;
//! - [`FieldProblem::least_squares`]: Levenberg–Marquardt with forward sensitivities, for a few parameters
//!   initial states and a delay of the inputs, with intervals. Fields with dry friction stick and slip
//!   ([`DryFriction`](pam_core::DryFriction)).
//!
//! Experiments that are held out ([`FieldProblem::with_held_out`]) take part in neither; both report the error on them.
//!
//! ```
//! use pam_core::{ParametricField, Scalar, VectorField};
//! use pam_solvers::{Integrator, NoInput, PidController, SaveAt, Tableau, Term};
//! use pam_train::field::{Experiment, FieldProblem, Outputs};
//!
//! /// `φ̈ = −ω² sin φ − d φ̇`
//! struct Pendulum<S> { omega_squared: S, damping: S }
//!
//! impl<S: Scalar> VectorField<S> for Pendulum<S> {
//!     fn state_len(&self) -> usize { 2 }
//!     fn input_len(&self) -> usize { 0 }
//!     fn eval_into(&self, _t: f64, y: &[S], _u: &[S], dy: &mut [S], _work: &mut [S]) {
//!         dy[0] = y[1];
//!         dy[1] = -self.omega_squared * y[0].sin() - self.damping * y[1];
//!     }
//! }
//!
//! impl ParametricField for Pendulum<f64> {
//!     type With<S: Scalar> = Pendulum<S>;
//!     fn parameters(&self) -> Vec<f64> { vec![self.omega_squared, self.damping] }
//!     fn with_parameters<S: Scalar>(&self, p: &[S]) -> Pendulum<S> {
//!         Pendulum { omega_squared: p[0], damping: p[1] }
//!     }
//! }
//!
//! let integrator = Integrator::new(Tableau::tsit5(), PidController::new(1e-8, 1e-8));
//! let times_s: Vec<f64> = (0..200).map(|k| 0.05 * f64::from(k)).collect();
//! let truth = Term::new(Pendulum { omega_squared: 9.0, damping: 0.2 }, NoInput);
//! let run = integrator.solve(&truth, 0.0, 10.0, &[1.0, 0.0], SaveAt::Times(&times_s))?;
//!
//! // Only the angle is measured.
//! let swing = [Experiment::new("swing", NoInput, times_s, run.component(0).collect())
//!     .starting_at(vec![1.0, 0.0])];
//! let guess = Pendulum { omega_squared: 8.0, damping: 0.0 };
//! let outputs = Outputs::new([(0, 1e-3)]); // state 0, noise of 0.001 rad
//! let problem = FieldProblem::new(&guess, &swing, outputs, &integrator);
//! let fit = problem.least_squares(&Default::default())?;
//! assert!((fit.parameters[0] - 9.0).abs() < 1e-4 && (fit.parameters[1] - 0.2).abs() < 1e-4);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod csv;
mod driven;
mod experiment;
mod least_squares;
mod normal;
mod outputs;
mod problem;
mod signals;
mod simulate;
mod train;

pub use experiment::{Experiment, MeasuredInput};
pub use least_squares::{FieldFit, LeastSquares};
pub use outputs::Outputs;
pub use problem::{FieldError, FieldProblem, HeldOutError};
pub use simulate::{Number, Numbers, SignalSensitivities};
pub use train::{FieldLoss, FieldTraining, TrainedField, outputs_error};
