//! Study of the search for laws: laws that stand in no list, hidden by the plant of the studies, which shares no code with the
//! search, and null sets.

mod developed;
mod eighth_outside;
mod eleventh_outside;
mod fifth_outside;
mod fourth_outside;
mod later;
mod ninth_outside;
mod outside;
mod seventh_outside;
mod shared;
mod sixth_outside;
mod tenth_outside;
mod thirteenth_outside;
mod twelfth_outside;

pub use developed::{laws, unseen};
pub use eighth_outside::eighth_outside;
pub use eleventh_outside::eleventh_outside;
pub use fifth_outside::fifth_outside;
pub use fourth_outside::fourth_outside;
pub use later::{fresh, last};
pub use ninth_outside::ninth_outside;
pub use outside::{outside, second_outside, third_outside};
pub use seventh_outside::seventh_outside;
pub use sixth_outside::sixth_outside;
pub use tenth_outside::tenth_outside;
pub use thirteenth_outside::thirteenth_outside;
pub use twelfth_outside::twelfth_outside;

use crate::diagnose::subject;
use crate::plant::{Excitation, Experiment, Hidden, Plant, Sensors};
use crate::study::data::data;
use crate::study::outcome::cpu_s;
use crate::study::{Case, Kind, ModelError, design};
use pam_data::{SavedModel, Subject, load_model};
use pam_diagnose::test_set::ChannelReduction;
use pam_diagnose::{
    DiagnoseOptions, DiagnosisSettings, JointDiagnosis, RecordingSets, diagnose, learn_remainder,
};
use pam_effects::{ExtendedModel, expression};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use std::time::Instant;

/// A law that is hidden, with what a right answer has.
#[derive(Debug, Clone)]
pub struct HiddenLaw {
    /// Its id.
    pub id: &'static str,
    /// As the plant hides it.
    pub hidden: Hidden,
    /// As an effect of expressions, for what the law itself reaches on the test set.
    definition: String,
    /// Its variables.
    pub variables: &'static [&'static str],
    /// Variables with which the same law can be written.
    pub or: &'static [&'static str],
    /// Whether it remembers.
    pub remembers: bool,
    /// Candidates that are taken out of the list, since they would name it.
    pub without: &'static [&'static str],
    /// Gauge pressures of the recordings, psi.
    pub psi: [[f64; 2]; 3],
}

/// A law of displacement, velocity, pressures or time without memory.
fn law(
    id: &'static str,
    values: &[(&str, f64)],
    definition: impl Into<String>,
    variables: &'static [&'static str],
) -> HiddenLaw {
    HiddenLaw {
        id,
        hidden: Hidden::new(id, values),
        definition: definition.into(),
        variables,
        or: &[],
        remembers: false,
        without: &[],
        psi: CONDITIONS,
    }
}

/// Gauge pressures of the recordings of [`laws`], psi.
const CONDITIONS: [[f64; 2]; 3] = [[40.0, 40.0], [70.0, 45.0], [35.0, 60.0]];
/// Length of a recording of the study, s.
pub const LENGTH_S: f64 = 20.0;
/// Length of one of the published protocol, s.
const PUBLISHED_S: f64 = 70.0;

/// Recordings of a length with a hidden law, by a seed of their noise.
#[must_use]
pub fn recordings(saved: &SavedModel, law: &HiddenLaw, seed: u64, length_s: f64) -> Vec<Subject> {
    let plant = Plant::of(&saved.model);
    let (effects, sensors) = ([law.hidden.clone()], Sensors::default());
    law.psi
        .par_iter()
        .enumerate()
        .map(|(i, &psi)| {
            let excitation = Excitation::published(length_s / PUBLISHED_S);
            let name = format!("nn_{:.0}{:.0}", psi[0], psi[1]);
            let seed = 1000 * seed + i as u64;
            let run = Experiment::new(&name, psi, &excitation, &effects, &sensors, seed);
            subject(saved, plant.record(&run))
        })
        .collect()
}

/// Null sets of the design of the study, whose model has no error, every so-manieth.
#[must_use]
pub fn nulls(count: usize) -> Vec<Case> {
    let all = design::full().into_iter().filter(|c| {
        c.kind == Kind::Null && c.factors.model_error == ModelError::None && c.repeats.is_none()
    });
    let all: Vec<Case> = all.filter(|c| c.id.starts_with("nulls")).collect();
    let every = (all.len() / count.max(1)).max(1);
    all.into_iter().step_by(every).take(count).collect()
}

