//! The published measured run (`data.mat`): arrays `F` (N), `x` (m), `dx` (m/s), `p1`, `p2` (kPa),
//! one row per sample at 1 kHz. `p1` falls as x rises, so it is the flexor.
//!
//! # Gauge or absolute
//!
//! The file does not record if the pressures are gauge or absolute, but the gas law decides: in a closed chamber
//! `ln P_abs + ln V(x)` is constant, and near x = 0 `d ln V_f/dx = (2ν − 1)/L0 = −d ln V_e/dx`. The regression of x on
//! `ln P`, the one of the [plausibility check](crate::plausibility), therefore gives the deformation coefficient ν that each
//! reading implies. For the published run this is ν = 3.659 and 3.635 (flexor, extensor) if the pressures are absolute and
//! 2.975, 2.955 if they are gauge; training on 29 other recordings of the rig gave 3.69. They are absolute.
//! [`PressureReference::Auto`] repeats this test for any file and notes the numbers in the recording.
//!
//! # Time
//!
//! Samples are timed by the rate of the rig file, else by a scalar of the file (`Fs`, …), else by an array of times in s
//! (`t`, …) as long as `x`, else at 1 kHz.

use super::format::{FileFormat, Head};
use super::mat;
use crate::error::DataError;
use crate::load_options::{LoadOptions, PressureReference};
use crate::plausibility::implied_deformation;
use crate::recording::{Recording, split_at_gaps};
use crate::rig_file::RigFile;
use pam_core::units::{MN_PER_N, NOMINAL_LENGTH_MM};
use std::collections::BTreeMap;
use std::path::Path;

/// Named arrays.
type Arrays = BTreeMap<String, Vec<f64>>;

/// The format of measured runs as MATLAB level 5 files.
#[derive(Debug)]
pub struct MatRun;

/// Samples per second of the published run, which its file does not say.
const RATE_HZ: f64 = 1000.0;
/// Names of a scalar that gives the samples per second.
const RATES: [&str; 6] = ["Fs", "fs", "rate_hz", "sample_rate", "sampleRate", "SampleRate"];
/// Names of an array of times, s.
const TIMES: [&str; 4] = ["t", "time", "time_s", "Time"];

/// The times of the samples, and what gave them if it was not the published rate.
fn times(
    path: &Path,
    arrays: &Arrays,
    rows: usize,
    rig: Option<&RigFile>,
) -> Result<(Vec<f64>, Option<String>), DataError> {
    let at_rate = |rate: f64| (0..rows).map(|k| k as f64 / rate).collect();
    if let Some(rate) = rig.and_then(|rig| rig.file.rate_hz) {
        return Ok((at_rate(rate), Some(format!("timed at the {rate} Hz of the rig file"))));
    }
    let scalar = RATES.iter().find_map(|name| match arrays.get(*name).map(Vec::as_slice) {
        Some([rate]) => Some((*name, *rate)),
        _ => None,
    });
    if let Some((name, rate)) = scalar {
        if !(rate.is_finite() && rate > 0.0) {
            let message = format!("`{name}` gives {rate} samples per second; it must be positive");
            return Err(DataError::file(path, message));
        }
        return Ok((at_rate(rate), Some(format!("timed at the {rate} Hz of `{name}`"))));
    }
    let named = TIMES.iter().find_map(|name| Some((*name, arrays.get(*name)?)));
    let Some((name, times)) = named.filter(|(_, times)| times.len() == rows) else {
        return Ok((at_rate(RATE_HZ), None));
    };
    Ok((times.clone(), Some(format!("timed by `{name}`, s"))))
}

impl FileFormat for MatRun {
    fn id(&self) -> &'static str {
        "mat"
    }
    fn name(&self) -> &'static str {
        "a MATLAB file"
    }
    fn recognises(&self, head: &Head<'_>) -> bool {
        head.bytes.starts_with(b"MATLAB")
            || head.bytes.starts_with(b"\x89HDF")
            || head.has_extension("mat")
    }
    fn holds_recording(&self, path: &Path) -> bool {
        mat::read(path).is_ok_and(|arrays| arrays.contains_key("dx"))
    }
    fn read_recordings(
        &self,
        path: &Path,
        options: &LoadOptions,
    ) -> Result<Vec<Recording>, DataError> {
        read(path, options)
    }
}

