//! Hybrid neural ODEs of a joint that an antagonistic pair of pneumatic artificial muscles moves: all layers of
//! the framework behind one name.
//!
//! | module | crate | feature | what it is for |
//! |---|---|---|---|
//! | [`core`] | `pam-core` | | scalars, activations, force models, the vector field |
//! | [`autodiff`] | `pam-autodiff` | | duals, tape, finite differences, exact ∂f/∂x |
//! | [`solvers`] | `pam-solvers` | | Runge–Kutta methods, adjoints, batched trajectories |
//! | [`exact`] | `pam-exact` | `joint` | closed form of networks of LeakyReLU and ReLU |
//! | [`surrogate`] | `pam-surrogate` | `joint` | smooth networks on piecewise polynomials of their force |
//! | [`data`] | `pam-data` | `joint` | recordings, models, their files |
//! | [`vocabulary`] | `pam-vocabulary` | `fields` | the effects that rig and diagnosis share, as data |
//! | [`expression`] | `pam-expression` | `fields` | expressions over named numbers, as terms of any field |
//! | [`rig`] | `pam-rig` | `rig` | a virtual rig with known ground truth |
//! | [`train`] | `pam-train` | `fields`, `joint` | losses, optimisers, curricula, predictions, scores |
//! | [`report`] | `pam-report` | `report` | figures and self-contained HTML |
//! | [`diagnose`] | `pam-diagnose` | `fields`, `joint` | names the causes of a model error and measures the error reduction |
//! | [`experiment`] | `pam-experiment` | `experiment` | detection limits, experiment design, certificates of the diagnosis |
//! | [`control`] | `pam-control` | `control` | stiffness, planning, identification, receding-horizon MPC |
//! | [`ablate`] | `pam-ablate` | `ablate` | sweeps over any setting, resumable, compared seed by seed |
//! | [`baselines`] | `pam-baselines` | `compare` | Kang, Koopman, GRU and others beside the hybrid model |
//!
//! Only the chosen features are compiled: `fields`, the default, is for your own vector fields and adds 39 crates from
//! elsewhere; `report` adds figures and pages; `joint` the pneumatic joint with recordings, training and diagnosis;
//! `control`, `rig`, `experiment`, `ablate` and `compare` what is built on it; `all` is everything.
//!
//! The [`prelude`] has the names of first experiments. A damped oscillator from closures, solved:
//!
//! ```
//! use pam::prelude::*;
//! use pam::solvers::Term;
//!
//! let field = FieldFn::new(2, 0, |_t, y: &[f64], _u: &[f64], dy: &mut [f64]| {
//!     dy[0] = y[1];
//!     dy[1] = -4.0 * y[0] - 0.1 * y[1];
//! });
//! let solution = Integrator::new(Tableau::tsit5(), PidController::new(1e-9, 1e-9)).solve(
//!     &Term::new(field, NoInput),
//!     0.0,
//!     5.0,
//!     &[1.0, 0.0],
//!     SaveAt::End,
//! )?;
//! let (damping, rate) = (0.05_f64, (4.0_f64 - 0.0025).sqrt());
//! let exact = (-damping * 5.0).exp() * ((rate * 5.0).cos() + damping / rate * (rate * 5.0).sin());
//! assert!((solution.state(0)[0] - exact).abs() < 1e-7);
//! # Ok::<(), Box<pam::solvers::SolveError<f64>>>(())
//! ```
//!
//! The shipped kind of model, its stiffness and where a force takes it:
//!
//! ```
//! use pam::num_dual::Dual64;
//! use pam::prelude::*;
//!
//! let model = JointModel::datasheet(SpringDamper::<f64>::published()); // any ForceModel goes here
//! let masses = model.gas_law_masses(0.0, [412.0, 412.0]);              // kPa absolute, at x = 0
//! let at = ForceInput {
//!     displacement_mm: 0.0, velocity_mm_s: 0.0,
//!     mass_flexor_g: masses.flexor_g, mass_extensor_g: masses.extensor_g,
//! };
//! let slope = linearise(&model.force.map(Dual64::constant), &at);      // exact, by dual numbers
//! assert!((slope.stiffness_n_mm - 150.0).abs() < 20.0);
//! ```

pub use num_dual;
#[cfg(feature = "ablate")]
pub use pam_ablate as ablate;
pub use pam_autodiff as autodiff;
#[cfg(feature = "compare")]
pub use pam_baselines as baselines;
#[cfg(feature = "control")]
pub use pam_control as control;
pub use pam_core as core;
#[cfg(feature = "joint")]
pub use pam_data as data;
#[cfg(feature = "fields")]
pub use pam_diagnose as diagnose;
#[cfg(feature = "joint")]
pub use pam_effects as effects;
#[cfg(feature = "joint")]
pub use pam_exact as exact;
#[cfg(feature = "experiment")]
pub use pam_experiment as experiment;
#[cfg(feature = "fields")]
pub use pam_expression as expression;
#[cfg(feature = "report")]
pub use pam_report as report;
#[cfg(feature = "rig")]
pub use pam_rig as rig;
pub use pam_solvers as solvers;
#[cfg(feature = "joint")]
pub use pam_surrogate as surrogate;
#[cfg(feature = "fields")]
pub use pam_train as train;
#[cfg(feature = "joint")]
pub use pam_trajectory as trajectory;
#[cfg(feature = "fields")]
pub use pam_vocabulary as vocabulary;

