//! The summary of a certificate, as a file of settings carries it.

use pam_data::document;
use serde::{Deserialize, Serialize};
use std::path::PathBuf;

/// How often the names of trials were right.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Trust {
    /// Logarithm of the odds from which trials count, against the model without any cause.
    pub log_odds: f64,
    /// Trials whose named set reached these odds, below those of the next entry.
    pub trials: u64,
    /// Those in which every name was right.
    pub right: u64,
    /// Exact 95 % limits of the share (Clopper and Pearson 1934).
    pub limits: [f64; 2],
}

/// What trials on one rig have shown of a diagnosis with these settings; the table `[certificate]` of a file of settings.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Certificate {
    /// Null sets: trials in which nothing was hidden.
    pub nulls: u64,
    /// Null sets in which something was named with these settings.
    pub false_alarms: u64,
    /// Exact 95 % limits of their share.
    pub false_alarm_limits: [f64; 2],
    /// The rate of false alarms that was asked for.
    pub level: f64,
    /// Shares of right names by the odds of the named set, ascending.
    pub trust: Vec<Trust>,
    /// Program, version and commit.
    pub made_by: String,
    /// Baseline recordings that the diagnoses had. A diagnosis with the certified settings needs them, or others of the same rig.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub baseline: Vec<PathBuf>,
}

impl Certificate {
    /// Takes the certificate out of a file of settings: the settings alone, and the certificate if there is one.
    ///
    /// # Errors
    /// A message if the text is no TOML or the certificate has other fields.
    pub fn split(text: &str) -> Result<(String, Option<Self>), String> {
        let mut table: toml::Table = toml::from_str(text).map_err(|e| e.message().to_owned())?;
        let Some(certificate) = table.remove("certificate") else {
            return Ok((text.to_owned(), None));
        };
        let certificate: Self = certificate
            .try_into()
            .map_err(|e: toml::de::Error| format!("certificate: {}", e.message()))?;
        let settings = document::to_toml(&table).map_err(|e| e.message().to_owned())?;
        Ok((settings, Some(certificate)))
    }

    /// The trials at the level of a named set.
    #[must_use]
    pub fn at(&self, log_odds: f64) -> Option<&Trust> {
        self.trust.iter().rev().find(|t| log_odds >= t.log_odds)
    }

    /// What the trials say of a named set with these odds, in a sentence.
    ///
    /// ```
    /// use pam_experiment::certify::{Certificate, Trust};
    /// let trust = Trust { log_odds: 3.0, trials: 240, right: 233, limits: [0.941, 0.988] };
    /// let certificate = Certificate {
    ///     nulls: 200, false_alarms: 4, false_alarm_limits: [0.005, 0.050], level: 0.05,
    ///     trust: vec![trust], made_by: String::new(), baseline: Vec::new(),
    /// };
    /// assert_eq!(
    ///     certificate.sentence(8.0),
    ///     "On this rig, names at this level were right in 97 % [94, 99] of 240 trials; in 4 of 200 null sets something was \
    ///      named (2.0 % [0.5, 5.0])."
    /// );
    /// ```
    #[must_use]
    pub fn sentence(&self, log_odds: f64) -> String {
        let percent = |v: f64| format!("{:.0}", 100.0 * v);
        let names = self.at(log_odds).filter(|t| t.trials > 0).map_or_else(
            || "On this rig, no trial reached this level".to_owned(),
            |t| {
                let share = t.right as f64 / t.trials as f64;
                let [low, high] = t.limits.map(percent);
                format!(
                    "On this rig, names at this level were right in {} % [{low}, {high}] of {} trials",
                    percent(share),
                    t.trials
                )
            },
        );
        if self.nulls == 0 {
            return format!("{names}; no null sets were diagnosed.");
        }
        let rate = self.false_alarms as f64 / self.nulls as f64;
        let [low, high] = self.false_alarm_limits.map(|v| 100.0 * v);
        format!(
            "{names}; in {} of {} null sets something was named ({:.1} % [{low:.1}, {high:.1}]).",
            self.false_alarms,
            self.nulls,
            100.0 * rate
        )
    }
}
