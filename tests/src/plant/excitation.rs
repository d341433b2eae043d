//! What the motor is told to do.

use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;

/// Sines of a filtered noise: enough that their sum is close to Gaussian.
const NOISE_SINES: usize = 40;

/// Lowest frequency of a filtered noise, Hz.
const NOISE_LOWEST_HZ: f64 = 0.1;

/// A commanded force over time.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub enum Excitation {
    /// Sines one after another: frequency (Hz), amplitude (N), duration (s).
    Sines(Vec<[f64; 3]>),
    /// A sine whose frequency rises linearly.
    Chirp {
        /// First and last frequency, Hz.
        from_to_hz: [f64; 2],
        /// Amplitude, N.
        amplitude_n: f64,
        /// Duration, s.
        duration_s: f64,
    },
    /// Levels that are held.
    Steps {
        /// Levels, N.
        levels_n: Vec<f64>,
        /// Time of each, s.
        hold_s: f64,
    },
    /// Sines of random frequencies and phases: a stationary noise between two frequencies.
    Noise {
        /// Frequency (Hz), amplitude (N), phase (rad) of each sine.
        sines: Vec<[f64; 3]>,
        /// Duration, s.
        duration_s: f64,
    },
}

impl Excitation {
    /// The published excitation, 0.5, 1 and 2 Hz at 1 and 1.5 A, with its times multiplied.
    #[must_use]
    pub fn published(share: f64) -> Self {
        let segments = [(0.5, 20.0), (1.0, 10.0), (2.0, 5.0)];
        let both = segments.map(|(f, t)| [133.5, 200.3].map(|a| [f, a, t * share]));
        Self::Sines(both.concat())
    }

    /// Levels between ± `largest_n`, drawn with a seed.
    #[must_use]
    pub fn steps(largest_n: f64, hold_s: f64, duration_s: f64, seed: u64) -> Self {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let levels = (duration_s / hold_s).ceil() as usize;
        let levels_n = (0..levels).map(|_| random.random_range(-largest_n..largest_n)).collect();
        Self::Steps { levels_n, hold_s }
    }

    /// Noise from 0.1 Hz to `highest_hz` with a root mean square of `rms_n`.
    #[must_use]
    pub fn noise(rms_n: f64, highest_hz: f64, duration_s: f64, seed: u64) -> Self {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let amplitude = rms_n * (2.0 / NOISE_SINES as f64).sqrt();
        let sines = (0..NOISE_SINES).map(|_| {
            let frequency = random.random_range(NOISE_LOWEST_HZ..highest_hz);
            [frequency, amplitude, random.random_range(0.0..TAU)]
        });
        Self::Noise { sines: sines.collect(), duration_s }
    }

    /// Duration, s.
    #[must_use]
    pub fn duration_s(&self) -> f64 {
        match self {
            Self::Sines(sines) => sines.iter().map(|s| s[2]).sum(),
            Self::Steps { levels_n, hold_s } => levels_n.len() as f64 * hold_s,
            Self::Chirp { duration_s, .. } | Self::Noise { duration_s, .. } => *duration_s,
        }
    }

    /// The command at `t` s, N; zero outside of its duration.
    #[must_use]
    pub fn force_n(&self, t: f64) -> f64 {
        if t < 0.0 || t >= self.duration_s() {
            return 0.0;
        }
        match self {
            Self::Sines(sines) => {
                let mut from = 0.0;
                for &[frequency, amplitude, duration] in sines {
                    if t < from + duration {
                        return amplitude * (TAU * frequency * (t - from)).sin();
                    }
                    from += duration;
                }
                0.0
            }
            Self::Chirp { from_to_hz: [from, to], amplitude_n, duration_s } => {
                let turns = from * t + (to - from) * t * t / (2.0 * duration_s);
                amplitude_n * (TAU * turns).sin()
            }
            Self::Steps { levels_n, hold_s } => {
                levels_n[((t / hold_s + 1e-9) as usize).min(levels_n.len() - 1)]
            }
            Self::Noise { sines, .. } => {
                sines.iter().map(|&[f, a, phase]| a * (TAU * f * t + phase).sin()).sum()
            }
        }
    }
}
