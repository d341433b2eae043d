//! Rows of the diagnosis' studies, and what they come to.

use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::fmt::Write;
use std::path::Path;

/// One hidden effect, or one of its parameters, in one diagnosis.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
pub struct Row {
    /// `plant`, `rig` or `rig-ideal`.
    pub source: String,
    /// `all@STRENGTH`, `pairs`, `nulls`, `unlisted` or the effects.
    pub case: String,
    /// What was hidden; `none` in a null set.
    pub hidden: String,
    /// Seed of the recordings and of the diagnosis.
    pub seed: u64,
    /// Residual of the plain model over the noise.
    pub over_noise: f64,
    /// Verdict.
    pub verdict: String,
    /// Named effects, joined by `+`.
    pub named: String,
    /// What they are confusable with, joined by `+`.
    pub confusable: String,
    /// A parameter of the hidden effect, if it was named.
    pub parameter: String,
    /// Its true value.
    pub truth: Option<f64>,
    /// What was found.
    pub value: Option<f64>,
    /// Lower end of the 95 % interval.
    pub low: Option<f64>,
    /// Upper end.
    pub high: Option<f64>,
    /// Reduction of the error on the test set.
    pub gain: f64,
    /// Lower end of its 95 % interval.
    pub gain_low: f64,
    /// Upper end.
    pub gain_high: f64,
}

impl Row {
    /// The rows of a file.
    ///
    /// # Panics
    /// If it cannot be read.
    #[must_use]
    pub fn read(path: &Path) -> Vec<Self> {
        let reader = csv::Reader::from_path(path);
        let mut reader = reader.unwrap_or_else(|e| panic!("{}: {e}", path.display()));
        let rows = reader.deserialize().map(|row| row.expect("a row of a study"));
        rows.collect()
    }

    fn outcome(&self) -> Outcome {
        let has = |list: &str, id: &str| list.split('+').any(|other| other == id);
        if has(&self.named, &self.hidden) {
            Outcome::Named
        } else if has(&self.confusable, &self.hidden) {
            Outcome::Confusable
        } else if self.named.is_empty() {
            Outcome::NoName
        } else {
            Outcome::Wrong
        }
    }

    /// Strength of a case `all@STRENGTH`.
    fn strength(&self) -> Option<f64> {
        self.case.strip_prefix("all@")?.parse().ok()
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Outcome {
    Named,
    Confusable,
    NoName,
    Wrong,
}

/// The confusion matrix, the detection curves, the coverage of the intervals and the gains, as Markdown.
#[must_use]
pub fn tables(rows: &[Row]) -> String {
    let mut out = String::new();
    let mut sources: Vec<&str> = rows.iter().map(|r| r.source.as_str()).collect();
    sources.sort_unstable();
    sources.dedup();
    for source in sources {
        let rows: Vec<&Row> = rows.iter().filter(|r| r.source == source).collect();
        let _ = writeln!(out, "## {source}\n");
        confusion(&rows, &mut out);
        detection(&rows, &mut out);
        numbers(&rows, &mut out);
    }
    out
}

/// One row a hidden effect and seed: parameters stand in several rows.
fn cases<'r>(rows: &[&'r Row]) -> Vec<&'r Row> {
    let mut cases: Vec<&Row> = Vec::new();
    for row in rows {
        let same = |c: &&Row| c.case == row.case && c.hidden == row.hidden && c.seed == row.seed;
        if !cases.iter().any(same) {
            cases.push(row);
        }
    }
    cases
}

