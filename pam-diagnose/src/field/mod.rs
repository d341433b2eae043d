//! Diagnosis of any vector field: which of the causes that its author lists explains what it misses.
//!
//! The author of the field writes every candidate into it, as a term with parameters, and lists which parameters belong
//! to which [`Candidate`] and at which values the term is absent ([`ParameterInfo::off`]). A set of causes is then a set
//! of parameters that are fitted, all others being off. [`diagnose_field`] runs the same search, rejection and verdict
//! as [`diagnose`](crate::diagnose) on it, with the same result and report. [`design_field`] compares planned
//! experiments by how well they distinguish confusable causes.
//!
//! ```
//! use pam_core::{ParametricField, Scalar, VectorField};
//! use pam_diagnose::Verdict;
//! use pam_vocabulary::ParameterInfo;
//! use pam_diagnose::field::{Candidate, FieldNoise, FieldOptions, diagnose_field};
//! use pam_solvers::{Integrator, NoInput, PidController, SaveAt, Tableau, Term};
//! use pam_train::field::{Experiment, FieldProblem, Outputs};
//!
//! /// A pendulum (rad, s) with what may be wrong with it: viscous damping, dry friction, a wind.
//! #[derive(Clone)]
//! struct Pendulum<S> { p: [S; 3] }
//!
//! impl<S: Scalar> VectorField<S> for Pendulum<S> {
//!     fn state_len(&self) -> usize { 2 }
//!     fn input_len(&self) -> usize { 0 }
//!     fn eval_into(&self, _t: f64, y: &[S], _u: &[S], dy: &mut [S], _work: &mut [S]) {
//!         let [viscous, dry, wind] = self.p;
//!         dy[0] = y[1];
//!         dy[1] = y[0].sin().scaled(-9.81) - viscous * y[1] - dry * y[1].scaled(50.0).tanh() + wind;
//!     }
//! }
//!
//! impl ParametricField for Pendulum<f64> {
//!     type With<S: Scalar> = Pendulum<S>;
//!     fn parameters(&self) -> Vec<f64> { self.p.to_vec() }
//!     fn with_parameters<S: Scalar>(&self, p: &[S]) -> Pendulum<S> { Pendulum { p: [p[0], p[1], p[2]] } }
//! }
//!
//! let integrator = Integrator::new(Tableau::tsit5(), PidController::new(1e-7, 1e-7));
//! let times_s: Vec<f64> = (0..400).map(|k| 0.02 * f64::from(k)).collect();
//! let experiments: Vec<Experiment<NoInput>> = [0.6, 1.0]
//!     .iter()
//!     .map(|&angle| {
//!         let real = Term::new(Pendulum { p: [0.0, 0.3, 0.0] }, NoInput); // dry friction is hidden
//!         let y0 = vec![angle, 0.0];
//!         let run = integrator.solve(&real, 0.0, 8.0, &y0, SaveAt::Times(&times_s))?;
//!         let measured = run.component(0).collect();
//!         let name = format!("from {angle} rad");
//!         Ok(Experiment::new(&name, NoInput, times_s.clone(), measured).starting_at(y0))
//!     })
//!     .collect::<Result<_, Box<pam_solvers::SolveError<f64>>>>()?;
//!
//! let model = Pendulum { p: [0.0; 3] };
//! let outputs = Outputs::new([(0, 2e-3)]);
//! let problem = FieldProblem::new(&model, &experiments, outputs, &integrator);
//! let candidates = [
//!     Candidate::one("viscous_damping", 0, ParameterInfo::linear("damping_per_s", [0.0, 10.0]), &[0.1]),
//!     Candidate::one("dry_friction", 1, ParameterInfo::linear("friction_rad_s2", [0.0, 10.0]), &[0.1]),
//!     Candidate::one("wind", 2, ParameterInfo::linear("push_rad_s2", [-10.0, 10.0]), &[0.1]),
//! ];
//! // The simulated angles have no noise, so its level is not learned from them.
//! let options = FieldOptions { noise: FieldNoise::AtLeast, ..FieldOptions::default() };
//! let found = diagnose_field(&problem, &candidates, &options)?;
//!
//! assert_eq!(found.verdict, Verdict::Explained);
//! assert_eq!(found.named(), ["dry_friction"]);
//! assert!((found.causes[0].parameters[0].1.value - 0.3).abs() < 0.01);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod candidate;
mod design;
mod diagnose;
mod features;
mod gated;
mod labels;
mod ladder;
#[cfg(feature = "laws")]
mod law;
mod options;
mod perturbed;
mod system;
#[cfg(feature = "laws")]
mod terms;

pub use candidate::Candidate;
pub use design::{FieldSeparation, design_field, sine_experiments};
pub use diagnose::{DiagnosedField, FieldBaseline, FieldDiagnosis, diagnose_field};
pub use ladder::{FieldRung, field_ladder};
#[cfg(feature = "laws")]
pub use law::learn_remainder_field;
pub use options::{FieldNoise, FieldOptions};

#[cfg(doc)]
use pam_vocabulary::ParameterInfo;