/// What the search said of a case.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct LawOutcome {
    /// The case: a law or a null set.
    pub id: String,
    /// Whether something is hidden.
    pub hidden: bool,
    /// Verdict of the diagnosis alone.
    pub diagnosis: String,
    /// Causes that the diagnosis alone names.
    pub named_before: Vec<String>,
    /// Verdict with the remainder.
    pub verdict: String,
    /// Causes that are named in the end, beside a law.
    pub named: Vec<String>,
    /// What became of the remainder.
    pub outcome: String,
    /// Causes that the diagnosis alone named and a law replaces, with the reasons.
    pub replaced: Vec<(String, String)>,
    /// Reasons of the verdict.
    pub reasons: Vec<String>,
    /// The law.
    pub law: Option<String>,
    /// Its numbers: value and 95 % interval.
    pub parameters: Vec<(String, [f64; 3])>,
    /// Its variables.
    pub variables: Vec<String>,
    /// Whether it remembers.
    pub remembers: bool,
    /// Whether the variables are those of the hidden law.
    pub right: bool,
    /// Groups of variables on which the correction depends, with the ratio of the errors without them and with them.
    pub depends_on: Vec<(String, f64)>,
    /// Laws that were fitted, with the causes beside them, the number of their parameters and their log odds to the first one.
    #[serde(default)]
    pub ranking: Vec<(String, usize, f64)>,
    /// Share of the error of the test set that the law removes, and that the hidden law itself removes when it is fitted.
    pub reduction: Option<[f64; 2]>,
    /// CPU time of the diagnosis, and of the remainder, s.
    pub cpu_s: [f64; 2],
    /// Wall-clock time of the remainder, s.
    pub wall_s: f64,
}

impl LawOutcome {
    /// Share of what the hidden law reaches; none where that predicts no better than nothing, because errors of the measured starts
    /// exceed its effect.
    #[must_use]
    pub fn reached(&self) -> Option<f64> {
        self.reduction.filter(|[_, best]| *best > 0.0).map(|[own, best]| own / best)
    }

    /// Whether the law is found: the right variables, and at least 80 % of what the hidden law reaches.
    #[must_use]
    pub fn is_found(&self) -> bool {
        self.right && self.reduction.is_some_and(|[own, best]| own >= best - 0.2 * best.abs())
    }
}

/// The error reduction over all channels, from the errors before of one list to those after of another.
fn reduction(before: &[ChannelReduction], after: &[ChannelReduction]) -> f64 {
    let (mut from, mut to) = (0.0, 0.0);
    for (b, a) in before.iter().zip(after).filter(|(b, _)| b.key != "v") {
        let variance = b.rmse_before.powi(2) / (1.0 - b.r2_before).max(1e-12);
        from += b.rmse_before.powi(2) / variance;
        to += a.rmse_after.powi(2) / variance;
    }
    1.0 - (to / from).sqrt()
}

fn published() -> SavedModel {
    load_model(crate::published_weights()).expect("the published weights")
}

/// The remainder is learned, and timed, by itself.
fn without_law(settings: &DiagnosisSettings) -> DiagnoseOptions {
    DiagnoseOptions { law: false, settings: *settings, ..DiagnoseOptions::default() }
}

