//! Which recordings are trained on and which are held out.

use pam_data::Recording;
use pam_data::conditions::{TRAINING_PSI, name_of};
use rand::SeedableRng;
use rand::rngs::ChaCha8Rng;
use rand::seq::SliceRandom;
use serde::{Deserialize, Serialize};

/// Which recordings of a data set: all, the training set, none, those that are not trained on, a share drawn by the
/// seed, or a list of names. A name is that of a recording (`nn_3060`), its pressures (`3060`), or a pattern in which
/// `*` stands for any characters and `?` for one (`monday-*`).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(
    untagged,
    expecting = "expected \"all\", \"train\", \"rest\", \"none\", a share such as 0.2, or a list of names"
)]
pub enum Selection {
    /// `all`, `train`, `rest` or `none`.
    Set(SelectionSet),
    /// This share of the recordings, drawn by the seed; at least one of two or more, and of a single recording its
    /// end.
    Share(f64),
    /// Names and patterns.
    Names(Vec<String>),
}

/// A selection that has a name.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum SelectionSet {
    /// All recordings.
    All,
    /// The 29 training conditions of the published curriculum; of recordings that are not named after pressures all
    /// but the held-out ones.
    Train,
    /// Recordings that are not trained on; where the training set leaves none, a fifth of the recordings, drawn by
    /// the seed, or the last fifth of a single one.
    Rest,
    /// None.
    None,
}

/// Which recordings are trained on and which are held out.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct DataSettings {
    /// Recordings to train on.
    pub train: Selection,
    /// Recordings to score on, never trained on.
    pub held_out: Selection,
    /// Seed of shares that are drawn: the same split for all seeds of the training.
    pub split_seed: u64,
}

impl Default for DataSettings {
    fn default() -> Self {
        Self {
            train: Selection::Set(SelectionSet::Train),
            held_out: Selection::Set(SelectionSet::Rest),
            split_seed: 1,
        }
    }
}

/// Share of the recordings that is held out where nothing else is said.
const HELD_OUT_SHARE: f64 = 0.2;

/// Use of a recording.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SplitRole {
    /// Trained on.
    Train,
    /// Scored only.
    HeldOut,
    /// Neither.
    Unused,
}

/// Recordings to train on and to score on.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct DataSplit {
    /// Trained on.
    pub train: Vec<Recording>,
    /// Scored only.
    pub held_out: Vec<Recording>,
}

impl DataSettings {
    /// The role of each recording of a set by its name. A single recording that is to be split in time is
    /// [`SplitRole::Train`] here.
    #[must_use]
    pub fn roles(&self, names: &[&str]) -> Vec<SplitRole> {
        let seed = self.split_seed;
        let published = names.iter().any(|name| is_condition(name));
        let default_train = self.train == Selection::Set(SelectionSet::Train) && !published;
        let rest = self.held_out == Selection::Set(SelectionSet::Rest);
        let mut held: Vec<bool> = match &self.held_out {
            Selection::Share(share) => drawn(names, *share, seed),
            // Nothing says what to train on: what is held out must be drawn first.
            Selection::Set(SelectionSet::Rest) if default_train => {
                drawn(names, HELD_OUT_SHARE, seed)
            }
            selection => names.iter().map(|n| !rest && selection.takes(n, false)).collect(),
        };
        let train: Vec<bool> = match &self.train {
            Selection::Share(share) => drawn(names, *share, seed.wrapping_add(1)),
            Selection::Set(SelectionSet::Rest) => held.iter().map(|held| !held).collect(),
            Selection::Set(SelectionSet::Train) if default_train => {
                held.iter().map(|held| !held).collect()
            }
            selection => names.iter().map(|n| selection.takes(n, false)).collect(),
        };
        if rest && !default_train {
            held = train.iter().map(|train| !train).collect();
        }
        let role = |(train, held): (&bool, &bool)| match (train, held) {
            // Named for both: an explicit list of held-out recordings is never trained on.
            (true, true) if matches!(self.held_out, Selection::Names(_) | Selection::Share(_)) => {
                SplitRole::HeldOut
            }
            (true, _) => SplitRole::Train,
            (false, true) => SplitRole::HeldOut,
            (false, false) => SplitRole::Unused,
        };
        train.iter().zip(&held).map(role).collect()
    }

    /// Checks that every name and pattern of the two lists selects a recording.
    ///
    /// # Errors
    /// The names that select none, with the recordings that there are.
    pub fn check_names(&self, names: &[&str]) -> Result<(), String> {
        for (key, selection) in [("train", &self.train), ("held_out", &self.held_out)] {
            let Selection::Names(wanted) = selection else { continue };
            let unknown = |wanted: &&String| {
                let alone = Selection::Names(vec![(*wanted).clone()]);
                !names.iter().any(|name| alone.takes(name, false))
            };
            let unknown: Vec<&str> = wanted.iter().filter(unknown).map(String::as_str).collect();
            if !unknown.is_empty() {
                return Err(format!(
                    "data.{key}: no recording is called `{}`; there are {}",
                    unknown.join("`, `"),
                    names.join(", ")
                ));
            }
        }
        Ok(())
    }

