//! Losses: by name, or a Python function.

use crate::arrays::rows;
use crate::errors::settings;
use crate::recording::Recording;
use crate::watch::Stop;
use numpy::{PyReadonlyArray2, PyUntypedArrayMethods};
use pam_trajectory::{AnyLoss, TrajectoryLoss};
use pyo3::prelude::*;
use std::sync::Arc;

/// A loss of one predicted recording.
pub(crate) enum Loss {
    /// One of the framework.
    Named(AnyLoss),
    /// `loss(recording, predicted) -> (value, cotangents)` with arrays `[samples, 4]`.
    Function(Py<PyAny>),
}

impl Loss {
    /// A loss from a name with fields (`huber:thresholds=0.5/5/2/2,…`), from JSON, or a function.
    pub(crate) fn of(loss: &Bound<'_, PyAny>) -> PyResult<Self> {
        if loss.is_callable() {
            return Ok(Self::Function(loss.clone().unbind()));
        }
        let text: String = loss.extract().map_err(|_| {
            settings("`loss` must be a name, a dict, or a function of (recording, predicted)")
        })?;
        let named: AnyLoss = if text.starts_with('{') {
            serde_json::from_str(&text).map_err(|e| settings(format!("loss: {e}")))?
        } else {
            text.parse().map_err(|e| settings(format!("{e}")))?
        };
        named.check().map_err(|e| settings(format!("loss: {e}")))?;
        Ok(Self::Named(named))
    }

    /// The value, with the derivative by the predicted states in `cotangents`. What a function raises stops the work.
    pub(crate) fn value_and_cotangents(
        &self,
        measured: &pam_data::Recording,
        predicted: &[[f64; 4]],
        cotangents: &mut [[f64; 4]],
        stop: &Stop,
    ) -> f64 {
        match self {
            Self::Named(loss) => loss.value_and_cotangents(measured, predicted, cotangents),
            Self::Function(function) => {
                let called = call(function, measured, predicted, cotangents);
                called.unwrap_or_else(|error| {
                    stop.ask(error);
                    f64::NAN
                })
            }
        }
    }
}

fn call(
    function: &Py<PyAny>,
    measured: &pam_data::Recording,
    predicted: &[[f64; 4]],
    cotangents: &mut [[f64; 4]],
) -> PyResult<f64> {
    Python::attach(|py| {
        let recording = Recording::wrapped(py, Arc::new(measured.clone()))?;
        let result = function.bind(py).call1((recording, rows(py, predicted)))?;
        let (value, slopes): (f64, PyReadonlyArray2<'_, f64>) = result.extract().map_err(|_| {
            settings(
                "the loss must return (value, cotangents): a number, and an array of float64 of the shape of `predicted`",
            )
        })?;
        if slopes.shape() != [predicted.len(), 4] {
            return Err(settings(format!(
                "the loss returned cotangents of shape {:?}, predicted has [{}, 4]",
                slopes.shape(),
                predicted.len()
            )));
        }
        for (to, from) in cotangents.iter_mut().zip(slopes.as_array().outer_iter()) {
            *to = std::array::from_fn(|i| from[i]);
        }
        Ok(value)
    })
}
