//! The standard columns, shared by CSV and `.npz`.

use crate::error::DataError;
use crate::load_options::PressureReference;
use crate::preprocess::derivative_of;
use crate::recording::{Recording, split_at_gaps};
use crate::rig_file::Filters;
use pam_core::SealedMasses;
use pam_core::units::{ATMOSPHERE_KPA, MN_PER_N};

/// Names of the standard columns, in order. Force is in N here, everything else as in
/// [`Recording`]. The velocity may be missing: it is then the derivative of the displacement.
pub const NAMES: [&str; 6] = [
    "time_s",
    "displacement_mm",
    "velocity_mm_s",
    "pressure_flexor_kpa",
    "pressure_extensor_kpa",
    "force_n",
];

/// The column that may be missing.
pub const VELOCITY: &str = NAMES[2];

/// The others.
pub(crate) const NEEDED: [&str; 5] = [NAMES[0], NAMES[1], NAMES[3], NAMES[4], NAMES[5]];

/// Key of the flexor's air mass, g.
pub const MASS_FLEXOR: &str = "mass_flexor_g";
/// Key of the extensor's air mass, g.
pub const MASS_EXTENSOR: &str = "mass_extensor_g";

/// Checks what a file gave, puts it into `recording` and splits it at gaps in time.
/// The pressures count from `reference`.
pub(crate) fn finish(
    mut recording: Recording,
    columns: [Vec<f64>; 5],
    velocity: Option<Vec<f64>>,
    masses: [Option<f64>; 2],
    reference: PressureReference,
) -> Result<Vec<Recording>, DataError> {
    recording.given_masses = match masses {
        [Some(flexor_g), Some(extensor_g)] => Some(SealedMasses { flexor_g, extensor_g }),
        [None, None] => None,
        _ => {
            return Err(DataError::file(
                &recording.source,
                format!("only one of `{MASS_FLEXOR}` and `{MASS_EXTENSOR}` is given; give both"),
            ));
        }
    };
    let [time, x, pf, pe, force_n] = columns;
    let time_len = time.len();
    recording.time_s = time;
    recording.displacement_mm = x;
    let derived = velocity.is_none();
    recording.velocity_mm_s = velocity.unwrap_or_else(|| vec![0.0; time_len]);
    let absolute = |p: Vec<f64>| p.into_iter().map(|p| p + reference.offset_kpa()).collect();
    recording.pressure_flexor_kpa = absolute(pf);
    recording.pressure_extensor_kpa = absolute(pe);
    if reference == PressureReference::Gauge {
        recording.notes.push(format!("pressures read as gauge: {ATMOSPHERE_KPA} kPa added"));
    }
    recording.force_mn = force_n.into_iter().map(|f| f * MN_PER_N).collect();
    recording.preprocessing = "taken as it is".into();
    recording.validate()?;
    let parts = split_at_gaps(recording, 2)?;
    if !derived {
        return Ok(parts);
    }
    let cutoff = Filters::default().velocity_hz;
    parts.into_iter().map(|part| derivative_of(part, Some(cutoff))).collect()
}

/// The six columns of a recording.
pub(crate) fn of(recording: &Recording) -> [Vec<f64>; 6] {
    [
        recording.time_s.clone(),
        recording.displacement_mm.clone(),
        recording.velocity_mm_s.clone(),
        recording.pressure_flexor_kpa.clone(),
        recording.pressure_extensor_kpa.clone(),
        recording.force_mn.iter().map(|f| f / MN_PER_N).collect(),
    ]
}
