//! The scaled samples of recordings as networks read them, and rollouts drawn from them.

use super::parameters::INPUTS;
use super::scaling::Scaling;
use pam_core::parallel;
use pam_data::Subject;
use rand::{Rng, RngExt};

/// The scaled samples of all recordings, one sequence for each recording and each sample of a step that a
/// sequence may begin with.
#[derive(Debug, Clone)]
pub struct Samples {
    samples_per_step: usize,
    /// Each begins with its first sample `warm_up` times: the joint at rest.
    sequences: Vec<Vec<[f32; INPUTS]>>,
}

impl Samples {
    /// Scales recordings; sequences read one sample of `samples_per_step`.
    #[must_use]
    pub fn of(
        subjects: &[Subject],
        scaling: &Scaling,
        samples_per_step: usize,
        warm_up: usize,
    ) -> Self {
        let sequence = |s: &Subject, phase: usize| -> Vec<[f32; INPUTS]> {
            let r = &s.recording;
            let own = (phase..r.len())
                .step_by(samples_per_step)
                .map(|k| scaling.input_over(r, k, samples_per_step).map(|v| v as f32));
            let first = own.clone().next().into_iter();
            let rest = first.flat_map(|f| std::iter::repeat_n(f, warm_up.saturating_sub(1)));
            rest.chain(own).collect()
        };
        let sequences = parallel::map(subjects.len() * samples_per_step, |k| {
            sequence(&subjects[k / samples_per_step], k % samples_per_step)
        });
        Self { samples_per_step, sequences }
    }

    /// The sequences that begin with the first samples of the recordings.
    pub fn whole(&self) -> impl Iterator<Item = &[[f32; INPUTS]]> {
        self.sequences.iter().step_by(self.samples_per_step).map(|s| &s[..])
    }

    /// Steps of the longest sequence, those of rest included.
    #[must_use]
    pub fn longest(&self) -> usize {
        self.sequences.iter().map(Vec::len).max().unwrap_or(0)
    }

    /// Draws `len` samples in a row: all starts of all recordings alike, or with a chance of `rest` the start
    /// of a recording at rest.
    ///
    /// # Panics
    /// If no sequence is that long.
    pub fn draw(&self, len: usize, rest: f64, random: &mut impl Rng) -> &[[f32; INPUTS]] {
        let starts = |s: &Vec<[f32; INPUTS]>| (s.len() + 1).saturating_sub(len);
        let total: usize = self.sequences.iter().map(starts).sum();
        let mut k = random.random_range(0..total);
        let at_rest = random.random_bool(rest);
        for s in &self.sequences {
            if k < starts(s) {
                let k = if at_rest { 0 } else { k };
                return &s[k..k + len];
            }
            k -= starts(s);
        }
        unreachable!("the draw is below the total")
    }
}
