//! How the rate of an optimiser changes over epochs, and when to stop.

use pam_core::settings::{SettingsError, require};
use serde::{Deserialize, Serialize};

/// The share of its base that a rate has in an epoch.
///
/// Every schedule may begin with `warm_up_epochs` (w, zero by default) in which the share rises
/// linearly, `(e + 1)/(w + 1)` in epoch e = 0, 1, …; what follows counts epochs from there, `t = e − w`.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "snake_case", deny_unknown_fields)]
pub enum Schedule {
    /// One, always.
    Constant {
        /// Epochs of linear rise.
        #[serde(default)]
        warm_up_epochs: usize,
    },
    /// `final + (1 − final) (1 + cos(π t/T))/2` with `T` the epochs after warm-up, so that the final
    /// share is that at the end of the last epoch (Loshchilov and Hutter 2017, without restarts).
    Cosine {
        /// Share at the end, 0 by default.
        #[serde(default)]
        final_share: f64,
        /// Epochs of linear rise.
        #[serde(default)]
        warm_up_epochs: usize,
    },
    /// The share is multiplied by `factor` after `patience` epochs in a row whose loss is not below
    /// `(1 − 10⁻⁴)` times the best one; the count starts again then. Epochs of warm-up set the best
    /// loss but are not counted.
    Plateau {
        /// Factor of the share, 0.5 by default.
        #[serde(default = "half")]
        factor: f64,
        /// Epochs without improvement, 10 by default.
        #[serde(default = "ten")]
        patience: usize,
        /// Share below which it does not fall, 10⁻³ by default.
        #[serde(default = "thousandth")]
        smallest_share: f64,
        /// Epochs of linear rise.
        #[serde(default)]
        warm_up_epochs: usize,
    },
    /// `per_epoch^t`.
    Exponential {
        /// Ratio of the shares of one epoch and the one before.
        per_epoch: f64,
        /// Epochs of linear rise.
        #[serde(default)]
        warm_up_epochs: usize,
    },
}

fn half() -> f64 {
    0.5
}

fn ten() -> usize {
    10
}

fn thousandth() -> f64 {
    1e-3
}

impl Default for Schedule {
    /// A constant rate from the start.
    fn default() -> Self {
        Self::Constant { warm_up_epochs: 0 }
    }
}

impl Schedule {
    /// Epochs of linear rise.
    #[must_use]
    pub fn warm_up_epochs(&self) -> usize {
        match *self {
            Self::Constant { warm_up_epochs }
            | Self::Cosine { warm_up_epochs, .. }
            | Self::Plateau { warm_up_epochs, .. }
            | Self::Exponential { warm_up_epochs, .. } => warm_up_epochs,
        }
    }

    /// Checks that shares are in [0, 1], ratios in (0, 1], and that patience is positive.
    ///
    /// # Errors
    /// [`SettingsError`] naming the first that is not.
    pub fn check(&self) -> Result<(), SettingsError> {
        let share = |name: &str, value: f64| {
            require((0.0..=1.0).contains(&value), || {
                format!("{name} must be in [0, 1], got {value}")
            })
        };
        let ratio = |name: &str, value: f64| {
            require(value > 0.0 && value <= 1.0, || {
                format!("{name} must be in (0, 1], got {value}")
            })
        };
        match *self {
            Self::Constant { .. } => Ok(()),
            Self::Cosine { final_share, .. } => share("final_share", final_share),
            Self::Plateau { factor, patience, smallest_share, .. } => {
                ratio("factor", factor)?;
                share("smallest_share", smallest_share)?;
                require(patience > 0, || "patience must be positive".into())
            }
            Self::Exponential { per_epoch, .. } => ratio("per_epoch", per_epoch),
        }
    }
}

/// Share of the best loss by which a loss must be below it to count as better on a plateau.
const IMPROVEMENT: f64 = 1e-4;

/// A schedule in operation. Its state can be written and read back.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Rate {
    /// The schedule.
    pub schedule: Schedule,
    /// Share that a plateau has come down to.
    share: f64,
    best: Option<f64>,
    /// Epochs since the best loss or the last reduction.
    waited: usize,
}

impl Rate {
    /// A schedule at its start.
    #[must_use]
    pub fn new(schedule: Schedule) -> Self {
        Self { schedule, share: 1.0, best: None, waited: 0 }
    }

    /// The rate of `epoch` (0, 1, …) out of `epochs`, in the unit of `base`. To be called once for each
    /// epoch, in order, with the loss that is known before its step; only a plateau looks at it. A loss
    /// that is not finite is never better, and does not count before a first one that is finite.
    pub fn next(&mut self, base: f64, epoch: usize, epochs: usize, loss: f64) -> f64 {
        let warm_up = self.schedule.warm_up_epochs();
        if let Schedule::Plateau { factor, patience, smallest_share, .. } = self.schedule {
            self.watch(loss, epoch >= warm_up);
            if self.waited >= patience.max(1) {
                self.share = (self.share * factor).max(smallest_share.min(self.share));
                self.waited = 0;
            }
        }
        if epoch < warm_up {
            return base * (epoch + 1) as f64 / (warm_up + 1) as f64;
        }
        let t = (epoch - warm_up) as f64;
        base * match self.schedule {
            Schedule::Constant { .. } => 1.0,
            Schedule::Cosine { final_share, .. } => {
                let done = (t / epochs.saturating_sub(warm_up).max(1) as f64).min(1.0);
                let cosine = 0.5 * (1.0 + (std::f64::consts::PI * done).cos());
                final_share + (1.0 - final_share) * cosine
            }
            Schedule::Plateau { .. } => self.share,
            Schedule::Exponential { per_epoch, .. } => per_epoch.powf(t),
        }
    }

    fn watch(&mut self, loss: f64, counts: bool) {
        let better = self.best.is_none_or(|best| loss < best - IMPROVEMENT * best.abs());
        if loss.is_finite() && better {
            self.best = Some(loss);
            self.waited = 0;
        } else if self.best.is_some() {
            self.waited += usize::from(counts);
        }
    }
}

/// Says stop after `patience` epochs in a row without a new best loss (Prechelt 1998). Its state can be
/// written and read back.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct EarlyStop {
    /// Epochs to wait.
    pub patience: usize,
    best: Option<f64>,
    waited: usize,
}

impl EarlyStop {
    /// Nothing seen yet.
    #[must_use]
    pub fn new(patience: usize) -> Self {
        Self { patience, best: None, waited: 0 }
    }

    /// Takes the loss of an epoch and says whether to stop. Any lower loss is a new best one; a loss
    /// that is not finite never is.
    #[must_use]
    pub fn stops(&mut self, loss: f64) -> bool {
        if loss.is_finite() && self.best.is_none_or(|best| loss < best) {
            self.best = Some(loss);
            self.waited = 0;
        } else {
            self.waited += 1;
        }
        self.waited >= self.patience.max(1)
    }

    /// The lowest loss so far.
    #[must_use]
    pub fn best(&self) -> Option<f64> {
        self.best
    }

    /// Epochs since that.
    #[must_use]
    pub fn waited(&self) -> usize {
        self.waited
    }
}
