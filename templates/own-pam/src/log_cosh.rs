//! A loss: the logarithm of the hyperbolic cosine, quadratic for small errors and linear for large ones.

use pam_cli::own::{Channel, NamedLoss, Recording, SettingsError, TrajectoryLoss};
use serde::{Deserialize, Serialize};

/// `Σ_c mean_k ln cosh((predicted − measured) / scale_c)`.
#[derive(Debug, Serialize, Deserialize)]
pub struct LogCosh {
    /// Scale of each channel: mm, mm/s, kPa, kPa.
    pub scales: [f64; 4],
}

/// What holds where a file gives no scales.
pub const LOG_COSH: LogCosh = LogCosh { scales: [0.1, 1.0, 5.0, 5.0] };

impl TrajectoryLoss for LogCosh {
    fn value_and_cotangents(
        &self,
        measured: &Recording,
        predicted: &[[f64; 4]],
        cotangents: &mut [[f64; 4]],
    ) -> f64 {
        let share = 1.0 / predicted.len() as f64;
        let mut value = 0.0;
        for (k, (p, w)) in predicted.iter().zip(cotangents).enumerate() {
            for (c, channel) in Channel::ALL.into_iter().enumerate() {
                let e = (p[c] - measured.channel(channel)[k]) / self.scales[c];
                // ln cosh e without overflow.
                value += share * (e.abs() + (-2.0 * e.abs()).exp().ln_1p() - 2.0_f64.ln());
                w[c] = share * e.tanh() / self.scales[c];
            }
        }
        value
    }

    fn check(&self) -> Result<(), SettingsError> {
        match self.scales.iter().all(|s| s.is_finite() && *s > 0.0) {
            true => Ok(()),
            false => Err(SettingsError(format!("scales must be positive, got {:?}", self.scales))),
        }
    }
}

impl NamedLoss for LogCosh {
    const NAME: &'static str = "log_cosh";
    const DESCRIPTION: &'static str =
        "logarithm of the hyperbolic cosine of the error over a scale";
}
