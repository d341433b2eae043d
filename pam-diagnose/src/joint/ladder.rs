//! Ladders of effects of the joint.

use super::diagnose::{DiagnoseOptions, RecordingSets, plausible, prepare};
use super::spans::spans;
use super::system::JointSystem;
use crate::data::{Roles, TestSource};
use crate::diagnosis::Prepared;
use crate::error::DiagnoseError;
use crate::ladder::{Ladder, RungModel, climb};
use crate::noise::{NoisePrior, estimated_noise};
use pam_effects::ExtendedModel;
use pam_effects::effects::AnyEffect;
use pam_effects::expression;
use pam_effects::simulation::Trial;

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
    let trials = prepare(model, sets.data.iter().chain(sets.test.unwrap_or_default()))?;
    let source =
        if sets.test.is_some() { TestSource::GivenFrom(sets.data.len()) } else { TestSource::Kept };
    let all: Vec<&Trial> = trials.iter().collect();
    let roles = Roles::assign(&spans(&all), source, options.seed, &settings.data)?;
    let open = roles.open();
    let effects = ladder.effects.clone();
    let system = JointSystem::new(all, &open, model.base(), &model.effects, effects, settings);
    let mut noise = estimated_noise(&system, &open, &settings.noise);
    let given = noise.iter_mut().zip(options.noise);
    given.for_each(|(noise, given)| *noise = given.unwrap_or(*noise));
    let prior = NoisePrior { given: options.noise.to_vec(), ..system.noise_prior(&open) };
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
