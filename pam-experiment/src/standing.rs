//! How the standing of candidates changes as measurements add up.

use crate::design::{Design, LiveCause};
use crate::error::ExperimentError;
use maud::{Markup, html};
use pam_diagnose::{DiagnoseOptions, JointDiagnosis, RecordingSets, Stage, diagnose};
use pam_effects::ExtendedModel;
use pam_vocabulary::plain_name;
use serde::Serialize;

/// The standing of a candidate after a measurement.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct CandidateStanding {
    /// Id of the candidate.
    pub effect: String,
    /// Posterior probability that it is at work, over the sets that were fitted.
    pub inclusion: f64,
    /// Whether it is named as a cause.
    pub named: bool,
    /// Whether it is not distinguished from a named cause.
    pub confusable: bool,
}

/// A diagnosis of all measurements up to one.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct MeasurementStanding {
    /// Name of the last measurement.
    pub measurement: String,
    /// Recordings of all of them.
    pub recordings: usize,
    /// The verdict.
    pub verdict: String,
    /// Logarithm of the odds of the named set against none.
    pub log_odds: f64,
    /// The candidates, in the order in which the diagnosis lists them.
    pub candidates: Vec<CandidateStanding>,
}

impl MeasurementStanding {
    fn of(name: &str, recordings: usize, found: &JointDiagnosis) -> Self {
        let confusable = |id: &str| {
            found.causes.iter().any(|c| c.confusable_with.iter().any(|other| other == id))
        };
        let standing = |effect: &str, inclusion: f64, named: bool| CandidateStanding {
            effect: effect.to_owned(),
            inclusion,
            named,
            confusable: !named && confusable(effect),
        };
        let named = found.causes.iter().map(|c| standing(&c.effect, c.inclusion, true));
        let minor = found.minor.iter().map(|c| standing(&c.effect, c.inclusion, false));
        let refused = found.refused.iter().map(|r| standing(&r.effect, r.inclusion, false));
        Self {
            measurement: name.to_owned(),
            recordings,
            verdict: found.verdict.to_string(),
            log_odds: found.score.log_odds,
            candidates: named.chain(minor).chain(refused).collect(),
        }
    }

    /// The standing of a candidate.
    #[must_use]
    pub fn of_candidate(&self, id: &str) -> Option<&CandidateStanding> {
        self.candidates.iter().find(|c| c.effect == id)
    }

    /// Ids of candidates that may be at work: named, or not distinguished from a named one.
    #[must_use]
    pub fn live(&self) -> Vec<&str> {
        let live = self.candidates.iter().filter(|c| c.named || c.confusable);
        live.map(|c| c.effect.as_str()).collect()
    }
}

/// A measurement: its name, and the number of its recordings.
pub type Measurement = (String, usize);

/// Diagnoses the first measurement, the first two together, and so on up to all of them; their recordings follow one another in
/// the data of `sets`. Returns the standing after each, and the diagnosis of all.
///
/// # Errors
/// [`ExperimentError`] if there are no measurements or they are not those of the data, or if one of the diagnoses cannot be made.
pub fn standing(
    model: &ExtendedModel,
    measurements: &[Measurement],
    sets: &RecordingSets<'_>,
    options: &DiagnoseOptions,
    progress: &(dyn Fn(usize, Stage, f64) + Sync),
) -> Result<(Vec<MeasurementStanding>, JointDiagnosis), ExperimentError> {
    let count: usize = measurements.iter().map(|m| m.1).sum();
    if count != sets.data.len() {
        let message = format!("they have {count} recordings, the data {}", sets.data.len());
        return Err(ExperimentError::setting("measurements", message));
    }
    let (mut all, mut last, mut end) = (Vec::new(), None, 0);
    for (k, (name, recordings)) in measurements.iter().enumerate() {
        end += recordings;
        // What takes long and only the whole answer shows, once.
        let is_last = k + 1 == measurements.len();
        let options = if is_last {
            options.clone()
        } else {
            DiagnoseOptions { law: false, ladder: None, ..options.clone() }
        };
        let sets = RecordingSets { data: &sets.data[..end], ..*sets };
        let found = diagnose(model, &sets, &options, &|stage, share| progress(k, stage, share))?;
        all.push(MeasurementStanding::of(name, end, &found));
        last = Some(found);
    }
    let none = || ExperimentError::setting("measurements", "there are none");
    Ok((all, last.ok_or_else(none)?))
}

/// The live causes of a diagnosis: named ones with the candidates that it does not distinguish from them.
#[must_use]
pub fn live_causes(found: &JointDiagnosis) -> Vec<LiveCause> {
    let confusable = found.causes.iter().filter(|c| !c.alternatives.is_empty());
    let live = confusable.map(|c| LiveCause {
        cause: (c.member.candidate, c.member.own().to_vec()),
        others: c.alternatives.iter().map(|a| (a.candidate, a.own().to_vec())).collect(),
    });
    live.collect()
}

/// The conclusion of a series of measurements in words: one answer, or the causes that are not distinguished yet. If a further measurement
/// has been designed, it also states whether that is expected to distinguish them.
#[must_use]
pub fn conclusion(found: &JointDiagnosis, design: Option<&Design>) -> String {
    let names =
        |ids: &[&str]| ids.iter().map(|id| plain_name(id)).collect::<Vec<_>>().join(" and ");
    if found.causes.is_empty() {
        return format!("No cause is named ({}).", found.verdict.to_string().replace('_', " "));
    }
    if live_causes(found).is_empty() {
        return format!("The measurements leave one answer: {}.", names(&found.named()));
    }
    let pairs = found.causes.iter().filter(|c| !c.confusable_with.is_empty()).map(|c| {
        let others: Vec<&str> = c.confusable_with.iter().map(String::as_str).collect();
        format!("{} from {}", plain_name(&c.effect), names(&others))
    });
    let left =
        format!("The measurements do not distinguish {}.", pairs.collect::<Vec<_>>().join("; "));
    match design {
        Some(design) => format!("{left} {}", design.sentence()),
        None => left,
    }
}

/// The standing after each measurement as a table.
#[must_use]
pub fn standing_section(all: &[MeasurementStanding], conclusion: &str) -> Markup {
    const LEAST: f64 = 0.01;
    let mut ids: Vec<&str> = Vec::new();
    for c in all.iter().flat_map(|m| &m.candidates) {
        let counts = c.named || c.confusable || c.inclusion >= LEAST;
        if counts && !ids.contains(&c.effect.as_str()) {
            ids.push(&c.effect);
        }
    }
    let cell = |m: &MeasurementStanding, id: &str| match m.of_candidate(id) {
        None => "–".to_owned(),
        Some(c) => {
            let share = format!("{:.0} %", 100.0 * c.inclusion);
            match (c.named, c.confusable) {
                (true, _) => format!("{share}, named"),
                (_, true) => format!("{share}, confusable"),
                _ => share,
            }
        }
    };
    html! {
        p { "Posterior probability that each candidate is at work, after the first measurement, the first two, and so on." }
        div.scroll { table {
            thead { tr { th { "candidate" } @for m in all { th { "after " (m.measurement) } } } }
            tbody {
                @for id in &ids { tr { td { (plain_name(id)) } @for m in all { td { (cell(m, id)) } } } }
                tr { td { "verdict" } @for m in all { td { (m.verdict.replace('_', " ")) } } }
                tr { td { "recordings" } @for m in all { td { (m.recordings) } } }
            }
        } }
        p { (conclusion) }
    }
}
