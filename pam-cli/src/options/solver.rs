//! With which method and steps the equations are solved.

use super::choice::choice;
use crate::error::{CliError, usage};
use clap::Args;
use pam_core::NamedChoice;
use pam_data::SavedModel;
use pam_effects::engine::{AUTO, EXACT, EngineChoice, SURROGATE};
use pam_solvers::{Interpolation, Tableau};
use pam_trajectory::{SolverSettings, StepChoice};
use serde_json::{Value, json};

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
        "exact (closed form, for networks of leaky_relu or relu), surrogate (a piecewise polynomial of a smooth force), a \
         Runge–Kutta method ({}), or auto: if no steps or tolerances are given, exact for such networks and surrogate for other \
         ones, and tsit5 where neither applies",
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
        let settings = self.steps.settings_for(&self.method, saved)?;
        let automatic = self.method == AUTO && !self.steps.are_given();
        Ok(if automatic && saved.info.effects.is_empty() {
            settings.for_prediction_of(&saved.model.force)
        } else {
            settings
        })
    }
}

impl StepOptions {
    /// True if steps or tolerances are given.
    #[must_use]
    pub fn are_given(&self) -> bool {
        self.step_ms.is_some() || self.rtol != DEFAULT_TOLERANCE || self.atol != DEFAULT_TOLERANCE
    }

    /// The settings for a model and a method: `exact`, `surrogate`, `auto` or a Runge–Kutta method.
    ///
    /// # Errors
    /// As [`settings`](Self::settings), and [`CliError::Usage`] if the exact method or a surrogate is asked for where
    /// it does not apply.
    pub fn settings_for(
        &self,
        method: &str,
        saved: &SavedModel,
    ) -> Result<SolverSettings, CliError> {
        if [EXACT, SURROGATE].contains(&method) {
            self.check_own_steps(method, saved)?;
        }
        if method == SURROGATE {
            return Ok(SolverSettings::surrogate(self.input));
        }
        let general =
            self.settings(if [AUTO, EXACT].contains(&method) { "tsit5" } else { method })?;
        let choice = EngineChoice {
            automatic: method == EXACT || (method == AUTO && !self.are_given()),
            ..EngineChoice::new(general)
        };
        let settings = choice.settings_for(&saved.model.force, !saved.info.effects.is_empty());
        match method {
            EXACT if settings.step != StepChoice::Exact => Err(CliError::Usage(format!(
                "--method exact is for networks of leaky_relu or relu; this model is a {}; leave \
                 --method out",
                saved.model.force.describe()
            ))),
            _ => Ok(settings),
        }
    }

    /// Checks that a method with steps of its own is given none, and that the model is one that it takes.
    fn check_own_steps(&self, method: &str, saved: &SavedModel) -> Result<(), CliError> {
        let refuse = |why: &str| Err(CliError::Usage(format!("--method {method}{why}")));
        if self.are_given() {
            return refuse(
                " takes no steps and has no error to control: drop --step-ms, --rtol and --atol",
            );
        }
        if !saved.info.effects.is_empty() {
            return refuse(": the model is extended by effects, which it does not simulate");
        }
        if self.input == Interpolation::Cubic {
            return refuse(" reads the force as zoh, linear or ramp, not cubic");
        }
        Ok(())
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
    let own = match settings.step {
        StepChoice::Exact => Some(EXACT),
        StepChoice::Surrogate => Some(SURROGATE),
        _ => None,
    };
    if let Some(method) = own {
        return json!({ "method": method, "input": settings.interpolation.name() });
    }
    let method = match settings.step {
        StepChoice::SurrogateElse { .. } => AUTO,
        _ => settings.tableau.name,
    };
    json!({
        "method": method,
        "step": settings.step,
        "input": settings.interpolation.name(),
    })
}
