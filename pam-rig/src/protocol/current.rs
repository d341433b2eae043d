//! Segments of the motor's current.

use super::table::Table;
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;

/// A segment of the motor's current along +x. Times within a segment start at zero.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "snake_case", deny_unknown_fields)]
pub enum CurrentSegment {
    /// No current.
    Rest {
        /// Length, s.
        duration_s: f64,
    },
    /// `amplitude sin(2π f t)`.
    Sine {
        /// Amplitude, A.
        amplitude_a: f64,
        /// Frequency, Hz.
        frequency_hz: f64,
        /// Length, s.
        duration_s: f64,
    },
    /// A sum of sines, `Σ amplitude sin(2π f t + phase)`.
    Multisine {
        /// Amplitude (A), frequency (Hz) and phase (deg) of each.
        components: Vec<[f64; 3]>,
        /// Length, s.
        duration_s: f64,
    },
    /// A triangle that starts at zero and rises.
    Triangle {
        /// Amplitude, A.
        amplitude_a: f64,
        /// Frequency, Hz.
        frequency_hz: f64,
        /// Length, s.
        duration_s: f64,
    },
    /// A sine whose frequency rises linearly.
    Chirp {
        /// Amplitude, A.
        amplitude_a: f64,
        /// Frequency at the start, Hz.
        from_hz: f64,
        /// Frequency at the end, Hz.
        to_hz: f64,
        /// Length, s.
        duration_s: f64,
    },
    /// Pulses at equal distances, the first after half a period.
    Pulses {
        /// Height, A.
        amplitude_a: f64,
        /// Length of a pulse, ms.
        width_ms: f64,
        /// Time from pulse to pulse, s.
        period_s: f64,
        /// `true` if every other pulse is negative.
        #[serde(default)]
        alternate: bool,
        /// Length, s.
        duration_s: f64,
    },
    /// Pulses of random sign after random pauses; the same for a seed.
    RandomPulses {
        /// Height, A.
        amplitude_a: f64,
        /// Length of a pulse, ms.
        width_ms: f64,
        /// Shortest and longest pause, ms.
        pause_ms: [f64; 2],
        /// Length, s.
        duration_s: f64,
    },
    /// A constant current.
    Constant {
        /// Current, A.
        amplitude_a: f64,
        /// Length, s.
        duration_s: f64,
    },
    /// A file with the columns `time_s, current_a`, held between its rows.
    Table(Table<1>),
}

impl CurrentSegment {
    /// Length, s.
    #[must_use]
    pub fn duration_s(&self) -> f64 {
        match self {
            Self::Rest { duration_s }
            | Self::Sine { duration_s, .. }
            | Self::Multisine { duration_s, .. }
            | Self::Triangle { duration_s, .. }
            | Self::Chirp { duration_s, .. }
            | Self::Pulses { duration_s, .. }
            | Self::RandomPulses { duration_s, .. }
            | Self::Constant { duration_s, .. } => *duration_s,
            Self::Table(table) => table.duration_s(),
        }
    }

    /// The same segment with another length; a file keeps its own.
    #[must_use]
    pub fn with_duration(mut self, length_s: f64) -> Self {
        match &mut self {
            Self::Rest { duration_s }
            | Self::Sine { duration_s, .. }
            | Self::Multisine { duration_s, .. }
            | Self::Triangle { duration_s, .. }
            | Self::Chirp { duration_s, .. }
            | Self::Pulses { duration_s, .. }
            | Self::RandomPulses { duration_s, .. }
            | Self::Constant { duration_s, .. } => *duration_s = length_s,
            Self::Table(_) => {}
        }
        self
    }

