//! Shows what a model of the joint gets wrong, names the cause, extends the model, and measures what that
//! gains.
//!
//! # The idea
//!
//! A free-run prediction that misses says that something is wrong and not what. This crate answers in the
//! language of the rig: *dry friction of 41 N*, not *a term in sgn ẋ*.
//!
//! * **Effects are parts of a model.** Every entry of a vocabulary of known faults ([`effects`]) is a term with
//!   parameters that carry units: a force, a law of the air, a memory, a sensor. An [`ExtendedModel`] is
//!   a hybrid model with such terms; it predicts, is fitted, is saved and loaded like one without. Nothing
//!   in the base model is trained again, since a network that is fitted to faulty data absorbs the fault.
//! * **Candidates compete as simulations.** Each candidate is fitted through the simulation, by
//!   Gauss–Newton with exact derivatives ([`fit`]), from several starting values where it has a scale. What is
//!   uncertain besides (mass, deformation coefficient, initial states, sealed air) is fitted along,
//!   tied to its measured value, so that no effect is named for what a slightly wrong start explains. Regressions of
//!   residuals on features are not used for names: in a free run the whole trajectory answers to a
//!   missing force, and misfit that lies on the lines of the excitation correlates with anything.
//! * **Fast enough to try them all.** With frozen weights and sealed air the network is a function of
//!   (x, ẋ) alone. [`simulation`] tabulates it once for each recording; reading the table costs nanoseconds
//!   where the network costs hundreds.
//! * **What was not fitted judges.** Sets of effects grow in a beam and shrink again; each member must earn
//!   its place on recordings, or parts of one, that took no part in the fit ([`search`]).
//! * **A name can be refused.** The [`Verdict`] is `nothing_found` where the error is at the level of noise,
//!   of the solver, or of what is ordinary for this model on healthy recordings; and
//!   `unexplained` where no name removes enough of what a flexible correction without names could remove. A
//!   fit that ends where the effect is only another one by its name, or that has another value in each
//!   part of the data, is refused as well. Alternatives that explain nearly as much are listed with each cause.
//!
//! # Modules, in reading order
//!
//! 1. [`effects`]: the vocabulary, one file an effect, and the hooks through which an effect acts.
//! 2. [`simulation`]: a recording made ready, the table of the base model's force, one march over any scalar.
//! 3. [`extended`]: the model with effects: prediction, files, refit.
//! 4. [`training`]: the gradient by weights and effects together, for the trainer.
//! 5. [`fit`]: residuals, sensitivities, normal equations, Levenberg–Marquardt, intervals.
//! 6. [`residual`]: what is wrong, before any name: dependence, spectrum, timing, sentences.
//! 7. [`search`]: noise floors, starting values, candidates, sets, the flexible reference.
//! 8. [`diagnosis`]: [`diagnose`], from recordings to verdict, causes and gain; `diagnosis.json`.
//! 9. [`design`]: the experiment that would tell confusable causes apart.
//! 10. [`report`]: the same as a page to read.
//! 11. [`field`]: the same idea for a vector field of any other system.
//!
//! # Example
//!
//! Dry friction is hidden in made-up recordings, and found again:
//!
//! ```
//! use pam_core::{AnyForce, JointModel, SpringDamper};
//! use pam_data::{MassOrigin, ModelInfo, Recording};
//! use pam_effects::effects::by_id;
//! use pam_diagnose::{Options, Sets, Verdict, diagnose};
//! use pam_effects::{ActiveEffect, ExtendedModel};
//! use pam_data::Subject;
//! use pam_trajectory::{Predictor, SolverSettings};
//! use std::f64::consts::TAU;
//!
//! let joint = JointModel::datasheet(AnyForce::from(SpringDamper::published()));
//! let masses = joint.gas_law_masses(0.0, [412.0, 412.0]); // kPa absolute, sealed at x = 0
//! let model = ExtendedModel { joint, info: ModelInfo::default(), effects: Vec::new() };
//!
//! // The plant is the model with friction that the model does not know of.
//! let effect = by_id("coulomb_friction").expect("an effect of the vocabulary");
//! let plant = model.with([ActiveEffect { effect, values: vec![20.0] }]);
//! let data: Vec<Subject> = [(0.5, 90.0), (1.0, 120.0), (1.0, 60.0)] // Hz, N
//!     .iter()
//!     .map(|(hz, newton)| {
//!         let time_s: Vec<f64> = (0..2000).map(|k| 4e-3 * f64::from(k)).collect();
//!         let command = Recording {
//!             displacement_mm: vec![0.0; time_s.len()],
//!             velocity_mm_s: vec![0.0; time_s.len()],
//!             pressure_flexor_kpa: vec![412.0; time_s.len()],
//!             pressure_extensor_kpa: vec![412.0; time_s.len()],
//!             force_mn: time_s.iter().map(|t| 1e3 * newton * (TAU * hz * t).sin()).collect(),
//!             time_s,
//!             ..Recording::empty("made up".as_ref())
//!         };
//!         let run = plant.predict(&command, masses, &SolverSettings::default())?;
//!         let recording = run.to_recording(&command, masses);
//!         Ok(Subject { recording, masses, origin: MassOrigin::Given })
//!     })
//!     .collect::<Result<_, Box<pam_trajectory::PredictError>>>()?;
//!
//! let candidates = ["coulomb_friction", "viscous_damping", "constant_load", "stiffness_scale"];
//! let options = Options {
//!     candidates: candidates.iter().filter_map(|id| by_id(id)).collect(), // all 24 by default
//!     ..Options::default()
//! };
//! let sets = Sets { data: &data, heldout: None, healthy: None };
//! let found = diagnose(&model, &sets, &options, &|_stage, _share| {})?;
//!
//! assert_eq!(found.verdict, Verdict::Explained);
//! assert_eq!(found.named(), ["coulomb_friction"]);
//! let (name, force) = found.causes[0].parameters[0];
//! assert_eq!(name, "force_n");
//! assert!((force.value - 20.0).abs() < 0.2);
//! assert!(found.gain.x.rmse_after < 0.05 * found.gain.x.rmse_before);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

pub mod data;
mod design;
pub mod diagnosis;
pub mod error;
pub mod field;
pub mod fit;
pub mod joint;
pub mod rejection;
pub mod report;
pub mod residual;
pub mod search;
pub mod settings;
pub mod test_set;
pub mod verdict;

pub use diagnosis::{Diagnosis, Stage};
pub use error::DiagnoseError;
pub use joint::{DiagnoseOptions, JointDiagnosis, RecordingSets, diagnose, refit};
pub use settings::DiagnosisSettings;
pub use verdict::Verdict;
