//! Custom effects, activations and losses that every command knows by name.

use crate::error::CliError;
use pam_core::activation::{self, NamedActivation};
use pam_effects::effects::{self, Effect};
use pam_trajectory::loss::{self, NamedLoss};

/// Makes one part known.
type Install = Box<dyn FnOnce() -> Result<(), CliError>>;

/// Custom effects, activations and losses for a custom `pam`.
///
/// ```no_run
/// use pam_cli::Registry;
/// # use pam_core::{ActivationFunction, Scalar, activation::NamedActivation};
/// # use serde::{Deserialize, Serialize};
/// # #[derive(Clone, Copy, Serialize, Deserialize)]
/// # struct Cube;
/// # impl ActivationFunction for Cube {
/// #     fn value<S: Scalar>(&self, z: S) -> S { z * z * z }
/// # }
/// # impl NamedActivation for Cube { const NAME: &'static str = "cube"; }
///
/// fn main() -> std::process::ExitCode {
///     pam_cli::run(Registry::default().activation(&Cube))
/// }
/// ```
///
/// Curricula then take `activation = "cube"`, as do sweeps, `--set` and every model that was trained with it; effects go
/// to `pam simulate --effect`, `pam diagnose --effects` and `model.effects` of a curriculum, losses to `loss` of a
/// curriculum and `pam gradient --loss`. `pam parts` lists what a program knows. `templates/own-pam` is such a program.
///
/// Files give names, and reading a file is no place to hand a registry to. So [`install`](Self::install) puts the parts
/// into tables of the process, one in the crate of each kind, to which is added and in which nothing is ever replaced:
/// a name means the same thing as long as the process runs.
#[derive(Default)]
#[must_use = "parts are known once the registry is installed or run"]
pub struct Registry {
    parts: Vec<Install>,
}

impl Registry {
    /// The same with an effect, which is known by the id of its [`EffectInfo`](pam_effects::effects::EffectInfo).
    pub fn effect<E: Effect>(mut self, effect: &'static E) -> Self {
        self.parts.push(Box::new(move || Ok(effects::register(effect)?)));
        self
    }

    /// The same with an activation. Its parameters are those that its name alone stands for.
    pub fn activation<A: NamedActivation>(mut self, activation: &A) -> Self {
        let activation = *activation;
        self.parts.push(Box::new(move || Ok(activation::register(&activation).map(drop)?)));
        self
    }

    /// The same with a loss. Its settings are those that hold where a file leaves them out.
    pub fn loss<L: NamedLoss>(mut self, loss: &'static L) -> Self {
        self.parts.push(Box::new(move || {
            loss::register(loss).map(drop).map_err(|e| CliError::Failed(e.to_string()))
        }));
        self
    }

    /// Makes the parts known to this process; [`run`](crate::run) does so before it parses the command line.
    ///
    /// # Errors
    /// [`CliError`] if another part has a name.
    pub fn install(self) -> Result<(), CliError> {
        self.parts.into_iter().try_for_each(|install| install())
    }
}

impl std::fmt::Debug for Registry {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Registry").field("parts", &self.parts.len()).finish()
    }
}
