//! `pam gradient`.

mod reference;

use super::RunCommand;
use crate::PARTIAL;
use crate::arguments::GlobalOptions;
use crate::console::{Console, table};
use crate::error::{CliError, failed, usage};
use crate::options::{DataOptions, ModelOptions, StepOptions, choice, describe_model, solver_json};
use crate::output::Output;
use crate::run_record::made_by;
use clap::Args;
use clap::builder::PossibleValuesParser;
use pam_core::{ModelError, NamedChoice, ParametricForce};
use pam_data::atomic::write_atomic;
use pam_data::formats::npz::{self, Array};
use pam_data::{SavedModel, Subject};
use pam_effects::engine::{AUTO, EXACT, EngineChoice, SURROGATE, choose};
use pam_numerics::statistics::median;
use pam_report::{GradientBlock, GradientReport, gradient_report};
use pam_solvers::Tableau;
use pam_trajectory::engine::{Precision, Progress};
use pam_trajectory::{
    AnyLoss, GradientChoice, SettingsError, SolverSettings, StepChoice, TrajectoryGradient,
    TrajectoryRequest, Windows,
};
use reference::{largest_error_mm, reference_displacements};
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Instant;

/// Arguments of `pam gradient`.
#[derive(Debug, Args)]
pub struct GradientArguments {
    /// The model.
    #[command(flatten)]
    pub model: ModelOptions,
    /// Recordings, or folders of them; each is predicted from its first row
    #[arg(long, required = true, num_args = 1.., value_name = "PATH")]
    pub data: Vec<PathBuf>,
    /// Loss, averaged over the recordings.
    #[arg(long, default_value = "paper", value_name = "NAME[:KEY=VALUE,…]", value_parser = NamedLoss::parse, help = losses())]
    pub loss: NamedLoss,
    /// Gradient method, by its name.
    #[arg(long, default_value = "auto", value_name = "NAME", help = gradient_methods())]
    pub method: String,
    /// Runge–Kutta method [default: tsit5]
    #[arg(long, value_name = "NAME", value_parser = tableaux())]
    pub solver: Option<String>,
    /// Float of the network; f32 goes with the adjoint of a network
    #[arg(long, value_parser = choice::<Precision>(), default_value = "f64", value_name = "FLOAT")]
    pub precision: Precision,
    /// Number of timed repeats; their median is reported
    #[arg(long, default_value_t = 1, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    pub repeat: u32,
    /// .npz with true displacements (mm), for the largest error: `x` [recordings, samples] in the order of
    /// --data or of an array `names`, or one array a recording, x_0, x_1, … or named as the recordings
    #[arg(long, value_name = "FILE.npz")]
    pub reference: Option<PathBuf>,
    /// File for loss, gradient and time
    #[arg(long, value_name = "FILE.npz")]
    pub out: PathBuf,
    /// Also write a report with figures
    #[arg(long, value_name = "FILE.html")]
    pub report: Option<PathBuf>,
    /// How recordings are read.
    #[command(flatten)]
    pub reading: DataOptions,
    /// Steps and input.
    #[command(flatten)]
    pub steps: StepOptions,
}

/// Parser of `pam gradient --solver`.
fn tableaux() -> PossibleValuesParser {
    Tableau::NAMES.iter().copied().chain([EXACT, SURROGATE]).into()
}

/// A loss with the text that names it.
#[derive(Debug, Clone)]
pub struct NamedLoss {
    /// The text as given.
    pub text: String,
    /// The loss.
    pub loss: AnyLoss,
}

impl NamedLoss {
    fn parse(text: &str) -> Result<Self, SettingsError> {
        Ok(Self { text: text.to_owned(), loss: text.parse()? })
    }
}

/// Help of `pam gradient --loss`.
fn losses() -> String {
    let named =
        AnyLoss::all().into_iter().map(|(name, description)| format!("{name} ({description})"));
    format!(
        "Loss, averaged over the recordings: {}. Fields as in a curriculum, lists with slashes: \
         squared:weights=100/100/1/1, huber:thresholds=0.5/5/2/2,weights=1/1/1/1, \
         masked:every=4,intervals_s=0..10/20..30,of=normalised",
        named.collect::<Vec<_>>().join(", ")
    )
}

