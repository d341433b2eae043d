//! What the diagnosis said of a case.

use super::case::{Case, Fault};
use super::data::{Truth, data};
use crate::plant::Hidden;
use pam_diagnose::report::{ReportContext, diagnosis_report};
use pam_diagnose::{DiagnoseOptions, RecordingSets, diagnose};
use pam_effects::ExtendedModel;
use serde::{Deserialize, Serialize};
use serde_json::Value;
use std::collections::BTreeMap;
use std::time::Instant;

/// Verdict of a diagnosis that was refused with an error.
pub const REFUSED: &str = "refused";

/// A fault that is at least this many times the limit of detection must not go unsaid in `explained`.
const CERTAIN_LIMITS: f64 = 2.0;

/// Largest error of a named onset that counts as right, s.
const SAME_TIME_S: f64 = 0.5;

/// A hidden effect with its size over the limit of detection.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct HiddenTruth {
    /// The effect.
    pub hidden: Hidden,
    /// Size over the limit; absent where it is not measured.
    pub limits: Option<f64>,
    /// As `limits`, of what is left of it beside the other hidden effects, whose values are free.
    pub limits_beside: Option<f64>,
}

impl HiddenTruth {
    /// Whether it can be detected and told from the other hidden effects; assumed where it is not measured.
    #[must_use]
    pub fn detectable(&self) -> bool {
        self.limits_beside.is_none_or(|l| l >= 1.0)
    }

    /// Whether it must not go unsaid.
    #[must_use]
    pub fn certain(&self) -> bool {
        self.limits_beside.is_none_or(|l| l >= CERTAIN_LIMITS)
    }
}

/// A named cause.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Named {
    /// Id.
    pub effect: String,
    /// Minor causes are listed and not in the headline.
    pub minor: bool,
    /// Share of what all causes remove.
    #[serde(default)]
    pub share: f64,
    /// By how much the mean square of a channel rises without it, in variances of the noise.
    pub rise: f64,
    /// Ids that explain nearly as much in its place.
    pub confusable_with: Vec<String>,
    /// Value and 95 % interval of each parameter.
    pub parameters: BTreeMap<String, [f64; 3]>,
}

impl Named {
    /// Whether it is the effect, or cannot be told from it.
    #[must_use]
    pub fn covers(&self, id: &str) -> bool {
        self.effect == id || self.confusable_with.iter().any(|other| other == id)
    }
}

/// The outcome of a case.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Outcome {
    /// The case.
    pub case: Case,
    /// What was hidden, with its values.
    pub truth: Vec<HiddenTruth>,
    /// The verdict, or [`REFUSED`].
    pub verdict: String,
    /// Why it was refused.
    pub error: Option<String>,
    /// Named causes.
    pub causes: Vec<Named>,
    /// Reduction of the error on the test set, with its 95 % interval.
    pub reduction: Option<[f64; 3]>,
    /// Root mean square of the residual before any cause, over the noise that the diagnosis assumes, by channel.
    pub over_noise: BTreeMap<String, f64>,
    /// Error of x on the test set before any cause, mm.
    pub x_before_mm: Option<f64>,
    /// CPU time of the diagnosis, s; absent where the system does not tell.
    pub cpu_s: Option<f64>,
    /// Wall-clock time of the diagnosis, s.
    pub wall_s: f64,
}

/// Makes the data of a case, diagnoses them, and returns the outcome with the diagnosis as JSON and its report as HTML, if
/// there is one.
///
/// # Panics
/// If the data cannot be made.
#[must_use]
pub fn run(case: &Case) -> (Outcome, Option<(Value, String)>) {
    let made = data(case);
    let model = ExtendedModel::from_saved(made.model.clone()).expect("known effects");
    let options =
        DiagnoseOptions { seed: case.diagnosis_seed, law: false, ..DiagnoseOptions::default() };
    let sets =
        RecordingSets { data: &made.subjects, test: None, baseline: made.baseline.as_deref() };
    let (start, cpu) = (Instant::now(), cpu_s());
    let result = diagnose(&model, &sets, &options, &|_, _| {});
    let wall_s = start.elapsed().as_secs_f64();
    let cpu_s = cpu.and_then(|before| Some(cpu_s()? - before));
    let truth = made.truth.iter().map(|t: &Truth| HiddenTruth {
        hidden: t.hidden.clone(),
        limits: t.limits,
        limits_beside: t.limits_beside,
    });
    let refused = Outcome {
        case: case.clone(),
        truth: truth.collect(),
        verdict: REFUSED.to_owned(),
        error: None,
        causes: Vec::new(),
        reduction: None,
        over_noise: BTreeMap::new(),
        x_before_mm: None,
        cpu_s,
        wall_s,
    };
    match result {
        Err(error) => (Outcome { error: Some(error.to_string()), ..refused }, None),
        Ok(found) => {
            let json = found.to_json("model.safetensors");
            let context = ReportContext {
                model: made.model.info.name.clone(),
                model_line: format!("Case {} of the study.", case.id),
                made_by: "study".to_owned(),
                ..ReportContext::default()
            };
            let report = diagnosis_report(&found, &context);
            (read(&json, refused), Some((json, report)))
        }
    }
}

