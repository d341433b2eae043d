//! When a member of a hypothesis acts.

use pam_vocabulary::{ActivityWindow, ParameterInfo};

/// What a member does in one experiment.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Acts {
    /// It is there all the time.
    Always,
    /// It is not there.
    Never,
    /// It comes or goes at times of the schedule, the first of which is this one.
    Within(ActivityWindow, usize),
}

/// What experiments have in common of the times of a member.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Pattern {
    /// Every experiment has the same times, counted from its first sample.
    Shared,
    /// It comes or goes once: experiments follow each other in their order, and those before and after the time are without
    /// it, or have it all the time.
    Once,
    /// Each experiment has times of its own.
    Each,
}

impl Pattern {
    /// Its name in files.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Shared => "shared",
            Self::Once => "once",
            Self::Each => "each",
        }
    }
}

/// When a member acts, experiment by experiment of a system.
#[derive(Debug, Clone, PartialEq)]
pub struct Schedule {
    /// What experiments have in common.
    pub pattern: Pattern,
    /// What it does in each experiment of the system.
    pub acts: Vec<Acts>,
    /// The times, s after the first sample of an experiment. Their values stand behind those of the candidate.
    pub times: Vec<ParameterInfo>,
    /// Whether the times are fitted.
    pub fitted: bool,
    /// Number of schedules from which this one was chosen.
    pub choices: f64,
}

impl Schedule {
    /// The same with times that keep their values.
    #[must_use]
    pub fn held(&self) -> Self {
        Self { fitted: false, ..self.clone() }
    }

    /// The same for parts of the experiments; `whole` gives the experiment of each part.
    #[must_use]
    pub fn of_parts(&self, whole: &[usize]) -> Self {
        Self { acts: whole.iter().map(|&e| self.acts[e]).collect(), ..self.clone() }
    }

    /// The times of an experiment among all times; empty where it has none.
    #[must_use]
    pub fn times_in(&self, experiment: usize) -> std::ops::Range<usize> {
        match self.acts[experiment] {
            Acts::Within(course, first) => first..first + course.time_len(),
            Acts::Always | Acts::Never => 0..0,
        }
    }

    /// The stretch of an experiment in which half of the member or more is there, s after its first sample; `None` where
    /// there is none. `values` are those of the times.
    #[must_use]
    pub fn stretch_s(&self, experiment: usize, values: &[f64]) -> Option<[f64; 2]> {
        match self.acts[experiment] {
            Acts::Always => Some([f64::NEG_INFINITY, f64::INFINITY]),
            Acts::Never => None,
            Acts::Within(course, first) => {
                let from = if course.onset { values[first] } else { f64::NEG_INFINITY };
                let last = first + course.time_len() - 1;
                let to = if course.end { values[last] } else { f64::INFINITY };
                (from < to).then_some([from, to])
            }
        }
    }
}