    /// The same with lists of names in place of shares that are drawn from these: a part of the recordings is then
    /// split as the whole is.
    #[must_use]
    pub fn pinned(&self, names: &[&str]) -> Self {
        let drawn = matches!(self.train, Selection::Share(_))
            || matches!(self.held_out, Selection::Share(_))
            || !names.iter().any(|name| is_condition(name));
        if !drawn || names.len() < 2 {
            return self.clone();
        }
        let roles = self.roles(names);
        let of = |role: SplitRole| {
            let taken = names.iter().zip(&roles).filter(|(_, r)| **r == role);
            Selection::Names(taken.map(|(name, _)| (*name).to_owned()).collect())
        };
        Self { train: of(SplitRole::Train), held_out: of(SplitRole::HeldOut), ..self.clone() }
    }

    /// Recordings by their roles. Of a single recording from which a share is held out, the last part in time is.
    #[must_use]
    pub fn split(&self, recordings: Vec<Recording>) -> DataSplit {
        let names: Vec<&str> = recordings.iter().map(|r| r.name.as_str()).collect();
        let share = match self.held_out {
            Selection::Share(share) => Some(share),
            Selection::Set(SelectionSet::Rest) if !is_condition(names.first().unwrap_or(&"")) => {
                Some(HELD_OUT_SHARE)
            }
            _ => None,
        };
        let whole = !matches!(self.train, Selection::Names(_) | Selection::Set(SelectionSet::All));
        if let ([only], Some(share)) = (&recordings[..], share.filter(|_| whole)) {
            let cut = ((1.0 - share.clamp(0.0, 1.0)) * only.len() as f64).round() as usize;
            if cut > 1 && cut + 1 < only.len() {
                return split_in_time(only, cut);
            }
        }
        let roles = self.roles(&names);
        let mut split = DataSplit::default();
        for (recording, role) in recordings.into_iter().zip(roles) {
            match role {
                SplitRole::Train => split.train.push(recording),
                SplitRole::HeldOut => split.held_out.push(recording),
                SplitRole::Unused => {}
            }
        }
        split
    }
}

/// The two parts of a recording, both with the reading at rest of the whole: the valves stay closed.
fn split_in_time(recording: &Recording, cut: usize) -> DataSplit {
    let mut whole = recording.clone();
    whole.sealed = Some(whole.reading_at_rest());
    let part = |range: std::ops::Range<usize>, number: usize| {
        let mut part = whole.slice(range);
        part.name = format!("{}#{number}", whole.name);
        part
    };
    DataSplit { train: vec![part(0..cut, 1)], held_out: vec![part(cut..whole.len(), 2)] }
}

/// A share of the names, drawn by the seed from the sorted ones: at least one, if there are two, and never all.
fn drawn(names: &[&str], share: f64, seed: u64) -> Vec<bool> {
    let n = names.len();
    let count = ((share.clamp(0.0, 1.0) * n as f64).round() as usize).clamp(1, n.max(2) - 1);
    let mut order: Vec<usize> = (0..n).collect();
    order.sort_by_key(|&k| names[k]);
    order.shuffle(&mut ChaCha8Rng::seed_from_u64(seed));
    let mut taken = vec![false; n];
    if n > 1 && share > 0.0 {
        order.iter().take(count).for_each(|&k| taken[k] = true);
    }
    taken
}

/// True for names after pressures: `nn_3060`.
fn is_condition(name: &str) -> bool {
    name.strip_prefix("nn_")
        .and_then(|code| code.get(..4))
        .is_some_and(|code| code.bytes().all(|b| b.is_ascii_digit()))
}

impl Selection {
    /// Whether a recording is selected by its name alone; `trained` says whether it is trained on. A share selects
    /// none so: see [`DataSettings::roles`].
    #[must_use]
    pub fn takes(&self, name: &str, trained: bool) -> bool {
        let code = name.strip_prefix("nn_").unwrap_or(name);
        match self {
            Self::Set(SelectionSet::All) => true,
            Self::Set(SelectionSet::None) | Self::Share(_) => false,
            Self::Set(SelectionSet::Rest) => !trained,
            Self::Set(SelectionSet::Train) => {
                let code = code.get(..4).unwrap_or_default();
                TRAINING_PSI.iter().any(|c| name_of(*c)[3..] == *code)
            }
            Self::Names(names) => names.iter().any(|n| n == code || matches(n, name)),
        }
    }
}

/// Whether a name matches a pattern with `*` and `?`.
fn matches(pattern: &str, name: &str) -> bool {
    let (pattern, name): (Vec<char>, Vec<char>) =
        (pattern.chars().collect(), name.chars().collect());
    // Reachable places of the pattern after each character of the name.
    let closure = |places: &mut Vec<bool>| {
        for k in 0..pattern.len() {
            if places[k] && pattern[k] == '*' {
                places[k + 1] = true;
            }
        }
    };
    let mut places = vec![false; pattern.len() + 1];
    places[0] = true;
    closure(&mut places);
    for c in name {
        let mut next = vec![false; pattern.len() + 1];
        for k in 0..pattern.len() {
            if places[k] {
                match pattern[k] {
                    '*' => next[k] = true,
                    p if p == '?' || p == c => next[k + 1] = true,
                    _ => {}
                }
            }
        }
        closure(&mut next);
        places = next;
    }
    places[pattern.len()]
}
