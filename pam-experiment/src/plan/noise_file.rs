//! The noise of the channels from a file.

use crate::error::ExperimentError;
use pam_data::{DataError, toml_file};
use pam_diagnose::noise::{Autoregression, Noise};
use serde::Deserialize;
use std::path::Path;

/// Orders of the autoregression of a channel that is correlated.
const ORDER: usize = 8;

/// The noise of one channel.
#[derive(Debug, Clone, Copy, Deserialize)]
#[serde(deny_unknown_fields)]
struct Channel {
    /// Standard deviation of means over a row of 20 ms, in the unit of the channel.
    deviation: f64,
    /// Time in which the autocorrelation falls to 1/e, s; 0 for white noise.
    #[serde(default)]
    correlation_s: f64,
}

/// A file of noise.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    x_mm: Channel,
    pressure_flexor_kpa: Channel,
    pressure_extensor_kpa: Channel,
}

/// The noise of x, P_f and P_e from TOML; `row_s` is the time between two rows of a diagnosis (20 ms unless its settings say
/// otherwise).
///
/// ```
/// use pam_experiment::plan::noise_from_toml;
/// let text = "x_mm = { deviation = 0.004 }\n\
///     pressure_flexor_kpa = { deviation = 0.1, correlation_s = 0.05 }\n\
///     pressure_extensor_kpa = { deviation = 0.1, correlation_s = 0.05 }";
/// let noise = noise_from_toml(text, "noise.toml", 0.02)?;
/// assert!((noise.deviation(1) - 0.1).abs() < 1e-12);
/// # Ok::<(), pam_experiment::ExperimentError>(())
/// ```
///
/// # Errors
/// [`ExperimentError::Data`] naming file, line and field.
pub fn noise_from_toml(
    text: &str,
    path: impl AsRef<Path>,
    row_s: f64,
) -> Result<Noise, ExperimentError> {
    let path = path.as_ref();
    let file: File = toml_file::parse(text, path)?;
    let channels = [
        ("x_mm", file.x_mm),
        ("pressure_flexor_kpa", file.pressure_flexor_kpa),
        ("pressure_extensor_kpa", file.pressure_extensor_kpa),
    ];
    let mut all = Vec::new();
    for (name, c) in channels {
        let allowed = [(c.deviation, f64::MIN_POSITIVE), (c.correlation_s, 0.0)];
        if allowed.iter().any(|(value, least)| !(*least..f64::INFINITY).contains(value)) {
            let message = format!(
                "{name}: `deviation` must be positive and `correlation_s` not negative, got {} and {}",
                c.deviation, c.correlation_s
            );
            return Err(DataError::file(path, message).into());
        }
        let share = if c.correlation_s > 0.0 { (-row_s / c.correlation_s).exp() } else { 0.0 };
        let gamma: Vec<f64> =
            (0..=ORDER).map(|lag| c.deviation.powi(2) * share.powi(lag as i32)).collect();
        all.push(Autoregression::of_autocovariance(&gamma, 1e6));
    }
    Ok(Noise::independent(all))
}
