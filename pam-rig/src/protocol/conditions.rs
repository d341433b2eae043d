//! Pairs of sealed pressures.

use pam_core::NamedChoice;
use pam_data::conditions::TRAINING_PSI;
use serde::{Deserialize, Serialize};

/// A set of conditions that has a name.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ConditionSet {
    /// The 29 training conditions.
    Train,
    /// All 225 pairs of 10, 15, …, 80 psi.
    Grid,
    /// The 15 equal pairs of the grid.
    Symmetric,
}

impl NamedChoice for ConditionSet {
    const KIND: &'static str = "set of conditions";
    const ALL: &'static [(&'static str, Self, &'static str)] = &[
        ("train", Self::Train, "the 29 training conditions"),
        ("grid", Self::Grid, "all 225 pairs of 10, 15, …, 80 psi"),
        ("symmetric", Self::Symmetric, "the 15 equal pairs of the grid"),
    ];
}

/// The sealed pressures at which a protocol is run.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(untagged, try_from = "Written")]
pub enum Conditions {
    /// A named set.
    Set(ConditionSet),
    /// Pairs of whole psi gauge, flexor and extensor.
    List(Vec<[u8; 2]>),
}

/// Conditions as a file writes them.
#[derive(Deserialize)]
#[serde(
    untagged,
    expecting = "expected \"train\", \"grid\", \"symmetric\" or a list of pairs like [[30, 60]]"
)]
enum Written {
    Name(String),
    List(Vec<Vec<f64>>),
}

impl TryFrom<Written> for Conditions {
    type Error = String;

    fn try_from(written: Written) -> Result<Self, String> {
        let list = match written {
            Written::Name(name) => return Self::parse(&name),
            Written::List(list) => list,
        };
        let whole = |p: f64| {
            ((0.0..=f64::from(LARGEST_PSI)).contains(&p) && p.fract() == 0.0)
                .then_some(p as u8)
                .ok_or_else(|| {
                    format!("conditions: {p} is not a whole number of 0 to {LARGEST_PSI} psi")
                })
        };
        let pair = |pair: Vec<f64>| match pair[..] {
            [f, e] => Ok([whole(f)?, whole(e)?]),
            _ => Err(format!("conditions: {pair:?} is not a pair of flexor and extensor")),
        };
        list.into_iter().map(pair).collect::<Result<_, _>>().map(Self::List)
    }
}

/// The largest pressure that the supply can hold, psi gauge.
pub(super) const LARGEST_PSI: u8 = 90;

impl Conditions {
    /// The pairs, psi gauge.
    #[must_use]
    pub fn psi(&self) -> Vec<[u8; 2]> {
        let steps = || (10..=80_u8).step_by(5);
        match self {
            Self::Set(ConditionSet::Train) => TRAINING_PSI.to_vec(),
            Self::Set(ConditionSet::Grid) => {
                steps().flat_map(|f| steps().map(move |e| [f, e])).collect()
            }
            Self::Set(ConditionSet::Symmetric) => steps().map(|p| [p, p]).collect(),
            Self::List(list) => list.clone(),
        }
    }

    /// Reads `train`, `grid`, `symmetric` or pairs like `30/60,45/45`.
    ///
    /// # Errors
    /// A message that says what is expected.
    pub fn parse(text: &str) -> Result<Self, String> {
        if let Ok(set) = ConditionSet::from_name(text.trim()) {
            return Ok(Self::Set(set));
        }
        let pair = |part: &str| {
            let (f, e) = part.split_once('/')?;
            Some([f.trim().parse().ok()?, e.trim().parse().ok()?])
        };
        let pairs: Option<Vec<_>> = text.split(',').map(pair).collect();
        let list = Self::List(pairs.ok_or_else(|| {
            let names: Vec<&str> = ConditionSet::ALL.iter().map(|(name, ..)| *name).collect();
            format!(
                "`{text}` is neither {} nor a list of whole psi like 30/60,45/45",
                names.join(", ")
            )
        })?);
        list.check()?;
        Ok(list)
    }

    /// Checks a list.
    ///
    /// # Errors
    /// A message if it is empty, repeats a pair, or asks for more than the supply gives.
    pub fn check(&self) -> Result<(), String> {
        let psi = self.psi();
        if psi.is_empty() {
            return Err("the list of conditions is empty".into());
        }
        for (i, pair) in psi.iter().enumerate() {
            if let Some(p) = pair.iter().find(|&&p| p > LARGEST_PSI) {
                return Err(format!(
                    "{p} psi is more than the supply can give ({LARGEST_PSI} psi)"
                ));
            }
            if psi[..i].contains(pair) {
                return Err(format!("the pair {}/{} is there twice", pair[0], pair[1]));
            }
        }
        Ok(())
    }
}