    /// Current at a time within the segment, A.
    #[must_use]
    pub fn current_a(&self, t: f64, seed: u64) -> f64 {
        match self {
            Self::Rest { .. } => 0.0,
            Self::Constant { amplitude_a, .. } => *amplitude_a,
            Self::Sine { amplitude_a, frequency_hz, .. } => {
                amplitude_a * (TAU * frequency_hz * t).sin()
            }
            Self::Multisine { components, .. } => {
                let sine = |[a, hz, deg]: &[f64; 3]| a * (TAU * hz * t + deg.to_radians()).sin();
                components.iter().map(sine).sum()
            }
            Self::Triangle { amplitude_a, frequency_hz, .. } => {
                let phase = (frequency_hz * t + 0.25).rem_euclid(1.0);
                amplitude_a * (1.0 - 4.0 * (phase - 0.5).abs())
            }
            Self::Chirp { amplitude_a, from_hz, to_hz, duration_s } => {
                let rate = (to_hz - from_hz) / duration_s;
                amplitude_a * (TAU * (from_hz + 0.5 * rate * t) * t).sin()
            }
            Self::Pulses { amplitude_a, width_ms, period_s, alternate, .. } => {
                // Edges fall on samples whose times carry rounding.
                let t = t + 0.5e-9;
                let count = (t / period_s).floor();
                let since = t - (count + 0.5) * period_s;
                if !(0.0..1e-3 * width_ms).contains(&since) {
                    return 0.0;
                }
                if *alternate && count % 2.0 == 1.0 { -amplitude_a } else { *amplitude_a }
            }
            Self::RandomPulses { amplitude_a, width_ms, pause_ms, .. } => {
                let mut random = ChaCha8Rng::seed_from_u64(seed);
                let mut start_s = 0.0;
                loop {
                    let pause: f64 =
                        pause_ms[0] + random.random::<f64>() * (pause_ms[1] - pause_ms[0]);
                    let sign = if random.random::<bool>() { 1.0 } else { -1.0 };
                    start_s += 1e-3 * pause;
                    if t < start_s {
                        return 0.0;
                    }
                    start_s += 1e-3 * width_ms;
                    if t < start_s {
                        return sign * amplitude_a;
                    }
                }
            }
            Self::Table(table) => table.at(t)[0],
        }
    }

    /// The first invalid field, with a message.
    pub(super) fn fault(&self) -> Option<(&'static str, String)> {
        let positive = |field: &'static str, value: f64| {
            (!(value.is_finite() && value > 0.0))
                .then(|| (field, format!("{value} must be a positive number")))
        };
        let current = |value: f64| {
            (value.is_nan() || value.abs() > LARGEST_A).then(|| {
                ("amplitude_a", format!("{value} A is outside ±{LARGEST_A} A of the amplifier"))
            })
        };
        let length = positive("duration_s", self.duration_s());
        match self {
            Self::Rest { .. } => length,
            Self::Constant { amplitude_a, .. } => length.or(current(*amplitude_a)),
            Self::Multisine { components, .. } => {
                let finite = components.iter().flatten().all(|v| v.is_finite());
                let highest: f64 = components.iter().map(|c| c[0].abs()).sum();
                length
                    .or((!finite || components.is_empty()).then(|| {
                        let why = "give one or more [amplitude_a, frequency_hz, phase_deg]";
                        ("components", why.to_owned())
                    }))
                    .or(current(highest).map(|(_, why)| ("components", why)))
                    .or(components.iter().find_map(|c| positive("components", c[1])))
            }
            Self::Sine { amplitude_a, frequency_hz, .. }
            | Self::Triangle { amplitude_a, frequency_hz, .. } => {
                length.or(current(*amplitude_a)).or(positive("frequency_hz", *frequency_hz))
            }
            Self::Chirp { amplitude_a, from_hz, to_hz, .. } => length
                .or(current(*amplitude_a))
                .or(positive("from_hz", *from_hz))
                .or(positive("to_hz", *to_hz)),
            Self::Pulses { amplitude_a, width_ms, period_s, .. } => length
                .or(current(*amplitude_a))
                .or(positive("width_ms", *width_ms))
                .or(positive("period_s", *period_s))
                .or((1e-3 * width_ms > 0.5 * period_s).then(|| {
                    ("width_ms", format!("{width_ms} ms is more than half of the period"))
                })),
            Self::RandomPulses { amplitude_a, width_ms, pause_ms, .. } => length
                .or(current(*amplitude_a))
                .or(positive("width_ms", *width_ms))
                .or(positive("pause_ms", pause_ms[0]))
                .or((!(pause_ms[1] >= pause_ms[0] && pause_ms[1].is_finite()))
                    .then(|| ("pause_ms", "the longest pause is below the shortest".to_owned()))),
            Self::Table(table) => {
                table.largest().map(|[a]| a).and_then(current).map(|(_, why)| ("file", why))
            }
        }
    }
}

/// Largest current of the amplifier, A: ±2047 counts.
pub(super) const LARGEST_A: f64 = 3.0;