/// Deformation coefficient of the published trained model.
const TRAINED_DEFORMATION: f64 = 3.690_974;

/// Reads a measured run; gaps in its times split it.
///
/// # Errors
/// [`DataError::File`] for files that are no MATLAB level 5, lack an array, or hold no valid run.
pub fn read(path: &Path, options: &LoadOptions) -> Result<Vec<Recording>, DataError> {
    let arrays = mat::read(path)?;
    let rig = options.rig.as_ref();
    let column = |name| mat::take(path, &arrays, name, "a measured run (F, x, dx, p1, p2)");
    let scaled =
        |values: &[f64], factor: f64| values.iter().map(|v| v * factor).collect::<Vec<_>>();
    let mut recording = Recording::empty(path);
    recording.displacement_mm = scaled(column("x")?, 1e3);
    recording.velocity_mm_s = scaled(column("dx")?, 1e3);
    recording.force_mn = scaled(column("F")?, MN_PER_N);
    recording.pressure_flexor_kpa = column("p1")?.to_vec();
    recording.pressure_extensor_kpa = column("p2")?.to_vec();
    let (time_s, timed_by) = times(path, &arrays, recording.displacement_mm.len(), rig)?;
    recording.time_s = time_s;
    recording.notes.extend(timed_by);

    let gauge = match options.pressure_reference {
        PressureReference::Absolute => false,
        PressureReference::Gauge => true,
        PressureReference::Auto => {
            let (gauge, note) = is_gauge(&recording, options);
            recording.notes.push(note);
            gauge
        }
    };
    if gauge {
        let atmosphere = options.atmosphere_kpa();
        let pressures = [&mut recording.pressure_flexor_kpa, &mut recording.pressure_extensor_kpa];
        pressures.into_iter().flatten().for_each(|p| *p += atmosphere);
    }
    recording.preprocessing =
        "as in the file (x low-passed forward and back at 3 Hz, dx at 20 Hz by its makers)".into();
    recording.validate()?;
    if let Some(rig) = rig {
        rig.add_air(&mut recording);
    }
    split_at_gaps(recording, 2)
}

/// Whether the pressures are gauge by the gas law, and the sentence that says why. Without an answer they are absolute.
fn is_gauge(recording: &Recording, options: &LoadOptions) -> (bool, String) {
    let rig = options.rig.as_ref();
    let length_mm = rig.map_or(NOMINAL_LENGTH_MM, |rig| rig.geometry().length_mm);
    let known = rig.filter(|rig| rig.muscles.deformation.or(rig.muscles.braid_angle_deg).is_some());
    let (expected, whose) = match known {
        Some(rig) => (rig.physical().deformation, "the rig file"),
        None => (TRAINED_DEFORMATION, "the trained model"),
    };
    let implied = |offset: f64| implied_deformation(recording, offset, length_mm);
    let (absolute, gauge) = match (implied(0.0), implied(options.atmosphere_kpa())) {
        (Some(absolute), Some(gauge)) => (absolute, gauge),
        (None, Some(_)) => {
            return (true, "pressures taken as gauge: absolute ones are positive".into());
        }
        _ => {
            let note = "pressures taken as absolute: the run is too short, or its pressures too constant, for the gas \
                        law to decide; --pressure gauge reads them as gauge";
            return (false, note.into());
        }
    };
    let distance = |nu: [f64; 2]| nu.iter().map(|n| (n - expected).abs()).sum::<f64>();
    let is_gauge = distance(gauge) < distance(absolute);
    let note = format!(
        "pressures taken as {}: the gas law implies ν = {:.3} (flexor) and {:.3} (extensor) if they are absolute, {:.3} and \
         {:.3} if gauge; {whose} has {expected:.3}",
        if is_gauge { "gauge" } else { "absolute" },
        absolute[0],
        absolute[1],
        gauge[0],
        gauge[1]
    );
    (is_gauge, note)
}
