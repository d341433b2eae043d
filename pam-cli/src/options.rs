//! Options that several commands share, and what they turn into.

use crate::error::CliError;
use clap::{Args, ValueEnum};
use pam_core::{Activation, AnyForce, JointModel, Mlp, NetworkForce, SpringDamper};
use pam_data::Subject;
use pam_data::formats::mat_run::PressureReference;
use pam_data::{
    LoadOptions, MassChoice, ModelInfo, MuscleSurfaces, Recording, SavedModel, load_model,
    open_recordings, parse_model, resolve_masses,
};
use pam_effects::ExtendedModel;
use pam_effects::engine::{AUTO, EXACT, EngineChoice};
use pam_solvers::{Interpolation, Tableau};
use pam_trajectory::{SolverSettings, StepChoice};
use serde_json::{Value, json};
use std::path::{Path, PathBuf};

/// Name of the trained model that comes with the program.
pub const DEFAULT_MODEL: &str = "default";

/// Trained on recordings of the virtual rig; `docs/training.md` has the commands that made it.
const DEFAULT_MODEL_BYTES: &[u8] = include_bytes!("../models/default.safetensors");

/// Name of the built-in physics-only model.
pub const SPRING_DAMPER: &str = "spring-damper";

/// Which model.
#[derive(Debug, Clone, Args)]
pub struct ModelOptions {
    /// Model file (.safetensors, .eqx), `default` for the trained model that comes with the program, or
    /// `spring-damper` for the physics-only one
    #[arg(long, value_name = "MODEL", default_value = DEFAULT_MODEL)]
    pub model: PathBuf,
    /// Activation of an .eqx network, which the file does not name [default: leaky_relu]
    #[arg(long, value_name = "NAME")]
    pub activation: Option<String>,
}

impl ModelOptions {
    /// Loads the model for a command that does not know effects. Of an extended model it takes the plain one
    /// that comes nearest, and says on standard error what became of the effects.
    ///
    /// # Errors
    /// As [`load_extended`](Self::load_extended).
    pub fn load(&self) -> Result<SavedModel, CliError> {
        let saved = self.load_extended()?;
        if saved.info.effects.is_empty() {
            return Ok(saved);
        }
        let plain = ExtendedModel::from_saved(saved)?.without_effects();
        if let Some(sentence) = plain.sentence() {
            eprintln!("{}: {sentence}", self.model.display());
        }
        Ok(plain.saved)
    }

    /// Loads the model with its effects, if it has any.
    ///
    /// # Errors
    /// [`CliError`] naming the file or the option.
    pub fn load_extended(&self) -> Result<SavedModel, CliError> {
        if self.model == Path::new(SPRING_DAMPER) {
            return Ok(built_in_spring_damper());
        }
        let mut saved = if self.model == Path::new(DEFAULT_MODEL) {
            parse_model(&self.model, DEFAULT_MODEL_BYTES)?
        } else {
            load_model(&self.model)?
        };
        if let Some(name) = &self.activation {
            let AnyForce::Network(force) = &saved.model.force else {
                return Err(CliError::Usage("--activation is for networks".into()));
            };
            let activation = Activation::from_name(name)?;
            let mlp = Mlp::new(force.mlp().layers().to_vec(), activation)?;
            saved.model.force = AnyForce::Network(NetworkForce::new(mlp)?);
        }
        Ok(saved)
    }
}

/// The trained model that comes with the program.
///
/// # Errors
/// [`CliError::Data`] if it cannot be read, which a build would have to be broken for.
pub fn default_model() -> Result<SavedModel, CliError> {
    Ok(parse_model(Path::new(DEFAULT_MODEL), DEFAULT_MODEL_BYTES)?)
}

/// The physics-only model: datasheet parameters and the published stiffness as a straight line.
#[must_use]
pub fn built_in_spring_damper() -> SavedModel {
    SavedModel {
        model: JointModel::datasheet(AnyForce::SpringDamper(SpringDamper::published())),
        info: ModelInfo {
            name: "linear spring–damper".into(),
            provenance:
                "physics only: datasheet mass, gas and geometry, published stiffness range \
                         and damping, no friction, nothing fitted"
                    .into(),
            trained: false,
            trained_on: Vec::new(),
            effects: Vec::new(),
            source: None,
        },
    }
}

