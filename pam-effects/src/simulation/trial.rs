//! A recording made ready for simulation.

use super::base::Base;
use super::halving::substeps_by_halving;
use super::record::ResampledRecord;
use super::table::ForceTable;
use pam_core::{ForceModel, JointModel, Latest, SealedMasses};
use pam_data::{Recording, Subject};
use std::ops::Range;
use std::sync::Arc;

/// A resampled recording with the base model's force at its sealed masses.
#[derive(Debug, Clone)]
pub struct Trial {
    /// The recording.
    pub record: ResampledRecord,
    /// The base model's force.
    pub table: ForceTable,
    /// Least substeps of each step of the grid, by the [kinks](substeps_by_halving) of the force.
    pub(super) least_substeps: usize,
    /// The force at the masses of the latest simulations.
    tables: Latest<SealedMasses, ForceTable>,
    /// The recorded force with the leads of the latest simulations, in samples.
    forces: Latest<f64, LedForce>,
}

/// The recorded force at half steps of the simulation with a lead.
#[derive(Debug)]
pub(super) struct LedForce {
    /// The whole force, mN.
    pub(super) whole_mn: Vec<f64>,
    /// The part of it that may be noise, mN.
    pub(super) doubtful_mn: Option<Vec<f64>>,
}

/// Masses whose tables are kept: a hypothesis is simulated many times with the same ones, by several threads.
const TABLES: usize = 4;
/// Leads whose forces are kept.
const LEADS: usize = 4;

impl Trial {
    /// Resamples a recording: force and channels on the grid, and the force table over one and a half times
    /// the measured range.
    #[must_use]
    pub fn new<F: ForceModel<f64> + Sync>(model: &JointModel<f64, F>, subject: &Subject) -> Self {
        let record = ResampledRecord::new(subject);
        let ranges = record.ranges;
        Self::with_table_over(model, subject, record, ranges)
    }

    /// A trial of a motion that has not been measured, with a grid point at every step, and the table over one and a half
    /// times given ranges of displacement (mm) and velocity (mm/s).
    #[must_use]
    pub fn over<F: ForceModel<f64> + Sync>(
        model: &JointModel<f64, F>,
        subject: &Subject,
        ranges: [[f64; 2]; 2],
    ) -> Self {
        let record = ResampledRecord { ranges, ..ResampledRecord::dense(subject) };
        Self::with_table_over(model, subject, record, ranges)
    }

    /// The same recording, in which the force of another one of the same times is the part of the force that may be noise of
    /// its sensor: what share of it is noise is a [nuisance](super::Nuisances::force_noise_share).
    #[must_use]
    pub fn with_doubtful_force(self, recording: &Recording) -> Self {
        let record = self.record.with_doubtful_force(recording);
        Self { record, forces: Latest::new(LEADS), ..self }
    }

    /// The table at other masses.
    pub(super) fn table_at(&self, masses: SealedMasses) -> Arc<ForceTable> {
        self.tables.get(masses, || self.table.with_masses(masses))
    }

    /// The recorded force at half steps of the simulation with a lead.
    pub(super) fn led(&self, lead_samples: f64) -> Arc<LedForce> {
        let record = &self.record;
        self.forces.get(lead_samples, || LedForce {
            whole_mn: record.force.led(lead_samples),
            doubtful_mn: record.doubtful_force.as_ref().map(|f| f.led(lead_samples)),
        })
    }

    /// Grid points of this range as a trial of their own ([`ResampledRecord::part`]).
    #[must_use]
    pub fn part(&self, points: Range<usize>) -> Self {
        self.with_record(self.record.part(points))
    }

    /// The first grid points as a trial ([`ResampledRecord::until`]).
    #[must_use]
    pub fn until(&self, points: usize) -> Self {
        self.with_record(self.record.until(points))
    }

    fn with_record(&self, record: ResampledRecord) -> Self {
        Self {
            record,
            table: self.table.clone(),
            least_substeps: self.least_substeps,
            tables: Latest::new(TABLES),
            forces: Latest::new(LEADS),
        }
    }

    fn with_table_over<F: ForceModel<f64> + Sync>(
        model: &JointModel<f64, F>,
        subject: &Subject,
        record: ResampledRecord,
        ranges: [[f64; 2]; 2],
    ) -> Self {
        let around = |[low, high]: [f64; 2]| {
            let margin = 0.25 * (high - low) + 0.5;
            [low - margin, high + margin]
        };
        let table = ForceTable::new(model, subject.masses, around(ranges[0]), around(ranges[1]));
        let (tables, forces) = (Latest::new(TABLES), Latest::new(LEADS));
        let trial = Self { record, table, least_substeps: 1, tables, forces };
        Self { least_substeps: substeps_by_halving(&trial, &Base::of(model)), ..trial }
    }
}

/// Least and greatest value.
pub(crate) fn range_of(values: &[f64]) -> [f64; 2] {
    let low = values.iter().copied().fold(f64::INFINITY, f64::min);
    let high = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    [low, high]
}
