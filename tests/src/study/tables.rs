//! The tables of a folder of outcomes.

use super::criteria::{Share, coverage, criteria};
use super::{Kind, Outcome, Source};
use crate::csv_text;
use pam_numerics::statistics::{median, quantile};
use std::cmp::Ordering;
use std::collections::BTreeMap;
use std::fmt::Write;

/// The criteria as rows of CSV.
///
/// # Errors
/// A sentence if the table cannot be written.
pub fn csv(outcomes: &[Outcome]) -> Result<String, String> {
    csv_of(outcomes, criteria)
}

/// The [`coverage`] of the intervals as rows of CSV: all parameters together, then each parameter with enough intervals to be judged, in
/// increasing order of coverage.
///
/// # Errors
/// A sentence if the table cannot be written.
pub fn coverage_csv(outcomes: &[Outcome]) -> Result<String, String> {
    csv_of(outcomes, by_share)
}

fn by_share(outcomes: &[Outcome]) -> Vec<Share> {
    let (sum, mut each) = coverage(outcomes);
    each.retain(|s| s.holds.is_some());
    each.sort_by(|a, b| a.share.partial_cmp(&b.share).unwrap_or(Ordering::Equal));
    each.insert(0, sum);
    each
}

fn csv_of(
    outcomes: &[Outcome],
    shares: impl Fn(&[Outcome]) -> Vec<Share>,
) -> Result<String, String> {
    let header = ["source", "criterion", "k", "n", "share", "low", "high", "asked", "holds"];
    let rows = by_source(outcomes).into_iter().flat_map(|(source, outcomes)| {
        let row = move |s: Share| {
            (source, s.criterion, s.k, s.n, s.share, s.low, s.high, s.asked, s.holds)
        };
        shares(&outcomes).into_iter().map(row)
    });
    csv_text(&header, rows)
}

/// Outcomes of plant and rig, which are never counted together.
fn by_source(outcomes: &[Outcome]) -> Vec<(&'static str, Vec<Outcome>)> {
    let of = |source| outcomes.iter().filter(move |o| o.case.factors.source == source);
    let both = [("plant", Source::Plant), ("rig", Source::Rig)];
    let mut all = both.map(|(name, s)| (name, of(s).cloned().collect::<Vec<_>>())).to_vec();
    all.retain(|(_, outcomes)| !outcomes.is_empty());
    all
}

/// Criteria, names given for each hidden effect, and times, as Markdown.
#[must_use]
pub fn markdown(outcomes: &[Outcome]) -> String {
    let mut out = String::new();
    for (source, outcomes) in by_source(outcomes) {
        section(source, &criteria(&outcomes), &mut out);
        names(&outcomes, &mut out);
        times(&outcomes, &mut out);
        let _ = writeln!(out);
    }
    out
}

/// The table of [`coverage_csv`] as Markdown.
#[must_use]
pub fn coverage_markdown(outcomes: &[Outcome]) -> String {
    let mut out = String::new();
    for (source, outcomes) in by_source(outcomes) {
        section(source, &by_share(&outcomes), &mut out);
        let _ = writeln!(out);
    }
    out
}

fn section(source: &str, shares: &[Share], out: &mut String) {
    let _ = writeln!(
        out,
        "## {source}\n\n| criterion | k of n | share | 95 % limits | asked | holds |\n|---|---|---|---|---|---|"
    );
    for s in shares {
        line(s, out);
    }
}

fn line(s: &Share, out: &mut String) {
    let share = s.share.map_or_else(|| "–".into(), |v| format!("{:.1} %", 100.0 * v));
    let holds = s.holds.map_or("", |h| if h { "yes" } else { "no" });
    let _ = writeln!(
        out,
        "| {} | {} of {} | {share} | {:.1} to {:.1} % | {} | {holds} |",
        s.criterion,
        s.k,
        s.n,
        100.0 * s.low,
        100.0 * s.high,
        s.asked
    );
}

/// What the diagnosis said of each kind and hidden effect.
fn names(outcomes: &[Outcome], out: &mut String) {
    let mut by: BTreeMap<(Kind, String), BTreeMap<String, usize>> = BTreeMap::new();
    for o in outcomes.iter().filter(|o| o.case.repeats.is_none()) {
        let hidden: Vec<&str> = o.truth.iter().map(|t| t.hidden.id.as_str()).collect();
        // Pairs are too many for a row each.
        let hidden = match o.case.kind {
            Kind::Pair => String::new(),
            _ => hidden.join("+"),
        };
        let names = o.headline_text();
        let said = match o.case.kind {
            Kind::Pair => o.verdict.clone(),
            _ => format!("{}{}{names}", o.verdict, if names.is_empty() { "" } else { ": " }),
        };
        *by.entry((o.case.kind, hidden)).or_default().entry(said).or_default() += 1;
    }
    let _ = writeln!(out, "\n| kind | hidden | said |\n|---|---|---|");
    for ((kind, hidden), said) in by {
        let mut said: Vec<(String, usize)> = said.into_iter().collect();
        said.sort_by(|a, b| b.1.cmp(&a.1).then(a.0.cmp(&b.0)));
        let said: Vec<String> = said.iter().map(|(s, n)| format!("{s} × {n}")).collect();
        let kind = format!("{kind:?}").to_lowercase();
        let _ = writeln!(out, "| {kind} | {hidden} | {} |", said.join("; "));
    }
}

fn times(outcomes: &[Outcome], out: &mut String) {
    let cpu: Vec<f64> = outcomes.iter().filter_map(|o| o.cpu_s).collect();
    if !cpu.is_empty() {
        let _ = writeln!(
            out,
            "\nCPU time of a diagnosis: median {:.1} s, 95 % below {:.1} s, sum {:.0} s of {} cases.",
            median(&cpu),
            quantile(&cpu, 0.95),
            cpu.iter().sum::<f64>(),
            cpu.len()
        );
    }
}
