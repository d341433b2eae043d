//! What the outcomes of all cases say together, and the settings that follow.

use super::CertifyOptions;
use super::case::{Outcome, Plan};
use super::certificate::{Certificate, Trust};
use super::shares::clopper_pearson;
use pam_data::document;
use pam_diagnose::DiagnosisSettings;
use serde::Serialize;

/// How often an effect was found at one magnitude.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Detected {
    /// Label of the effect.
    pub label: String,
    /// Magnitude in multiples of its limit.
    pub multiple: f64,
    /// Trials.
    pub trials: u64,
    /// Those in which it was named, alone or as one that is not distinguished.
    pub right: u64,
    /// Those in which it was the only name.
    pub exact: u64,
    /// Exact 95 % limits of the share of the right ones.
    pub limits: [f64; 2],
}

/// How often one effect was taken for another.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Confusion {
    /// Label of the hidden effect; `none` in null sets.
    pub hidden: String,
    /// Id of a named cause; `none` where nothing was named.
    pub named: String,
    /// Trials.
    pub trials: u64,
}

/// How often the 95 % intervals of a parameter held the truth, where the effect was named.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Coverage {
    /// Id of the effect, and its parameter.
    pub parameter: String,
    /// Intervals.
    pub trials: u64,
    /// Those that hold the truth.
    pub covered: u64,
    /// Exact 95 % limits of their share.
    pub limits: [f64; 2],
}

/// The summary of all cases; `certificate.json`.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Summary {
    /// Cases that are over, of all.
    pub cases: [usize; 2],
    /// Cases without a diagnosis.
    pub refused: usize,
    /// Null sets in which something was named with the settings of the cases, of all, with exact 95 % limits.
    pub false_alarms: (u64, u64, [f64; 2]),
    /// Verdicts of the null sets, with how many had each.
    pub null_verdicts: Vec<(String, u64)>,
    /// Logarithm of the odds from which causes are named with the certified settings.
    pub log_odds: f64,
    /// Null sets that are needed for the exact limit of the level.
    pub nulls_needed: u64,
    /// The certificate of the certified settings.
    pub certificate: Certificate,
    /// Detection with the certified settings.
    pub detected: Vec<Detected>,
    /// Confusions with the certified settings.
    pub confusions: Vec<Confusion>,
    /// Coverage of intervals.
    pub coverage: Vec<Coverage>,
    /// Coverage of all intervals together.
    pub coverage_of_all: Coverage,
    /// Effects that are not seen within their range.
    pub left_out: Vec<String>,
    /// Mean wall-clock time of a case, s.
    pub mean_wall_s: f64,
}

/// Confidence of limits.
const CONFIDENCE: f64 = 0.95;
/// Confidence, one-sided, with which the rate of false alarms is below the level.
const HELD: f64 = 0.95;
/// Steps of the logarithm of the odds between levels of trust.
const TRUST_STEPS: [f64; 4] = [0.0, 10.0, 50.0, 250.0];
/// Largest odds of the settings.
const LARGEST_ODDS: f64 = 1e12;

/// The lowest logarithm of the odds, at least `least`, at which the null sets hold the level: by the exact upper limit where
/// there are enough of them, else by their share.
fn held(nulls: &[&Outcome], least: f64, level: f64) -> f64 {
    let n = nulls.len() as u64;
    let upper = |k: u64| clopper_pearson(k, n, 2.0 * HELD - 1.0)[1];
    let allowed = (0..=n).take_while(|&k| upper(k) <= level).last();
    let allowed = allowed.unwrap_or((level * n as f64) as u64) as usize;
    let mut odds: Vec<f64> =
        nulls.iter().filter(|o| !o.named.is_empty()).map(|o| o.log_odds).collect();
    odds.sort_by(|a, b| b.total_cmp(a));
    // Just above the first one that is one too many.
    odds.get(allowed).map_or(least, |o| least.max(o + 0.01)).min(LARGEST_ODDS.ln())
}