/// One line on a model's force and parameters.
#[must_use]
pub fn describe_model(saved: &SavedModel) -> String {
    let p = saved.model.physical();
    let effects = ExtendedModel::from_saved(saved.clone())
        .map(|e| e.describe_effects())
        .ok()
        .filter(|text| !text.is_empty())
        .map(|text| format!(" ExtendedModel by {text}."))
        .unwrap_or_default();
    format!(
        "Force: {}; m = {:.3} kg, C = {:.4e} kPa·mm³/g, ν = {:.4}.{effects}",
        saved.model.force.describe(),
        p.mass_kg,
        p.gas_coefficient,
        p.deformation
    )
}

/// What zero means in a `.mat` run's pressures.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum PressureArgument {
    /// Decide by the gas law and say so
    Auto,
    /// Zero is vacuum
    Absolute,
    /// Zero is the atmosphere
    Gauge,
}

/// Where masses come from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum MassArgument {
    /// Gas law for a trained model, surfaces (if given) for an untrained one
    Auto,
    /// The model's gas law at the start of the run
    #[value(alias = "gas_law")]
    GasLaw,
    /// The single-muscle surfaces of --surfaces
    Surfaces,
}

/// How recordings are read.
#[derive(Debug, Clone, Args)]
pub struct DataOptions {
    /// Source of the sealed air masses; masses that a file gives always win
    #[arg(long, value_enum, default_value = "auto", value_name = "SOURCE")]
    pub masses: MassArgument,
    /// Single-muscle surfaces (poly44_all_fits.mat)
    #[arg(long, value_name = "FILE")]
    pub surfaces: Option<PathBuf>,
    /// Filter CSV and .npz data like a raw log and take the velocity anew
    #[arg(long)]
    pub preprocess: bool,
    /// Change a constant of the raw-log loader, for example cutoff_hz=10 or search_from_row=0; may
    /// be given several times
    #[arg(long = "loader", value_name = "KEY=VALUE")]
    pub loader: Vec<String>,
    /// What zero means in the pressures of a .mat run
    #[arg(long, value_enum, default_value = "auto", value_name = "REFERENCE")]
    pub mat_pressure: PressureArgument,
}

impl DataOptions {
    /// The loader's options.
    ///
    /// # Errors
    /// [`CliError::Usage`] naming a loader option that does not exist.
    pub fn load_options(&self) -> Result<LoadOptions, CliError> {
        let mut options = LoadOptions {
            preprocess: self.preprocess,
            pressure_reference: match self.mat_pressure {
                PressureArgument::Auto => PressureReference::Auto,
                PressureArgument::Absolute => PressureReference::Absolute,
                PressureArgument::Gauge => PressureReference::Gauge,
            },
            ..LoadOptions::default()
        };
        for assignment in &self.loader {
            options
                .raw_log
                .set(assignment)
                .map_err(|e| CliError::Usage(format!("--loader {assignment}: {e}")))?;
        }
        Ok(options)
    }

    /// The mass source.
    #[must_use]
    pub fn mass_choice(&self) -> MassChoice {
        match self.masses {
            MassArgument::Auto => MassChoice::Auto,
            MassArgument::GasLaw => MassChoice::GasLaw,
            MassArgument::Surfaces => MassChoice::Surfaces,
        }
    }

    /// The surfaces, if a file is given.
    ///
    /// # Errors
    /// [`CliError::Data`] naming what is wrong with it.
    pub fn load_surfaces(&self) -> Result<Option<MuscleSurfaces>, CliError> {
        Ok(self.surfaces.as_deref().map(MuscleSurfaces::read).transpose()?)
    }

