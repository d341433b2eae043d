//! How a model is trained, as data.
//!
//! A [`Curriculum`] is a TOML file: the network to start from, the recordings, and stages that follow
//! each other, each from the best parameters of the one before. Unset options of a stage come from
//! the curriculum. Those that come with the crate are in [`Curriculum::BUILT_IN`]; `pam train NAME
//! --print` shows them.

mod builtin;
mod data;
mod error;
mod overrides;
mod settings;
mod stage;

pub use data::{DataSettings, DataSplit, Selection, SelectionSet, SplitRole};
pub use error::CurriculumError;
pub use overrides::set_value;
pub use settings::{CoordinateSettings, ModelSettings, SolverChoice, StartModel};
pub use stage::{DerivativeStage, GasStage, Shooting, SolveStage, Stage};

use crate::optimiser::OptimiserSettings;
use crate::regulariser::AnyRegulariser;
use crate::schedule::Schedule;
use pam_trajectory::loss::AnyLoss;
use serde::{Deserialize, Serialize};

/// A way to train.
///
/// ```
/// use pam_train::curriculum::Curriculum;
///
/// let curriculum = Curriculum::parse(
///     "name = 'short'\n[model]\nhidden = [8]\n[[stage]]\nkind = 'gas'\nname = 'deformation from pressures'\n",
///     "short.toml", // for messages
///     &["rate=3e-4".to_owned()],
/// )?;
/// assert_eq!(curriculum.stages.len(), 1);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Curriculum {
    /// Its name.
    pub name: String,
    /// The network to start from.
    #[serde(default)]
    pub model: ModelSettings,
    /// Which recordings.
    #[serde(default)]
    pub data: DataSettings,
    /// Coordinates of the optimiser.
    #[serde(default)]
    pub coordinates: CoordinateSettings,
    /// How the equations are solved.
    #[serde(default)]
    pub solver: SolverChoice,
    /// The loss.
    #[serde(default)]
    pub loss: AnyLoss,
    /// Penalties that are added to the loss.
    #[serde(default, skip_serializing_if = "Vec::is_empty", rename = "regulariser")]
    pub regularisers: Vec<AnyRegulariser>,
    /// The optimiser.
    #[serde(default)]
    pub optimiser: OptimiserSettings,
    /// Learning rate at the start of a stage.
    #[serde(default = "default_rate")]
    pub rate: f64,
    /// How the rate changes within a stage.
    #[serde(default)]
    pub schedule: Schedule,
    /// Largest norm of the gradient; longer ones are cut.
    #[serde(default = "default_clip")]
    pub clip: f64,
    /// Epochs of a stage that is trained through the solver after each of which the held-out recordings
    /// are predicted and scored; at the ends of stages only if absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub score_every: Option<usize>,
    /// The stages.
    #[serde(rename = "stage")]
    pub stages: Vec<Stage>,
}

fn default_rate() -> f64 {
    1e-4
}

fn default_clip() -> f64 {
    1.0
}
