//! A recording on the simulation's own grid.

use super::input::{FineForce, resampled};
use crate::effects::Rest;
use pam_core::SealedMasses;
use pam_data::Subject;
use pam_data::preprocess::LowPass;
use pam_data::{Channel, MassOrigin};

/// Where a trial came from.
#[derive(Debug, Clone)]
pub struct RecordSource {
    /// Name of the recording.
    pub name: String,
    /// Commanded gauge pressures, psi, if the name tells.
    pub command_psi: Option<[f64; 2]>,
    /// Where the masses came from.
    pub origin: MassOrigin,
    /// Time of the first sample, s.
    pub start_s: f64,
}

/// A recording on the uniform grid of the simulation: what drives the joint, and what was measured.
#[derive(Debug, Clone)]
pub struct ResampledRecord {
    /// Where it came from.
    pub source: RecordSource,
    /// Time between two grid points, s.
    pub step_s: f64,
    /// Time between the start of the excitation and the first grid point, s; not zero for a part of a
    /// recording.
    pub since_start_s: f64,
    /// Time between two samples of the recording, s.
    pub sample_s: f64,
    /// The force at half steps.
    pub force: FineForce,
    /// The low-pass that the measured channels went through, for the grid; simulated ones follow.
    pub low_pass: [Option<LowPass>; 4],
    /// Measured channels at the grid points, in the order of the state: mm, mm/s, kPa, kPa.
    pub measured: [Vec<f64>; 4],
    /// Readings at rest and at the first sample, as measured.
    pub rest: Rest<f64>,
    /// Measured velocity at the first sample, mm/s.
    pub start_mm_s: f64,
    /// Masses by the measured sealed pressures (or as given), g.
    pub masses: SealedMasses,
}

impl ResampledRecord {
    /// Step of the simulation, s.
    pub const STEP_S: f64 = 4e-3;

    /// Prepares a recording: force and channels on the grid.
    #[must_use]
    pub fn new(subject: &Subject) -> Self {
        let r = &subject.recording;
        let (t0, t1) = r.span_s();
        let points = ((t1 - t0) / Self::STEP_S + 1e-6).floor() as usize + 1;
        let measured = Channel::ALL
            .map(|c| resampled(&r.time_s, r.channel(c), t0, Self::STEP_S, points.max(2)));
        let sealed = r.reading_at_rest();
        let [x0, v0, pf0, pe0] = r.initial_state();
        let rest = Rest {
            sealed_mm: sealed.displacement_mm,
            sealed_kpa: [sealed.pressure_flexor_kpa, sealed.pressure_extensor_kpa],
            start_mm: x0,
            start_kpa: [pf0, pe0],
        };
        Self {
            source: RecordSource {
                name: r.name.clone(),
                command_psi: r.command_psi,
                origin: subject.origin,
                start_s: t0,
            },
            step_s: Self::STEP_S,
            since_start_s: 0.0,
            sample_s: pam_data::recording::median_step_s(&r.time_s),
            force: FineForce::new(r, 0.5 * Self::STEP_S, 2 * points.max(2)),
            low_pass: r
                .low_passed
                .cutoff_hz
                .map(|cutoff| cutoff.and_then(|hz| LowPass::new(hz, 1.0 / Self::STEP_S))),
            measured,
            rest,
            start_mm_s: v0,
            masses: subject.masses,
        }
    }

    /// Number of grid points.
    #[must_use]
    pub fn points(&self) -> usize {
        self.measured[0].len()
    }

    /// Length, s.
    #[must_use]
    pub fn duration_s(&self) -> f64 {
        self.step_s * (self.points() - 1) as f64
    }

    /// The filters that simulated channels go through; none where there are too few points to filter.
    #[must_use]
    pub fn filters(&self) -> [Option<LowPass>; 4] {
        self.low_pass.map(|filter| filter.filter(|_| self.points() >= LowPass::shortest()))
    }
}
