//! Which experiments train, validate and test.

use super::split::Split;
use crate::error::DiagnoseError;
use crate::fit::Problem;
use crate::noise::Noise;
use crate::search::Candidates;
use crate::settings::{DataSettings, DiagnosisSettings};
use crate::test_set::TestSet;
use rand::SeedableRng;
use rand::rngs::ChaCha8Rng;
use rand::seq::SliceRandom;
use serde::Serialize;
use std::ops::Range;

/// Share of the shortest length that a recording needs: 3000 samples at 1 kHz span 2.999 s.
const LEAST_SHARE: f64 = 0.999;

/// The test data, which no decision sees.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(tag = "kind", rename_all = "snake_case")]
pub enum TestData {
    /// Recordings that were given as test set.
    Given {
        /// Their names.
        recordings: Vec<String>,
    },
    /// Recordings of the data that were held out.
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

impl TestData {
    /// Whether it is the end of the only recording.
    #[must_use]
    pub fn is_last_part(&self) -> bool {
        matches!(self, Self::LastPart { .. })
    }

    /// In words.
    #[must_use]
    pub fn sentence(&self) -> String {
        match self {
            Self::Given { recordings } => format!("The given test set: {}.", recordings.join(", ")),
            Self::Kept { recordings } => {
                format!("The test set, held out of the data: {}.", recordings.join(", "))
            }
            Self::LastPart { from_s } => {
                format!("The test set is the part of the recording after t = {from_s:.1} s.")
            }
        }
    }
}

/// The validation data, by which names are chosen. Afterwards the names are refitted to training and validation data.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(tag = "kind", rename_all = "snake_case")]
pub enum ValidationData {
    /// Recordings of the data.
    Recordings {
        /// Their names.
        recordings: Vec<String>,
    },
    /// With one or two recordings a part of each, the last one of the first and the first one of the second, so that
    /// both excitations train and validate.
    Parts {
        /// Name, and the span in s after the first sample.
        parts: Vec<(String, [f64; 2])>,
    },
}

impl ValidationData {
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
        format!("Causes were chosen on {by}, and then refitted to training and validation data.")
    }
}

/// Where the test set comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum TestSource {
    /// From the experiment of this index on.
    GivenFrom(usize),
    /// A part of the data is held out.
    Kept,
    /// There is none.
    Absent,
}

/// An experiment before it has a role.
#[derive(Debug, Clone, PartialEq)]
pub struct Span {
    /// Its name.
    pub name: String,
    /// Time from its first to its last sample, s.
    pub duration_s: f64,
    /// Lowest and highest value of each variable: as many for each experiment, or none.
    pub ranges: Vec<[f64; 2]>,
}

/// An experiment up to the end of its open part: the rows that may train, validate, and set a noise level or a scale.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OpenPart {
    /// Index of the experiment.
    pub experiment: usize,
    /// Time after the first sample at which the test rows begin, s; infinite without test rows.
    pub end_s: f64,
}

impl OpenPart {
    /// The first `count` experiments, each as a whole.
    #[must_use]
    pub fn whole(count: usize) -> Vec<Self> {
        (0..count).map(|experiment| Self { experiment, end_s: f64::INFINITY }).collect()
    }
}

/// The role of each experiment.
#[derive(Debug)]
pub struct Roles {
    train: Vec<usize>,
    validation: Vec<usize>,
    test: Vec<usize>,
    /// The validation data.
    pub validation_data: ValidationData,
    /// The test data; absent without a test set.
    pub test_data: Option<TestData>,
}

