//! The numbers of one channel.

use super::saturation::Saturation;
use super::{drift, noise, quantisation};
use crate::recording::Recording;
use pam_core::units::MN_PER_N;
use pam_numerics::statistics::{mean, standard_deviation};
use serde::Serialize;
use std::borrow::Cow;

/// A channel of a recording, the force among them.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum MeasuredChannel {
    /// Displacement x, mm.
    Displacement,
    /// Velocity ẋ, mm/s.
    Velocity,
    /// Flexor pressure, kPa absolute.
    PressureFlexor,
    /// Extensor pressure, kPa absolute.
    PressureExtensor,
    /// External force, N.
    Force,
}

impl MeasuredChannel {
    /// All of them.
    pub const ALL: [Self; 5] = [
        Self::Displacement,
        Self::Velocity,
        Self::PressureFlexor,
        Self::PressureExtensor,
        Self::Force,
    ];

    /// Its column in CSV files.
    #[must_use]
    pub fn column(self) -> &'static str {
        crate::formats::columns::NAMES[1 + self as usize]
    }

    /// Its unit.
    #[must_use]
    pub fn unit(self) -> &'static str {
        match self {
            Self::Displacement => "mm",
            Self::Velocity => "mm/s",
            Self::PressureFlexor | Self::PressureExtensor => "kPa",
            Self::Force => "N",
        }
    }

    /// Its values in its unit.
    #[must_use]
    pub fn values(self, r: &Recording) -> Cow<'_, [f64]> {
        match self {
            Self::Displacement => Cow::Borrowed(&r.displacement_mm),
            Self::Velocity => Cow::Borrowed(&r.velocity_mm_s),
            Self::PressureFlexor => Cow::Borrowed(&r.pressure_flexor_kpa),
            Self::PressureExtensor => Cow::Borrowed(&r.pressure_extensor_kpa),
            Self::Force => Cow::Owned(r.force_mn.iter().map(|f| f / MN_PER_N).collect()),
        }
    }
}

/// Quality of one channel. All numbers are in its [unit](MeasuredChannel::unit).
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ChannelQuality {
    /// Its column in CSV files.
    pub column: &'static str,
    /// The unit of the numbers.
    pub unit: &'static str,
    /// Smallest value.
    pub lowest: f64,
    /// Largest value.
    pub highest: f64,
    /// Mean.
    pub mean: f64,
    /// Standard deviation.
    pub deviation: f64,
    /// Standard deviation of the white part of the noise, from third differences.
    pub noise: f64,
    /// Smallest step between values, if the channel has levels; `null` for a continuous one.
    pub resolution: Option<f64>,
    /// Mean of the last tenth less that of the first.
    pub drift: f64,
    /// Samples at the ends of the range while the joint moves.
    pub saturation: Saturation,
}

impl ChannelQuality {
    pub(super) fn of(r: &Recording, channel: MeasuredChannel) -> Self {
        let values = channel.values(r);
        let low = values.iter().copied().fold(f64::INFINITY, f64::min);
        let high = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        Self {
            column: channel.column(),
            unit: channel.unit(),
            lowest: low,
            highest: high,
            mean: mean(&values),
            deviation: standard_deviation(&values),
            noise: noise::white(&values),
            resolution: quantisation::resolution(&values),
            drift: drift::change(&values),
            saturation: Saturation::of(r, channel, &values),
        }
    }

    /// Largest less smallest value.
    #[must_use]
    pub fn range(&self) -> f64 {
        self.highest - self.lowest
    }

    /// True if the values never change but by rounding.
    #[must_use]
    pub fn is_constant(&self) -> bool {
        self.range() <= 1e-12 * self.mean.abs()
    }
}