fn run(
    model: &ExtendedModel,
    sets: &RecordingSets<'_>,
    options: &DiagnoseOptions,
    id: &str,
) -> (LawOutcome, Option<(JointDiagnosis, Vec<ChannelReduction>)>) {
    let cpu = || cpu_s().unwrap_or(f64::NAN);
    let start = cpu();
    let none = LawOutcome {
        id: id.to_owned(),
        hidden: false,
        diagnosis: "refused".into(),
        named_before: Vec::new(),
        verdict: "refused".into(),
        named: Vec::new(),
        outcome: String::new(),
        replaced: Vec::new(),
        reasons: Vec::new(),
        law: None,
        parameters: Vec::new(),
        variables: Vec::new(),
        remembers: false,
        right: false,
        depends_on: Vec::new(),
        ranking: Vec::new(),
        reduction: None,
        cpu_s: [0.0; 2],
        wall_s: 0.0,
    };
    let found = match diagnose(model, sets, options, &|_, _| {}) {
        Ok(found) => found,
        Err(e) => return (LawOutcome { outcome: e.to_string(), ..none }, None),
    };
    let between = cpu();
    let named_before = found.named().into_iter().map(str::to_owned).collect();
    let (diagnosis, before) = (found.verdict.to_string(), found.error_reduction.channels.clone());
    let clock = Instant::now();
    let found = match learn_remainder(model, sets, options, found, &|_| {}) {
        Ok(found) => found,
        Err(e) => return (LawOutcome { diagnosis, outcome: e.to_string(), ..none }, None),
    };
    let wall_s = clock.elapsed().as_secs_f64();
    let cpu_s = [between - start, cpu() - between];
    let remainder = found.remainder.as_ref().expect("it was asked for");
    let law = remainder.law.as_ref();
    let mut variables = law.map_or_else(Vec::new, |l| l.variables.clone());
    variables.sort();
    let outcome = LawOutcome {
        diagnosis,
        named_before,
        verdict: found.verdict.to_string(),
        named: match law {
            Some(l) => l.beside.clone(),
            None => found.named().into_iter().map(str::to_owned).collect(),
        },
        outcome: remainder.outcome.to_string(),
        replaced: law.map_or_else(Vec::new, |l| {
            l.replaces.iter().map(|r| (r.effect.clone(), r.reason())).collect()
        }),
        reasons: found.reasons.clone(),
        law: law.map(|l| l.expression.clone()),
        parameters: law.map_or_else(Vec::new, |l| {
            let of = |(n, i): &(String, pam_diagnose::fit::Interval)| {
                (n.clone(), [i.value, i.ci95[0], i.ci95[1]])
            };
            l.parameters.iter().map(of).collect()
        }),
        depends_on: remainder.correction.as_ref().map_or_else(Vec::new, |c| {
            c.depends_on.iter().map(|d| (d.on.clone(), d.error_ratio)).collect()
        }),
        ranking: remainder
            .ranking
            .iter()
            .map(|r| (format!("{} beside {:?}", r.expression, r.beside), r.parameters, r.log_odds))
            .collect(),
        variables,
        remembers: law.is_some_and(|l| l.remembers),
        cpu_s,
        wall_s,
        ..none
    };
    (outcome, Some((found, before)))
}

/// Hides a law in recordings of a length, looks for it, and compares it with itself.
///
/// # Panics
/// If the published weights cannot be read.
#[must_use]
pub fn run_law(
    law: &HiddenLaw,
    seed: u64,
    length_s: f64,
    settings: &DiagnosisSettings,
) -> LawOutcome {
    let saved = published();
    let data = recordings(&saved, law, seed, length_s);
    let model = ExtendedModel::from_saved(saved).expect("no effects");
    let sets = RecordingSets { data: &data, test: None, baseline: None };
    let mut options = without_law(settings);
    options.candidates.retain(|e| !law.without.contains(&e.info().id));
    let (mut outcome, found) = run(&model, &sets, &options, &format!("{}-{seed}", law.id));
    outcome.hidden = true;
    let Some((found, before)) = found else { return outcome };
    let remainder = found.remainder.as_ref().expect("it was asked for");
    let Some(l) = &remainder.law else { return outcome };
    // A dry friction opposes the velocity, whether or not its level depends on it.
    let own: Vec<&str> = outcome.variables.iter().map(String::as_str).collect();
    let mut with_velocity = law.variables.to_vec();
    with_velocity.push("v");
    with_velocity.sort_unstable();
    let friction = law.definition.contains("dry_friction_n");
    outcome.right = (own == law.variables
        || (!law.or.is_empty() && own == law.or)
        || (friction && own == with_velocity))
        && l.remembers == law.remembers;
    // What the hidden law itself reaches.
    let text = format!(
        "[[effect]]\nid = \"hidden_law\"\ndescription = \"the hidden law\"\n{}\n",
        law.definition
    );
    let truth = expression::parse(&text).expect("a definition");
    let options = DiagnoseOptions { candidates: truth, ..without_law(settings) };
    if let Ok(best) = diagnose(&model, &sets, &options, &|_, _| {}) {
        let own = reduction(&before, &l.error_reduction.channels);
        outcome.reduction = Some([own, reduction(&before, &best.error_reduction.channels)]);
    }
    outcome
}

/// Looks for a law in a null set.
#[must_use]
pub fn run_null(case: &Case, settings: &DiagnosisSettings) -> LawOutcome {
    let made = data(case);
    let model = ExtendedModel::from_saved(made.model.clone()).expect("no effects");
    let sets =
        RecordingSets { data: &made.subjects, test: None, baseline: made.baseline.as_deref() };
    run(&model, &sets, &without_law(settings), &case.id).0
}