impl Roles {
    /// Assigns roles to experiments. Test and validation experiments are those without which the ranges of the variables narrow
    /// least; among equals [`DataSettings::split_seed`] draws.
    ///
    /// # Errors
    /// [`DiagnoseError::TooLittle`] if there are no experiments, no test experiments where they are given, or one is
    /// shorter than [`DataSettings::shortest_s`].
    pub fn assign(
        all: &[Span],
        source: TestSource,
        settings: &DataSettings,
    ) -> Result<Self, DiagnoseError> {
        let data = match source {
            TestSource::GivenFrom(first) => first,
            _ => all.len(),
        };
        let fail = |message: String| Err(DiagnoseError::TooLittle(message));
        if let Some(short) =
            all[..data].iter().find(|e| e.duration_s < LEAST_SHARE * settings.shortest_s)
        {
            return fail(format!(
                "recording `{}` is {} s long; a diagnosis needs at least {} s of each",
                short.name, short.duration_s, settings.shortest_s
            ));
        }
        if data == 0 {
            return fail("there are no recordings".into());
        }
        let names = |which: &[usize]| which.iter().map(|&i| all[i].name.clone()).collect();
        let share = settings.kept_share;
        let mut random = ChaCha8Rng::seed_from_u64(settings.split_seed as u64);
        let mut open: Vec<usize> = (0..data).collect();
        let (test, test_data) = match source {
            TestSource::GivenFrom(first) if first == all.len() => {
                return fail("the test set is empty".into());
            }
            TestSource::GivenFrom(first) => {
                let test: Vec<usize> = (first..all.len()).collect();
                let recordings = names(&test);
                (test, Some(TestData::Given { recordings }))
            }
            TestSource::Kept if open.len() >= 2 => {
                let test = keep(all, &mut open, share, &mut random);
                let recordings = names(&test);
                (test, Some(TestData::Kept { recordings }))
            }
            TestSource::Kept => {
                let from_s = (1.0 - share) * all[0].duration_s;
                (vec![0], Some(TestData::LastPart { from_s }))
            }
            TestSource::Absent => (Vec::new(), None),
        };
        let (validation, validation_data) = if open.len() >= 3 {
            let validation = keep(all, &mut open, share, &mut random);
            let recordings = names(&validation);
            (validation, ValidationData::Recordings { recordings })
        } else {
            let spans: Vec<Span> = open
                .iter()
                .map(|&i| match test_data {
                    Some(TestData::LastPart { from_s }) => {
                        Span { duration_s: from_s, ..all[i].clone() }
                    }
                    _ => all[i].clone(),
                })
                .collect();
            let parts = ends(&spans, share);
            (open.clone(), ValidationData::Parts { parts })
        };
        Ok(Self { train: open, validation, test, validation_data, test_data })
    }

    /// The experiments that train or validate.
    #[must_use]
    pub fn open(&self) -> Vec<OpenPart> {
        let mut open: Vec<usize> = self.train.iter().chain(&self.validation).copied().collect();
        open.sort_unstable();
        open.dedup();
        let end_s = self.end_of_open_s();
        open.into_iter().map(|experiment| OpenPart { experiment, end_s }).collect()
    }

    /// The roles of parts of the open experiments, without a test set; `whole` gives the experiment of each part, `spans` its
    /// name and length.
    #[must_use]
    pub fn of_parts(&self, whole: &[usize], spans: &[Span], settings: &DataSettings) -> Self {
        let parts_of = |experiments: &[usize]| -> Vec<usize> {
            (0..whole.len()).filter(|&k| experiments.contains(&whole[k])).collect()
        };
        let validation_data = match &self.validation_data {
            ValidationData::Parts { .. } => {
                ValidationData::Parts { parts: ends(spans, settings.kept_share) }
            }
            recordings => recordings.clone(),
        };
        Self {
            train: parts_of(&self.train),
            validation: parts_of(&self.validation),
            test: Vec::new(),
            validation_data,
            test_data: None,
        }
    }

