//! The standard columns, shared by CSV and `.npz`.

use crate::error::DataError;
use crate::load_options::LoadOptions;
use crate::preprocess::{Cutoffs, derivative_of};
use crate::recording::{Recording, SealedReading, split_at_gaps};
use crate::rig_file::{Filters, RigFile};
use pam_core::SealedMasses;
use pam_core::units::MN_PER_N;
use std::sync::Arc;

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
/// Keys of the reading at rest after the valves were closed: displacement, pressures of flexor and extensor.
pub const SEALED: [&str; 3] =
    ["sealed_displacement_mm", "sealed_pressure_flexor_kpa", "sealed_pressure_extensor_kpa"];
/// Key of the rig that made a recording, in TOML.
pub const RIG: &str = "rig";

/// Content of a file of standard columns other than the columns.
#[derive(Default)]
pub(crate) struct Header {
    numbers: [Option<f64>; 5],
    pub(crate) rig: Option<RigFile>,
}

impl Header {
    /// The keys of numbers.
    pub(crate) const KEYS: [&str; 5] =
        [MASS_FLEXOR, MASS_EXTENSOR, SEALED[0], SEALED[1], SEALED[2]];

    /// Sets the number of one of [`KEYS`](Self::KEYS).
    ///
    /// # Errors
    /// A sentence if it cannot be this number.
    pub(crate) fn set(&mut self, place: usize, value: f64) -> Result<(), String> {
        // Masses are never gauge, and the displacement may be anything.
        let (what, unit) = match place {
            0 | 1 => ("an air mass must be positive", "g"),
            _ => ("a reading at rest must be a finite number", "mm or kPa"),
        };
        if !value.is_finite() || (place < 2 && value <= 0.0) {
            return Err(format!("{what}, got {value} {unit}"));
        }
        self.numbers[place] = Some(value);
        Ok(())
    }

    /// Puts it into a recording whose pressures count from `zero_kpa`.
    fn apply(self, recording: &mut Recording, zero_kpa: f64) -> Result<(), DataError> {
        let fail = |message: String| Err(DataError::file(&recording.source, message));
        let [flexor, extensor, x, pf, pe] = self.numbers;
        let masses = match (flexor, extensor) {
            (Some(flexor_g), Some(extensor_g)) => Some(SealedMasses { flexor_g, extensor_g }),
            (None, None) => None,
            _ => {
                return fail(format!(
                    "only one of `{MASS_FLEXOR}` and `{MASS_EXTENSOR}` is given; give both"
                ));
            }
        };
        let sealed = match (x, pf, pe) {
            (Some(displacement_mm), Some(pf), Some(pe)) => Some(SealedReading {
                displacement_mm,
                pressure_flexor_kpa: pf + zero_kpa,
                pressure_extensor_kpa: pe + zero_kpa,
            }),
            (None, None, None) => None,
            _ => return fail(format!("give all of `{}`, or none", SEALED.join("`, `"))),
        };
        recording.given_masses = masses;
        recording.sealed = sealed;
        recording.rig = self.rig.map(Arc::new);
        Ok(())
    }
}

/// The numbers that a recording's file says besides the columns, with these masses.
pub(crate) fn numbers_of(
    recording: &Recording,
    masses: Option<SealedMasses>,
) -> Vec<(&'static str, f64)> {
    let masses = masses.map(|m| [m.flexor_g, m.extensor_g]).into_iter().flatten();
    let mut all: Vec<_> = [MASS_FLEXOR, MASS_EXTENSOR].into_iter().zip(masses).collect();
    if let Some(s) = recording.sealed {
        let values = [s.displacement_mm, s.pressure_flexor_kpa, s.pressure_extensor_kpa];
        all.extend(SEALED.into_iter().zip(values));
    }
    all
}

/// Checks what a file gave, puts it into `recording` and splits it at gaps in time. The rig of the options wins over the
/// one that the file names, but for the filters that the file's channels went through already.
pub(crate) fn finish(
    mut recording: Recording,
    columns: [Vec<f64>; 5],
    velocity: Option<Vec<f64>>,
    header: Header,
    options: &LoadOptions,
) -> Result<Vec<Recording>, DataError> {
    let zero_kpa = options.zero_kpa();
    header.apply(&mut recording, zero_kpa)?;
    let own = recording.rig.clone();
    if let Some(rig) = &options.rig {
        recording.rig = Some(Arc::new(rig.sizes()));
    }
    let [time, x, pf, pe, force_n] = columns;
    let time_len = time.len();
    recording.time_s = time;
    recording.displacement_mm = x;
    let derived = velocity.is_none();
    recording.velocity_mm_s = velocity.unwrap_or_else(|| vec![0.0; time_len]);
    let absolute = |p: Vec<f64>| p.into_iter().map(|p| p + zero_kpa).collect();
    recording.pressure_flexor_kpa = absolute(pf);
    recording.pressure_extensor_kpa = absolute(pe);
    if zero_kpa != 0.0 {
        recording.notes.push(format!("pressures read as gauge: {zero_kpa} kPa added"));
    }
    recording.force_mn = force_n.into_iter().map(|f| f * MN_PER_N).collect();
    recording.preprocessing = "taken as it is".into();
    recording.validate()?;
    let rig = options.rig.as_ref().or(own.as_deref());
    if let Some(rig) = rig {
        rig.add_air(&mut recording);
    }
    let behind = own.as_deref().filter(|own| own.filter.in_file).or(rig);
    // With `preprocess` the caller filters all channels alike.
    let behind = behind.filter(|r| r.cutoffs() != Cutoffs::default() && !options.preprocess);
    let velocity_hz = rig.map_or(Filters::default().velocity_hz, |rig| rig.filter.velocity_hz);
    let processed = |part: Recording| {
        let part = match behind {
            Some(rig) => rig.behind_filters(part)?,
            None => part,
        };
        if derived {
            derivative_of(part, (velocity_hz > 0.0).then_some(velocity_hz))
        } else {
            Ok(part)
        }
    };
    split_at_gaps(recording, 2)?.into_iter().map(processed).collect()
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
