//! A case of the study.

use crate::plant::{Colour, Excitation, Hidden, Noise, Sensors};
use serde::{Deserialize, Serialize};

/// What a case asks.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Kind {
    /// Nothing is hidden.
    Null,
    /// One effect of the vocabulary.
    Single,
    /// Two effects of the vocabulary.
    Pair,
    /// One effect that begins within the recordings, or acts in some of them only.
    Onset,
    /// Something that the vocabulary does not list.
    Unlisted,
    /// A single case that once went wrong.
    Row,
}

/// Strength of a hidden effect, relative to the limit of detection in the data of its case and to what a laboratory
/// would want to know of; see [`detection`](super::detection).
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Strength {
    /// Near the limit.
    Weak,
    /// Clearly above it.
    Medium,
    /// Twice as strong as medium.
    Strong,
    /// Magnitudes that the case gives.
    Given,
}

/// A hidden effect as the design draws it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub enum Fault {
    /// A variant of [`magnitudes`](crate::magnitudes) at a strength.
    Drawn {
        /// Its label.
        label: String,
        /// Its strength.
        strength: Strength,
        /// Share of each recording after which it begins.
        onset: f64,
        /// Numbers of the recordings in which it acts; all if absent.
        only: Option<Vec<usize>>,
    },
    /// An effect with its values.
    Given(Hidden),
}

impl Fault {
    /// A variant that acts always.
    #[must_use]
    pub fn drawn(label: &str, strength: Strength) -> Self {
        Self::Drawn { label: label.to_owned(), strength, onset: 0.0, only: None }
    }
}

/// The shape of an excitation.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Shape {
    /// The published protocol: 0.5, 1 and 2 Hz at 1 and 1.5 A.
    Published,
    /// A sine of this frequency (Hz); the recordings have amplitudes of their own.
    Sine(f64),
    /// 0.3 to 6 Hz.
    Chirp,
    /// Random levels, held for one second.
    Steps,
    /// Noise of 0.1 to 3 Hz.
    Noise,
}

/// How the model under diagnosis differs from the plant.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ModelError {
    /// Not at all.
    None,
    /// The force is off by a smooth function of its inputs with this root mean square, relative to the force's.
    Force(f64),
    /// Every weight of the network is multiplied by one plus this.
    Weights(f64),
}

/// Where the recordings come from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Source {
    /// The plant of the studies.
    Plant,
    /// The virtual rig, through its raw logs, diagnosed with its default model.
    Rig,
}

/// What the recordings of a case are like.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Factors {
    /// Plant or rig; the rig has sensors and rates of its own.
    pub source: Source,
    /// Sampling rate, Hz.
    pub rate_hz: f64,
    /// Factor on the noise of the sensors.
    pub loudness: f64,
    /// Correlation of the noise of the pressures.
    pub pressure_colour: Colour,
    /// Noise of the recorded force, N.
    pub force_noise: Noise,
    /// Encoder step, mm.
    pub encoder_mm: f64,
    /// Whether the motor follows the command between samples.
    pub smooth_force: bool,
    /// Cutoff of the loader's low-pass, Hz; 0 for unfiltered columns.
    pub cutoff_hz: f64,
    /// Recordings under diagnosis.
    pub recordings: usize,
    /// Duration of each, s.
    pub duration_s: f64,
    /// Excitation.
    pub shape: Shape,
    /// Error of the model.
    pub model_error: ModelError,
    /// Whether baseline recordings are given.
    pub baseline: bool,
    /// Pressures that are written as gauge pressures by mistake.
    pub gauge: bool,
}

/// Three recordings of 20 s with the sensors of the published rig and a model without error.
impl Default for Factors {
    fn default() -> Self {
        let sensors = Sensors::default();
        Self {
            source: Source::Plant,
            rate_hz: sensors.rate_hz,
            loudness: 1.0,
            pressure_colour: Colour::White,
            force_noise: sensors.force,
            encoder_mm: sensors.encoder_mm,
            smooth_force: false,
            cutoff_hz: sensors.cutoff_hz,
            recordings: 3,
            duration_s: 20.0,
            shape: Shape::Published,
            model_error: ModelError::None,
            baseline: false,
            gauge: false,
        }
    }
}

/// Amplitudes of the recordings, N: between the published 1 and 1.5 A.
const AMPLITUDES_N: [f64; 3] = [133.5, 200.3, 165.0];

/// Frequencies of a chirp, Hz, and most cycles per sample of any excitation.
const CHIRP_HZ: [f64; 2] = [0.3, 6.0];
const CYCLES_PER_SAMPLE: f64 = 1.0 / 6.0;

/// Hold of a step, s; highest frequency of a noise, Hz, and its root mean square relative to the amplitude.
const HOLD_S: f64 = 1.0;
const NOISE_HZ: f64 = 3.0;
const NOISE_SHARE: f64 = 0.45;

/// Duration of the published protocol, s.
const PUBLISHED_S: f64 = 70.0;

impl Factors {
    /// The sensors of the plant.
    #[must_use]
    pub fn sensors(&self) -> Sensors {
        let usual = Sensors::default();
        Sensors {
            rate_hz: self.rate_hz,
            encoder_mm: self.encoder_mm,
            displacement: usual.displacement.times(self.loudness),
            pressure: Noise { colour: self.pressure_colour, ..usual.pressure.times(self.loudness) },
            force: self.force_noise,
            smooth_force: self.smooth_force,
            cutoff_hz: self.cutoff_hz,
        }
    }

    /// The excitation of one recording.
    #[must_use]
    pub fn excitation(&self, recording: usize, seed: u64) -> Excitation {
        let amplitude_n = AMPLITUDES_N[recording % AMPLITUDES_N.len()];
        let highest = CYCLES_PER_SAMPLE * self.rate_hz;
        let (duration_s, seed) = (self.duration_s, seed.wrapping_mul(1009) + recording as u64);
        match self.shape {
            Shape::Published => Excitation::published(duration_s / PUBLISHED_S),
            Shape::Sine(hz) => Excitation::Sines(vec![[hz.min(highest), amplitude_n, duration_s]]),
            Shape::Chirp => Excitation::Chirp {
                from_to_hz: [CHIRP_HZ[0], CHIRP_HZ[1].min(highest)],
                amplitude_n,
                duration_s,
            },
            Shape::Steps => Excitation::steps(amplitude_n, HOLD_S, duration_s, seed),
            Shape::Noise => Excitation::noise(
                NOISE_SHARE * amplitude_n,
                NOISE_HZ.min(highest),
                duration_s,
                seed,
            ),
        }
    }

    /// Whether a fault can be told from an error of the model: the model has none, or baseline recordings show it.
    #[must_use]
    pub fn judgeable(&self) -> bool {
        self.baseline || self.model_error == ModelError::None
    }
}

/// A case: recordings, what is hidden in them, and the seeds of noise and diagnosis.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Case {
    /// Id, `singles-031`.
    pub id: String,
    /// Kind.
    pub kind: Kind,
    /// What the recordings are like.
    pub factors: Factors,
    /// What is hidden.
    pub faults: Vec<Fault>,
    /// Pressures of the recordings, psi gauge; drawn by the seed if empty.
    pub conditions: Vec<[f64; 2]>,
    /// Seed of pressures, excitation and noise.
    pub seed: u64,
    /// Seed of the diagnosis.
    pub diagnosis_seed: u64,
    /// The case with the same data and another seed of the diagnosis.
    pub repeats: Option<String>,
}