impl Summary {
    /// The summary of the outcomes of a plan.
    #[must_use]
    pub fn of(plan: &Plan, outcomes: &[Outcome], options: &CertifyOptions, made_by: &str) -> Self {
        let settings = &options.detect.diagnosis.settings;
        let nulls: Vec<&Outcome> =
            outcomes.iter().filter(|o| o.case.effect.is_none() && o.error.is_none()).collect();
        let n = nulls.len() as u64;
        let log_odds = held(&nulls, settings.search.odds.ln(), options.level);
        let alarms = |at: f64| nulls.iter().filter(|o| o.names_at(at)).count() as u64;
        let (before, after) = (alarms(f64::NEG_INFINITY), alarms(log_odds));
        let hidden: Vec<&Outcome> =
            outcomes.iter().filter(|o| o.case.effect.is_some() && o.error.is_none()).collect();
        let certificate = Certificate {
            nulls: n,
            false_alarms: after,
            false_alarm_limits: clopper_pearson(after, n, CONFIDENCE),
            level: options.level,
            trust: trust(&hidden, log_odds),
            made_by: made_by.to_owned(),
            baseline: Vec::new(),
        };
        let coverage = coverage(&hidden, log_odds);
        let all = coverage.iter().fold((0, 0), |(t, c), own| (t + own.trials, c + own.covered));
        Self {
            cases: [outcomes.len(), plan.cases.len()],
            refused: outcomes.iter().filter(|o| o.error.is_some()).count(),
            null_verdicts: verdicts(&nulls),
            false_alarms: (before, n, clopper_pearson(before, n, CONFIDENCE)),
            log_odds,
            nulls_needed: ((1.0 - HELD).ln() / (1.0 - options.level).ln()).ceil() as u64,
            certificate,
            detected: detected(&hidden, log_odds),
            confusions: confusions(outcomes, log_odds),
            coverage_of_all: Coverage {
                parameter: "all".into(),
                trials: all.0,
                covered: all.1,
                limits: clopper_pearson(all.1, all.0, CONFIDENCE),
            },
            coverage,
            left_out: plan.left_out.clone(),
            mean_wall_s: outcomes.iter().map(|o| o.wall_s).sum::<f64>()
                / outcomes.len().max(1) as f64,
        }
    }
}

fn verdicts(nulls: &[&Outcome]) -> Vec<(String, u64)> {
    let mut all: Vec<(String, u64)> = Vec::new();
    for o in nulls {
        match all.iter_mut().find(|v| v.0 == o.verdict) {
            Some(there) => there.1 += 1,
            None => all.push((o.verdict.clone(), 1)),
        }
    }
    all
}

fn trust(hidden: &[&Outcome], log_odds: f64) -> Vec<Trust> {
    let steps = TRUST_STEPS.map(|s| log_odds + s);
    let level = |k: usize| {
        let next = steps.get(k + 1).copied().unwrap_or(f64::INFINITY);
        let here: Vec<&&Outcome> =
            hidden.iter().filter(|o| o.names_at(steps[k]) && o.log_odds < next).collect();
        let (trials, right) =
            (here.len() as u64, here.iter().filter(|o| o.is_right()).count() as u64);
        Trust {
            log_odds: steps[k],
            trials,
            right,
            limits: clopper_pearson(right, trials, CONFIDENCE),
        }
    };
    (0..steps.len()).map(level).collect()
}

