//! Which recordings are fitted, which judge names, and which only measure the gain.

use crate::error::DiagnoseError;
use crate::fit::BURN_IN_S;
use crate::fit::{Floors, Problem};
use crate::search::Split;
use pam_data::Subject;
use pam_effects::simulation::{Base, Trial};
use rand::seq::SliceRandom;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde::Serialize;

/// The recordings of a diagnosis.
#[derive(Debug, Clone, Copy, Default)]
pub struct Sets<'a> {
    /// Recordings in which something may be wrong.
    pub data: &'a [Subject],
    /// Recordings that only measure the gain; kept aside from the data if absent.
    pub heldout: Option<&'a [Subject]>,
    /// Recordings on which the model was validated: their error is ordinary.
    pub healthy: Option<&'a [Subject]>,
}

/// What took no part in naming or fitting: the gain is measured there.
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
        let measured = |what: &str, recordings: &[String]| {
            let (n, names) = (recordings.len(), recordings.join(", "));
            format!(
                "The gain is measured on {n} {what}, which took no part in naming or fitting: {names}."
            )
        };
        match self {
            Self::Given { recordings } => measured("given recording(s)", recordings),
            Self::Kept { recordings } => measured("recording(s) that were kept aside", recordings),
            Self::LastPart { from_s } => format!(
                "The gain is measured after t = {from_s:.1} s, which took no part in naming or fitting."
            ),
        }
    }
}

/// What names are chosen by, beside the likelihood of what is fitted. Afterwards everything is fitted to both.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(tag = "kind", rename_all = "snake_case")]
pub enum JudgedBy {
    /// Recordings of the data that are left out of the fits.
    Recordings {
        /// Their names.
        recordings: Vec<String>,
    },
    /// With one or two recordings a third of each, the last one of the first and the first one of the second,
    /// so that both excitations are seen from both sides.
    Parts {
        /// Name, and the span in s after the first sample.
        parts: Vec<(String, [f64; 2])>,
    },
}

impl JudgedBy {
    /// In words.
    #[must_use]
    pub fn sentence(&self) -> String {
        let by = match self {
            Self::Recordings { recordings } => recordings.join(", "),
            Self::Parts { parts } => parts
                .iter()
                .map(|(name, [from, to])| format!("{name} from {from:.1} to {to:.1} s"))
                .collect::<Vec<_>>()
                .join(", "),
        };
        format!("Names were judged by {by}, left out of the fits until they were chosen.")
    }
}

/// Share of a data set that is kept aside for the gain, and of the rest that judges names.
const KEPT: f64 = 1.0 / 3.0;
/// Shortest recording that can be parted, s.
const SHORTEST_S: f64 = 3.0;

/// What measures the gain.
#[derive(Debug, Clone, Copy)]
pub(super) enum Blind<'a> {
    /// These recordings.
    Given(&'a [Subject]),
    /// A part of the data.
    Kept,
    /// Nothing: no gain is asked for.
    Nothing,
}

/// Trials of one set, and what each is for.
#[derive(Debug)]
pub(super) struct Prepared {
    trials: Vec<Trial>,
    train: Vec<usize>,
    judge: Vec<usize>,
    blind: Vec<usize>,
    pub(super) judged_by: JudgedBy,
    /// Absent if no gain is asked for.
    pub(super) held_out: Option<HeldOut>,
}

impl Prepared {
    /// Prepares data and parts them; the same seed parts them in the same way.
    pub(super) fn new(
        model: &pam_effects::ExtendedModel,
        data: &[Subject],
        blind: Blind<'_>,
        seed: u64,
    ) -> Result<Self, DiagnoseError> {
        let trial = |s: &Subject| Trial::new(&model.joint, s);
        let mut trials: Vec<Trial> = data.iter().map(trial).collect();
        if let Some(short) = trials.iter().find(|t| t.record.duration_s() < SHORTEST_S) {
            return Err(DiagnoseError::TooLittle(format!(
                "recording `{}` is {:.1} s long; a diagnosis needs at least {SHORTEST_S} s of each",
                short.record.source.name,
                short.record.duration_s()
            )));
        }
        if trials.is_empty() {
            return Err(DiagnoseError::TooLittle("there are no recordings".into()));
        }
        let names = |trials: &[Trial], which: &[usize]| {
            which.iter().map(|&i| trials[i].record.source.name.clone()).collect::<Vec<_>>()
        };
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let mut open: Vec<usize> = (0..trials.len()).collect();
        let (aside, held_out) = match blind {
            Blind::Given([]) => {
                return Err(DiagnoseError::TooLittle("there is no held-out recording".into()));
            }
            Blind::Given(more) => {
                let first = trials.len();
                trials.extend(more.iter().map(trial));
                let aside: Vec<usize> = (first..trials.len()).collect();
                let recordings = names(&trials, &aside);
                (aside, Some(HeldOut::Given { recordings }))
            }
            Blind::Kept if open.len() >= 2 => {
                let aside = keep(&mut open, &mut random);
                let recordings = names(&trials, &aside);
                (aside, Some(HeldOut::Kept { recordings }))
            }
            Blind::Kept => {
                let from_s = (1.0 - KEPT) * trials[0].record.duration_s();
                (vec![0], Some(HeldOut::LastPart { from_s }))
            }
            Blind::Nothing => (Vec::new(), None),
        };
        let (judge, judged_by) = if open.len() >= 3 {
            let judge = keep(&mut open, &mut random);
            let recordings = names(&trials, &judge);
            (judge, JudgedBy::Recordings { recordings })
        } else {
            let part = |(place, &i): (usize, &usize)| {
                let t = &trials[i];
                let end_s = match held_out {
                    Some(HeldOut::LastPart { from_s }) => from_s,
                    _ => t.record.duration_s(),
                };
                let span =
                    if place == 0 { [(1.0 - KEPT) * end_s, end_s] } else { [0.0, KEPT * end_s] };
                (t.record.source.name.clone(), span)
            };
            let parts = open.iter().enumerate().map(part).collect();
            (open.clone(), JudgedBy::Parts { parts })
        };
        Ok(Self { trials, train: open, judge, blind: aside, judged_by, held_out })
    }

