//! Parts of a curriculum that hold for all its stages.

use crate::coordinates::{Frozen, PhysicalForm};
use crate::warm_start::Initialisation;
use pam_core::{ModelError, NamedChoice};
use pam_data::RigFile;
use pam_effects::EffectRecord;
use pam_effects::engine::{AUTO, EXACT, EngineChoice, SURROGATE};
use pam_solvers::{Interpolation, Tableau};
use pam_trajectory::engine::{GradientChoice, Precision};
use pam_trajectory::predict::{SolverSettings, StepChoice};
use serde::{Deserialize, Serialize};
use std::path::PathBuf;

/// The network to start from.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct ModelSettings {
    /// Random weights, or a model file.
    pub start: StartModel,
    /// Widths of the hidden layers of a random network.
    pub hidden: Vec<usize>,
    /// Its activation.
    pub activation: String,
    /// How its weights are drawn.
    pub initialisation: Initialisation,
    /// Effects that are parts of the model, with the values from which they are trained, in the form of
    /// a model file; those of the file to start from besides.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub effects: Vec<EffectRecord>,
    /// The rig: size of its muscles and its data sheet, from which a random model starts, and what its files are. The
    /// published rig if absent.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rig: Option<RigFile>,
}

impl Default for ModelSettings {
    fn default() -> Self {
        Self {
            start: StartModel::Random,
            hidden: vec![96, 96],
            activation: "leaky_relu".into(),
            initialisation: Initialisation::He,
            effects: Vec::new(),
            rig: None,
        }
    }
}

/// Where the first parameters come from.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum StartModel {
    /// Random weights and datasheet parameters.
    #[default]
    Random,
    /// A model file with a network.
    File(PathBuf),
}

/// Coordinates of the optimiser.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct CoordinateSettings {
    /// Whether the network's weights are those between scaled inputs and a scaled output.
    pub scaled: bool,
    /// Form of the physical parameters.
    pub physical: PhysicalForm,
    /// Groups that stay as they are. C is tied to the masses, which come from the same gas law: a factor of it
    /// changes nothing that is measured.
    pub frozen: Frozen,
    /// How much faster than the others the coordinates of effects move. At 1 a step of the rate changes
    /// predictions by the rate times the standard deviation of the measured channels.
    pub effect_rate: f64,
}

impl Default for CoordinateSettings {
    fn default() -> Self {
        Self {
            scaled: true,
            physical: PhysicalForm::Logarithm,
            frozen: Frozen { gas_coefficient: true, ..Frozen::default() },
            effect_rate: 100.0,
        }
    }
}

/// How the equations are solved while training.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct SolverChoice {
    /// Runge–Kutta method: tsit5, rk4, bs3, dp5; `exact` for the closed form of networks of leaky_relu
    /// or relu, which needs no steps, runs in doubles and takes any input but cubic; `surrogate` for steps on a piecewise
    /// polynomial of a smooth force, likewise; `auto` for the closed form where it applies and bs3 elsewhere.
    pub method: String,
    /// Constant steps of this length, ms; adaptive if absent.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub step_ms: Option<f64>,
    /// Relative and absolute tolerance of adaptive steps.
    pub tolerance: f64,
    /// How the force is read between samples: zoh, linear, cubic, ramp.
    pub input: String,
    /// Float of the network.
    pub precision: Precision,
    /// How the gradient is found: `auto` for the exact adjoint of the fast path's steps or pieces, or the
    /// name of a [`GradientChoice`] for comparison. All but `adjoint` run in double precision, one recording at a
    /// time, and slowly.
    #[serde(skip_serializing_if = "is_auto")]
    pub gradient: String,
}

fn is_auto(name: &str) -> bool {
    name == AUTO
}

/// The closed form where it applies, elsewhere the cheapest that meets the published path's accuracy: on 70 s of the published excitation the
/// largest error of x is 0.018 mm against 0.025 mm (`docs/peers.md`).
impl Default for SolverChoice {
    fn default() -> Self {
        Self {
            method: "auto".into(),
            step_ms: None,
            tolerance: 1e-3,
            input: "ramp".into(),
            precision: Precision::F32,
            gradient: AUTO.into(),
        }
    }
}

impl SolverChoice {
    /// The gradient method; `auto` and `exact` are the adjoint.
    ///
    /// # Errors
    /// [`ModelError::UnknownName`], or [`ModelError::Shape`] for a gradient that does not go with the
    /// method.
    pub fn gradient_choice(&self) -> Result<GradientChoice, ModelError> {
        let closed = [EXACT, SURROGATE].contains(&self.method.as_str());
        match self.gradient.as_str() {
            AUTO => return Ok(GradientChoice::Adjoint),
            own if closed && own == self.method => return Ok(GradientChoice::Adjoint),
            EXACT => {
                return Err(ModelError::Shape(
                    "solver.gradient exact goes with solver.method exact".into(),
                ));
            }
            _ => {}
        }
        match GradientChoice::from_name(&self.gradient)? {
            other if closed => Err(ModelError::Shape(format!(
                "solver.method {} has a gradient of its own, not {}; take method bs3",
                self.method,
                other.name()
            ))),
            choice => Ok(choice),
        }
    }

    /// The choice of an engine.
    ///
    /// # Errors
    /// As [`settings`](Self::settings).
    pub fn engine_choice(&self) -> Result<EngineChoice, ModelError> {
        Ok(EngineChoice {
            settings: self.settings()?,
            // The closed form has no other gradient than its own.
            automatic: self.method == AUTO && self.step_ms.is_none() && self.gradient == AUTO,
            gradient: self.gradient_choice()?,
            precision: self.precision,
        })
    }

    /// The settings of a solve of any force; those of the general solver for `auto`.
    ///
    /// # Errors
    /// [`ModelError::UnknownName`], [`ModelError::NotPositive`], or [`ModelError::Shape`] for a cubic
    /// input with `exact`.
    pub fn settings(&self) -> Result<SolverSettings, ModelError> {
        self.gradient_choice()?;
        if [EXACT, SURROGATE].contains(&self.method.as_str()) {
            let interpolation = Interpolation::from_name(&self.input)?;
            if interpolation == Interpolation::Cubic {
                return Err(ModelError::Shape(format!(
                    "solver.method {} takes input zoh, linear or ramp, not cubic",
                    self.method
                )));
            }
            return Ok(if self.method == EXACT {
                SolverSettings::exact(interpolation)
            } else {
                SolverSettings::surrogate(interpolation)
            });
        }
        let step = match self.step_ms {
            Some(ms) => {
                ModelError::require_positive("solver.step_ms", ms)?;
                StepChoice::Constant { step_s: 1e-3 * ms }
            }
            None => {
                ModelError::require_positive("solver.tolerance", self.tolerance)?;
                StepChoice::Adaptive { rtol: self.tolerance, atol: self.tolerance }
            }
        };
        Ok(SolverSettings {
            tableau: Tableau::from_name(if self.method == AUTO { "bs3" } else { &self.method })?,
            step,
            interpolation: Interpolation::from_name(&self.input)?,
        })
    }
}