fn detected(hidden: &[&Outcome], log_odds: f64) -> Vec<Detected> {
    let mut all: Vec<Detected> = Vec::new();
    for o in hidden {
        let Some(label) = &o.case.label else { continue };
        let place = all.iter().position(|d| d.label == *label && d.multiple == o.case.multiple);
        let place = place.unwrap_or_else(|| {
            all.push(Detected {
                label: label.clone(),
                multiple: o.case.multiple,
                trials: 0,
                right: 0,
                exact: 0,
                limits: [0.0, 1.0],
            });
            all.len() - 1
        });
        let own = &mut all[place];
        own.trials += 1;
        own.right += u64::from(o.names_at(log_odds) && o.is_right());
        own.exact += u64::from(o.names_at(log_odds) && o.is_exact());
    }
    all.iter_mut().for_each(|d| d.limits = clopper_pearson(d.right, d.trials, CONFIDENCE));
    all
}

fn confusions(outcomes: &[Outcome], log_odds: f64) -> Vec<Confusion> {
    let mut all: Vec<Confusion> = Vec::new();
    for o in outcomes.iter().filter(|o| o.error.is_none()) {
        let hidden = o.case.label.clone().unwrap_or_else(|| "none".into());
        let mut names: Vec<String> = o.named.iter().map(|n| n.effect.clone()).collect();
        if !o.names_at(log_odds) {
            names = vec!["none".into()];
        }
        for named in names {
            match all.iter_mut().find(|c| c.hidden == hidden && c.named == named) {
                Some(there) => there.trials += 1,
                None => all.push(Confusion { hidden: hidden.clone(), named, trials: 1 }),
            }
        }
    }
    all
}

fn coverage(hidden: &[&Outcome], log_odds: f64) -> Vec<Coverage> {
    let mut all: Vec<Coverage> = Vec::new();
    for o in hidden.iter().filter(|o| o.names_at(log_odds)) {
        let Some(effect) = &o.case.effect else { continue };
        let Some(named) = o.named.iter().find(|n| n.effect == *effect) else { continue };
        for ((name, _, ci95), truth) in named.parameters.iter().zip(&o.case.values) {
            let parameter = format!("{effect}.{name}");
            let place = all.iter().position(|c| c.parameter == parameter).unwrap_or_else(|| {
                all.push(Coverage { parameter, trials: 0, covered: 0, limits: [0.0, 1.0] });
                all.len() - 1
            });
            all[place].trials += 1;
            all[place].covered += u64::from((ci95[0]..=ci95[1]).contains(truth));
        }
    }
    all.iter_mut().for_each(|c| c.limits = clopper_pearson(c.covered, c.trials, CONFIDENCE));
    all
}

/// The certified settings as a file for `pam diagnose --settings`, with the certificate in them.
///
/// # Panics
/// Never: settings are plain tables.
#[must_use]
pub fn settings_file(summary: &Summary, settings: &DiagnosisSettings) -> String {
    let mut certified = *settings;
    let odds = (1e3 * summary.log_odds.exp()).ceil() / 1e3;
    let search = &mut certified.search;
    search.odds = search.odds.max(odds);
    search.odds_of_few_blocks = search.odds_of_few_blocks.max(odds);
    certified.onset.odds = certified.onset.odds.max(odds);
    let default = DiagnosisSettings::default();
    let mut table = changed(&toml_of(&certified), &toml_of(&default));
    table.insert("certificate".into(), toml::Value::Table(toml_of(&summary.certificate)));
    document::to_toml(&table).expect("settings are plain tables")
}

fn toml_of<T: Serialize>(value: &T) -> toml::Table {
    toml::Table::try_from(value).expect("settings are plain tables")
}

/// The values of a table that differ from those of another.
fn changed(own: &toml::Table, other: &toml::Table) -> toml::Table {
    let mut all = toml::Table::new();
    for (key, value) in own {
        match (value, other.get(key)) {
            (toml::Value::Table(own), Some(toml::Value::Table(other))) => {
                let inner = changed(own, other);
                if !inner.is_empty() {
                    all.insert(key.clone(), toml::Value::Table(inner));
                }
            }
            (value, other) if other != Some(value) => {
                all.insert(key.clone(), value.clone());
            }
            _ => {}
        }
    }
    all
}
