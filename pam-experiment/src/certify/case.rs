//! The cases of a certificate, and what a diagnosis says of each.

use super::CertifyOptions;
use crate::detect::{Detection, TrialProgress, detect_along};
use crate::error::ExperimentError;
use pam_data::Subject;
use pam_diagnose::JointDiagnosis;
use pam_effects::effects::by_id;
use pam_effects::{ActiveEffect, ExtendedModel};
use serde::{Deserialize, Serialize};

/// One set of recordings that is diagnosed.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Case {
    /// Its name, which names its file.
    pub id: String,
    /// Label of the hidden effect; absent in a null set.
    pub label: Option<String>,
    /// Its id.
    pub effect: Option<String>,
    /// Its magnitude in multiples of the limit from which it is named.
    pub multiple: f64,
    /// Its values: parameters, then switches.
    pub values: Vec<f64>,
    /// Seed of residuals and diagnosis.
    pub seed: u64,
}

/// All cases of a certificate.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Plan {
    /// The cases.
    pub cases: Vec<Case>,
    /// Labels of effects that are not seen within their range.
    pub left_out: Vec<String>,
    /// Limits from which effects are named: label, parameter, value.
    pub limits: Vec<(String, String, f64)>,
}

/// The cases for baseline recordings: effects at multiples of their limits, of either sign where there are two, and null
/// sets. With the options of [`with_baseline`](super::with_baseline), the limits account for the model errors in the
/// baseline recordings.
///
/// # Errors
/// [`ExperimentError`] if the limits cannot be foretold.
pub fn plan(
    model: &ExtendedModel,
    baseline: &[Subject],
    options: &CertifyOptions,
) -> Result<(Plan, Detection), ExperimentError> {
    // The certificate makes trials of its own; others only where their number is given.
    let progress: Option<TrialProgress<'_>> = match options.detect.trials {
        Some(_) => Some(&|_, _| {}),
        None => None,
    };
    let (detection, ways) = detect_along(model, baseline, None, &options.detect, progress)?;
    let (mut cases, mut left_out, mut limits) = (Vec::new(), Vec::new(), Vec::new());
    for (l, way) in detection.limits.iter().zip(&ways) {
        let Some(limit) = l.named else {
            left_out.push(l.label.clone());
            continue;
        };
        limits.push((l.label.clone(), l.parameter.clone(), limit.value));
        for multiple in &options.multiples {
            for repeat in 0..options.repeats {
                let magnitude = multiple * limit.magnitude;
                let other_side = repeat % 2 == 1 && way.admits(-magnitude);
                let magnitude = if other_side { -magnitude } else { magnitude };
                let label = l.label.replace([' ', '(', ')'], "-").replace("--", "-");
                cases.push(Case {
                    id: format!("{}-x{multiple}-{repeat}", label.trim_end_matches('-')),
                    label: Some(l.label.clone()),
                    effect: Some(l.effect.clone()),
                    multiple: *multiple,
                    values: way.values(magnitude),
                    seed: 0,
                });
            }
        }
    }
    cases.extend((0..options.nulls).map(|k| Case {
        id: format!("null-{k:03}"),
        label: None,
        effect: None,
        multiple: 0.0,
        values: Vec::new(),
        seed: 0,
    }));
    for (k, case) in cases.iter_mut().enumerate() {
        case.seed = options.seed.wrapping_mul(1_000_003).wrapping_add(k as u64);
    }
    Ok((Plan { cases, left_out, limits }, detection))
}

impl Case {
    /// The hidden effect.
    #[must_use]
    pub fn active(&self) -> Option<ActiveEffect> {
        let effect = by_id(self.effect.as_deref()?)?;
        Some(ActiveEffect { effect, values: self.values.clone() })
    }
}

/// A named cause of a case.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Named {
    /// Its id.
    pub effect: String,
    /// Ids that the diagnosis does not distinguish from it.
    pub confusable_with: Vec<String>,
    /// Parameters: name, value and 95 % interval.
    pub parameters: Vec<(String, f64, [f64; 2])>,
}

impl Named {
    /// Whether it is this effect, or confusable with it.
    fn may_be(&self, effect: &String) -> bool {
        self.effect == *effect || self.confusable_with.contains(effect)
    }
}

/// What the diagnosis of a case says.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Outcome {
    /// The case.
    pub case: Case,
    /// The verdict, or `refused` with the reason in `error`.
    pub verdict: String,
    /// What speaks against `explained` or `nothing_found`, in sentences.
    #[serde(default)]
    pub reasons: Vec<String>,
    /// Named causes.
    pub named: Vec<Named>,
    /// Causes that are listed as minor.
    pub minor: Vec<String>,
    /// Logarithm of the odds of the named set against none.
    pub log_odds: f64,
    /// Why there is no diagnosis.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub error: Option<String>,
    /// Wall-clock time, s.
    pub wall_s: f64,
}

impl Outcome {
    /// The outcome of a diagnosis.
    #[must_use]
    pub fn of(case: &Case, found: &JointDiagnosis, wall_s: f64) -> Self {
        let named = found.causes.iter().map(|c| Named {
            effect: c.effect.clone(),
            confusable_with: c.confusable_with.clone(),
            parameters: c
                .parameters
                .iter()
                .map(|(name, i)| ((*name).to_owned(), i.value, i.ci95))
                .collect(),
        });
        Self {
            case: case.clone(),
            verdict: found.verdict.to_string(),
            reasons: found.reasons.clone(),
            named: named.collect(),
            minor: found.minor.iter().map(|c| c.effect.clone()).collect(),
            log_odds: found.score.log_odds,
            error: None,
            wall_s,
        }
    }

    /// The outcome of a case without a diagnosis.
    #[must_use]
    pub fn refused(case: &Case, error: String, wall_s: f64) -> Self {
        Self {
            case: case.clone(),
            verdict: "refused".into(),
            reasons: Vec::new(),
            named: Vec::new(),
            minor: Vec::new(),
            log_odds: 0.0,
            error: Some(error),
            wall_s,
        }
    }

    /// Whether something is named at these odds.
    #[must_use]
    pub fn names_at(&self, log_odds: f64) -> bool {
        !self.named.is_empty() && self.log_odds >= log_odds
    }

    /// Whether the hidden effect is named or confusable with a named one.
    #[must_use]
    pub fn is_named(&self) -> bool {
        let Some(effect) = &self.case.effect else { return false };
        self.named.iter().any(|n| n.may_be(effect))
    }

    /// Whether the hidden effect is the only name, or each name is said not to be distinguished from it.
    #[must_use]
    pub fn is_right(&self) -> bool {
        let Some(effect) = &self.case.effect else { return self.named.is_empty() };
        !self.named.is_empty() && self.named.iter().all(|n| n.may_be(effect))
    }

    /// Whether the hidden effect is the only name.
    #[must_use]
    pub fn is_exact(&self) -> bool {
        let names: Vec<&str> = self.named.iter().map(|n| n.effect.as_str()).collect();
        self.case.effect.as_deref().map_or(names.is_empty(), |e| names == [e])
    }
}
