//! Channels at the end of their range.

use super::channel::{ChannelQuality, MeasuredChannel};
use super::settings::QualitySettings;
use super::{QualityFinding, QualityKind};
use crate::plausibility::Severity;
use crate::recording::Recording;
use serde::Serialize;

/// Fewest equal samples at an end of the range that count as clipped.
const SHORTEST_RUN: usize = 5;
/// Least motion of the other channel during a run, as a share of its range: sealed air answers to every motion.
const TELLING_MOTION: f64 = 0.02;

/// Shares of the samples that stand at the ends of the range although they should move.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
pub struct Saturation {
    /// At the smallest value.
    pub at_lowest_share: f64,
    /// At the largest value.
    pub at_highest_share: f64,
}

impl Saturation {
    /// Pressures must follow the displacement, the displacement the pressures; a force may be held.
    pub(super) fn of(r: &Recording, channel: MeasuredChannel, values: &[f64]) -> Self {
        let witness = match channel {
            MeasuredChannel::PressureFlexor | MeasuredChannel::PressureExtensor => {
                &r.displacement_mm
            }
            MeasuredChannel::Displacement => &r.pressure_flexor_kpa,
            MeasuredChannel::Velocity | MeasuredChannel::Force => return Self::default(),
        };
        let (low, high) = ends(values);
        if low == high {
            return Self::default();
        }
        Self {
            at_lowest_share: clipped(values, witness, low),
            at_highest_share: clipped(values, witness, high),
        }
    }
}

fn ends(values: &[f64]) -> (f64, f64) {
    values
        .iter()
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| (low.min(*v), high.max(*v)))
}

/// Share of the samples in runs at `end` during which the witness moves.
fn clipped(values: &[f64], witness: &[f64], end: f64) -> f64 {
    let (low, high) = ends(witness);
    let mut count = 0;
    let mut start = 0;
    while start < values.len() {
        let run = values[start..].iter().take_while(|v| **v == end).count();
        if run >= SHORTEST_RUN {
            let (from, to) = ends(&witness[start..start + run]);
            if to - from > TELLING_MOTION * (high - low) {
                count += run;
            }
        }
        start += run.max(1);
    }
    count as f64 / values.len() as f64
}

pub(super) fn finding(c: &ChannelQuality, s: &QualitySettings) -> Option<QualityFinding> {
    let Saturation { at_lowest_share: low, at_highest_share: high } = c.saturation;
    if low.max(high) < s.clipped_share {
        return None;
    }
    let end = |share: f64, value: f64| {
        format!("{:.1} % of the time at {value:.3} {}", 100.0 * share, c.unit)
    };
    let places: Vec<String> = [(low, c.lowest), (high, c.highest)]
        .into_iter()
        .filter(|(share, _)| *share >= s.clipped_share)
        .map(|(share, value)| end(share, value))
        .collect();
    let message = format!(
        "{} is clipped: it stands {} while the joint moves; widen the range of the sensor or its amplifier, or leave these \
         times out",
        c.column,
        places.join(" and ")
    );
    Some(QualityFinding::new(QualityKind::Saturation, Severity::Error, c.column, message))
}