    /// The trials that may be fitted.
    pub(super) fn open(&self) -> Vec<&Trial> {
        let mut which: Vec<usize> = self.train.iter().chain(&self.judge).copied().collect();
        which.sort_unstable();
        which.dedup();
        which.into_iter().map(|i| &self.trials[i]).collect()
    }

    /// What names are chosen by.
    pub(super) fn split(&self, base: Base<f64>, floors: Floors) -> Split<'_> {
        let train = self.problem(&self.train, base, floors);
        let judge = self.problem(&self.judge, base, floors);
        match &self.judged_by {
            JudgedBy::Parts { parts } => {
                let judged = |i: usize, t: &Trial| {
                    let [from, to] = parts[i].1.map(|s| point(t, s));
                    from.max(burn_in(t))..to.min(self.end_of_open(t))
                };
                // What judges is at one end; the rest is fitted.
                let fitted = |i: usize, t: &Trial| {
                    let judged = judged(i, t);
                    let (start, end) = (burn_in(t), self.end_of_open(t));
                    if judged.start <= start { judged.end..end } else { start..judged.start }
                };
                Split {
                    train: train.with_windows(fitted),
                    held: judge.with_windows(judged),
                    same_trials: true,
                }
            }
            JudgedBy::Recordings { .. } => {
                let held = Problem { forgive_offsets: true, ..judge };
                Split { train, held, same_trials: false }
            }
        }
    }

    /// Everything that may be fitted, once the names are chosen.
    pub(super) fn whole(&self, base: Base<f64>, floors: Floors) -> Problem<'_> {
        Problem::new(self.open(), base, BURN_IN_S, floors)
            .with_windows(|_, t| burn_in(t)..self.end_of_open(t))
    }

    /// What measures the gain.
    pub(super) fn blind(&self, base: Base<f64>, floors: Floors) -> Problem<'_> {
        let blind = self.problem(&self.blind, base, floors);
        match self.held_out {
            Some(HeldOut::LastPart { from_s }) => {
                blind.with_windows(|_, t| point(t, from_s)..t.record.points())
            }
            _ => Problem { forgive_offsets: true, ..blind },
        }
    }

    fn problem(&self, which: &[usize], base: Base<f64>, floors: Floors) -> Problem<'_> {
        Problem::new(which.iter().map(|&i| &self.trials[i]), base, BURN_IN_S, floors)
    }

    fn end_of_open(&self, t: &Trial) -> usize {
        match self.held_out {
            Some(HeldOut::LastPart { from_s }) => point(t, from_s),
            _ => t.record.points(),
        }
    }
}

/// Takes a third of the recordings out, at least one, both lists in their order.
fn keep(open: &mut Vec<usize>, random: &mut ChaCha8Rng) -> Vec<usize> {
    let kept = ((KEPT * open.len() as f64).round() as usize).max(1);
    open.shuffle(random);
    let mut aside: Vec<usize> = open.drain(..kept).collect();
    aside.sort_unstable();
    open.sort_unstable();
    aside
}

fn point(t: &Trial, time_s: f64) -> usize {
    ((time_s / t.record.step_s) as usize).min(t.record.points())
}

/// Where errors begin to count.
fn burn_in(t: &Trial) -> usize {
    point(t, BURN_IN_S).min(t.record.points() / 4)
}

/// A number of the bootstrap for a seed.
pub(super) fn random(seed: u64) -> impl FnMut(usize) -> usize {
    let mut random = ChaCha8Rng::seed_from_u64(seed ^ 0x9e37_79b9_7f4a_7c15);
    move |below| random.random_range(0..below)
}
