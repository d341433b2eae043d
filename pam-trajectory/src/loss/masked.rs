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