    /// Reads recordings with their masses for a model.
    ///
    /// # Errors
    /// [`CliError`] naming file, line and column, or the option.
    pub fn subjects(
        &self,
        paths: &[PathBuf],
        saved: &SavedModel,
        read: &(dyn Fn() + Sync),
    ) -> Result<Vec<Subject>, CliError> {
        let surfaces = self.load_surfaces()?;
        let mut subjects = Vec::new();
        for recording in self.recordings(paths, read)? {
            let (masses, origin) = resolve_masses(
                &recording,
                &saved.model,
                saved.info.trained,
                self.mass_choice(),
                surfaces.as_ref(),
            )?;
            subjects.push(Subject { recording, masses, origin });
        }
        Ok(subjects)
    }

    /// Reads recordings in parallel, in the order of the files, each with a name of its own.
    /// `read` is called after each file.
    ///
    /// # Errors
    /// [`CliError::Data`] naming file, line and column.
    pub fn recordings(
        &self,
        paths: &[PathBuf],
        read: &(dyn Fn() + Sync),
    ) -> Result<Vec<Recording>, CliError> {
        use rayon::prelude::*;
        let options = self.load_options()?;
        let files: Vec<Result<Vec<Recording>, _>> = paths
            .par_iter()
            .map(|path| {
                let recordings = open_recordings(path, &options);
                read();
                recordings
            })
            .collect();
        let mut all: Vec<Recording> = Vec::new();
        for recordings in files {
            for mut recording in recordings? {
                let taken = |name: &str| all.iter().any(|r| r.name == name);
                if taken(&recording.name) {
                    let base = recording.name.clone();
                    recording.name = (2..)
                        .map(|k| format!("{base}~{k}"))
                        .find(|name| !taken(name))
                        .unwrap_or(base);
                }
                all.push(recording);
            }
        }
        Ok(all)
    }

    /// The options as JSON, for run folders.
    ///
    /// # Errors
    /// As [`load_options`](DataOptions::load_options).
    pub fn to_json(&self) -> Result<Value, CliError> {
        let load = self.load_options()?;
        Ok(json!({
            "masses": format!("{:?}", self.masses).to_lowercase(),
            "surfaces": self.surfaces,
            "preprocess": self.preprocess,
            "mat_pressure": format!("{:?}", self.mat_pressure).to_lowercase(),
            "raw_log": load.raw_log,
        }))
    }
}

/// How a sampled force is read.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum InputArgument {
    /// Held until the next sample, as in the published path
    Zoh,
    /// Straight lines between samples; leads a held force by half a sample
    Linear,
    /// Straight lines between the middles of the holds: follows a held force at long steps
    Ramp,
    /// Cubic Hermite pieces
    Cubic,
}

/// With which method the equations are solved.
#[derive(Debug, Clone, Args)]
pub struct SolverOptions {
    /// exact (closed form, for networks of leaky_relu or relu), a Runge–Kutta method (tsit5, rk4, bs3,
    /// dp5), or auto: exact where it applies and no steps or tolerances are given, else tsit5
    #[arg(long, alias = "solver", default_value = AUTO, value_name = "NAME")]
    pub method: String,
    /// Steps and input.
    #[command(flatten)]
    pub steps: StepOptions,
}

/// Tolerances that are not given.
const DEFAULT_TOLERANCE: f64 = 1e-6;

/// How steps are chosen and the force is read.
#[derive(Debug, Clone, Args)]
pub struct StepOptions {
    /// Constant steps of this many ms instead of error control
    #[arg(long, value_name = "MS", allow_negative_numbers = true, conflicts_with_all = ["rtol", "atol"])]
    pub step_ms: Option<f64>,
    /// Relative tolerance of the error control
    #[arg(long, default_value_t = DEFAULT_TOLERANCE, allow_negative_numbers = true, value_name = "R")]
    pub rtol: f64,
    /// Absolute tolerance of the error control, in mm, mm/s and kPa
    #[arg(long, default_value_t = DEFAULT_TOLERANCE, allow_negative_numbers = true, value_name = "A")]
    pub atol: f64,
    /// How the measured force is read between samples
    #[arg(long, value_enum, default_value = "zoh", value_name = "HOW")]
    pub input: InputArgument,
}

