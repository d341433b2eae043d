//! The result of a diagnosis; `diagnosis.json`.

use crate::data::{TestData, ValidationData};
use crate::ladder::Ladder;
use crate::onset::{LateFault, OnsetTest};
use crate::rejection::NullTest;
use crate::remainder::Remainder;
use crate::residual::ResidualSummary;
use crate::search::OutputInfo;
use crate::test_set::{ErrorReduction, Trace};
use crate::verdict::{Anomaly, Cause, ChannelBand, Rank, Refused, Verdict};
use serde::Serialize;
use serde_json::Value;

/// The stages of a diagnosis.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Stage {
    /// Preparing the recordings.
    Preparing,
    /// Learning the baseline discrepancy.
    Baseline,
    /// Trying candidates.
    Searching,
    /// Weighing names and measuring the error reduction.
    Judging,
    /// Fitting the error that remains after the named causes.
    Learning,
}

impl Stage {
    /// Label of the stage for a progress bar, and the completed share of the whole when this share of the stage is complete. The
    /// whole is the diagnosis or, for [`Stage::Learning`], the fit of the remaining error.
    #[must_use]
    pub fn progress(self, share: f64) -> (&'static str, f64) {
        let (from, to, what) = match self {
            Self::Preparing => (0.0, 0.05, "preparing"),
            Self::Baseline => (0.05, 0.35, "baseline discrepancy"),
            Self::Searching => (0.35, 0.9, "trying causes"),
            Self::Judging => (0.9, 1.0, "measuring"),
            Self::Learning => (0.0, 1.0, "fitting the remaining error"),
        };
        (what, from + share * (to - from))
    }
}

/// Shares of the error of the test set above the noise.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Explainable {
    /// Share that a flexible model without names removes.
    pub any_correction: f64,
    /// Share that the named causes remove.
    pub named: f64,
}

/// How probable the named set is, from training and validation rows.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct SetScore {
    /// Logarithm of its posterior probability, up to a constant that all sets share: the log-likelihood of the whitened
    /// rows, with the noise that was learned beside the set, less the prices of parameters, choices and nuisances.
    pub log_posterior: f64,
    /// Logarithm of its odds against the system without any cause; 0 where nothing is named.
    pub log_odds: f64,
}

/// The result of a diagnosis; `model` is the system's own part of it.
#[derive(Debug, Clone, Serialize)]
pub struct Diagnosis<M> {
    /// The outcome.
    pub verdict: Verdict,
    /// Named causes, the largest share of the error first.
    pub causes: Vec<Cause>,
    /// Causes that remove next to nothing of the error, or may be there by chance beside larger ones.
    pub minor: Vec<Cause>,
    /// Reasons against `explained`, or for an error without a name, in sentences.
    pub reasons: Vec<String>,
    /// Each channel of the test data beside its noise.
    pub bands: Vec<ChannelBand>,
    /// Features of the remaining residual that noise does not have.
    pub anomalies: Vec<Anomaly>,
    /// Candidates that are not named, and why; the most probable first.
    pub refused: Vec<Refused>,
    /// The score of the named causes together.
    pub score: SetScore,
    /// Every candidate alone, best first.
    pub ranking: Vec<Rank>,
    /// The residual before any cause is named.
    pub residual: ResidualSummary,
    /// Errors before and after on the test set.
    pub error_reduction: ErrorReduction,
    /// Removable and removed shares of the error of the test set.
    pub explainable: Explainable,
    /// The max-statistic null test; absent if there is no residual.
    pub null_test: Option<NullTest>,
    /// The model of the error that no listed cause explains; absent if none was asked for or the model is inadequate.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub remainder: Option<Remainder>,
    /// The test of the best beginning or end against chance; absent where none may reach the odds.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub onset_test: Option<OnsetTest>,
    /// Change of the simulation of the test data by the named causes, in standard deviations, if it is too small to test them; absent if
    /// the test data confirm them, or nothing is named.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub untested_change: Option<f64>,
    /// What is there in the test data only, if the rest of the error looks like it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub late_fault: Option<LateFault>,
    /// A ladder that was climbed on the same data.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub ladder: Option<Ladder>,
    /// By how much the named beginning or end would lower the weighted squared residual at each time (s), to first order, in
    /// each open recording; for figures.
    #[serde(skip)]
    pub onset_curves: Vec<(String, Vec<(f64, f64)>)>,
    /// The validation data, by which names were chosen.
    pub validation: ValidationData,
    /// The test data, which no decision has seen.
    pub test: TestData,
    /// Names of the recordings that were fitted in the end.
    pub fitted: Vec<String>,
    /// The system's own part: the extended model, the field's parameters.
    #[serde(flatten)]
    pub model: M,
    /// Standard deviation below which an error counts as noise, for each fitted channel.
    #[serde(skip)]
    pub noise: Vec<f64>,
    /// The measured channels.
    #[serde(skip)]
    pub outputs: Vec<OutputInfo>,
    /// Name of the excitation with its unit.
    #[serde(skip)]
    pub excitation_label: String,
    /// The test recordings before and after, for figures.
    #[serde(skip)]
    pub traces: Vec<Trace>,
    /// Work of the search for causes, in integration steps of the system without any.
    #[serde(skip)]
    pub(crate) work_steps: f64,
}

impl<M: Serialize> Diagnosis<M> {
    /// The diagnosis as it is written; `model` is the path of the extended model.
    ///
    /// # Panics
    /// If the system's own part cannot be written as a JSON object.
    #[must_use]
    pub fn to_json(&self, model: &str) -> Value {
        let mut json = serde_json::to_value(self).expect("a diagnosis is made of plain values");
        json["model"] = model.into();
        json
    }
}

impl Diagnosis<()> {
    /// The diagnosis with the system's own part.
    pub(super) fn with_model<M>(self, model: M) -> Diagnosis<M> {
        Diagnosis {
            model,
            verdict: self.verdict,
            causes: self.causes,
            minor: self.minor,
            reasons: self.reasons,
            bands: self.bands,
            anomalies: self.anomalies,
            refused: self.refused,
            score: self.score,
            ranking: self.ranking,
            residual: self.residual,
            error_reduction: self.error_reduction,
            explainable: self.explainable,
            null_test: self.null_test,
            remainder: self.remainder,
            onset_test: self.onset_test,
            untested_change: self.untested_change,
            late_fault: self.late_fault,
            ladder: self.ladder,
            onset_curves: self.onset_curves,
            validation: self.validation,
            test: self.test,
            fitted: self.fitted,
            noise: self.noise,
            outputs: self.outputs,
            excitation_label: self.excitation_label,
            traces: self.traces,
            work_steps: self.work_steps,
        }
    }
}

impl<M> Diagnosis<M> {
    /// Whether the system is extended, by named causes or by what was learned beside them.
    #[must_use]
    pub fn is_extended(&self) -> bool {
        !self.causes.is_empty() || self.remainder.as_ref().is_some_and(Remainder::is_part_of_model)
    }

    /// Ids of the named causes.
    #[must_use]
    pub fn named(&self) -> Vec<&str> {
        self.causes.iter().map(|c| c.effect.as_str()).collect()
    }
}
