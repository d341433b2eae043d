//! How good is a recording, and what can be learned from it?
//!
//! [`assess`] measures what a recording is worth before any model is fitted: sampling, clipped and dead channels,
//! resolution, drift, noise, delays between channels, and what the motion excites. Each finding is one plain sentence
//! with its severity. What contradicts the physics of the joint (units, signs, order of the columns) is found by
//! [`plausibility`](crate::plausibility), which needs a model; this needs none.
//!
//! ```no_run
//! use pam_data::{LoadOptions, quality, read_recordings};
//! for recording in read_recordings(["logs"], &LoadOptions::default())? {
//!     let quality = quality::assess(&recording, &quality::QualitySettings::default());
//!     println!("{}: {:.1} Hz", recording.name, quality.timing.rate_hz);
//!     for finding in &quality.findings {
//!         println!("{}", finding.message);
//!     }
//! }
//! # Ok::<(), pam_data::DataError>(())
//! ```

mod channel;
mod dead;
mod delay;
mod drift;
mod excitation;
mod noise;
mod quantisation;
mod saturation;
mod settings;
mod timing;

pub use channel::{ChannelQuality, MeasuredChannel};
pub use delay::Delay;
pub use excitation::Excitation;
pub use saturation::Saturation;
pub use settings::QualitySettings;
pub use timing::Timing;

use crate::plausibility::Severity;
use crate::recording::Recording;
use serde::Serialize;

/// Subject of a check of quality.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum QualityKind {
    /// Steps of time.
    Timing,
    /// A channel stays at the end of its range.
    Saturation,
    /// A channel has few levels.
    Quantisation,
    /// A channel wanders.
    Drift,
    /// A channel is noisy.
    Noise,
    /// A channel never changes.
    Dead,
    /// A channel comes later than another.
    Delay,
    /// The motion does not tell something.
    Excitation,
}

/// One sentence on a recording.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct QualityFinding {
    /// Its subject.
    pub kind: QualityKind,
    /// [`Error`](Severity::Error) if the data should not be fitted as they are.
    pub severity: Severity,
    /// The column concerned, by its name in CSV files.
    pub channel: String,
    /// The problem, its size and the remedy.
    pub message: String,
}

impl QualityFinding {
    fn new(kind: QualityKind, severity: Severity, channel: &str, message: String) -> Self {
        Self { kind, severity, channel: channel.to_owned(), message }
    }
}

/// Quality of a recording.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Quality {
    /// Name of the recording.
    pub recording: String,
    /// Sampling.
    pub timing: Timing,
    /// Each channel: x, ẋ, P_f, P_e, F.
    pub channels: Vec<ChannelQuality>,
    /// By how much channels come later than the displacement.
    pub delays: Vec<Delay>,
    /// Excitation by the motion.
    pub excitation: Excitation,
    /// Findings to read before a fit, errors first.
    pub findings: Vec<QualityFinding>,
}

/// Assesses a recording. Cost: some ten milliseconds per 70 s at 1 kHz.
#[must_use]
pub fn assess(recording: &Recording, settings: &QualitySettings) -> Quality {
    let timing = Timing::of(recording);
    let channels: Vec<ChannelQuality> =
        MeasuredChannel::ALL.iter().map(|c| ChannelQuality::of(recording, *c)).collect();
    let delays = delay::delays(recording, settings);
    let excitation = Excitation::of(recording);
    let mut findings = timing.findings(settings);
    for channel in &channels {
        findings.extend(dead::finding(channel, recording));
        findings.extend(saturation::finding(channel, settings));
        findings.extend(quantisation::finding(channel, settings));
        findings.extend(drift::finding(channel, settings));
        findings.extend(noise::finding(channel, settings));
    }
    findings.extend(delays.iter().filter_map(|d| d.finding(settings)));
    findings.extend(excitation.findings(settings));
    findings.sort_by_key(|f| std::cmp::Reverse(f.severity));
    Quality { recording: recording.name.clone(), timing, channels, delays, excitation, findings }
}
