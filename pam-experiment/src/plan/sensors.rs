//! What the sensors of a rig show of a simulated motion.

use crate::error::ExperimentError;
use pam_core::units::{ATMOSPHERE_KPA, KPA_PER_PSI, MN_PER_N, PULLEY_RADIUS_MM};
use pam_data::Subject;
use pam_data::preprocess::{Cutoffs, derivative_of, filtered};
use pam_diagnose::DiagnoseOptions;
use pam_diagnose::joint::{PreparedTrials, Signatures};
use pam_diagnose::noise::Noise;
use pam_effects::ExtendedModel;
use pam_rig::sensors::{PressureParameters, PressureSensor, SensorParameters};
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};
use rand_distr::StandardNormal;

/// Cutoff of the loader of raw logs, Hz.
pub const LOADER_HZ: f64 = 20.0;

/// What a diagnosis sees of recordings beside the motion.
#[derive(Debug, Clone)]
pub struct SensorView {
    /// The noise of the rows of each channel.
    pub noise: Noise,
    /// The recordings as they would be measured; empty if only the noise is known.
    pub recordings: Vec<Subject>,
}

impl From<Noise> for SensorView {
    fn from(noise: Noise) -> Self {
        Self { noise, recordings: Vec::new() }
    }
}

/// What a diagnosis would see of simulated recordings if the sensors of a rig had read them, with the loader of raw
/// logs: also what the noise of the measured force does to the prediction.
///
/// # Errors
/// [`ExperimentError`] if the recordings are too short.
pub fn sensor_view(
    model: &ExtendedModel,
    recordings: &[Subject],
    sensors: &SensorParameters,
    options: &DiagnoseOptions,
) -> Result<SensorView, ExperimentError> {
    let seed = |k: usize| options.seed.wrapping_mul(1000).wrapping_add(k as u64);
    let noisy: Result<Vec<Subject>, ExperimentError> = recordings
        .iter()
        .enumerate()
        .map(|(k, clean)| measured(clean, sensors, LOADER_HZ, seed(k)))
        .collect();
    let noisy = noisy?;
    let trials = PreparedTrials::new(model, &noisy, &options.settings)?;
    let seen = Signatures::new(model, &trials, options, None)?;
    Ok(SensorView { noise: seen.noise().common(), recordings: noisy })
}

impl SensorView {
    /// The recordings as they would be measured: those of the sensors, or the simulated ones with noise that is drawn for each row
    /// of a diagnosis, of `row_s`.
    #[must_use]
    pub fn measured(&self, simulated: &[Subject], row_s: f64, seed: u64) -> Vec<Subject> {
        if !self.recordings.is_empty() {
            return self.recordings.clone();
        }
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let of = |subject: &Subject| {
            let mut recording = subject.recording.clone();
            let (from, to) = recording.span_s();
            let rows = ((to - from) / row_s) as usize + 1;
            let noise = self.noise.drawn(rows, || random.sample(StandardNormal));
            let r = &mut recording;
            let columns =
                [&mut r.displacement_mm, &mut r.pressure_flexor_kpa, &mut r.pressure_extensor_kpa];
            for (column, noise) in columns.into_iter().zip(&noise) {
                for (value, t) in column.iter_mut().zip(&r.time_s) {
                    *value += noise[((t - from) / row_s) as usize];
                }
            }
            Subject { recording, ..*subject }
        };
        simulated.iter().map(of).collect()
    }
}

/// A simulated recording as sensors read it: steps and noise of encoder, pressure and current sensors, and the zero-phase
/// low-pass of the loader at `cutoff_hz` (0: none).
///
/// The lag of the pressure sensors shapes their noise, and is no error of its own: it is the same with and without an
/// effect. The recorded force carries the noise of the current sensor, the motion follows the true force.
///
/// # Errors
/// [`ExperimentError`] if the recording is too short for the filter.
pub fn measured(
    subject: &Subject,
    sensors: &SensorParameters,
    cutoff_hz: f64,
    seed: u64,
) -> Result<Subject, ExperimentError> {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut r = subject.recording.clone();
    let step_s = pam_data::recording::median_step_s(&r.time_s);
    for x in &mut r.displacement_mm {
        *x = -sensors.encoder.read_deg(*x).to_radians() * PULLEY_RADIUS_MM;
    }
    let quiet = PressureParameters { step_psi: 0.0, noise_psi: 0.0, ..sensors.pressure };
    for channel in [&mut r.pressure_flexor_kpa, &mut r.pressure_extensor_kpa] {
        let mut real = PressureSensor::new(sensors.pressure, step_s);
        let mut ideal = PressureSensor::new(quiet, step_s);
        for p in channel.iter_mut() {
            let psi = (*p - ATMOSPHERE_KPA) / KPA_PER_PSI;
            let (_, seen) = real.read_psi(psi, random.sample(StandardNormal));
            let (_, clean) = ideal.read_psi(psi, 0.0);
            *p += (seen - clean) * KPA_PER_PSI;
        }
    }
    for force in &mut r.force_mn {
        let ampere = MN_PER_N * sensors.motor.force_n(1.0);
        let current = *force / ampere;
        *force = ampere * sensors.current.read_a(current, random.sample(StandardNormal));
    }
    let recording = if cutoff_hz > 0.0 && cutoff_hz < 0.5 / step_s {
        derivative_of(filtered(r, &Cutoffs::all(cutoff_hz))?, None)?
    } else {
        r
    };
    Ok(Subject { recording, ..*subject })
}
