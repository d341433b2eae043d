//! Counts of outcomes with exact binomial limits, one for each criterion.

use super::{Kind, Outcome, Strength};
use pam_experiment::certify::clopper_pearson;
use serde::Serialize;
use std::collections::BTreeMap;

/// Fewest intervals of a parameter from which its coverage is judged.
const FEWEST_INTERVALS: usize = 20;

/// `k` of `n` with the 95 % limits of Clopper and Pearson (1934).
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Share {
    /// What is counted.
    pub criterion: String,
    /// Count.
    pub k: usize,
    /// Trials.
    pub n: usize,
    /// `k/n`; absent without trials.
    pub share: Option<f64>,
    /// Lower limit.
    pub low: f64,
    /// Upper limit.
    pub high: f64,
    /// What must hold, in words; empty for counts that are told only.
    pub asked: String,
    /// Whether it holds; absent without trials or request.
    pub holds: Option<bool>,
}

/// What must hold of a share.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Asked {
    /// Nothing.
    Told,
    /// At least this.
    AtLeast(f64),
    /// At most this.
    AtMost(f64),
    /// At most the first, with an upper limit of at most the second.
    AtMostWithin(f64, f64),
    /// Between both.
    Between(f64, f64),
}

/// The exact 95 % limits of a binomial share: quantiles of Beta(k, n − k + 1) and Beta(k + 1, n − k).
#[must_use]
pub fn limits(k: usize, n: usize) -> [f64; 2] {
    clopper_pearson(k as u64, n as u64, 0.95)
}

impl Share {
    /// A share of the outcomes that count.
    #[must_use]
    pub fn new(criterion: &str, k: usize, n: usize, asked: Asked) -> Self {
        let share = (n > 0).then(|| k as f64 / n as f64);
        let [low, high] = limits(k, n);
        let percent = |v: f64| format!("{:.0} %", 100.0 * v);
        let (text, holds): (String, Option<bool>) = match asked {
            Asked::Told => (String::new(), None),
            Asked::AtLeast(least) => (format!("≥ {}", percent(least)), share.map(|s| s >= least)),
            Asked::AtMost(most) => (format!("≤ {}", percent(most)), share.map(|s| s <= most)),
            Asked::AtMostWithin(most, limit) => (
                format!("≤ {}, upper limit ≤ {}", percent(most), percent(limit)),
                share.map(|s| s <= most && high <= limit),
            ),
            Asked::Between(least, most) => (
                format!("{} to {}", percent(least), percent(most)),
                share.map(|s| least <= s && s <= most),
            ),
        };
        Self { criterion: criterion.into(), k, n, share, low, high, asked: text, holds }
    }

    fn of<'o>(
        criterion: &str,
        outcomes: impl IntoIterator<Item = &'o Outcome>,
        counts: impl Fn(&Outcome) -> bool,
        asked: Asked,
    ) -> Self {
        let all: Vec<&Outcome> = outcomes.into_iter().collect();
        Self::new(criterion, all.iter().filter(|o| counts(o)).count(), all.len(), asked)
    }
}