/// Help of `pam gradient --method`.
fn gradient_methods() -> String {
    let named = GradientChoice::ALL.iter().map(|(name, c)| format!("{name} ({})", c.describe()));
    format!(
        "Gradient method: exact (closed form, for networks of leaky_relu or relu), surrogate (a piecewise polynomial of a \
         smooth network), {}, or auto: exact where \
         it applies, else adjoint",
        named.collect::<Vec<_>>().join(", ")
    )
}

impl RunCommand for GradientArguments {
    fn outputs(&self) -> Vec<Output<'_>> {
        [Some(&self.out), self.report.as_ref()]
            .into_iter()
            .flatten()
            .map(|p| Output::File(p))
            .collect()
    }

    fn run(&self, global: &GlobalOptions, console: &Console) -> Result<ExitCode, CliError> {
        if self.out.extension().is_none_or(|e| e != "npz") {
            return Err(CliError::Usage(format!("--out {} must end in .npz", self.out.display())));
        }
        let saved = self.model.load(global.rig_for(&self.data)?.as_ref())?;
        let choice = engine_choice(self, &saved)?;
        let subjects = self.reading.subjects(&self.data, &saved, global, console)?;
        let reference = match &self.reference {
            Some(path) => Some(reference_displacements(path, &subjects)?),
            None => None,
        };
        let settings = choice.settings_for(&saved.model.force, false);
        let windows = Windows::of(subjects, None);
        let work = Work { arguments: self, saved: &saved, windows: &windows, settings, choice };
        let measured = work.measure(console)?;
        work.check_travel(&measured)?;
        let x_error = reference.map(|r| largest_error_mm(&r, &measured));
        work.finish(&measured, x_error, global, console)
    }
}

/// Steps and gradient method. Without a word on either the exact method is taken where it applies, else
/// the adjoint of tsit5.
fn engine_choice(
    arguments: &GradientArguments,
    saved: &SavedModel,
) -> Result<EngineChoice, CliError> {
    let solver = arguments.solver.as_deref();
    let precision = arguments.precision;
    let single = precision == Precision::F32;
    let (settings, gradient) = match arguments.method.as_str() {
        method @ (EXACT | SURROGATE) if solver.is_some_and(|s| s != method) => {
            return Err(CliError::Usage(format!(
                "--method {method} solves in its own way; drop --solver"
            )));
        }
        method @ (EXACT | SURROGATE) if single => {
            return Err(CliError::Usage(format!(
                "--method {method} runs in doubles; drop --precision"
            )));
        }
        // Their gradients are the adjoints of their own steps.
        method @ (EXACT | SURROGATE) => {
            (arguments.steps.settings_for(method, saved)?, GradientChoice::Adjoint)
        }
        AUTO if solver.is_none() && !single => {
            (arguments.steps.settings_for(AUTO, saved)?, GradientChoice::Adjoint)
        }
        method => {
            let choice = match method {
                AUTO => GradientChoice::Adjoint,
                _ => GradientChoice::from_name(method).map_err(with_own_names).map_err(usage)?,
            };
            (arguments.steps.settings(solver.unwrap_or("tsit5"))?, choice)
        }
    };
    Ok(EngineChoice { settings, automatic: false, gradient, precision })
}

/// The error of an unknown method, with the names that only the command knows.
fn with_own_names(error: ModelError) -> ModelError {
    match error {
        ModelError::UnknownName { kind, name, known } => {
            let known = format!("{known}, {EXACT}, {SURROGATE}, {AUTO}");
            ModelError::UnknownName { kind, name, known }
        }
        other => other,
    }
}

/// A gradient to compute.
struct Work<'a> {
    arguments: &'a GradientArguments,
    saved: &'a SavedModel,
    windows: &'a Windows,
    settings: SolverSettings,
    choice: EngineChoice,
}

/// A gradient with the median time it took, and the predicted states of each recording.
struct Measured {
    gradient: TrajectoryGradient,
    states: Vec<Vec<[f64; 4]>>,
    seconds: f64,
}

/// The tasks of an engine on a progress bar.
struct Bar(indicatif::ProgressBar);

impl Progress for Bar {
    fn planned(&self, tasks: usize) {
        self.0.set_length(tasks as u64);
    }

    fn done(&self) {
        self.0.inc(1);
    }
}

