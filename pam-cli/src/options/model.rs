//! Which model a command works with.

use super::choice::named;
use crate::error::CliError;
use clap::Args;
use pam_core::{Activation, AnyForce, JointModel, Mlp, NetworkForce, SpringDamper};
use pam_data::{ModelInfo, RigFile, SavedModel, load_model, parse_model};
use pam_effects::ExtendedModel;
use std::path::{Path, PathBuf};

/// Name of the trained model that comes with the program.
pub const DEFAULT_MODEL: &str = "default";

/// Trained on recordings of the virtual rig; `docs/training.md` has the commands that made it.
const DEFAULT_MODEL_BYTES: &[u8] = include_bytes!("../../models/default.safetensors");

/// Name of the built-in physics-only model.
pub const SPRING_DAMPER: &str = "spring-damper";

/// Which model.
#[derive(Debug, Clone, Args)]
pub struct ModelOptions {
    /// Model file (.safetensors, .eqx), `default` for the trained model that comes with the program, or
    /// `spring-damper` for the physics-only one
    #[arg(long, value_name = "MODEL", default_value = DEFAULT_MODEL)]
    pub model: PathBuf,
    /// Activation of an .eqx network, which the file does not name [default: leaky_relu]
    #[arg(long, value_name = "NAME", value_parser = named(Activation::names(), Activation::from_name))]
    pub activation: Option<Activation>,
}

impl ModelOptions {
    /// Loads the model for a command that does not know effects. Of an extended model it takes the plain one
    /// that comes nearest, and says on standard error what became of the effects.
    ///
    /// # Errors
    /// As [`load_extended`](Self::load_extended).
    pub fn load(&self, rig: Option<&RigFile>) -> Result<SavedModel, CliError> {
        let saved = self.load_extended(rig)?;
        if saved.info.effects.is_empty() {
            return Ok(saved);
        }
        let plain = ExtendedModel::from_saved(saved)?.without_effects();
        if let Some(sentence) = plain.sentence() {
            eprintln!("{}: {sentence}", self.model.display());
        }
        Ok(plain.saved)
    }

    /// Loads the model with its effects, if it has any; the physics-only one with the sizes of the rig.
    ///
    /// # Errors
    /// [`CliError`] naming the file or the option.
    pub fn load_extended(&self, rig: Option<&RigFile>) -> Result<SavedModel, CliError> {
        if self.model == Path::new(SPRING_DAMPER) {
            return Ok(built_in_spring_damper(rig));
        }
        let mut saved = if self.model == Path::new(DEFAULT_MODEL) {
            parse_model(&self.model, DEFAULT_MODEL_BYTES)?
        } else {
            load_model(&self.model)?
        };
        if let Some(rig) = rig {
            self.warn_of_geometry(&saved, rig);
        }
        if let Some(activation) = self.activation {
            let AnyForce::Network(force) = &saved.model.force else {
                return Err(CliError::Usage("--activation is for networks".into()));
            };
            let mlp = Mlp::new(force.mlp().layers().to_vec(), activation)?;
            saved.model.force = AnyForce::Network(NetworkForce::new(mlp)?);
        }
        Ok(saved)
    }

    /// A trained model keeps its own geometry; says so if the rig has another.
    fn warn_of_geometry(&self, saved: &SavedModel, rig: &RigFile) {
        let (own, other) = (saved.model.geometry, rig.geometry());
        if own != other {
            eprintln!(
                "{}: the model has muscles of {} x {} mm (radius x length), the rig {} x {} mm; the model keeps its own",
                self.model.display(),
                own.radius_mm,
                own.length_mm,
                other.radius_mm,
                other.length_mm
            );
        }
    }
}

/// The trained model that comes with the program.
///
/// # Errors
/// [`CliError::Data`] if it cannot be read, which a build would have to be broken for.
pub fn default_model() -> Result<SavedModel, CliError> {
    Ok(parse_model(Path::new(DEFAULT_MODEL), DEFAULT_MODEL_BYTES)?)
}

/// The physics-only model: parameters of the data sheet and the published stiffness as a straight line; of a rig those of
/// its own data sheet, with ideal muscles.
#[must_use]
pub fn built_in_spring_damper(rig: Option<&RigFile>) -> SavedModel {
    let spring = rig.map_or_else(SpringDamper::published, RigFile::spring_damper);
    let force = AnyForce::SpringDamper(spring);
    SavedModel {
        model: match rig {
            Some(rig) => rig.model(force),
            None => JointModel::datasheet(force),
        },
        info: ModelInfo {
            name: "linear spring–damper".into(),
            provenance:
                "physics only: datasheet mass, gas and geometry, published stiffness range \
                         and damping, no friction, nothing fitted"
                    .into(),
            trained: false,
            trained_on: Vec::new(),
            effects: Vec::new(),
            rig: rig.cloned(),
            source: None,
        },
    }
}

/// One line on a model's force and parameters.
#[must_use]
pub fn describe_model(saved: &SavedModel) -> String {
    let p = saved.model.physical();
    let effects = match ExtendedModel::from_saved(saved.clone()) {
        Ok(extended) if extended.effects.is_empty() => String::new(),
        Ok(extended) => format!(" Extended by {}.", extended.describe_effects()),
        Err(e) => format!(" Extended by effects that cannot be used here: {e}."),
    };
    format!(
        "Force: {}; m = {:.3} kg, C = {:.4e} kPa·mm³/g, ν = {:.4}.{effects}",
        saved.model.force.describe(),
        p.mass_kg,
        p.gas_coefficient,
        p.deformation
    )
}
