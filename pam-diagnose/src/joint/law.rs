//! What a diagnosis of the joint leaves, learned.

use super::diagnose::{DiagnoseOptions, JointDiagnosis, RecordingSets, prepare};
use super::pieces::{Piece, integrated_s, pieces};
use super::spans::spans;
use super::system::JointSystem;
use super::terms::JointTerms;
use crate::data::Roles;
use crate::error::DiagnoseError;
use crate::fit::Hypothesis;
use crate::law::{Data, NOTHING_LEFT, rest};
use crate::noise::Noise;
use crate::remainder::{
    Budget, Ground, Remainder, RemainderOutcome, is_replaceable, named_and_settled, nothing_left,
};
use crate::search::Work;
use crate::settings::DiagnosisSettings;
use pam_effects::effects::AnyEffect;
use pam_effects::expression;
use pam_effects::model::{ActiveEffect, ExtendedModel};
use pam_effects::simulation::{ResampledRecord, Trial, needed_substeps};
use std::sync::Arc;

/// Length of the recordings of the published loader, s. Of shorter ones all parts of the search take about as much.
const USUAL_S: f64 = 70.0;

/// Learns what the named causes of a diagnosis leave of the error: a smooth correction of the forces, of the air or of the
/// sensors, through the simulation, and a short law in its place if there is one
/// ([`remainder`](crate::remainder), [`law`](crate::law)).
///
/// Model, recordings and options are those of the [`diagnose`](super::diagnose) that made the diagnosis. The result has
/// [`remainder`](crate::Diagnosis::remainder). If a law or a correction is confirmed by the test set, the extended model
/// holds it, and a verdict of `explained` becomes `partly_explained`, one of `nothing_found` `unexplained`. A diagnosis whose
/// causes leave nothing but noise comes back without a fit. [`diagnose`](super::diagnose) does this unless its options say otherwise.
///
/// # Errors
/// [`DiagnoseError`] as of the diagnosis.
pub fn learn_remainder(
    model: &ExtendedModel,
    sets: &RecordingSets<'_>,
    options: &DiagnoseOptions,
    found: JointDiagnosis,
    progress: &(dyn Fn(f64) + Sync),
) -> Result<JointDiagnosis, DiagnoseError> {
    options.settings.check()?;
    let (trials, roles) = prepare(model, sets, options)?;
    from_trials(model, (&trials, &roles), options, found, progress)
}

/// The work that the diagnosis of a single recording may take; there is no limit for several ones.
fn budget(
    roles: &Roles,
    trials: &[Trial],
    settings: &DiagnosisSettings,
    work: &Arc<Work>,
) -> Budget {
    if !roles.is_one_recording() {
        return Budget::unlimited(Arc::clone(work));
    }
    let length_s = trials.iter().map(|t| t.record.duration_s()).fold(USUAL_S, f64::max);
    let steps = length_s / ResampledRecord::STEP_S;
    Budget { work: Arc::clone(work), most_steps: settings.remainder.most_simulations * steps }
}

/// As [`learn_remainder`], from recordings that are ready for simulation.
pub(super) fn from_trials(
    model: &ExtendedModel,
    (trials, roles): (&[Trial], &Roles),
    options: &DiagnoseOptions,
    mut found: JointDiagnosis,
    progress: &(dyn Fn(f64) + Sync),
) -> Result<JointDiagnosis, DiagnoseError> {
    let settings = &options.settings;
    if nothing_left(&found, &settings.remainder) {
        found.remainder = Some(Remainder::none(RemainderOutcome::NothingLeft, NOTHING_LEFT));
        return Ok(found);
    }
    let all: Vec<&Trial> = trials.iter().collect();
    let open = roles.open();
    let causes = || found.causes.iter().chain(&found.minor);
    let listed: Vec<&'static dyn AnyEffect> =
        causes().map(|c| options.candidates[c.member.candidate]).collect();
    let (named, settled) = named_and_settled(&found);
    let base = model.base();
    let system =
        JointSystem::new(all.clone(), &open, base, &model.effects, listed.clone(), settings);
    let (noise, mut prior) = system.first_noise(&open, options.noise);
    let mut noise = noise;
    if let Some(baseline) = &found.model.baseline {
        prior.discrepancy.add(&baseline.discrepancy);
        // Errors that the model makes on the baseline recordings as well are none that a correction is to remove.
        for (noise, size) in noise.iter_mut().zip(baseline.sizes()) {
            *noise = noise.hypot(size);
        }
    }
    let baseline = found.model.baseline.clone();
    let work = Arc::new(Work::starting_at(found.work_steps));
    let budget = budget(roles, trials, settings, &work);
    let space = JointTerms::new(all, open, base, &model.effects, baseline, listed, settings)
        .counted_by(&work);
    let ground = Ground {
        roles,
        noise: Noise::white(&noise),
        prior,
        named,
        settled,
        rivals: Vec::new(),
        margin: 0.0,
        replaceable: is_replaceable(&found),
        listed: space.listed.len(),
        choices: options.candidates.len(),
        settings,
        seed: options.seed,
        budget,
    };
    // As many integration steps, where the mechanics is so fast that a grid step is divided.
    let substeps = trials.iter().map(|t| needed_substeps(t, &space.base)).max().unwrap_or(1);
    let pieces = pieces(&space.trials, &space.open, &settings.remainder, substeps);
    let rest = match pieces {
        None => rest(&Data::whole(&space, &ground), found.verdict, progress)?,
        Some(pieces) => {
            let cut = |p: &Piece| trials[p.recording].part(p.points.clone());
            let cut: Vec<Trial> = pieces.iter().map(cut).collect();
            let part = space.of_parts(cut.iter().collect());
            let of: Vec<usize> = pieces.iter().map(|p| p.recording).collect();
            let roles = roles.of_parts(&of, &spans(&part.trials), &settings.data);
            let data = Data {
                whole: (&space, &ground),
                chosen: (&part, &ground.of_parts(&roles, &of)),
                is_whole: false,
                is_short: integrated_s(&space.trials, &space.open, substeps)
                    <= settings.remainder.most_slow_s,
            };
            rest(&data, found.verdict, progress)?
        }
    };
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