/// The outcome that a `diagnosis.json` tells.
fn read(json: &Value, unread: Outcome) -> Outcome {
    let number = |v: &Value| v.as_f64().unwrap_or(f64::NAN);
    let pair = |v: &Value| [number(&v["ci95"][0]), number(&v["ci95"][1])];
    let list = |v: &Value| v.as_array().cloned().unwrap_or_default();
    let text = |v: &Value| v.as_str().unwrap_or_default().to_owned();
    let named = |cause: &Value, minor: bool| {
        let parameters = cause["parameters"].as_object().cloned().unwrap_or_default();
        Named {
            effect: text(&cause["effect"]),
            minor,
            share: number(&cause["share_of_error_removed"]),
            rise: number(&cause["rise_without"]),
            confusable_with: list(&cause["confusable_with"]).iter().map(text).collect(),
            parameters: parameters
                .iter()
                .map(|(name, p)| (name.clone(), [number(&p["value"]), pair(p)[0], pair(p)[1]]))
                .collect(),
        }
    };
    let gain = &json["error_reduction"]["overall"];
    let channels = json["residual"]["channels"].as_object().cloned().unwrap_or_default();
    Outcome {
        verdict: text(&json["verdict"]),
        causes: [("causes", false), ("minor", true)]
            .iter()
            .flat_map(|(key, minor)| list(&json[*key]).into_iter().map(|c| named(&c, *minor)))
            .collect(),
        reduction: Some([number(&gain["error_reduction"]), pair(gain)[0], pair(gain)[1]]),
        over_noise: channels
            .iter()
            .map(|(key, c)| (key.clone(), number(&c["rms"]) / number(&c["noise"])))
            .collect(),
        x_before_mm: json["error_reduction"]["x"]["rmse_before"].as_f64(),
        ..unread
    }
}

impl Outcome {
    /// Causes of the headline: all but the minor ones.
    pub fn headline(&self) -> impl Iterator<Item = &Named> {
        self.causes.iter().filter(|c| !c.minor)
    }

    /// Whether `explained` is a wrong verdict on a phenomenon outside the vocabulary. It is right only if a listed effect has the same
    /// equation, and that effect alone is named, with the right onset.
    #[must_use]
    pub fn explained_unlisted_wrongly(&self) -> bool {
        let said = |c: &Named, t: &HiddenTruth| {
            let begins_s = c.parameters.get("onset_s").map_or(f64::NAN, |onset| onset[0]);
            c.covers(t.hidden.same_as()) && (begins_s - t.hidden.begins_s()).abs() <= SAME_TIME_S
        };
        let right = |c: &Named| self.truth.iter().any(|t| said(c, t));
        self.verdict == "explained" && !self.headline().all(right)
    }

    /// Whether a headline cause is the effect or cannot be told from it.
    #[must_use]
    pub fn names(&self, id: &str) -> bool {
        self.headline().any(|c| c.covers(id))
    }

    /// Whether the first cause is a hidden effect or cannot be told from one.
    #[must_use]
    pub fn first_is_right(&self) -> bool {
        let first = self.headline().next();
        first.is_some_and(|c| self.truth.iter().any(|t| c.covers(&t.hidden.id)))
    }

    /// Headline causes that are no hidden effect and can be told from each.
    #[must_use]
    pub fn superfluous(&self) -> usize {
        let right = |c: &&Named| self.truth.iter().any(|t| c.covers(&t.hidden.id));
        self.headline().filter(|c| !right(c)).count()
    }

    /// Whether the verdict is `explained` although a hidden effect of at least twice the limit of detection is unsaid.
    #[must_use]
    pub fn explained_wrongly(&self) -> bool {
        let said = |t: &HiddenTruth| self.causes.iter().any(|c| c.covers(t.hidden.same_as()));
        let unsaid = |t: &HiddenTruth| t.certain() && !said(t);
        self.verdict == "explained" && self.truth.iter().any(unsaid)
    }

    /// Names of the causes of the headline, joined by `+`.
    #[must_use]
    pub fn headline_text(&self) -> String {
        self.headline().map(|c| c.effect.as_str()).collect::<Vec<_>>().join("+")
    }

    /// The strength with which a single effect was drawn.
    #[must_use]
    pub fn strength(&self) -> Option<super::Strength> {
        match self.case.faults.first()? {
            Fault::Drawn { strength, .. } => Some(*strength),
            Fault::Given(_) => None,
        }
    }

    /// Parameters of hidden effects that were named: `effect.parameter`, truth, value and interval.
    #[must_use]
    pub fn estimates(&self) -> Vec<(String, f64, [f64; 3])> {
        let mut all = Vec::new();
        for t in &self.truth {
            let Some(cause) = self.causes.iter().find(|c| c.effect == t.hidden.id) else {
                continue;
            };
            for (name, interval) in &cause.parameters {
                // A parameter that was not given acts with its value zero, which is none for a scale.
                if let Some(truth) = t.hidden.values.get(name) {
                    all.push((format!("{}.{name}", t.hidden.id), *truth, *interval));
                }
            }
        }
        all
    }
}

/// CPU time of the process, s, from `/proc` where there is one.
#[must_use]
pub fn cpu_s() -> Option<f64> {
    let status = std::fs::read_to_string("/proc/self/schedstat").ok();
    let threads = std::fs::read_dir("/proc/self/task").ok()?;
    let of = |path: std::path::PathBuf| {
        let text = std::fs::read_to_string(path.join("schedstat")).ok()?;
        text.split_whitespace().next()?.parse::<f64>().ok()
    };
    status?;
    Some(threads.flatten().filter_map(|t| of(t.path())).sum::<f64>() * 1e-9)
}
