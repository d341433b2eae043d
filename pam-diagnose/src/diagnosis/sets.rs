//! Which recordings are fitted and which judge.

use crate::error::DiagnoseError;
use crate::extended::BURN_IN_S;
use crate::fit::{Floors, Problem};
use crate::search::Split;
use crate::simulation::{Base, Trial};
use pam_train::Subject;
use rand::seq::SliceRandom;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde::Serialize;

/// The recordings of a diagnosis.
#[derive(Debug, Clone, Copy, Default)]
pub struct Sets<'a> {
    /// Recordings in which something may be wrong.
    pub data: &'a [Subject],
    /// Recordings that only judge; kept aside from the data if absent.
    pub heldout: Option<&'a [Subject]>,
    /// Recordings on which the model was validated: their error is ordinary.
    pub healthy: Option<&'a [Subject]>,
}

/// What took no part in naming and fitting.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(tag = "kind", rename_all = "snake_case")]
pub enum HeldOut {
    /// Recordings that were given for it.
    Given {
        /// Their names.
        recordings: Vec<String>,
    },
    /// Recordings of the data that were kept aside.
    Kept {
        /// Their names.
        recordings: Vec<String>,
    },
    /// The last part of the only recording.
    LastPart {
        /// Where it begins, s after the first sample.
        from_s: f64,
    },
}

impl HeldOut {
    /// In words.
    #[must_use]
    pub fn sentence(&self) -> String {
        match self {
            Self::Given { recordings } => {
                format!(
                    "Judged on {} given recording(s): {}.",
                    recordings.len(),
                    recordings.join(", ")
                )
            }
            Self::Kept { recordings } => format!(
                "{} recording(s) were kept aside to judge: {}.",
                recordings.len(),
                recordings.join(", ")
            ),
            Self::LastPart { from_s } => {
                format!("Everything after t = {from_s:.1} s was kept aside to judge.")
            }
        }
    }
}

/// Share of a data set that is kept aside.
const KEPT: f64 = 1.0 / 3.0;
/// Shortest recording that can be parted, s.
const SHORTEST_S: f64 = 3.0;

/// Trials of one set, and which of them are fitted.
#[derive(Debug)]
pub(super) struct Prepared {
    pub(super) trials: Vec<Trial>,
    train: Vec<usize>,
    held: Vec<usize>,
    pub(super) held_out: HeldOut,
}

impl Prepared {
    /// Prepares data and parts them; the same seed parts them in the same way.
    pub(super) fn new(
        model: &crate::Extended,
        data: &[Subject],
        heldout: Option<&[Subject]>,
        seed: u64,
    ) -> Result<Self, DiagnoseError> {
        let trial = |s: &Subject| Trial::new(&model.joint, s);
        let mut trials: Vec<Trial> = data.iter().map(trial).collect();
        if let Some(short) = trials.iter().find(|t| t.duration_s() < SHORTEST_S) {
            return Err(DiagnoseError::TooLittle(format!(
                "recording `{}` is {:.1} s long; a diagnosis needs at least {SHORTEST_S} s of each",
                short.source.name,
                short.duration_s()
            )));
        }
        let n = trials.len();
        let names = |trials: &[Trial], which: &[usize]| {
            which.iter().map(|&i| trials[i].source.name.clone()).collect::<Vec<_>>()
        };
        let (train, held, held_out) = match heldout {
            Some(more) => {
                trials.extend(more.iter().map(trial));
                let held: Vec<usize> = (n..trials.len()).collect();
                let recordings = names(&trials, &held);
                ((0..n).collect(), held, HeldOut::Given { recordings })
            }
            None if n >= 2 => {
                let kept = ((KEPT * n as f64).round() as usize).max(1);
                let mut order: Vec<usize> = (0..n).collect();
                let mut random = ChaCha8Rng::seed_from_u64(seed);
                order.shuffle(&mut random);
                let (held, train) = order.split_at(kept);
                let (mut held, mut train) = (held.to_vec(), train.to_vec());
                held.sort_unstable();
                train.sort_unstable();
                let recordings = names(&trials, &held);
                (train, held, HeldOut::Kept { recordings })
            }
            None if n == 1 => {
                let from_s = (1.0 - KEPT) * trials[0].duration_s();
                (vec![0], vec![0], HeldOut::LastPart { from_s })
            }
            None => return Err(DiagnoseError::TooLittle("there are no recordings".into())),
        };
        if held.is_empty() || train.is_empty() {
            return Err(DiagnoseError::TooLittle(
                "there must be a recording to fit and one to judge by".into(),
            ));
        }
        Ok(Self { trials, train, held, held_out })
    }

    /// The trials that are fitted.
    pub(super) fn train(&self) -> Vec<&Trial> {
        self.train.iter().map(|&i| &self.trials[i]).collect()
    }

    /// All trials.
    pub(super) fn all(&self) -> Vec<&Trial> {
        self.trials.iter().collect()
    }

    pub(super) fn split(&self, base: Base<f64>, floors: Floors) -> Split<'_> {
        let of = |which: &[usize]| {
            Problem::new(which.iter().map(|&i| &self.trials[i]), base, BURN_IN_S, floors)
        };
        let (train, held) = (of(&self.train), of(&self.held));
        match self.held_out {
            HeldOut::LastPart { from_s } => {
                let point = |t: &Trial| (from_s / t.step_s) as usize;
                let burn = |t: &Trial| (BURN_IN_S / t.step_s) as usize;
                Split {
                    train: train.with_windows(|_, t| burn(t)..point(t)),
                    held: held.with_windows(|_, t| point(t)..t.points()),
                    same_trials: true,
                }
            }
            _ => {
                let held = Problem { forgive_offsets: true, ..held };
                Split { train, held, same_trials: false }
            }
        }
    }
}

/// A number of the bootstrap for a seed.
pub(super) fn random(seed: u64) -> impl FnMut(usize) -> usize {
    let mut random = ChaCha8Rng::seed_from_u64(seed ^ 0x9e37_79b9_7f4a_7c15);
    move |below| random.random_range(0..below)
}
