//! Any loss on some of the samples.

use super::TrajectoryLoss;
use crate::settings::{SettingsError, require};
use pam_data::{Channel, Recording};
use serde::{Deserialize, Serialize};

/// Another loss, restricted to samples that count: every n-th one, within intervals of time. The inner
/// loss sees a recording of these samples alone, so that its means (and variances) are over them; the
/// others add nothing and have no cotangent. If none counts, the loss is zero.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Masked<L: ?Sized> {
    /// The loss of the samples that count.
    pub of: Box<L>,
    /// Samples 0, n, 2n, … of the recording count; one (all of them) by default.
    #[serde(default = "one")]
    pub every: usize,
    /// Closed intervals of the time since the recording's first sample, s, of which at least one must
    /// hold the sample; no interval, the default, means the whole recording. Ends are taken to a
    /// nanosecond, for the differences of decimal times are rounded.
    #[serde(default)]
    pub intervals_s: Vec<[f64; 2]>,
}

fn one() -> usize {
    1
}

/// How far outside an interval a sample may be, s.
const SLACK_S: f64 = 1e-9;

impl<L: ?Sized> Masked<L> {
    /// Indices of the samples that count.
    #[must_use]
    pub fn samples(&self, time_s: &[f64]) -> Vec<usize> {
        let inside = |k: usize| {
            let t = time_s[k] - time_s[0];
            let holds = |[from, to]: &[f64; 2]| *from - SLACK_S <= t && t <= *to + SLACK_S;
            self.intervals_s.is_empty() || self.intervals_s.iter().any(holds)
        };
        (0..time_s.len()).step_by(self.every.max(1)).filter(|&k| inside(k)).collect()
    }
}

/// The recording of some samples.
fn selected(recording: &Recording, samples: &[usize]) -> Recording {
    let of = |column: &[f64]| samples.iter().map(|&k| column[k]).collect();
    Recording {
        time_s: of(&recording.time_s),
        displacement_mm: of(recording.channel(Channel::X)),
        velocity_mm_s: of(recording.channel(Channel::V)),
        pressure_flexor_kpa: of(recording.channel(Channel::Pf)),
        pressure_extensor_kpa: of(recording.channel(Channel::Pe)),
        force_mn: of(&recording.force_mn),
        ..recording.without_samples()
    }
}

impl<L: TrajectoryLoss + ?Sized> TrajectoryLoss for Masked<L> {
    fn check(&self) -> Result<(), SettingsError> {
        require(self.every > 0, || "every 0th sample is none; `every` must be positive".into())?;
        require(self.intervals_s.iter().all(|[from, to]| from <= to), || {
            format!("an interval must end after it begins, got {:?}", self.intervals_s)
        })?;
        self.of.check()
    }

    fn value_and_cotangents(
        &self,
        measured: &Recording,
        predicted: &[[f64; 4]],
        cotangents: &mut [[f64; 4]],
    ) -> f64 {
        let samples = self.samples(&measured.time_s);
        if samples.len() == measured.len() {
            return self.of.value_and_cotangents(measured, predicted, cotangents);
        }
        cotangents.fill([0.0; 4]);
        if samples.is_empty() {
            return 0.0;
        }
        let part: Vec<[f64; 4]> = samples.iter().map(|&k| predicted[k]).collect();
        let mut by_part = vec![[0.0; 4]; part.len()];
        let value =
            self.of.value_and_cotangents(&selected(measured, &samples), &part, &mut by_part);
        for (&k, c) in samples.iter().zip(by_part) {
            cotangents[k] = c;
        }
        value
    }
}

#[cfg(test)]
mod tests {
    use super::super::testing::{assert_cotangents, noisy, random_recording};
    use super::super::{Huber, HuberForm, Normalised, SquaredError};
    use super::*;
    use proptest::prelude::*;

    fn masked<L>(of: L, every: usize, intervals_s: &[[f64; 2]]) -> Masked<L> {
        Masked { of: Box::new(of), every, intervals_s: intervals_s.to_vec() }
    }