/// Everything for your own system, without any joint: fields and their names, solvers, experiments, fits, the
/// diagnosis.
#[cfg(feature = "fields")]
pub mod field {
    pub use pam_autodiff::ByTape;
    pub use pam_core::{
        DryFriction, FieldFn, FieldNames, ParametricField, Scalar, VectorField, field_fn,
    };
    pub use pam_diagnose::field::{
        Candidate, DiagnosedField, FieldBaseline, FieldDiagnosis, FieldNoise, FieldOptions,
        FieldSeparation, design_field, diagnose_field, sine_experiments,
    };
    pub use pam_diagnose::{DiagnosisSettings, Verdict};
    pub use pam_expression::{Compiled, Terms, WithTerms};
    pub use pam_solvers::sensitivity::DiscreteAdjoint;
    pub use pam_solvers::{
        Constant, Input, InputFn, Integrator, Interpolation, NoInput, ParametricInput,
        PidController, SampledInput, SaveAt, Tableau, Term,
    };
    pub use pam_train::field::{
        Experiment, FieldError, FieldFit, FieldLoss, FieldProblem, FieldTraining, HeldOutError,
        LeastSquares, MeasuredInput, Number, Numbers, Outputs, SignalSensitivities, TrainedField,
        outputs_error,
    };
    pub use pam_vocabulary::ParameterInfo;
}

/// Names for first experiments: a vector field solved; with the feature `joint` a model and a recording predicted, trained
/// and diagnosed.
/// Everything else is in its crate: `pam::solvers::Term`, `pam::report::LineFigure`, `pam::train::curriculum::Curriculum`.
pub mod prelude {
    pub use pam_autodiff::linearise;
    pub use pam_core::{
        FieldFn, ForceInput, JointModel, ParametricField, Scalar, SpringDamper, VectorField,
        field_fn,
    };
    #[cfg(feature = "joint")]
    pub use pam_data::{LoadOptions, Recording, Subject, load_model, read_recordings, subjects};
    #[cfg(feature = "joint")]
    pub use pam_diagnose::diagnose;
    pub use pam_solvers::{InputFn, Integrator, NoInput, PidController, SaveAt, Tableau};
    #[cfg(feature = "joint")]
    pub use pam_train::evaluate;
    #[cfg(feature = "joint")]
    pub use pam_train::training::Training;
    #[cfg(feature = "joint")]
    pub use pam_trajectory::{Predictor, SolverSettings};
}

/// The Rust code of the README and of the book, compiled and run as documentation tests.
#[cfg(all(doctest, feature = "all"))]
mod book {
    #![doc = include_str!("../../README.md")]
    #![doc = include_str!("../../docs/introduction.md")]
    #![doc = include_str!("../../docs/tutorial.md")]
    #![doc = include_str!("../../docs/theory.md")]
    #![doc = include_str!("../../docs/other-systems.md")]
    #![doc = include_str!("../../docs/how-to.md")]
    #![doc = include_str!("../../docs/own-rig.md")]
    #![doc = include_str!("../../docs/own-effects.md")]
    #![doc = include_str!("../../docs/rig.md")]
    #![doc = include_str!("../../docs/training.md")]
    #![doc = include_str!("../../docs/diagnosis.md")]
    #![doc = include_str!("../../docs/experiment.md")]
    #![doc = include_str!("../../docs/laws.md")]
    #![doc = include_str!("../../docs/control.md")]
    #![doc = include_str!("../../docs/gradients.md")]
    #![doc = include_str!("../../docs/exact.md")]
    #![doc = include_str!("../../docs/python.md")]
    #![doc = include_str!("../../docs/matlab-and-r.md")]
    #![doc = include_str!("../../docs/compare.md")]
    #![doc = include_str!("../../docs/ablations.md")]
    #![doc = include_str!("../../docs/effects.md")]
    #![doc = include_str!("../../docs/formats.md")]
    #![doc = include_str!("../../docs/architecture.md")]
    #![doc = include_str!("../../docs/reproduction.md")]
    #![doc = include_str!("../../docs/experiments.md")]
    #![doc = include_str!("../../docs/peers.md")]
    #![doc = include_str!("../../docs/robustness.md")]
    #![doc = include_str!("../../docs/other-tools.md")]
    #![doc = include_str!("../../docs/gallery.md")]
    #![doc = include_str!("../../docs/api-tour.md")]
    #![doc = include_str!("../../docs/commands.md")]
    #![doc = include_str!("../../docs/troubleshooting.md")]
    #![doc = include_str!("../../docs/glossary.md")]
    #![doc = include_str!("../../docs/units.md")]
    #![doc = include_str!("../../docs/install.md")]
}
