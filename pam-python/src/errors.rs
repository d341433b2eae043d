//! Exceptions: the classes of `pam_ode.errors`, with what the framework's errors know.

use pam_baselines::BaselineError;
use pam_cli::CliError;
use pam_control::ControlError;
use pam_data::DataError;
use pam_train::curriculum::CurriculumError;
use pam_train::training::TrainingError;
use pam_trajectory::{EngineError, PredictError};
use pyo3::prelude::*;

/// An exception of a class of `pam_ode.errors` that carries attributes.
fn exception(
    class: &str,
    message: &str,
    attributes: impl FnOnce(&Bound<'_, PyAny>) -> PyResult<()>,
) -> PyErr {
    Python::attach(|py| {
        let make = || {
            let error =
                py.import("pam_ode.errors")?.getattr(class)?.call1((message.trim_end(),))?;
            attributes(&error)?;
            Ok(PyErr::from_value(error))
        };
        make().unwrap_or_else(|e: PyErr| e)
    })
}

fn plain(class: &str, message: &str) -> PyErr {
    exception(class, message, |_| Ok(()))
}

/// An argument that makes no sense.
pub(crate) fn settings(message: impl AsRef<str>) -> PyErr {
    plain("SettingsError", message.as_ref())
}

/// An effect that cannot be read.
pub(crate) fn effect(message: impl AsRef<str>) -> PyErr {
    plain("EffectError", message.as_ref())
}

/// The exception of an error of the framework.
pub(crate) fn raised(error: impl Into<CliError>) -> PyErr {
    let error = error.into();
    let text = error.to_string();
    match error {
        CliError::Data(e) => data(&e),
        CliError::Model(_) => plain("ModelError", &text),
        CliError::Rig(pam_rig::RigError::Data(e))
        | CliError::Training(TrainingError::Data(e))
        | CliError::Curriculum(CurriculumError::Data(e))
        | CliError::Control(ControlError::Data(e))
        | CliError::Baseline(BaselineError::Data(e)) => data(&e),
        CliError::Rig(_) => plain("RigError", &text),
        CliError::Control(ControlError::Motion { time_s, .. }) => {
            exception("ControlError", &text, |e| e.setattr("time_s", time_s))
        }
        CliError::Control(_) => plain("ControlError", &text),
        CliError::Curriculum(CurriculumError::Override { text, message }) => {
            settings(format!("`{text}`: {message}"))
        }
        CliError::Curriculum(_) | CliError::Usage(_) => settings(&text),
        CliError::Training(TrainingError::Engine(e)) => engine(&e),
        CliError::Training(TrainingError::Diverged { stage, epoch, .. }) => {
            exception("TrainingError", &text, |e| {
                e.setattr("stage", stage)?;
                e.setattr("epoch", epoch)
            })
        }
        CliError::Training(_) => plain("TrainingError", &text),
        CliError::Effect(_) => plain("EffectError", &text),
        CliError::Diagnose(_) => plain("DiagnoseError", &text),
        CliError::Baseline(_) => plain("ComparisonError", &text),
        CliError::Ablate(_) | CliError::Experiment(_) | CliError::Failed(_) => {
            plain("PamError", &text)
        }
    }
}

fn data(error: &DataError) -> PyErr {
    let (path, line, column) = match error {
        DataError::Io { path, .. } | DataError::File { path, .. } => (path, None, None),
        DataError::Line { path, line, .. } => (path, Some(*line), None),
        DataError::Cell { path, line, column, .. } => (path, Some(*line), Some(column.clone())),
    };
    exception("DataError", &error.to_string(), |e| {
        e.setattr("file", path.display().to_string())?;
        e.setattr("line", line)?;
        e.setattr("column", column)
    })
}

/// The exception of an engine's error.
pub(crate) fn engine(error: &EngineError) -> PyErr {
    match error {
        EngineError::Input(_) => plain("DataError", &error.to_string()),
        EngineError::Model(_) => plain("ModelError", &error.to_string()),
        EngineError::Request(_) => settings(error.to_string()),
        EngineError::Effect { .. } => plain("EffectError", &error.to_string()),
    }
}

/// The exception of a prediction that stopped early. Its `partial` is what was predicted until then, `[samples, 4]`.
pub(crate) fn predict(error: &PredictError, time_s: &[f64]) -> PyErr {
    let c = &error.partial.channels;
    let states: Vec<[f64; 4]> =
        (0..error.partial.len()).map(|k| [c.x[k], c.v[k], c.pf[k], c.pe[k]]).collect();
    exception("SolveError", &error.to_string(), |e| {
        e.setattr("recording", &error.name)?;
        let reached = states.len().checked_sub(1).and_then(|k| time_s.get(k));
        e.setattr("time_s", reached)?;
        e.setattr("partial", crate::arrays::rows(e.py(), &states))
    })
}
