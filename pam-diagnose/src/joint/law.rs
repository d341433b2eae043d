//! What a diagnosis of the joint leaves, learned.

use super::diagnose::{DiagnoseOptions, JointDiagnosis, RecordingSets, prepare};
use super::spans::spans;
use super::system::JointSystem;
use super::terms::JointTerms;
use crate::data::{Roles, TestSource};
use crate::error::DiagnoseError;
use crate::fit::{Hypothesis, Member};
use crate::law::rest;
use crate::noise::{Noise, NoisePrior, estimated_noise};
use crate::remainder::Ground;
use crate::verdict::Cause;
use pam_effects::effects::AnyEffect;
use pam_effects::expression;
use pam_effects::model::{ActiveEffect, ExtendedModel};
use pam_effects::simulation::Trial;

/// Learns what the named causes of a diagnosis leave of the error: a smooth correction of the forces, of the air or of the
/// sensors, through the simulation, and a short law in its place if there is one
/// ([`remainder`](crate::remainder), [`law`](crate::law)).
///
/// Model, recordings and options are those of the [`diagnose`](super::diagnose) that made the diagnosis. The result has
/// [`remainder`](crate::Diagnosis::remainder). If a law or a correction is confirmed by the test set, the extended model
/// holds it, and a verdict of `explained` becomes `partly_explained`, one of `nothing_found` `unexplained`. A diagnosis whose
/// causes leave nothing but noise comes back within the time of a fit.
///
/// # Errors
/// [`DiagnoseError`] as of the diagnosis.
pub fn learn_remainder(
    model: &ExtendedModel,
    sets: &RecordingSets<'_>,
    options: &DiagnoseOptions,
    mut found: JointDiagnosis,
    progress: &(dyn Fn(f64) + Sync),
) -> Result<JointDiagnosis, DiagnoseError> {
    let settings = &options.settings;
    settings.check()?;
    let trials = prepare(model, sets.data.iter().chain(sets.test.unwrap_or_default()))?;
    let source =
        if sets.test.is_some() { TestSource::GivenFrom(sets.data.len()) } else { TestSource::Kept };
    let all: Vec<&Trial> = trials.iter().collect();
    let roles = Roles::assign(&spans(&all), source, options.seed, &settings.data)?;
    let open = roles.open();
    let causes = || found.causes.iter().chain(&found.minor);
    let listed: Vec<&'static dyn AnyEffect> =
        causes().map(|c| options.candidates[c.member.candidate]).collect();
    let member = |(candidate, c): (usize, &Cause)| Member { candidate, ..c.member.clone() };
    let is_settled = |c: &Cause| c.member.schedule.is_none() && c.stability_test.holds();
    let named: Vec<Member> = causes().enumerate().map(member).collect();
    let settled: Vec<Member> =
        causes().enumerate().filter(|(_, c)| is_settled(c)).map(member).collect();
    let learned = found
        .model
        .baseline
        .as_ref()
        .map_or_else(Default::default, |b| (b.effects.clone(), b.share_deviations.clone()));
    let base = model.base();
    let system =
        JointSystem::new(all.clone(), &open, base, &model.effects, listed.clone(), settings);
    let mut noise = estimated_noise(&system, &open, &settings.noise);
    let given = noise.iter_mut().zip(options.noise);
    given.for_each(|(noise, given)| *noise = given.unwrap_or(*noise));
    let mut prior = NoisePrior { given: options.noise.to_vec(), ..system.noise_prior(&open) };
    if let Some(baseline) = &found.model.baseline {
        prior.add(baseline.discrepancy.clone());
    }
    let space = JointTerms::new(all, open, base, &model.effects, learned, listed, settings);
    let ground = Ground {
        roles: &roles,
        noise: Noise::white(&noise),
        prior,
        named,
        settled,
        rivals: Vec::new(),
        listed: space.listed.len(),
        choices: options.candidates.len(),
        settings,
        seed: options.seed,
    };
    let rest = rest(&space, &ground, found.verdict, progress)?;
    if !rest.added.is_empty() {
        let named = rest.named.iter().map(|m| system.active(m));
        let mut added = Vec::new();
        for (definition, values) in &rest.added {
            let effects = expression::parse(&crate::terms::TermSpace::file(
                &space,
                std::slice::from_ref(definition),
            ))?;
            added.extend(
                effects.into_iter().map(|effect| ActiveEffect { effect, values: values.clone() }),
            );
        }
        let shared = Hypothesis {
            members: Vec::new(),
            fixed: 0,
            shared: rest.shared.clone(),
            locals: Vec::new(),
        };
        let learned = space.learned_in_part(&shared);
        found.model.extended = model.with(learned.into_iter().chain(named).chain(added));
    }
    rest.put_into(&mut found);
    Ok(found)
}
