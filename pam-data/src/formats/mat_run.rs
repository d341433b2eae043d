//! The published measured run (`data.mat`): arrays `F` (N), `x` (m), `dx` (m/s), `p1`, `p2` (kPa),
//! one row per sample at 1 kHz. `p1` falls as x rises, so it is the flexor.
//!
//! # Gauge or absolute
//!
//! The file does not record if the pressures are gauge or absolute, but the gas law decides:
//! in a closed chamber `ln P_abs + ln V(x)` is constant, and near x = 0 `d ln V_f/dx = (2ν − 1)/L0 =
//! −d ln V_e/dx`. Regressing `ln P` on x therefore gives the deformation coefficient ν that each
//! reading implies. For the published run this is ν = 3.65 and 3.67 (flexor, extensor) if the
//! pressures are absolute and 2.97, 2.98 if they are gauge; training on 29 other recordings of the
//! rig gave 3.69. They are absolute. [`PressureReference::Auto`] repeats this test for any file and
//! notes the numbers in the recording.

use super::format::{FileFormat, Head};
use super::mat;
use crate::error::DataError;
use crate::load_options::{LoadOptions, PressureReference};
use crate::recording::Recording;
use pam_core::units::{ATMOSPHERE_KPA, MN_PER_N, NOMINAL_LENGTH_MM};
use std::path::Path;

/// The format of measured runs as MATLAB level 5 files.
#[derive(Debug)]
pub struct MatRun;

/// Samples per second of the published run, which its file does not say.
const RATE_HZ: f64 = 1000.0;
/// Names of a scalar that gives the samples per second.
const RATES: [&str; 6] = ["Fs", "fs", "rate_hz", "sample_rate", "sampleRate", "SampleRate"];
/// Names of an array of times, s.
const TIMES: [&str; 4] = ["t", "time", "time_s", "Time"];

/// The sampling rate that a file gives as a scalar or by its times; that of the published run if it gives neither.
fn rate_in(path: &Path) -> Result<f64, DataError> {
    let arrays = mat::read(path)?;
    let rows = arrays.get("x").map_or(0, Vec::len);
    let scalar = RATES.iter().find_map(|name| match arrays.get(*name).map(Vec::as_slice) {
        Some([rate]) => Some((*name, *rate)),
        _ => None,
    });
    let times = || {
        let name = TIMES.iter().find(|name| arrays.get(**name).is_some_and(|t| t.len() == rows))?;
        Some((*name, 1.0 / crate::recording::median_step_s(&arrays[*name])))
    };
    let Some((name, rate)) = scalar.or_else(times) else { return Ok(RATE_HZ) };
    if rate.is_finite() && rate > 0.0 {
        return Ok(rate);
    }
    Err(DataError::file(
        path,
        format!("`{name}` gives {rate} samples per second; it must be positive"),
    ))
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
        let given = options.rig.as_ref().and_then(|rig| rig.file.rate_hz);
        let rate = match given {
            Some(rate) => rate,
            None => rate_in(path)?,
        };
        read(path, options.pressure_reference, rate)
    }
}

/// Deformation coefficient of the published trained model.
const TRAINED_DEFORMATION: f64 = 3.690_974;

/// Reads a measured run at `rate_hz` samples per second.
///
/// # Errors
/// [`DataError::File`] for files that are no MATLAB level 5, lack an array, or hold no valid run.
pub fn read(
    path: &Path,
    reference: PressureReference,
    rate_hz: f64,
) -> Result<Vec<Recording>, DataError> {
    let arrays = mat::read(path)?;
    let column = |name| mat::take(path, &arrays, name, "a measured run (F, x, dx, p1, p2)");
    let scaled =
        |values: &[f64], factor: f64| values.iter().map(|v| v * factor).collect::<Vec<_>>();
    let mut recording = Recording::empty(path);
    recording.displacement_mm = scaled(column("x")?, 1e3);
    recording.velocity_mm_s = scaled(column("dx")?, 1e3);
    recording.force_mn = scaled(column("F")?, MN_PER_N);
    recording.time_s = (0..recording.displacement_mm.len()).map(|k| k as f64 / rate_hz).collect();
    let (p1, p2) = (column("p1")?, column("p2")?);

    let implied = |offset: f64| {
        let slope = |p: &[f64]| log_slope(&recording.displacement_mm, p, offset);
        // Flexor: −L0 d(ln P)/dx = 2ν − 1; the extensor mirrors it.
        [-slope(p1), slope(p2)].map(|s| 0.5 * (1.0 + NOMINAL_LENGTH_MM * s))
    };
    let (absolute, gauge) = (implied(0.0), implied(ATMOSPHERE_KPA));
    let distance = |nu: [f64; 2]| nu.iter().map(|n| (n - TRAINED_DEFORMATION).abs()).sum::<f64>();
    let offset = match reference {
        PressureReference::Absolute => 0.0,
        PressureReference::Gauge => ATMOSPHERE_KPA,
        PressureReference::Auto => {
            let is_gauge = distance(gauge) < distance(absolute);
            recording.notes.push(format!(
                "pressures taken as {}: the gas law implies ν = {:.3} (flexor) and {:.3} (extensor) \
                 if they are absolute, {:.3} and {:.3} if gauge; the trained model has {:.3}",
                if is_gauge { "gauge" } else { "absolute" },
                absolute[0],
                absolute[1],
                gauge[0],
                gauge[1],
                TRAINED_DEFORMATION
            ));
            if is_gauge { ATMOSPHERE_KPA } else { 0.0 }
        }
    };
    recording.pressure_flexor_kpa = p1.iter().map(|p| p + offset).collect();
    recording.pressure_extensor_kpa = p2.iter().map(|p| p + offset).collect();
    recording.preprocessing =
        "as in the file (x low-passed forward and back at 3 Hz, dx at 20 Hz by its makers)".into();
    recording.validate()?;
    Ok(vec![recording])
}

/// Least-squares slope of `ln(p + offset)` over `x`; zero if undefined.
fn log_slope(x: &[f64], p: &[f64], offset: f64) -> f64 {
    let n = x.len().min(p.len()) as f64;
    let logs: Vec<f64> = p.iter().map(|v| (v + offset).ln()).collect();
    let (mx, ml) = (x.iter().sum::<f64>() / n, logs.iter().sum::<f64>() / n);
    let (mut sxy, mut sxx) = (0.0, 0.0);
    for (a, b) in x.iter().zip(&logs) {
        sxy += (a - mx) * (b - ml);
        sxx += (a - mx) * (a - mx);
    }
    let slope = sxy / sxx;
    if slope.is_finite() { slope } else { 0.0 }
}
