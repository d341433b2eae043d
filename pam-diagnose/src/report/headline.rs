//! The headline of a diagnosis, in words.

use super::percent;
use crate::diagnosis::Diagnosis;
use crate::verdict::Cause;
use pam_core::units::significant;
use pam_vocabulary::{ActivityWindow, plain_name};

/// Relative rise of the RMSE of a channel from which the report says that it became worse.
const WORSE: f64 = 0.02;

/// Share of the removed error from which a cause stands in the headline.
const LEADING: f64 = 0.01;

/// The named causes in the headline, and those whose share of the removed error is below [`LEADING`].
pub(super) fn leading<M>(d: &Diagnosis<M>) -> (Vec<&Cause>, Vec<&Cause>) {
    let (leading, small): (Vec<_>, Vec<_>) =
        d.causes.iter().partition(|c| c.share_of_error_removed >= LEADING);
    if leading.is_empty() { (small, leading) } else { (leading, small) }
}

/// The headline figure of a diagnosis: the RMSE of the first output, the displacement of a joint, on the test set.
pub(super) struct Headline {
    /// Name of the output.
    pub output: String,
    /// Its unit.
    pub unit: String,
    /// RMSE of the model.
    pub before: f64,
    /// RMSE of the extended model.
    pub after: f64,
}

impl Headline {
    pub(super) fn of<M>(d: &Diagnosis<M>) -> Option<Self> {
        let (output, channel) = (d.outputs.first()?, d.error_reduction.channels.first()?);
        Some(Self {
            output: output.name.clone(),
            unit: output.unit.clone(),
            before: channel.rmse_before,
            after: channel.rmse_after,
        })
    }

    /// `1 − RMSE after / RMSE before`.
    pub(super) fn reduction(&self) -> f64 {
        if self.before > 0.0 { 1.0 - self.after / self.before } else { 0.0 }
    }

    /// What one subject, or several, do to the RMSE, and by how much: ("reduces", 0.4), ("raise", 0.1).
    pub(super) fn change(&self, is_one: bool) -> (&'static str, f64) {
        let reduction = self.reduction();
        let verb = match (reduction < 0.0, is_one) {
            (false, true) => "reduces",
            (false, false) => "reduce",
            (true, true) => "raises",
            (true, false) => "raise",
        };
        (verb, reduction.abs())
    }
}

/// The names of causes in a sentence: "dry friction and constant load".
pub(super) fn names(causes: &[&Cause]) -> String {
    joined(&causes.iter().map(|c| plain_name(&c.effect)).collect::<Vec<_>>())
}

/// Items with commas, and "and" before the last.
fn joined(items: &[String]) -> String {
    joined_by(items, "and")
}

/// Items with commas, and a conjunction before the last.
pub(super) fn joined_by(items: &[String], conjunction: &str) -> String {
    match items {
        [] => String::new(),
        [one] => one.clone(),
        [first @ .., last] => format!("{} {conjunction} {last}", first.join(", ")),
    }
}

/// A sentence with a capital letter.
pub(super) fn capitalised(text: &str) -> String {
    let mut letters = text.chars();
    letters.next().map_or_else(String::new, |c| c.to_uppercase().chain(letters).collect())
}

/// The causes with their values: "dry friction (force 41.9 N [36.4, 47.5])".
pub(super) fn with_values(causes: &[&Cause]) -> String {
    let cause = |c: &&Cause| {
        // Times are told in a sentence of their own.
        let own = c
            .parameters
            .iter()
            .filter(|(name, _)| c.acts.is_none() || !ActivityWindow::is_time(name));
        let values: Vec<String> = own
            .map(|(name, i)| {
                let (name, unit) = quantity(name);
                let n = |v| significant(v, 3);
                let space = if unit.is_empty() { "" } else { " " };
                format!("{name} {}{space}{unit} [{}, {}]", n(i.value), n(i.ci95[0]), n(i.ci95[1]))
            })
            .collect();
        format!("{} ({})", plain_name(&c.effect), values.join(", "))
    };
    joined(&causes.iter().map(cause).collect::<Vec<_>>())
}

/// When causes that are not always there act, in sentences with a space before each; empty if there are none.
pub(super) fn times(causes: &[Cause]) -> String {
    let sentence = |c: &Cause| {
        let text = c.acts.as_ref()?.sentence(&plain_name(&c.effect));
        Some(format!(" {}.", capitalised(&text)))
    };
    causes.iter().filter_map(sentence).collect()
}

/// A parameter's name in words, and the unit at its end: `velocity_mm_s` is velocity in mm/s.
pub(super) fn quantity(name: &str) -> (String, &'static str) {
    const UNITS: [(&str, &str); 13] = [
        ("_n_per_mm", "N/mm"),
        ("_ns_m", "N s/m"),
        ("_per_s", "1/s"),
        ("_percent_per_min", "% per minute"),
        ("_per_min", "per minute"),
        ("_mm_s", "mm/s"),
        ("_kpa", "kPa"),
        ("_mm", "mm"),
        ("_ms", "ms"),
        ("_kg", "kg"),
        ("_hz", "Hz"),
        ("_n", "N"),
        ("_s", "s"),
    ];
    for (suffix, unit) in UNITS {
        if let Some(stem) = name.strip_suffix(suffix) {
            return (stem.replace('_', " "), unit);
        }
    }
    (name.replace('_', " "), "")
}

/// A sentence on the channels whose error rose on the test set; empty if there are none.
pub(super) fn worse<M>(d: &Diagnosis<M>) -> String {
    let worse =
        d.error_reduction.channels.iter().filter(|c| c.rmse_after > (1.0 + WORSE) * c.rmse_before);
    let each =
        worse.map(|c| format!("{} by {}", c.label, percent(c.rmse_after / c.rmse_before - 1.0)));
    let each = joined(&each.collect::<Vec<_>>());
    if each.is_empty() { each } else { format!(" The error became larger in {each}.") }
}

/// Causes with a small share of the removed error and minor causes, each in a sentence; empty if there are none.
pub(super) fn lesser<M>(d: &Diagnosis<M>) -> String {
    let small = (format!("With less than {} of the removed error", percent(LEADING)), leading(d).1);
    let minor = ("Minor, with little influence on the error".to_owned(), d.minor.iter().collect());
    let told =
        [small, minor].into_iter().filter(|(_, causes): &(_, Vec<&Cause>)| !causes.is_empty());
    told.map(|(what, causes)| format!(" {what}: {}.", with_values(&causes))).collect()
}