impl SolverOptions {
    /// The settings for a model.
    ///
    /// # Errors
    /// As [`StepOptions::settings_for`].
    pub fn settings_for(&self, saved: &SavedModel) -> Result<SolverSettings, CliError> {
        self.steps.settings_for(&self.method, saved)
    }
}

impl StepOptions {
    /// Whether steps or tolerances are asked for.
    #[must_use]
    pub fn are_given(&self) -> bool {
        self.step_ms.is_some() || self.rtol != DEFAULT_TOLERANCE || self.atol != DEFAULT_TOLERANCE
    }

    /// The settings for a model and a method: `exact`, `auto` or a Runge–Kutta method.
    ///
    /// # Errors
    /// As [`settings`](Self::settings), and [`CliError::Usage`] if the exact method is asked for where
    /// it does not apply.
    pub fn settings_for(
        &self,
        method: &str,
        saved: &SavedModel,
    ) -> Result<SolverSettings, CliError> {
        let general =
            self.settings(if [AUTO, EXACT].contains(&method) { "tsit5" } else { method })?;
        let choice = EngineChoice {
            automatic: method == EXACT || (method == AUTO && !self.are_given()),
            ..EngineChoice::new(general)
        };
        let settings = choice.settings_for(&saved.model.force, !saved.info.effects.is_empty());
        match method {
            EXACT if self.are_given() => Err(CliError::Usage(
                "--method exact takes no steps and has no error to control: drop --step-ms, --rtol \
                 and --atol"
                    .into(),
            )),
            EXACT if !saved.info.effects.is_empty() => Err(CliError::Usage(
                "--method exact: the model is extended by effects, which are not piecewise affine".into(),
            )),
            EXACT if settings.interpolation == Interpolation::Cubic => Err(CliError::Usage(
                "--method exact reads the force as zoh, linear or ramp, not cubic".into(),
            )),
            EXACT if settings.step != StepChoice::Exact => Err(CliError::Usage(format!(
                "--method exact is for networks of leaky_relu or relu; this model is a {}; leave \
                 --method out",
                saved.model.force.describe()
            ))),
            _ => Ok(settings),
        }
    }

    /// The settings for the Runge–Kutta method of this name.
    ///
    /// # Errors
    /// [`CliError`] for unknown methods, steps and tolerances that are not positive, and methods
    /// without error estimate under error control.
    pub fn settings(&self, method: &str) -> Result<SolverSettings, CliError> {
        let positive = |name: &str, value: f64| {
            if value.is_finite() && value > 0.0 {
                Ok(value)
            } else {
                Err(CliError::Usage(format!("--{name} must be positive, got {value}")))
            }
        };
        let tableau = Tableau::from_name(method)?;
        let step = match self.step_ms {
            Some(ms) => StepChoice::Constant { step_s: positive("step-ms", ms)? * 1e-3 },
            None if tableau.error.is_none() => {
                return Err(CliError::Usage(format!(
                    "{method} has no error estimate; give --step-ms"
                )));
            }
            None => StepChoice::Adaptive {
                rtol: positive("rtol", self.rtol)?,
                atol: positive("atol", self.atol)?,
            },
        };
        let interpolation = match self.input {
            InputArgument::Zoh => Interpolation::Hold,
            InputArgument::Linear => Interpolation::Linear,
            InputArgument::Ramp => Interpolation::Ramp,
            InputArgument::Cubic => Interpolation::Cubic,
        };
        Ok(SolverSettings { tableau, step, interpolation })
    }
}

/// Solver settings as JSON, for run folders.
#[must_use]
pub fn solver_json(settings: &SolverSettings) -> Value {
    if settings.step == StepChoice::Exact {
        return json!({ "method": EXACT, "input": settings.interpolation.name() });
    }
    json!({
        "method": settings.tableau.name,
        "step": settings.step,
        "input": settings.interpolation.name(),
    })
}
