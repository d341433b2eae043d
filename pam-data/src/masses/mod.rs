//! The air sealed in the muscles: given by the file, by the gas law, or by the measured surfaces of
//! single muscles.

mod surfaces;

pub use surfaces::MuscleSurfaces;

use crate::error::DataError;
use crate::recording::Recording;
use pam_core::{ForceModel, JointModel, NamedChoice, SealedMasses};

/// Which source of masses is asked for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum MassChoice {
    /// Given masses if the file has them; else the gas law for a trained model; else the surfaces,
    /// if there are any, and the gas law if not.
    #[default]
    Auto,
    /// The gas law with the model's parameters, `m_i = P_i V_i(x) / C`.
    GasLaw,
    /// Equilibrium on the surfaces of single muscles, averaged over both branches.
    Surfaces,
}

impl NamedChoice for MassChoice {
    const KIND: &'static str = "source of the masses";
    const ALL: &'static [(&'static str, Self, &'static str)] = &[
        (
            "auto",
            Self::Auto,
            "gas law for a trained model, surfaces (if given) for an untrained one",
        ),
        ("gas-law", Self::GasLaw, "the model's gas law at the start of the run"),
        ("surfaces", Self::Surfaces, "equilibrium on the single-muscle surfaces"),
    ];
}

/// How the masses of recordings are found.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct MassOptions {
    /// The source.
    pub choice: MassChoice,
    /// Surfaces of single muscles, for the sources that need them.
    pub surfaces: Option<MuscleSurfaces>,
}

/// Where masses came from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "snake_case")]
pub enum MassOrigin {
    /// The file.
    Given,
    /// The gas law at the start of the run.
    GasLaw,
    /// The single-muscle surfaces.
    Surfaces,
}

impl MassOrigin {
    /// In words, for reports.
    #[must_use]
    pub fn label(self) -> &'static str {
        match self {
            Self::Given => "given",
            Self::GasLaw => "gas law",
            Self::Surfaces => "surfaces",
        }
    }
}

/// The sealed masses of a recording. Masses that the file gives win over every choice.
///
/// The gas law is applied to the sealed reading (mean at rest before the excitation) where the file
/// has one, else to the first sample.
///
/// # Errors
/// [`DataError`] if surfaces are asked for and absent or have no equilibrium for this recording, or
/// the masses are not positive.
pub fn resolve_masses<F: ForceModel<f64>>(
    recording: &Recording,
    model: &JointModel<f64, F>,
    trained: bool,
    choice: MassChoice,
    surfaces: Option<&MuscleSurfaces>,
) -> Result<(SealedMasses, MassOrigin), DataError> {
    if let Some(masses) = recording.given_masses {
        return Ok((masses, MassOrigin::Given));
    }
    let use_surfaces = match choice {
        MassChoice::GasLaw => false,
        MassChoice::Surfaces => true,
        MassChoice::Auto => !trained && surfaces.is_some(),
    };
    if use_surfaces {
        let surfaces = surfaces.ok_or_else(|| {
            DataError::file(
                &recording.source,
                "masses from surfaces were asked for, but no surface file (poly44_all_fits.mat) is \
                 given",
            )
        })?;
        return Ok((surfaces.masses(recording)?, MassOrigin::Surfaces));
    }
    let rest = recording.reading_at_rest();
    let pressures = [rest.pressure_flexor_kpa, rest.pressure_extensor_kpa];
    let masses = model.gas_law_masses(rest.displacement_mm, pressures);
    let masses = SealedMasses::new(masses.flexor_g, masses.extensor_g).map_err(|e| {
        DataError::file(&recording.source, format!("gas law at the start of the run: {e}"))
    })?;
    Ok((masses, MassOrigin::GasLaw))
}
