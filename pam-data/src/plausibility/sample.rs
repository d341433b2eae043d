//! The part of a recording that the checks need.

use super::blocks::{Blocks, differences, squares, without_drift};
use super::gas::{ChamberSlope, chamber_slope};
use super::readings::PressureUnit;
use super::settings::PlausibilitySettings;
use crate::masses::MassOrigin;
use crate::recording::{Recording, median_step_s};
use crate::subject::Subject;
use pam_core::SealedMasses;
use pam_numerics::statistics::median;

/// One recording, averaged, with the slopes of its pressures under every reading.
pub(super) struct Sample<'a> {
    pub(super) recording: &'a Recording,
    /// Averages; absent if the recording is too short for regressions.
    pub(super) blocks: Option<Blocks>,
    /// Seconds per unit of the time column.
    pub(super) time_scale: f64,
    /// Median displacement in the unit of the file.
    pub(super) middle_x: f64,
    /// Largest displacement in the unit of the file.
    pub(super) largest_x: f64,
    /// Median pressures of flexor and extensor as stated.
    pub(super) pressures: [f64; 2],
    /// Masses that the file gives.
    pub(super) given: Option<SealedMasses>,
    /// Speed of the motion, RMS of ẋ over RMS of x, 1/s.
    pub(super) rate_per_s: f64,
    /// For every candidate unit, `d ln P/dx` of both chambers per unit of the file's x.
    pub(super) slopes: Vec<[Option<ChamberSlope>; 2]>,
}

impl<'a> Sample<'a> {
    pub(super) fn new(
        subject: &'a Subject,
        units: &[PressureUnit],
        s: &PlausibilitySettings,
    ) -> Self {
        let r = &subject.recording;
        let time_scale = time_scale(median_step_s(&r.time_s), s);
        let blocks = Blocks::new(r, time_scale, s);
        let slopes = units
            .iter()
            .map(|unit| {
                let Some(b) = blocks.as_ref().filter(|b| moves(b)) else { return [None; 2] };
                let slope = |i: usize| chamber_slope(&b.x, &b.pressures[i], unit.reading, 1.0);
                [slope(0), slope(1)]
            })
            .collect();
        let rate_per_s = blocks.as_ref().filter(|b| moves(b)).map_or(0.0, |b| {
            let x = without_drift(&b.x);
            (squares(&differences(&x)) / squares(&x)).sqrt() / (b.step * time_scale)
        });
        let given = (subject.origin == MassOrigin::Given).then_some(subject.masses);
        Self {
            recording: r,
            blocks,
            time_scale,
            middle_x: median(&r.displacement_mm),
            largest_x: r.displacement_mm.iter().fold(0.0, |a: f64, x| a.max(x.abs())),
            pressures: [median(&r.pressure_flexor_kpa), median(&r.pressure_extensor_kpa)],
            given,
            rate_per_s,
            slopes,
        }
    }

    /// Name of the recording.
    pub(super) fn name(&self) -> String {
        self.recording.name.clone()
    }
}

/// `true` if the displacement is not constant.
pub(super) fn moves(b: &Blocks) -> bool {
    let scale = b.x.iter().fold(0.0, |a: f64, x| a.max(x.abs()));
    squares(&without_drift(&b.x)) > 1e-18 * scale * scale * b.x.len() as f64
}

/// Seconds per unit of a time column with this sampling step: seconds, or the largest of ms, µs and ns that makes the
/// step possible.
pub(super) fn time_scale(step: f64, s: &PlausibilitySettings) -> f64 {
    [1.0, 1e-3, 1e-6, 1e-9]
        .into_iter()
        .find(|scale| step * scale <= s.longest_step_s)
        .unwrap_or(1.0)
}
