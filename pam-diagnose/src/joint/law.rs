//! Laws of the joint.

use super::diagnose::{DiagnoseOptions, JointDiagnosis, RecordingSets, prepare};
use super::spans::spans;
use super::terms::JointTerms;
use crate::data::{Roles, TestSource};
use crate::error::DiagnoseError;
use crate::fit::{Hypothesis, Member};
use crate::noise::{Noise, NoisePrior, estimated_noise};
use crate::remainder::{Ground, learn};
use crate::search::{Candidates, Rows};
use pam_effects::model::ExtendedModel;
use pam_effects::simulation::Trial;
use super::system::JointSystem;
use pam_effects::effects::AnyEffect;

/// A prototype.
pub fn find(
    model: &ExtendedModel,
    sets: &RecordingSets<'_>,
    options: &DiagnoseOptions,
    found: &JointDiagnosis,
) -> Result<(), DiagnoseError> {
    let settings = &options.settings;
    let trials = prepare(model, sets.data.iter().chain(sets.test.unwrap_or_default()))?;
    let source =
        if sets.test.is_some() { TestSource::GivenFrom(sets.data.len()) } else { TestSource::Kept };
    let all: Vec<&Trial> = trials.iter().collect();
    let roles = Roles::assign(&spans(&all), source, options.seed, &settings.data)?;
    let open = roles.open();
    let named: Vec<Member> = found
        .causes
        .iter()
        .chain(&found.minor)
        .enumerate()
        .map(|(k, c)| Member { candidate: k, values: c.member.values.clone() })
        .collect();
    let listed: Vec<_> = found
        .causes
        .iter()
        .chain(&found.minor)
        .map(|c| options.candidates[c.member.candidate])
        .collect();
    let base = model.base();
    let effects: Vec<&dyn AnyEffect> = listed.iter().map(|e| *e as &dyn AnyEffect).collect();
    let system = JointSystem::new(all.clone(), &open, base, &model.effects, effects, settings);
    let mut noise = estimated_noise(&system, &open, &settings.noise);
    let given = noise.iter_mut().zip(options.noise);
    given.for_each(|(noise, given)| *noise = given.unwrap_or(*noise));
    let prior = NoisePrior { given: options.noise.to_vec(), ..system.noise_prior(&open) };
    // The noise beside the named causes.
    let white = Noise::white(&noise);
    let choosing = roles.split(&system, &white, settings);
    let whole = roles.whole(&system, &white, settings);
    let mut rows = Rows::new(choosing, whole, prior.clone());
    let set = Hypothesis { members: named.clone(), ..rows.whole.base() };
    let fit = rows.learn_beside(&set).ok_or_else(|| DiagnoseError::TooLittle("diverges".into()))?;
    eprintln!("named chi {:?} noise {:?} rpo {}", fit.errors.mean(), rows.whole.noise.deviations(), rows.whole.rows_per_observation);
    let space = JointTerms::new(all, open, base, &model.effects, (Vec::new(), Vec::new()), listed.clone(), settings);
    let ground = Ground {
        roles: &roles,
        noise: white.clone(),
        prior,
        named: fit.hypothesis.members.clone(),
        settings,
        listed: listed.len(),
        seed: options.seed,
    };
    let clock = std::time::Instant::now();
    let learned = learn(&space, &ground)?;
    eprintln!("learned in {:.2} s", clock.elapsed().as_secs_f64());
    let Some(learned) = learned else { return Ok(()) };
    eprintln!("best {:?} {} drop {:?}", learned.terms.iter().map(|t| (t[0].place, t.len())).collect::<Vec<_>>(), learned.deviation, learned.drop);
    crate::law::find(&space, &ground, &learned)?;
    let _ = system.candidate_len();
    Ok(())
}
