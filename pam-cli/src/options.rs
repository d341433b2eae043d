//! Options that several commands share, and what they turn into.

use crate::arguments::GlobalOptions;
use crate::console::Console;
use crate::error::{CliError, usage};
use clap::Args;
use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use pam_core::{
    Activation, AnyForce, JointModel, Mlp, ModelError, NamedChoice, NetworkForce, SpringDamper,
};
use pam_data::plausibility::{PlausibilitySettings, Severity};
use pam_data::quality::{QualityKind, QualitySettings};
use pam_data::{
    LoadOptions, MassChoice, MassOptions, ModelInfo, MuscleSurfaces, PressureReference, Recording,
    RigFile, SavedModel, Subject, collect_paths_of, load_model, parse_model, plausibility, quality,
    read_files,
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
    #[arg(long, value_name = "NAME", value_parser = named(Activation::names(), Activation::from_name))]
    pub activation: Option<Activation>,
}

impl ModelOptions {
    /// Loads the model for a command that does not know effects. Of an extended model it takes the plain one
    /// that comes nearest, and says on standard error what became of the effects.
    ///
    /// # Errors
    /// As [`load_extended`](Self::load_extended).
    pub fn load(&self, global: &GlobalOptions) -> Result<SavedModel, CliError> {
        let saved = self.load_extended(global)?;
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
    pub fn load_extended(&self, global: &GlobalOptions) -> Result<SavedModel, CliError> {
        let rig = global.rig()?;
        if self.model == Path::new(SPRING_DAMPER) {
            return Ok(built_in_spring_damper(rig.as_ref()));
        }
        let mut saved = if self.model == Path::new(DEFAULT_MODEL) {
            parse_model(&self.model, DEFAULT_MODEL_BYTES)?
        } else {
            load_model(&self.model)?
        };
        if let Some(rig) = &rig {
            self.warn_of_geometry(&saved, rig);
        }
        if let Some(activation) = self.activation {
            let AnyForce::Network(force) = &saved.model.force else {
                return Err(CliError::Usage("--activation is for networks".into()));
            };
            let mlp = Mlp::new(force.mlp().layers().to_vec(), activation)?;
            saved.model.force = AnyForce::Network(NetworkForce::new(mlp)?);
        }
        Ok(saved)
    }

    /// A trained model keeps its own geometry; says so if the rig file has another.
    fn warn_of_geometry(&self, saved: &SavedModel, rig: &RigFile) {
        let (own, other) = (saved.model.geometry, rig.geometry());
        if own != other {
            eprintln!(
                "{}: the model has muscles of {} x {} mm (radius x length), the rig file {} x {} mm; the model keeps its own",
                self.model.display(),
                own.radius_mm,
                own.length_mm,
                other.radius_mm,
                other.length_mm
            );
        }
    }
}

/// The trained model that comes with the program.
///
/// # Errors
/// [`CliError::Data`] if it cannot be read, which a build would have to be broken for.
pub fn default_model() -> Result<SavedModel, CliError> {
    Ok(parse_model(Path::new(DEFAULT_MODEL), DEFAULT_MODEL_BYTES)?)
}

/// The physics-only model: parameters of the data sheet and the published stiffness as a straight line; of a rig those of
/// its own data sheet, with ideal muscles.
#[must_use]
pub fn built_in_spring_damper(rig: Option<&RigFile>) -> SavedModel {
    let spring = rig.map_or_else(SpringDamper::published, RigFile::spring_damper);
    let force = AnyForce::SpringDamper(spring);
    SavedModel {
        model: match rig {
            Some(rig) => rig.model(force),
            None => JointModel::datasheet(force),
        },
        info: ModelInfo {
            name: "linear spring–damper".into(),
            provenance:
                "physics only: datasheet mass, gas and geometry, published stiffness range \
                         and damping, no friction, nothing fitted"
                    .into(),
            trained: false,
            trained_on: Vec::new(),
            effects: Vec::new(),
            rig: rig.cloned(),
            source: None,
        },
    }
}

/// One line on a model's force and parameters.
#[must_use]
pub fn describe_model(saved: &SavedModel) -> String {
    let p = saved.model.physical();
    let effects = match ExtendedModel::from_saved(saved.clone()) {
        Ok(extended) if extended.effects.is_empty() => String::new(),
        Ok(extended) => format!(" Extended by {}.", extended.describe_effects()),
        Err(e) => format!(" Extended by effects that cannot be used here: {e}."),
    };
    format!(
        "Force: {}; m = {:.3} kg, C = {:.4e} kPa·mm³/g, ν = {:.4}.{effects}",
        saved.model.force.describe(),
        p.mass_kg,
        p.gas_coefficient,
        p.deformation
    )
}

/// Names and descriptions of a choice of the library.
pub(crate) fn possible_values<T: NamedChoice>() -> impl Iterator<Item = PossibleValue> {
    T::ALL.iter().map(|(name, _, description)| {
        PossibleValue::new(*name).help(*description).alias(name.replace('-', "_"))
    })
}

/// Parser of a choice of the library, with `possible_values`. Underscores may stand for hyphens.
pub fn choice<T: NamedChoice>() -> impl TypedValueParser<Value = T> {
    PossibleValuesParser::new(possible_values::<T>())
        .try_map(|name| T::from_name(&name.replace('_', "-")))
}

/// Parser of a value that the library knows by one of `names`.
pub fn named<T: Clone + Send + Sync + 'static>(
    names: Vec<&'static str>,
    from_name: fn(&str) -> Result<T, ModelError>,
) -> impl TypedValueParser<Value = T> {
    PossibleValuesParser::new(names).try_map(move |name| from_name(&name))
}

