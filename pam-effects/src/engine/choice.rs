//! Which engine a model is evaluated with.

use super::EffectsEngine;
use super::of_network::OfNetwork;
use crate::model::ActiveEffect;
use pam_core::{AnyForce, ForceModel, NetworkForce};
use pam_surrogate::SurrogateSettings;
use pam_trajectory::engine::{
    BatchedEngine, ClosedFormEngine, EngineError, EngineForce, GeneralEngine, GradientChoice,
    Precision, SurrogateEngine, TrajectoryEngine,
};
use pam_trajectory::{SolverSettings, StepChoice};

/// Name of the method that is the closed form where it applies.
pub const AUTO: &str = "auto";
/// Name of the closed form of (leaky) ReLU networks.
pub const EXACT: &str = "exact";
/// Name of the steps on a piecewise polynomial of a smooth force.
pub const SURROGATE: &str = "surrogate";

/// How trajectories and gradients are to be found.
#[derive(Debug, Clone, PartialEq)]
pub struct EngineChoice {
    /// Method, steps and reading of the force.
    pub settings: SolverSettings,
    /// Whether the closed form replaces the steps where it applies ([`AUTO`]).
    pub automatic: bool,
    /// The gradient method; [`GradientChoice::Adjoint`] is that of the fast engines.
    pub gradient: GradientChoice,
    /// Precision of the network, in engines that have a choice.
    pub precision: Precision,
}

impl EngineChoice {
    /// The adjoint in doubles.
    #[must_use]
    pub fn new(settings: SolverSettings) -> Self {
        Self {
            settings,
            automatic: false,
            gradient: GradientChoice::Adjoint,
            precision: Precision::F64,
        }
    }

    /// The settings for a force, with or without effects: those of the closed form if it is taken
    /// [automatically](Self::automatic).
    #[must_use]
    pub fn settings_for(&self, force: &impl ForceModel<f64>, effects: bool) -> SolverSettings {
        let settings = &self.settings;
        if self.automatic && !effects && settings.exact_applies_to(force) {
            SolverSettings::exact(settings.interpolation)
        } else {
            settings.clone()
        }
    }
}

/// A model and the choice for it, with the settings found.
struct Case<'a, F> {
    force: &'a F,
    effects: &'a [ActiveEffect],
    choice: &'a EngineChoice,
    settings: SolverSettings,
}

/// An entry of the list of engines.
struct Entry<F> {
    suits: fn(&Case<'_, F>) -> bool,
    make: fn(&Case<'_, F>) -> Box<dyn TrajectoryEngine<F>>,
}

/// The engines, the preferred ones first. A further engine is a line here.
fn engines<F: EngineForce>() -> [Entry<F>; 5] {
    [
        Entry {
            suits: |c| !c.effects.is_empty(),
            make: |c| match c.choice.precision {
                Precision::F32 => Box::new(EffectsEngine::<f32>::new(c.effects)),
                Precision::F64 => Box::new(EffectsEngine::<f64>::new(c.effects)),
            },
        },
        Entry {
            suits: |c| c.settings.step == StepChoice::Exact,
            make: |c| Box::new(ClosedFormEngine::new(c.settings.interpolation)),
        },
        Entry {
            suits: |c| c.settings.step == StepChoice::Surrogate,
            make: |c| {
                let accuracy = SurrogateSettings::default();
                Box::new(SurrogateEngine::new(c.settings.interpolation, accuracy))
            },
        },
        Entry {
            suits: |c| c.choice.gradient == GradientChoice::Adjoint && c.force.network().is_some(),
            make: |c| match c.choice.precision {
                Precision::F32 => Box::new(BatchedEngine::<f32>::new(c.settings.clone())),
                Precision::F64 => Box::new(BatchedEngine::<f64>::new(c.settings.clone())),
            },
        },
        Entry {
            suits: |_| true,
            make: |c| Box::new(GeneralEngine::new(c.choice.gradient, c.settings.clone())),
        },
    ]
}

/// A force model whose engine is chosen at run time.
///
/// This crate instantiates the engines for [`AnyForce`], which those for [`NetworkForce`] are as well, so that crates above do
/// not compile them again. For another force, an empty `impl ChooseEngine` is enough; its engines are compiled in the crate that uses it.
pub trait ChooseEngine: EngineForce + Sized + 'static {
    /// Implements [`choose`].
    ///
    /// # Errors
    /// See [`choose`].
    fn choose_engine(
        &self,
        effects: &[ActiveEffect],
        choice: &EngineChoice,
    ) -> Result<Box<dyn TrajectoryEngine<Self>>, EngineError> {
        choose_any(self, effects, choice)
    }
}

// A default method is instantiated in the crate that calls it; methods written out for concrete types are compiled here.
impl ChooseEngine for AnyForce<f64> {
    fn choose_engine(
        &self,
        effects: &[ActiveEffect],
        choice: &EngineChoice,
    ) -> Result<Box<dyn TrajectoryEngine<Self>>, EngineError> {
        choose_any(self, effects, choice)
    }
}

impl ChooseEngine for NetworkForce<f64> {
    fn choose_engine(
        &self,
        effects: &[ActiveEffect],
        choice: &EngineChoice,
    ) -> Result<Box<dyn TrajectoryEngine<Self>>, EngineError> {
        let engine = AnyForce::from(self.clone()).choose_engine(effects, choice)?;
        Ok(Box::new(OfNetwork(engine)))
    }
}

/// The engine for models with this kind of force and these effects.
///
/// # Errors
/// [`EngineError::Request`] if another gradient method than the adjoint is chosen for a model with effects or for
/// the closed form, which have adjoints of their own.
pub fn choose<F: ChooseEngine>(
    force: &F,
    effects: &[ActiveEffect],
    choice: &EngineChoice,
) -> Result<Box<dyn TrajectoryEngine<F>>, EngineError> {
    force.choose_engine(effects, choice)
}

fn choose_any<F: EngineForce + 'static>(
    force: &F,
    effects: &[ActiveEffect],
    choice: &EngineChoice,
) -> Result<Box<dyn TrajectoryEngine<F>>, EngineError> {
    let settings = choice.settings_for(force, !effects.is_empty());
    let own_adjoint = match (effects, settings.step) {
        ([_, ..], _) => Some("a model with effects has the adjoint of its own steps"),
        (_, StepChoice::Exact) => Some("the closed form has the adjoint of its own segments"),
        (_, StepChoice::Surrogate) => Some("steps on a surrogate have an adjoint of their own"),
        _ => None,
    };
    if let Some(why) = own_adjoint
        && choice.gradient != GradientChoice::Adjoint
    {
        return Err(EngineError::Request(format!(
            "gradient {}: {why}; take {AUTO}",
            choice.gradient.name()
        )));
    }
    let case = Case { force, effects, choice, settings };
    let engine = engines().into_iter().find(|entry| (entry.suits)(&case));
    Ok((engine.expect("the last one suits every case").make)(&case))
}