    fn evaluate(loss: &dyn TrajectoryLoss, m: &Recording, p: &[[f64; 4]]) -> (f64, Vec<[f64; 4]>) {
        // What was there before must not matter.
        let mut cotangents = vec![[f64::NAN; 4]; p.len()];
        (loss.value_and_cotangents(m, p, &mut cotangents), cotangents)
    }

    #[test]
    fn cotangents_are_the_derivative() {
        let thresholds = [1.0; 4];
        let huber = Huber { form: HuberForm::PseudoHuber, thresholds, weights: [1.0; 4] };
        for seed in 0..5 {
            assert_cotangents(&masked(SquaredError::published(), 3, &[]), seed);
            assert_cotangents(&masked(Normalised::default(), 2, &[[0.02, 0.2]]), seed);
            assert_cotangents(&masked(huber, 1, &[[0.0, 0.05], [0.1, 0.13]]), seed);
        }
    }

    /// Samples lie 0.01 s apart from 7.3 s on.
    #[test]
    fn time_is_that_since_the_first_sample() {
        let time_s: Vec<f64> = (0..30).map(|k| 7.3 + 0.01 * f64::from(k)).collect();
        let samples = |every, intervals: &[[f64; 2]]| masked((), every, intervals).samples(&time_s);
        assert_eq!(samples(10, &[]), [0, 10, 20]);
        assert_eq!(samples(1, &[[0.05, 0.08]]), [5, 6, 7, 8]);
        assert_eq!(samples(2, &[[0.05, 0.08], [0.07, 0.11]]), [6, 8, 10]);
        assert_eq!(samples(1, &[[7.3, 7.5]]), Vec::<usize>::new());
    }

    #[test]
    fn a_loss_of_no_sample_is_zero() {
        let measured = random_recording(10, 1);
        let loss = masked(SquaredError::paper(), 1, &[[50.0, 60.0]]);
        let (value, cotangents) = evaluate(&loss, &measured, &noisy(&measured, 2));
        assert_eq!((value, cotangents), (0.0, vec![[0.0; 4]; 10]));
    }

    proptest! {
        #[test]
        fn samples_outside_do_not_matter(
            n in 2_usize..60,
            every in 1_usize..7,
            from in 0.0_f64..0.5,
            width in 0.0_f64..0.3,
            seed in 0_u64..1000,
        ) {
            let measured = random_recording(n, seed);
            let predicted = noisy(&measured, seed + 1);
            let loss = masked(SquaredError::paper(), every, &[[from, from + width]]);
            let counts = loss.samples(&measured.time_s);
            let (value, cotangents) = evaluate(&loss, &measured, &predicted);
            let mut other = predicted.clone();
            for k in 0..n {
                if counts.contains(&k) {
                    prop_assert!(k % every == 0);
                } else {
                    prop_assert_eq!(cotangents[k], [0.0; 4]);
                    other[k] = [1e9; 4];
                }
            }
            prop_assert_eq!(evaluate(&loss, &measured, &other), (value, cotangents));
        }

        /// The mean over all samples is that of the n interleaved masks, each by its share.
        #[test]
        fn disjoint_masks_add_up(n in 2_usize..60, cut in 0.0_f64..0.6, seed in 0_u64..1000) {
            let measured = random_recording(n, seed);
            let predicted = noisy(&measured, seed + 1);
            let whole = evaluate(&SquaredError::paper(), &measured, &predicted).0;
            // Not at a sample, of which both closed intervals would take hold.
            let cut = (cut / 0.01).floor() * 0.01 + 0.005;
            let sum: f64 = [[0.0, cut], [cut, 1e3]]
                .iter()
                .map(|interval| {
                    let loss = masked(SquaredError::paper(), 1, &[*interval]);
                    let share = loss.samples(&measured.time_s).len() as f64 / n as f64;
                    share * evaluate(&loss, &measured, &predicted).0
                })
                .sum();
            prop_assert!((sum - whole).abs() <= 1e-12 * whole);
        }
    }
}