/// How recordings are read.
#[derive(Debug, Clone, Args)]
pub struct DataOptions {
    /// Source of the sealed air masses; masses that a file gives always win
    #[arg(long, value_parser = choice::<MassChoice>(), default_value = "auto", value_name = "SOURCE")]
    pub masses: MassChoice,
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
    /// The zero of the pressures of CSV, .npz and .mat data; raw logs are gauge
    #[arg(long, alias = "mat-pressure", value_parser = choice::<PressureReference>(), default_value = "auto", value_name = "REFERENCE")]
    pub pressure: PressureReference,
}

impl DataOptions {
    /// The loader's options.
    ///
    /// # Errors
    /// [`CliError::Usage`] naming a loader option that does not exist.
    pub fn load_options(&self, rig: Option<RigFile>) -> Result<LoadOptions, CliError> {
        let mut options = LoadOptions {
            rig,
            preprocess: self.preprocess,
            pressure_reference: self.pressure,
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

    /// How the masses are found.
    ///
    /// # Errors
    /// [`CliError::Data`] naming what is wrong with the file of the surfaces.
    pub fn mass_options(&self) -> Result<MassOptions, CliError> {
        let surfaces = self.surfaces.as_deref().map(MuscleSurfaces::read).transpose()?;
        Ok(MassOptions { choice: self.masses, surfaces })
    }

    /// Reads recordings of files and folders, of a rig if there is one, with a progress bar.
    ///
    /// # Errors
    /// [`CliError`] naming file, line and column, or the option.
    pub fn recordings(
        &self,
        paths: &[impl AsRef<Path>],
        rig: Option<RigFile>,
        console: &Console,
    ) -> Result<Vec<Recording>, CliError> {
        let options = self.load_options(rig)?;
        let paths = collect_paths_of(paths, options.rig.as_ref())?;
        let bar = console.progress(paths.len(), "reading");
        let recordings = read_files(&paths, &options, &|| bar.inc(1));
        bar.finish_and_clear();
        Ok(recordings?)
    }

    /// Reads recordings with their masses for a model, prints their notes, and checks them against the physics of
    /// the joint. They are read as files of the rig of `--rig-file`, or of the rig of the model.
    ///
    /// # Errors
    /// As [`recordings`](Self::recordings); [`CliError::Failed`] if units, columns or signs are wrong and `--accept`
    /// is not given.
    pub fn subjects(
        &self,
        paths: &[impl AsRef<Path>],
        saved: &SavedModel,
        global: &GlobalOptions,
        console: &Console,
    ) -> Result<Vec<Subject>, CliError> {
        let subjects = self.unchecked_subjects(paths, saved, global, console)?;
        check_plausible(saved, &subjects, global, console)?;
        Ok(subjects)
    }

    /// [`subjects`](Self::subjects) without the check.
    ///
    /// # Errors
    /// As [`recordings`](Self::recordings).
    pub fn unchecked_subjects(
        &self,
        paths: &[impl AsRef<Path>],
        saved: &SavedModel,
        global: &GlobalOptions,
        console: &Console,
    ) -> Result<Vec<Subject>, CliError> {
        let masses = self.mass_options()?;
        let rig = global.rig()?.or_else(|| saved.info.rig.clone());
        let subjects = Subject::resolve(self.recordings(paths, rig, console)?, saved, &masses)?;
        subjects.iter().for_each(|s| console.notes(&s.recording));
        Ok(subjects)
    }

    /// The options as JSON, for run folders.
    ///
    /// # Errors
    /// As [`load_options`](DataOptions::load_options).
    pub fn to_json(&self, global: &GlobalOptions) -> Result<Value, CliError> {
        let load = self.load_options(global.rig()?)?;
        Ok(json!({
            "masses": format!("{:?}", self.masses).to_lowercase(),
            "surfaces": self.surfaces,
            "preprocess": self.preprocess,
            "pressure": format!("{:?}", self.pressure).to_lowercase(),
            "raw_log": load.raw_log,
            "rig": load.rig,
            "accept": global.accept,
        }))
    }
}

/// Prints what in recordings contradicts the physics of the joint.
///
/// # Errors
/// [`CliError::Failed`] if that is certain and `--accept` is not given.
pub fn check_plausible(
    saved: &SavedModel,
    subjects: &[Subject],
    global: &GlobalOptions,
    console: &Console,
) -> Result<(), CliError> {
    let settings = PlausibilitySettings::for_model(saved);
    let findings = plausibility::check_with(&saved.model, subjects, &settings);
    let errors = plausibility::errors(&findings);
    if !(errors.is_empty() || global.accept) {
        let sentences: Vec<String> = errors.iter().map(ToString::to_string).collect();
        return Err(CliError::Failed(format!(
            "{}. Look at the data with `pam inspect`, describe them with --rig-file, or use them all the same with \
             --accept",
            sentences.join("; ")
        )));
    }
    findings.iter().for_each(|finding| console.warn(finding.to_string()));
    check_quality(subjects, global, console)
}

/// Prints what makes recordings worth less than they look: clipped, dead and delayed channels.
///
/// # Errors
/// [`CliError::Failed`] if a channel is clipped or dead and `--accept` is not given.
pub fn check_quality(
    subjects: &[Subject],
    global: &GlobalOptions,
    console: &Console,
) -> Result<(), CliError> {
    let mut errors = Vec::new();
    for subject in subjects {
        let quality = quality::assess(&subject.recording, &QualitySettings::default());
        for finding in quality.findings {
            let sentence = format!("{}: {}", quality.recording, finding.message);
            match (finding.severity, finding.kind) {
                (Severity::Error, _) if !global.accept => errors.push(sentence),
                (Severity::Error, _) | (_, QualityKind::Delay | QualityKind::Dead) => {
                    console.warn(sentence);
                }
                // The rest is for `pam inspect`: it limits what can be learned, and nothing is wrong.
                _ => {}
            }
        }
    }
    if errors.is_empty() {
        return Ok(());
    }
    Err(CliError::Failed(format!(
        "{}. Look at the data with `pam inspect --out DIR`, or use them all the same with --accept",
        errors.join("; ")
    )))
}

/// With which method the equations are solved.
#[derive(Debug, Clone, Args)]
pub struct SolverOptions {
    /// Method, by its name.
    #[arg(long, alias = "solver", default_value = AUTO, value_name = "NAME", help = solver_methods())]
    pub method: String,
    /// Steps and input.
    #[command(flatten)]
    pub steps: StepOptions,
}

/// Help of `--method` of the commands that simulate.
fn solver_methods() -> String {
    format!(
        "exact (closed form, for networks of leaky_relu or relu), a Runge–Kutta method ({}), or auto: exact \
         where it applies and no steps or tolerances are given, else tsit5",
        Tableau::NAMES.join(", ")
    )
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
    #[arg(long, value_parser = choice::<Interpolation>(), default_value = "zoh", value_name = "HOW")]
    pub input: Interpolation,
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
    /// True if steps or tolerances are given.
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
        let tableau = Tableau::from_name(method).map_err(usage)?;
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
        Ok(SolverSettings { tableau, step, interpolation: self.input })
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
