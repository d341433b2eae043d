//! Ladders of effects of the joint.

use super::diagnose::{DiagnoseOptions, RecordingSets, plausible, prepare};
use super::system::JointSystem;
use crate::diagnosis::Prepared;
use crate::error::DiagnoseError;
use crate::ladder::{Ladder, RungModel, climb};
use pam_effects::effects::AnyEffect;
use pam_effects::simulation::Trial;
use pam_effects::{EffectError, ExtendedModel, expression};
use std::path::Path;

/// A ladder before it is climbed: effects, from the shortest model to the richest one.
#[derive(Debug, Clone)]
pub struct EffectLadder {
    /// Its name.
    pub name: String,
    /// Its rungs.
    pub effects: Vec<&'static dyn AnyEffect>,
}

impl EffectLadder {
    /// The friction models M1 to M6 of a geared drive ([`expression::friction_ladder`]): Coulomb and viscous friction, Stribeck,
    /// load-dependent, load-dependent with Stribeck, each side by itself, quadratic.
    #[must_use]
    pub fn friction() -> Self {
        Self { name: "friction".into(), effects: expression::friction_ladder() }
    }

    /// The ladder `friction`, or the effects of a file in their order; `None` for another name without an extension.
    ///
    /// # Errors
    /// [`EffectError`] with the place in the file.
    pub fn named(name: &str) -> Option<Result<Self, EffectError>> {
        if name == "friction" {
            return Some(Ok(Self::friction()));
        }
        let path = Path::new(name);
        let (stem, _) = path.file_stem().zip(path.extension())?;
        let name = stem.to_string_lossy().into_owned();
        Some(expression::load(path).map(|effects| Self { name, effects }))
    }
}

/// Fits every rung of a ladder to recordings, beside the effects that the model has. Of the options, seed, settings, noise and
/// plausibility count.
///
/// # Errors
/// [`DiagnoseError`] as for [`diagnose`](super::diagnose), or if no start of a rung can be simulated.
pub fn joint_ladder(
    model: &ExtendedModel,
    sets: &RecordingSets<'_>,
    ladder: &EffectLadder,
    options: &DiagnoseOptions,
    done: &(dyn Fn(f64) + Sync),
) -> Result<Ladder, DiagnoseError> {
    let settings = &options.settings;
    settings.check()?;
    plausible(model, sets, options)?;
    let (trials, roles) = prepare(model, sets, options)?;
    let all: Vec<&Trial> = trials.iter().collect();
    let open = roles.open();
    let effects = ladder.effects.clone();
    let system = JointSystem::new(all, &open, model.base(), &model.effects, effects, settings);
    let (noise, prior) = system.first_noise(&open, options.noise);
    let prepared = Prepared {
        system: &system,
        roles: &roles,
        noise,
        prior,
        baseline_discrepancy: Vec::new(),
        baseline: None,
        settings,
        seed: options.seed,
    };
    let rung = |(k, effect): (usize, &&'static dyn AnyEffect)| RungModel {
        id: effect.info().id.to_owned(),
        description: effect.info().description.to_owned(),
        candidates: vec![k],
    };
    let rungs: Vec<RungModel> = ladder.effects.iter().enumerate().map(rung).collect();
    climb(&prepared, &ladder.name, &rungs, done)
}
