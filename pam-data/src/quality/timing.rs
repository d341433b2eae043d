//! Sampling.

use super::settings::QualitySettings;
use super::{QualityFinding, QualityKind};
use crate::plausibility::Severity;
use crate::recording::{Recording, median_step_s};
use pam_numerics::statistics::root_mean_square;
use serde::Serialize;

/// The sampling of a recording.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Timing {
    /// Samples per second: one over the median step.
    pub rate_hz: f64,
    /// From first to last sample, s.
    pub duration_s: f64,
    /// RMS deviation of the steps from their median, over it.
    pub jitter_share: f64,
    /// Shortest step, s.
    pub shortest_step_s: f64,
    /// Longest step, s.
    pub longest_step_s: f64,
    /// Gaps at which the file was split: whether this recording is a part of a run.
    pub is_part: bool,
}

impl Timing {
    pub(super) fn of(r: &Recording) -> Self {
        let step = median_step_s(&r.time_s);
        let steps: Vec<f64> = r.time_s.windows(2).map(|w| w[1] - w[0]).collect();
        let off: Vec<f64> = steps.iter().map(|s| s / step - 1.0).collect();
        let (from, to) = r.span_s();
        Self {
            rate_hz: 1.0 / step,
            duration_s: to - from,
            jitter_share: root_mean_square(&off),
            shortest_step_s: steps.iter().copied().fold(f64::INFINITY, f64::min),
            longest_step_s: steps.iter().copied().fold(0.0, f64::max),
            is_part: r.name.contains('#'),
        }
    }

    pub(super) fn findings(&self, s: &QualitySettings) -> Vec<QualityFinding> {
        let make = |message| {
            QualityFinding::new(QualityKind::Timing, Severity::Warning, "time_s", message)
        };
        let mut out = Vec::new();
        if self.jitter_share > s.jitter_share {
            out.push(make(format!(
                "the time steps vary by {:.1} % (RMS; {:.4} to {:.4} s around {:.4} s): resample the data to equal steps, \
                 since filters take them as equal",
                100.0 * self.jitter_share,
                self.shortest_step_s,
                self.longest_step_s,
                1.0 / self.rate_hz
            )));
        }
        if self.rate_hz < s.lowest_rate_hz {
            out.push(make(format!(
                "{:.2} samples per second are few: motion above {:.2} Hz is not resolved, and the velocity is a coarse \
                 derivative",
                self.rate_hz,
                0.1 * self.rate_hz
            )));
        }
        if self.is_part {
            out.push(make(
                "the run has gaps in time and is split there: predictions start anew after each gap".into(),
            ));
        }
        out
    }
}
