//! The standard columns, shared by CSV and `.npz`.

use crate::recording::Recording;
use pam_core::units::MN_PER_N;

/// Names of the standard columns, in order. Force is in N here, everything else as in
/// [`Recording`].
pub const NAMES: [&str; 6] = [
    "time_s",
    "displacement_mm",
    "velocity_mm_s",
    "pressure_flexor_kpa",
    "pressure_extensor_kpa",
    "force_n",
];

/// Key of the flexor's air mass, g.
pub const MASS_FLEXOR: &str = "mass_flexor_g";
/// Key of the extensor's air mass, g.
pub const MASS_EXTENSOR: &str = "mass_extensor_g";

/// Puts six columns into a recording.
pub(crate) fn fill(recording: &mut Recording, columns: [Vec<f64>; 6]) {
    let [time, x, v, pf, pe, force_n] = columns;
    recording.time_s = time;
    recording.displacement_mm = x;
    recording.velocity_mm_s = v;
    recording.pressure_flexor_kpa = pf;
    recording.pressure_extensor_kpa = pe;
    recording.force_mn = force_n.into_iter().map(|f| f * MN_PER_N).collect();
    recording.preprocessing = "taken as it is".into();
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
