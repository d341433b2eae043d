//! Shows what a model gets wrong on recordings, names the cause, extends the model by it, and measures the error
//! reduction.
//!
//! # The idea
//!
//! The error of a free-run prediction shows that something is wrong and not what. This crate answers in the
//! language of the rig: *dry friction of 41 N*, not *a term in sgn ẋ*.
//!
//! * **Causes are parts of a model.** A candidate is a term with parameters that carry units: an
//!   [effect](pam_effects::effects) of the joint, or a term of any vector field. Nothing in the base model is trained
//!   again, since a network that is fitted to faulty data absorbs the fault.
//! * **Candidates compete as simulations.** Each set of candidates is fitted through the simulation, by
//!   Levenberg–Marquardt with exact derivatives, from several starting values where it has a scale. Uncertain values
//!   (mass, initial states, sealed air) are fitted along, with Gaussian priors, so that no cause is named for a slightly
//!   wrong start. Regressions of residuals on features are not used for names: in a free run the whole trajectory responds
//!   to a missing force.
//! * **The noise is learned.** What a flexible model cannot learn from the motion is noise, of any colour. All decisions
//!   read residuals that are whitened by it, so that sums of squares are likelihoods ([`noise`]).
//! * **All candidates and all pairs are screened at once**, to first order, and the largest score is compared with what
//!   chance makes of it. Sets are compared by their posterior odds, and each further cause must reach a ratio of odds.
//! * **Training, validation and test data.** Names are chosen on training and validation data. The verdict reads a test set
//!   that no decision has seen: each channel must be within its noise, and the error reduction must be proven.
//! * **A name can be rejected.** The [`Verdict`] is `nothing_found` where the error is at the level of noise or of the
//!   model's baseline discrepancy, and `unexplained` where something is left that has no name. Alternatives that explain
//!   nearly as much are listed with each cause, and every candidate that is not named with the reason.
//!
//! # Modules, in the order in which a recording passes them
//!
//! | module | what happens there |
//! |---|---|
//! | [`joint`], [`field`] | recordings of the joint, or of any vector field, become experiments; effects, or terms, become candidates |
//! | [`data`] | experiments get their roles: training, validation, test |
//! | [`noise`] | the noise of each channel is learned; residuals are whitened |
//! | [`residual`] | a recording becomes residuals; their size, dependence, spectrum and time profile are summarised |
//! | [`fit`] | a hypothesis is fitted; confidence intervals |
//! | [`search`] | sets of candidates are screened, fitted and exchanged; the trait [`search::Candidates`] |
//! | [`rejection`] | a name is rejected: absent, unstable, no better than chance |
//! | [`ladder`] | models of one phenomenon, from a short one to a rich one |
//! | [`onset`] | causes that begin, end or grow at a time |
//! | [`verdict`] | the verdict falls; causes with their alternatives |
//! | [`test_set`] | the data that no decision has seen; error reduction |
//! | [`diagnosis`] | these steps in order, and their result, `diagnosis.json` |
//! | [`report`] | the result as a page |
//! | [`settings`] | every number on which a diagnosis depends |
//!
//! The feature `joint`, which is on by default, has [`joint`] and settings from TOML; `report`, which it brings, has
//! [`report`].
//!
//! # Example
//!
//! Dry friction is hidden in made-up recordings, and found again:
//!
//! ```
//! use pam_core::{AnyForce, JointModel, SpringDamper};
//! use pam_data::{MassOrigin, ModelInfo, Recording};
//! use pam_effects::effects::by_id;
//! use pam_diagnose::{DiagnoseOptions, RecordingSets, Verdict, diagnose};
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
//!             ..Recording::empty("made up")
//!         };
//!         let run = plant.predict(&command, masses, &SolverSettings::default())?;
//!         let recording = run.to_recording(&command, masses);
//!         Ok(Subject { recording, masses, origin: MassOrigin::Given })
//!     })
//!     .collect::<Result<_, Box<pam_trajectory::PredictError>>>()?;
//!
//! let candidates = ["coulomb_friction", "viscous_damping", "constant_load", "stiffness_scale"];
//! let options = DiagnoseOptions {
//!     candidates: candidates.iter().filter_map(|id| by_id(id)).collect(), // all 28 by default
//!     ..DiagnoseOptions::default()
//! };
//! let sets = RecordingSets { data: &data, test: None, baseline: None };
//! let found = diagnose(&model, &sets, &options, &|_stage, _share| {})?;
//!
//! assert_eq!(found.verdict, Verdict::Explained);
//! assert_eq!(found.named(), ["coulomb_friction"]);
//! let (name, force) = found.causes[0].parameters[0];
//! assert_eq!(name, "force_n");
//! assert!((force.value - 20.0).abs() < 0.2);
//! let x = &found.error_reduction.channels[0];
//! assert!(x.rmse_after < 0.05 * x.rmse_before);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

pub mod data;
mod design;
pub mod diagnosis;
pub mod error;
pub mod field;
pub mod fit;
#[cfg(feature = "joint")]
pub mod joint;
pub mod ladder;
#[cfg_attr(not(feature = "laws"), allow(dead_code))]
pub mod law;
pub mod linearised;
pub mod noise;
pub mod onset;
pub mod rejection;
#[cfg_attr(not(feature = "laws"), allow(dead_code))]
pub mod remainder;
#[cfg(feature = "report")]
pub mod report;
pub mod residual;
pub mod search;
pub mod settings;
#[cfg_attr(not(feature = "laws"), allow(dead_code))]
pub mod terms;
pub mod test_set;
pub mod verdict;

pub use diagnosis::{Diagnosis, Stage};
pub use error::DiagnoseError;
#[cfg(feature = "joint")]
pub use joint::{
    BaselineDiscrepancy, CutRecording, DiagnoseOptions, EffectLadder, JointDiagnosis,
    RecordingSets, diagnose, joint_ladder, learn_remainder, refit,
};
pub use settings::DiagnosisSettings;
pub use verdict::Verdict;