/// The criteria on outcomes.
#[must_use]
pub fn criteria(outcomes: &[Outcome]) -> Vec<Share> {
    let own = |kind: Kind| move |o: &&Outcome| o.case.kind == kind && o.case.repeats.is_none();
    let of = |kind: Kind| outcomes.iter().filter(own(kind));
    // An error of the model that no baseline recording shows cannot be told from a fault.
    let judged = |o: &&Outcome| o.case.factors.judgeable();
    let named = |o: &Outcome| o.headline().next().is_some();
    let whole = |o: &&Outcome| o.truth.iter().all(super::outcome::HiddenTruth::detectable);
    let medium = |o: &&Outcome| o.strength() == Some(Strength::Medium);
    let singles = || of(Kind::Single).filter(judged).filter(whole);
    let pairs = || of(Kind::Pair).filter(judged).filter(whole);
    let both = |o: &Outcome| o.truth.iter().all(|t| o.names(&t.hidden.id));
    let faulty = || {
        outcomes
            .iter()
            .filter(|o| o.case.kind != Kind::Row && o.case.kind != Kind::Null)
            .filter(|o| o.case.repeats.is_none())
    };
    let nothing = |o: &Outcome| o.verdict == "nothing_found";
    let pairs_of_seeds: Vec<(&Outcome, &Outcome)> = outcomes
        .iter()
        .filter_map(|o| {
            let first = o.case.repeats.as_ref()?;
            Some((outcomes.iter().find(|other| other.case.id == *first)?, o))
        })
        .collect();
    let same = pairs_of_seeds.iter().filter(|(a, b)| a.headline_text() == b.headline_text());
    let refused = |o: &Outcome| o.verdict == super::outcome::REFUSED;
    let mut all = vec![
        Share::of(
            "false names on null sets",
            of(Kind::Null).filter(judged),
            named,
            Asked::AtMostWithin(0.05, 0.08),
        ),
        Share::of(
            "`nothing_found` on null sets",
            of(Kind::Null).filter(judged),
            nothing,
            Asked::AtLeast(0.9),
        ),
        Share::of(
            "names on null sets with a model error and no baseline recordings",
            of(Kind::Null).filter(|o| !judged(o)),
            named,
            Asked::Told,
        ),
        Share::of(
            "first name right, single effects of medium strength",
            singles().filter(medium),
            Outcome::first_is_right,
            Asked::AtLeast(0.95),
        ),
        Share::of(
            "first name right, all detectable single effects",
            singles(),
            Outcome::first_is_right,
            Asked::AtLeast(0.9),
        ),
        Share::of(
            "single effects below the limit of detection that are named",
            of(Kind::Single).filter(|o| !whole(o)),
            Outcome::first_is_right,
            Asked::Told,
        ),
        Share::of("both of a pair named", pairs(), both, Asked::AtLeast(0.85)),
        Share::of(
            "superfluous names in the headline, singles and pairs",
            of(Kind::Single).chain(of(Kind::Pair)).filter(judged),
            |o| o.superfluous() > 0,
            Asked::AtMost(0.03),
        ),
        Share::of(
            "`explained` with a certain fault unsaid",
            faulty(),
            Outcome::explained_wrongly,
            Asked::AtMost(0.02),
        ),
        Share::of(
            "`explained` where something unlisted is hidden",
            of(Kind::Unlisted),
            Outcome::explained_unlisted_wrongly,
            Asked::AtMost(0.02),
        ),
        Share::of(
            "`nothing_found` where a detectable effect begins within a recording",
            of(Kind::Onset).filter(whole),
            nothing,
            Asked::Told,
        ),
        Share::new(
            "same names with another seed of the diagnosis",
            same.count(),
            pairs_of_seeds.len(),
            Asked::AtLeast(0.95),
        ),
        Share::of("refused with an error", outcomes, refused, Asked::Told),
    ];
    let (sum, each) = coverage(outcomes);
    all.push(sum);
    let [k, n] = intervals(outcomes, |o| !judged(&o)).values().fold([0, 0], add);
    all.push(Share::new(
        "interval holds the truth, model error and no baseline recordings",
        k,
        n,
        Asked::Told,
    ));
    all.extend(each);
    all
}

/// Coverage of the 95 % intervals of single effects and pairs: of all parameters together, and of each.
#[must_use]
pub fn coverage(outcomes: &[Outcome]) -> (Share, Vec<Share>) {
    let by = intervals(outcomes, |o| o.case.factors.judgeable());
    let sum = by.values().fold([0, 0], add);
    let each = by
        .into_iter()
        .map(|(name, [k, n])| {
            let asked = if n < FEWEST_INTERVALS { Asked::Told } else { Asked::Between(0.9, 0.99) };
            Share::new(&format!("interval holds the truth, `{name}`"), k, n, asked)
        })
        .collect();
    (Share::new("interval holds the truth, all parameters", sum[0], sum[1], Asked::Told), each)
}

/// For each parameter of single effects and pairs that are so, how many intervals hold the truth, of how many.
fn intervals(outcomes: &[Outcome], are: impl Fn(&Outcome) -> bool) -> BTreeMap<String, [usize; 2]> {
    let mut by: BTreeMap<String, [usize; 2]> = BTreeMap::new();
    let usual =
        |o: &&Outcome| matches!(o.case.kind, Kind::Single | Kind::Pair) && o.case.repeats.is_none();
    for o in outcomes.iter().filter(usual).filter(|o| are(o)) {
        for (name, truth, [_, low, high]) in o.estimates() {
            let held = usize::from(low <= truth && truth <= high);
            let count = by.entry(name).or_default();
            *count = add(*count, &[held, 1]);
        }
    }
    by
}

fn add(a: [usize; 2], b: &[usize; 2]) -> [usize; 2] {
    [a[0] + b[0], a[1] + b[1]]
}