/// How often each name was given, hidden effect by hidden effect.
fn confusion(rows: &[&Row], out: &mut String) {
    let mut kinds: Vec<&str> = rows.iter().map(|r| r.case.as_str()).collect();
    kinds.dedup();
    kinds.sort_unstable();
    kinds.dedup();
    for kind in kinds {
        let rows: Vec<&Row> = rows.iter().copied().filter(|r| r.case == kind).collect();
        let cases = cases(&rows);
        let _ = writeln!(
            out,
            "### Confusion, `{kind}`\n\n| hidden | sets | by name | confusable | no name | wrong | names given |\n|---|---|---|---|---|---|---|"
        );
        let mut order: Vec<&str> = Vec::new();
        for case in &cases {
            if !order.contains(&case.hidden.as_str()) {
                order.push(&case.hidden);
            }
        }
        for hidden in order {
            let own: Vec<&&Row> = cases.iter().filter(|c| c.hidden == hidden).collect();
            let count = |o: Outcome| own.iter().filter(|c| c.outcome() == o).count();
            let mut names: BTreeMap<&str, usize> = BTreeMap::new();
            for case in &own {
                let name = if case.named.is_empty() { &case.verdict } else { &case.named };
                *names.entry(name).or_default() += 1;
            }
            let names: Vec<String> = names.iter().map(|(n, k)| format!("{n} × {k}")).collect();
            let _ = writeln!(
                out,
                "| {hidden} | {} | {} | {} | {} | {} | {} |",
                own.len(),
                count(Outcome::Named),
                count(Outcome::Confusable),
                count(Outcome::NoName),
                count(Outcome::Wrong),
                names.join(", ")
            );
        }
        let _ = writeln!(out);
    }
}

/// How often an effect is found (by name or as confusable) at each strength, with the residual over the noise.
fn detection(rows: &[&Row], out: &mut String) {
    let cases = cases(rows);
    let mut strengths: Vec<f64> = cases.iter().filter_map(|c| c.strength()).collect();
    strengths.sort_by(f64::total_cmp);
    strengths.dedup();
    if strengths.len() < 2 {
        return;
    }
    let head: Vec<String> = strengths.iter().map(|s| format!("× {s}")).collect();
    let _ = writeln!(
        out,
        "### Detection\n\nShare of the sets in which the effect is found, by name or as confusable, and in brackets the residual over the noise.\n\n| hidden | {} |\n|---{}|",
        head.join(" | "),
        "|---".repeat(strengths.len())
    );
    let mut order: Vec<&str> = Vec::new();
    for case in cases.iter().filter(|c| c.strength().is_some()) {
        if !order.contains(&case.hidden.as_str()) {
            order.push(&case.hidden);
        }
    }
    for hidden in order {
        let cells: Vec<String> = strengths
            .iter()
            .map(|&strength| {
                let own: Vec<&&Row> = cases
                    .iter()
                    .filter(|c| c.hidden == hidden && c.strength() == Some(strength))
                    .collect();
                if own.is_empty() {
                    return String::new();
                }
                let found = |c: &Row| matches!(c.outcome(), Outcome::Named | Outcome::Confusable);
                let found = own.iter().filter(|c| found(c)).count();
                let size = own.iter().map(|c| c.over_noise).sum::<f64>() / own.len() as f64;
                format!("{:.2} ({size:.1})", found as f64 / own.len() as f64)
            })
            .collect();
        let _ = writeln!(out, "| {hidden} | {} |", cells.join(" | "));
    }
    let _ = writeln!(out);
}

/// Coverage of the intervals, and gains.
fn numbers(rows: &[&Row], out: &mut String) {
    let with: Vec<(f64, f64, f64, f64)> =
        rows.iter().filter_map(|r| Some((r.truth?, r.value?, r.low?, r.high?))).collect();
    let inside = |(t, _, low, high): (f64, f64, f64, f64)| low <= t && t <= high;
    let near = |(t, v, ..): (f64, f64, f64, f64)| (v - t).abs() <= 0.1 * t.abs();
    let cases = cases(rows);
    let named: Vec<&&Row> = cases.iter().filter(|c| !c.named.is_empty()).collect();
    let nulls: Vec<&&Row> = cases.iter().filter(|c| c.hidden == "none").collect();
    let _ = writeln!(
        out,
        "Parameters: {} found, {} inside their 95 % interval, {} within 10 %, {} one of both.  ",
        with.len(),
        with.iter().filter(|p| inside(**p)).count(),
        with.iter().filter(|p| near(**p)).count(),
        with.iter().filter(|p| inside(**p) || near(**p)).count()
    );
    let _ = writeln!(
        out,
        "Error reduction on the test set: positive with its interval above zero in {} of {} diagnoses that name something.  ",
        named.iter().filter(|c| c.gain_low > 0.0).count(),
        named.len()
    );
    if !nulls.is_empty() {
        let alarms = nulls.iter().filter(|c| c.verdict != "nothing_found").count();
        let _ = writeln!(out, "Null sets: {alarms} false alarms of {}.  ", nulls.len());
    }
    let _ = writeln!(out);
}