    /// Training and validation rows.
    #[must_use]
    pub fn split<'a, C: Candidates + ?Sized>(
        &self,
        system: &'a C,
        noise: &Noise,
        settings: &'a DiagnosisSettings,
    ) -> Split<'a, C> {
        let problem =
            |which: &[usize]| Problem::new(system, which.to_vec(), noise.clone(), settings);
        let (train, validation) = (problem(&self.train), problem(&self.validation));
        let ValidationData::Parts { parts } = &self.validation_data else {
            return Split { train, validation, same_experiments: false };
        };
        let validated = |place: usize, e: usize| -> Range<usize> {
            let [from, to] = parts[place].1.map(|s| system.point_at(e, s));
            let open = self.open_window(&train, place);
            from.max(open.start)..to.min(open.end)
        };
        // The validation part is at one end; the rest is fitted.
        let fitted = |place: usize, e: usize| {
            let (validated, open) = (validated(place, e), self.open_window(&train, place));
            let at_start = validated.start <= open.start;
            if at_start { validated.end..open.end } else { open.start..validated.start }
        };
        Split {
            train: train.with_windows(fitted),
            validation: validation.with_windows(validated),
            same_experiments: true,
        }
    }

    /// Training and validation rows together, for names that are chosen already.
    #[must_use]
    pub fn whole<'a, C: Candidates + ?Sized>(
        &self,
        system: &'a C,
        noise: &Noise,
        settings: &'a DiagnosisSettings,
    ) -> Problem<'a, C> {
        let open = self.open().iter().map(|part| part.experiment).collect();
        let all = Problem::new(system, open, noise.clone(), settings);
        all.with_windows(|place, _| self.open_window(&all, place))
    }

    /// The test set.
    #[must_use]
    pub fn test<'a, C: Candidates + ?Sized>(
        &self,
        system: &'a C,
        noise: &Noise,
        settings: &'a DiagnosisSettings,
    ) -> TestSet<'a, C> {
        let problem = Problem::new(system, self.test.clone(), noise.clone(), settings);
        let same_experiments = self.is_one_recording();
        let problem = match self.test_data {
            Some(TestData::LastPart { from_s }) => problem
                .with_windows(|place, e| system.point_at(e, from_s)..problem.windows[place].end),
            _ => problem,
        };
        TestSet::new(problem, same_experiments)
    }

    /// Whether the end of a single recording is the test set.
    pub(crate) fn is_one_recording(&self) -> bool {
        self.test_data.as_ref().is_some_and(TestData::is_last_part)
    }

    fn end_of_open_s(&self) -> f64 {
        match self.test_data {
            Some(TestData::LastPart { from_s }) => from_s,
            _ => f64::INFINITY,
        }
    }

    /// The window of an experiment of a problem up to the test rows.
    fn open_window<C: Candidates + ?Sized>(
        &self,
        problem: &Problem<'_, C>,
        place: usize,
    ) -> Range<usize> {
        let window = &problem.windows[place];
        let end = problem.system.point_at(problem.experiments[place], self.end_of_open_s());
        window.start..end.min(window.end)
    }
}

/// A share of each experiment by turns at its end and at its beginning.
fn ends(all: &[Span], share: f64) -> Vec<(String, [f64; 2])> {
    let part = |(place, span): (usize, &Span)| {
        let end_s = span.duration_s;
        let at_end = place % 2 == 0;
        let span_s = if at_end { [(1.0 - share) * end_s, end_s] } else { [0.0, share * end_s] };
        (span.name.clone(), span_s)
    };
    all.iter().enumerate().map(part).collect()
}

/// Takes a share of the experiments out, at least one, both lists in their order: one after the other, of those without which the
/// ranges of the variables narrow least, so that predictions for the held-out experiments are interpolations.
fn keep(all: &[Span], open: &mut Vec<usize>, share: f64, random: &mut ChaCha8Rng) -> Vec<usize> {
    let count = ((share * open.len() as f64).round() as usize).clamp(1, open.len() - 1);
    open.shuffle(random);
    let mut kept = Vec::with_capacity(count);
    for _ in 0..count {
        let losses: Vec<f64> = (0..open.len()).map(|k| range_lost(all, open, k)).collect();
        let least = (0..open.len()).min_by(|&a, &b| losses[a].total_cmp(&losses[b]));
        kept.push(open.remove(least.unwrap_or(0)));
    }
    kept.sort_unstable();
    open.sort_unstable();
    kept
}

/// Lowest and highest of some values.
pub(crate) fn range(values: impl Iterator<Item = f64>) -> [f64; 2] {
    values.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], v| [low.min(v), high.max(v)])
}

/// Narrowing of a range, as a share of it, below which an experiment counts as inside the range of the others.
const SAME_RANGE: f64 = 0.05;

/// By how much the ranges of the variables narrow without one of the experiments, as shares of them, summed up.
fn range_lost(all: &[Span], open: &[usize], without: usize) -> f64 {
    let width = |variable: usize, counts: &dyn Fn(usize) -> bool| {
        let own = (0..open.len()).filter(|k| counts(*k)).map(|k| all[open[k]].ranges[variable]);
        let [low, high] = range(own.flatten());
        (high - low).max(0.0)
    };
    let lost = |variable: usize| {
        let whole = width(variable, &|_| true);
        let share = 1.0 - width(variable, &|k| k != without) / whole;
        if share > SAME_RANGE { share } else { 0.0 }
    };
    (0..all[open[without]].ranges.len()).map(lost).sum()
}
