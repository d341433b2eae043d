//! Recordings that are scored and never trained on.

use pam_data::fingerprint::fingerprint;
use pam_data::{Channel, Recording, Subject};
use std::sync::Arc;

/// Held-out recordings, with their channels and forces in single precision: a data set has many times more of them than are trained on,
/// and all are kept until the training ends. Rounding changes a mean R² by about 1e-7. Times and the reading at rest, which
/// give the masses, stay exact.
#[derive(Debug)]
pub(super) struct HeldOut {
    recordings: Vec<Rounded>,
    fingerprint: String,
}

/// A recording in single precision.
#[derive(Debug)]
struct Rounded {
    /// Everything but the samples.
    without_samples: Subject,
    /// Recordings that were sampled at the same times share them.
    time_s: Arc<Vec<f64>>,
    channels: [Vec<f32>; 4],
    force_mn: Vec<f32>,
    /// The force before its filter.
    unfiltered_force_mn: Option<Vec<f32>>,
}

impl HeldOut {
    /// Keeps recordings in single precision.
    pub(super) fn of(subjects: Vec<Subject>) -> Self {
        let fingerprint = fingerprint(subjects.iter().map(|s| &s.recording));
        let mut recordings: Vec<Rounded> = Vec::with_capacity(subjects.len());
        for subject in subjects {
            let last = recordings.last().map(|r| &r.time_s);
            let rounded = Rounded::of(subject, last);
            recordings.push(rounded);
        }
        Self { recordings, fingerprint }
    }

    /// Number of recordings.
    pub(super) fn len(&self) -> usize {
        self.recordings.len()
    }

    /// The [fingerprint](pam_data::fingerprint) of the recordings as they were measured.
    pub(super) fn fingerprint(&self) -> &str {
        &self.fingerprint
    }

    /// The recordings in double precision, with the masses that they had at first.
    pub(super) fn subjects(&self) -> impl Iterator<Item = Subject> + '_ {
        self.recordings.iter().map(Rounded::subject)
    }
}

impl Rounded {
    fn of(subject: Subject, known: Option<&Arc<Vec<f64>>>) -> Self {
        let rounded = |values: &[f64]| values.iter().map(|&v| v as f32).collect();
        let mut without_samples = subject.clone_without_samples();
        let r = subject.recording;
        without_samples.recording.sealed = Some(r.reading_at_rest());
        without_samples.recording.low_passed.cutoff_hz = r.low_passed.cutoff_hz;
        without_samples.recording.low_passed.resolution = r.low_passed.resolution;
        Self {
            without_samples,
            channels: Channel::ALL.map(|c| rounded(r.channel(c))),
            force_mn: rounded(&r.force_mn),
            unfiltered_force_mn: r.low_passed.force_mn.as_deref().map(rounded),
            time_s: known.filter(|t| ***t == r.time_s).cloned().unwrap_or_else(|| r.time_s.into()),
        }
    }

    fn subject(&self) -> Subject {
        let doubles = |values: &[f32]| values.iter().map(|&v| f64::from(v)).collect();
        let mut subject = self.without_samples.clone();
        let r: &mut Recording = &mut subject.recording;
        r.time_s.clone_from(&self.time_s);
        [r.displacement_mm, r.velocity_mm_s, r.pressure_flexor_kpa, r.pressure_extensor_kpa] =
            [0, 1, 2, 3].map(|c| doubles(&self.channels[c]));
        r.force_mn = doubles(&self.force_mn);
        r.low_passed.force_mn = self.unfiltered_force_mn.as_deref().map(doubles);
        subject
    }
}
