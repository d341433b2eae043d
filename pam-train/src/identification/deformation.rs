//! The deformation coefficient.
//!
//! Sealed isothermal air follows `P = P(0) V(x(0))/V(x)`, from which ν follows at every frequency alike.
//! Air that exchanges heat with the wall does not: slow cycles are isothermal, fast ones adiabatic, and an
//! isothermal model can only say so by a larger ν. A filter of the pressure sensor works the other way.
//! So ν is fitted at each frequency of the excitation by itself, and where these differ there is no ν to
//! have an error of. Air that is polytropic at all frequencies alike cannot be told from a larger ν.

use super::by_groups;
use crate::segments::frequency_segments;
use crate::warm_start::gas::{Stretch, deformation_of};
use pam_core::MuscleGeometry;
use pam_data::Subject;
use serde::Serialize;

/// ν at one frequency of the excitation.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct FrequencyEstimate {
    /// The frequency, Hz.
    pub frequency_hz: f64,
    /// ν.
    pub deformation: f64,
    /// Standard error over recordings; none for fewer than two.
    pub standard_error: Option<f64>,
}

/// An estimate of ν.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct DeformationEstimate {
    /// ν over everything.
    pub deformation: f64,
    /// Standard error over recordings; none for fewer than two.
    pub standard_error: Option<f64>,
    /// ν at each frequency, in rising order; empty if the excitation is not periodic.
    pub by_frequency: Vec<FrequencyEstimate>,
}

/// Difference between frequencies, relative to ν and to its standard error, beyond which ν is not
/// identified. Both must be exceeded: many recordings make any difference significant.
const DIFFERENCE: f64 = 0.03;
const SIGNIFICANCE: f64 = 3.0;
/// Frequencies that differ by less than this factor are one.
const SAME_FREQUENCY: f64 = 1.25;

impl DeformationEstimate {
    /// ν, if the recordings determine it: it is the same at all frequencies of the excitation.
    #[must_use]
    pub fn determined(&self) -> Option<f64> {
        self.doubt().is_none().then_some(self.deformation)
    }

    /// Why ν is not identified, if it is not.
    #[must_use]
    pub fn doubt(&self) -> Option<String> {
        if self.standard_error.is_none() {
            return Some("no standard error: it takes two recordings".into());
        }
        let by = &self.by_frequency;
        let low = by.iter().min_by(|a, b| a.deformation.total_cmp(&b.deformation))?;
        let high = by.iter().max_by(|a, b| a.deformation.total_cmp(&b.deformation))?;
        let difference = high.deformation - low.deformation;
        let error = low.standard_error?.hypot(high.standard_error?);
        if difference <= DIFFERENCE * self.deformation || difference <= SIGNIFICANCE * error {
            return None;
        }
        let each: Vec<String> = by
            .iter()
            .map(|f| {
                format!(
                    "{:.3} ± {:.3} at {:.3} Hz",
                    f.deformation,
                    f.standard_error.unwrap_or(f64::NAN),
                    f.frequency_hz
                )
            })
            .collect();
        Some(format!(
            "not identified: {}; sealed isothermal air has one ν at all frequencies, so the air \
             exchanges heat or the sensors filter the pressures",
            each.join(", ")
        ))
    }
}

/// Estimates ν from recordings.
#[must_use]
pub fn identify_deformation(
    subjects: &[Subject],
    geometry: &MuscleGeometry,
    start: f64,
) -> DeformationEstimate {
    let whole: Vec<Stretch<'_>> =
        subjects.iter().map(|s| Stretch { subject: s, range: 0..s.recording.len() }).collect();
    let (deformation, standard_error) = estimate(&whole, geometry, start);
    let mut segments: Vec<(f64, Stretch<'_>)> = Vec::new();
    for subject in subjects {
        let r = &subject.recording;
        for segment in frequency_segments(&r.time_s, &r.force_mn) {
            if let Some(frequency) = segment.frequency_hz {
                segments.push((frequency, Stretch { subject, range: segment.range }));
            }
        }
    }
    segments.sort_by(|a, b| a.0.total_cmp(&b.0));
    let by_frequency = segments
        .chunk_by(|a, b| b.0 < SAME_FREQUENCY * a.0)
        .map(|group| {
            let stretches: Vec<Stretch<'_>> = group.iter().map(|g| g.1.clone()).collect();
            let (deformation, standard_error) = estimate(&stretches, geometry, deformation);
            let mean = group.iter().map(|g| g.0).sum::<f64>() / group.len() as f64;
            FrequencyEstimate { frequency_hz: mean, deformation, standard_error }
        })
        .collect();
    DeformationEstimate { deformation, standard_error, by_frequency }
}

/// ν and its standard error by stretches of recordings.
fn estimate(
    stretches: &[Stretch<'_>],
    geometry: &MuscleGeometry,
    start: f64,
) -> (f64, Option<f64>) {
    let (nu, sums) = deformation_of(stretches, geometry, start);
    let mut groups: Vec<(*const Subject, (f64, f64))> = Vec::new();
    for (stretch, s) in stretches.iter().zip(&sums) {
        let of = std::ptr::from_ref(stretch.subject);
        match groups.iter_mut().find(|g| g.0 == of) {
            Some((_, g)) => *g = (g.0 + s.slope_error, g.1 + s.slope_square),
            None => groups.push((of, (s.slope_error, s.slope_square))),
        }
    }
    let groups: Vec<(f64, f64)> = groups.into_iter().map(|g| g.1).collect();
    (nu, by_groups(&groups).1)
}
