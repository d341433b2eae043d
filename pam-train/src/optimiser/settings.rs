//! The choice of an optimiser.

use super::{AdamSettings, LbfgsSettings};
use pam_core::settings::{SettingsError, require};
use serde::{Deserialize, Serialize};

/// An optimiser by its name: a table with `kind` and any of its settings; Adam by default.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "snake_case", deny_unknown_fields)]
pub enum OptimiserSettings {
    /// Adam (Kingma and Ba 2015). Defaults are those of the paper.
    Adam {
        /// Decay of the mean of gradients, 0.9.
        #[serde(default = "beta1")]
        beta1: f64,
        /// Decay of the mean of squared gradients, 0.999.
        #[serde(default = "beta2")]
        beta2: f64,
        /// Added to the root of the latter, 1e-8.
        #[serde(default = "epsilon")]
        epsilon: f64,
    },
    /// Adam with decoupled weight decay (Loshchilov and Hutter 2019).
    #[serde(rename = "adamw")]
    AdamW {
        /// As for Adam.
        #[serde(default = "beta1")]
        beta1: f64,
        /// As for Adam.
        #[serde(default = "beta2")]
        beta2: f64,
        /// As for Adam.
        #[serde(default = "epsilon")]
        epsilon: f64,
        /// Share by which coordinates shrink in a step of rate one, 0.01.
        #[serde(default = "weight_decay")]
        weight_decay: f64,
    },
    /// L-BFGS (Liu and Nocedal 1989).
    Lbfgs(LbfgsSettings),
}

fn beta1() -> f64 {
    AdamSettings::default().beta1
}

fn beta2() -> f64 {
    AdamSettings::default().beta2
}

fn epsilon() -> f64 {
    AdamSettings::default().epsilon
}

fn weight_decay() -> f64 {
    0.01
}

impl Default for OptimiserSettings {
    fn default() -> Self {
        Self::Adam { beta1: beta1(), beta2: beta2(), epsilon: epsilon() }
    }
}

impl OptimiserSettings {
    /// The settings of [`Adam`](super::Adam), unless this is L-BFGS.
    #[must_use]
    pub fn adam(&self) -> Option<AdamSettings> {
        match *self {
            Self::Adam { beta1, beta2, epsilon } => {
                Some(AdamSettings { beta1, beta2, epsilon, weight_decay: 0.0 })
            }
            Self::AdamW { beta1, beta2, epsilon, weight_decay } => {
                Some(AdamSettings { beta1, beta2, epsilon, weight_decay })
            }
            Self::Lbfgs(_) => None,
        }
    }

    /// Checks that each setting is in the range for which the method is defined.
    ///
    /// # Errors
    /// [`SettingsError`] naming the first that is not.
    pub fn check(&self) -> Result<(), SettingsError> {
        if let Self::Lbfgs(own) = self {
            return own.check();
        }
        let Some(AdamSettings { beta1, beta2, epsilon, weight_decay }) = self.adam() else {
            return Ok(());
        };
        for (name, beta) in [("beta1", beta1), ("beta2", beta2)] {
            require((0.0..1.0).contains(&beta), || {
                format!("{name} must be in [0, 1), got {beta}")
            })?;
        }
        require(epsilon.is_finite() && epsilon > 0.0, || {
            format!("epsilon must be positive and finite, got {epsilon}")
        })?;
        require(weight_decay.is_finite() && weight_decay >= 0.0, || {
            format!("weight_decay must be finite and not negative, got {weight_decay}")
        })
    }
}
