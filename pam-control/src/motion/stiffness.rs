use super::spec::Words;
use crate::error::ControlError;
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;

/// Desired stiffness over time, N/mm.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum StiffnessProfile {
    /// The same at all times.
    Constant(f64),
    /// `mean + amplitude · sin(2π f t)`.
    Sine {
        /// Middle, N/mm.
        mean_n_mm: f64,
        /// Amplitude, N/mm.
        amplitude_n_mm: f64,
        /// Frequency, Hz.
        frequency_hz: f64,
    },
    /// One value after the other, each held for a time; then from the start again.
    Steps {
        /// The values, N/mm.
        values_n_mm: Vec<f64>,
        /// How long each is held, s.
        hold_s: f64,
    },
}

impl StiffnessProfile {
    /// Reads a profile: `150`, `sine:mean=150,A=10,f=0.1`, or `steps:140/150/160,hold=50`.
    ///
    /// # Errors
    /// [`ControlError::Spec`] saying what is wrong.
    pub fn parse(text: &str) -> Result<Self, ControlError> {
        if let Ok(value) = text.trim().parse::<f64>() {
            return if value.is_finite() && value > 0.0 {
                Ok(Self::Constant(value))
            } else {
                Err(ControlError::spec(text, "a stiffness must be positive and finite (N/mm)"))
            };
        }
        if let Some(rest) = text.strip_prefix("steps:") {
            let (list, hold) = rest
                .split_once(",hold=")
                .ok_or_else(|| ControlError::spec(text, "write steps:140/150/160,hold=SECONDS"))?;
            let number = |t: &str| {
                t.trim().parse::<f64>().ok().filter(|v| v.is_finite() && *v > 0.0).ok_or_else(
                    || ControlError::spec(text, format!("`{}` is not a positive number", t.trim())),
                )
            };
            let values_n_mm = list.split('/').map(number).collect::<Result<Vec<_>, _>>()?;
            return Ok(Self::Steps { values_n_mm, hold_s: number(hold)? });
        }
        let mut words = Words::parse(text)?;
        if words.kind != "sine" {
            return Err(ControlError::spec(
                text,
                "a stiffness is a number (N/mm), sine:mean=…,A=…,f=… or steps:…/…,hold=…",
            ));
        }
        let (mean_n_mm, amplitude_n_mm) = (words.take_positive("mean")?, words.take("A")?);
        let frequency_hz = words.take_positive("f")?;
        words.finish()?;
        if amplitude_n_mm.abs() >= mean_n_mm {
            return Err(ControlError::spec(text, "the stiffness must stay positive"));
        }
        Ok(Self::Sine { mean_n_mm, amplitude_n_mm, frequency_hz })
    }

    /// The stiffness at a time, N/mm.
    #[must_use]
    pub fn at(&self, time_s: f64) -> f64 {
        match self {
            Self::Constant(value) => *value,
            Self::Sine { mean_n_mm, amplitude_n_mm, frequency_hz } => {
                mean_n_mm + amplitude_n_mm * (TAU * frequency_hz * time_s).sin()
            }
            Self::Steps { values_n_mm, hold_s } => {
                // A sample that should lie on a step must not fall before it by rounding.
                let step = (time_s / hold_s + 1e-9).floor().max(0.0) as usize;
                values_n_mm[step % values_n_mm.len()]
            }
        }
    }
}