impl Work<'_> {
    /// Name of the method.
    fn method(&self) -> &'static str {
        match self.settings.step {
            StepChoice::Exact => EXACT,
            StepChoice::Surrogate => SURROGATE,
            _ => self.choice.gradient.name(),
        }
    }

    fn subjects(&self) -> &[Subject] {
        self.windows.subjects()
    }

    /// Refuses predictions in which a chamber has no volume left: the joint has run away, and neither loss nor gradient
    /// means anything.
    fn check_travel(&self, measured: &Measured) -> Result<(), CliError> {
        let model = &self.saved.model;
        let limit = model.geometry.displacement_limit_mm(model.physical().deformation);
        for (k, (subject, states)) in self.subjects().iter().zip(&measured.states).enumerate() {
            let stopped = measured.gradient.failures.iter().any(|f| f.problem == k);
            let past = states.iter().position(|y| y[0].is_nan() || y[0].abs() >= limit);
            if let Some(i) = past.filter(|_| !stopped) {
                return Err(failed(format!(
                    "{}: the predicted x = {:.1} mm at t = {:.4} s is past ±{limit:.1} mm, where a chamber has no volume \
                     left; the force or the model is not of this joint, and its gradient means nothing",
                    subject.recording.name, states[i][0], subject.recording.time_s[i]
                )));
            }
        }
        Ok(())
    }

    /// The last of the repeated gradients, with the median time.
    fn measure(&self, console: &Console) -> Result<Measured, CliError> {
        let model = &self.saved.model;
        let mut engine = choose(&model.force, &[], &self.choice).map_err(usage)?;
        if self.choice.precision != engine.precision() {
            return Err(CliError::Usage(
                "--precision f32 is for the adjoint of a network; all else runs in doubles".into(),
            ));
        }
        let mut times = Vec::new();
        loop {
            let bar = Bar(console.progress(self.subjects().len(), "differentiating"));
            let request = TrajectoryRequest {
                progress: Some(&bar),
                ..TrajectoryRequest::new(model, self.windows)
            };
            let start = Instant::now();
            let gradient =
                engine.value_and_gradient(&request, &self.arguments.loss.loss).map_err(failed)?;
            times.push(start.elapsed().as_secs_f64());
            bar.0.finish_and_clear();
            if times.len() == self.arguments.repeat as usize {
                let states = (0..self.subjects().len()).map(|i| engine.predicted(i).to_vec());
                let seconds = median(&times);
                return Ok(Measured { gradient, states: states.collect(), seconds });
            }
        }
    }

    /// Writes the files, prints the summary, and says with which code to end.
    fn finish(
        &self,
        measured: &Measured,
        x_error_mm: Option<f64>,
        global: &GlobalOptions,
        console: &Console,
    ) -> Result<ExitCode, CliError> {
        let gradient = &measured.gradient;
        for failure in &gradient.failures {
            let name = &self.subjects()[failure.problem].recording.name;
            console.warn(format!(
                "{name} adds nothing, its prediction stopped: {}",
                failure.kind.describe(failure.time_s)
            ));
        }
        if gradient.failures.len() == self.subjects().len() {
            return Err(failed("no recording could be predicted to its end"));
        }
        let arrays = self.arrays(measured, x_error_mm);
        npz::write(&self.arguments.out, &arrays)?;
        let blocks = blocks(&arrays);
        if let Some(path) = &self.arguments.report {
            write_atomic(path, self.report(measured, x_error_mm, &blocks).as_bytes())?;
        }
        let s = &gradient.statistics;
        console.json(&json!({
            "loss": gradient.value,
            "recordings": self.subjects().iter().zip(&gradient.values).map(|(subject, value)| json!({
                "name": subject.recording.name,
                "loss": value,
            })).collect::<Vec<_>>(),
            "gradient_norm": blocks.iter().map(|b| (b.name.clone(), json!(b.norm())))
                .collect::<serde_json::Map<String, Value>>(),
            "value_and_grad_s": measured.seconds,
            "x_error_mm": x_error_mm,
            "loss_name": self.arguments.loss.text,
            "method": self.method(),
            "precision": self.arguments.precision.name(),
            "solver": solver_json(&self.settings),
            "accepted_steps": s.accepted,
            "rejected_steps": s.rejected,
            "field_evaluations": s.evaluations,
            "field_pullbacks": s.pullbacks,
            "stored_bytes": s.stored_bytes,
            "failures": gradient.failures.iter().map(|f| json!({
                "name": self.subjects()[f.problem].recording.name,
                "time_s": f.time_s,
                "why": f.kind.describe(f.time_s),
            })).collect::<Vec<_>>(),
            "seed": global.seed,
            "made_by": made_by(),
        }));
        console.text(self.summary(measured, x_error_mm, &blocks));
        Ok(if gradient.failures.is_empty() { ExitCode::SUCCESS } else { ExitCode::from(PARTIAL) })
    }

    /// The arrays of the output file.
    fn arrays(&self, measured: &Measured, x_error_mm: Option<f64>) -> BTreeMap<String, Array> {
        let g = &measured.gradient;
        let mut arrays = BTreeMap::new();
        // The gradient has the shape of the force, so it is stored as one.
        let parts = self.saved.model.force.with_parameters(&g.force).to_parts();
        for (name, tensor) in parts.tensors {
            let shape = tensor.shape.iter().map(|&n| n as u64).collect();
            arrays.insert(format!("grad_{name}"), Array { shape, values: tensor.values });
        }
        let raw = vec![g.raw.mass, g.raw.gas_coefficient, g.raw.deformation];
        arrays.insert("grad_raw".into(), Array::vector(raw));
        arrays.insert("grad_auxiliary_damping".into(), Array::scalar(g.auxiliary_damping));
        let rows = |width: u64, values: Vec<f64>| Array {
            shape: vec![values.len() as u64 / width, width],
            values,
        };
        let masses = g.masses.iter().flat_map(|m| [m.flexor_g, m.extensor_g]).collect();
        arrays.insert("grad_masses".into(), rows(2, masses));
        let states = g.initial_states.iter().flatten().copied().collect();
        arrays.insert("grad_initial_state".into(), rows(4, states));
        arrays.insert("loss".into(), Array::scalar(g.value));
        arrays.insert("loss_of_recording".into(), Array::vector(g.values.clone()));
        arrays.insert("value_and_grad_s".into(), Array::scalar(measured.seconds));
        if let Some(error) = x_error_mm {
            arrays.insert("x_error_mm".into(), Array::scalar(error));
        }
        arrays
    }

    fn summary(
        &self,
        measured: &Measured,
        x_error: Option<f64>,
        blocks: &[GradientBlock],
    ) -> String {
        let (g, s) = (&measured.gradient, &measured.gradient.statistics);
        let mut rows = vec![["gradient", "numbers", "norm", "largest"].map(str::to_owned).to_vec()];
        rows.extend(blocks.iter().map(|b| {
            vec![
                b.name.clone(),
                b.values.len().to_string(),
                format!("{:.6e}", b.norm()),
                format!("{:.6e}", b.largest()),
            ]
        }));
        let mut text = format!(
            "{} loss {:.9e} over {} recording(s), {} in {:.4} s\n\n{}\n\n  {} steps, {} rejected, {} \
             evaluations, {} pullbacks, {:.1} MB stored",
            self.arguments.loss.text,
            g.value,
            self.subjects().len() - g.failures.len(),
            self.method(),
            measured.seconds,
            table(&rows),
            s.accepted,
            s.rejected,
            s.evaluations,
            s.pullbacks,
            s.stored_bytes as f64 / 1e6
        );
        if let Some(error) = x_error {
            text += &format!("\n  largest error of x against the reference: {error:.6e} mm");
        }
        text + &format!("\n\ngradient: {}", self.arguments.out.display())
    }

    fn report(
        &self,
        measured: &Measured,
        x_error: Option<f64>,
        blocks: &[GradientBlock],
    ) -> String {
        let g = &measured.gradient;
        gradient_report(&GradientReport {
            title: format!("Gradient of {}", self.saved.info.name),
            lead: format!(
                "{} {} loss. {}; gradient by {}, network in {}.",
                describe_model(self.saved),
                self.arguments.loss.text,
                self.settings.describe(),
                self.method(),
                self.arguments.precision.name()
            ),
            loss: g.value,
            seconds: measured.seconds,
            x_error_mm: x_error,
            recordings: self
                .subjects()
                .iter()
                .zip(&g.values)
                .enumerate()
                .map(|(i, (s, &loss))| (s.recording.clone(), loss, measured.states[i].clone()))
                .collect(),
            blocks: blocks.to_vec(),
            made_by: made_by(),
        })
    }
}

/// The gradient arrays of an output file.
fn blocks(arrays: &BTreeMap<String, Array>) -> Vec<GradientBlock> {
    arrays
        .iter()
        .filter_map(|(name, array)| {
            let name = name.strip_prefix("grad_")?.to_owned();
            Some(GradientBlock { name, values: array.values.clone() })
        })
        .collect()
}
