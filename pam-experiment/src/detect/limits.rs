//! Limits of all effects, and which of them are confused.

use super::demand::{Demand, Kind, of_nothing};
use super::pairs::pairs;
use super::ray::{Ray, rays};
use super::result::{Detection, Limit, Limits};
use super::trials::{Trials, TriedLimit};
use super::{DetectOptions, GivenValues};
use crate::error::ExperimentError;
use crate::plan::{SensorView, Synthesis};
use pam_core::parallel;
use pam_data::Subject;
use pam_diagnose::joint::{PreparedTrials, Signatures};
use pam_effects::ExtendedModel;
use pam_effects::effects::AnyEffect;
use pam_effects::simulation::ResampledRecord;
use std::sync::atomic::{AtomicUsize, Ordering};

/// Magnitude of the first trial over the limit from which a diagnosis lists an effect. It is named from 1 to 4 times that limit, 2.6 times in
/// the median of 31 effects and directions (results/experiment), where rivals and the confirmation on test data ask for more.
const NAMED_OVER_LISTED: f64 = 4.0;

/// The effects that are asked about, with their places among the candidates.
fn asked(
    options: &DetectOptions,
) -> Result<Vec<(usize, &'static dyn AnyEffect, GivenValues)>, ExperimentError> {
    let candidates = &options.diagnosis.candidates;
    let place = |g: &GivenValues| {
        let at = candidates.iter().position(|e| e.info().id == g.effect);
        let at = at.ok_or_else(|| {
            ExperimentError::setting("effects", format!("`{}` is no candidate", g.effect))
        })?;
        Ok((at, candidates[at], g.clone()))
    };
    if options.effects.is_empty() {
        let all = candidates.iter().enumerate();
        let given = |e: &&'static dyn AnyEffect| GivenValues {
            effect: e.info().id.to_owned(),
            values: Vec::new(),
        };
        return Ok(all.map(|(k, e)| (k, *e, given(e))).collect());
    }
    options.effects.iter().map(place).collect()
}

/// The limits of a diagnosis of recordings, measured or simulated. The noise is learned from them as a diagnosis does, unless it is
/// given. With [`discrepancy`](pam_diagnose::DiagnoseOptions::discrepancy) the limits account for
/// model errors, and the recordings are the baseline recordings from which these were learned. Trials ([`DetectOptions::trials`]) diagnose recordings with the effects in them, made of
/// these; `progress` is called with the number of finished trials and of all.
///
/// ```
/// use pam_core::{AnyForce, JointModel, SpringDamper};
/// use pam_data::ModelInfo;
/// use pam_effects::ExtendedModel;
/// use pam_experiment::detect::{DetectOptions, detect};
/// use pam_experiment::plan::{noise_from_toml, planned_runs};
/// use pam_rig::{Conditions, Protocol};
///
/// let joint = JointModel::datasheet(AnyForce::from(SpringDamper::published()));
/// let model = ExtendedModel { joint, info: ModelInfo::default(), effects: Vec::new() };
/// let mut protocol = Protocol::paper();
/// protocol.conditions = Some(Conditions::List(vec![[45, 45], [30, 30], [60, 60]]));
/// protocol.current.truncate(1);
/// let runs = planned_runs(&protocol, &Default::default(), 250.0, 1)?;
/// let recordings: Vec<_> = runs.iter().map(|r| r.simulated(&model)).collect::<Result<_, _>>()?;
/// let text = "x_mm = { deviation = 0.004 }\npressure_flexor_kpa = { deviation = 0.1 }\npressure_extensor_kpa = { deviation = 0.1 }";
/// let noise = noise_from_toml(text, "noise.toml", 0.02)?;
/// let options = DetectOptions {
///     effects: vec!["viscous_damping".parse()?, "coulomb_friction".parse()?],
///     trials: Some(0),
///     ..DetectOptions::default()
/// };
/// let detection = detect(&model, &recordings, Some(&noise.into()), &options, &|_, _| {})?;
/// let friction = detection.of("coulomb_friction").and_then(|l| l.value()).expect("it is seen");
/// assert!(friction > 0.01 && friction < 10.0); // N
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// [`ExperimentError`] if there is too little data, the model diverges on it, or a given effect or value is unknown.
pub fn detect(
    model: &ExtendedModel,
    recordings: &[Subject],
    view: Option<&SensorView>,
    options: &DetectOptions,
    progress: TrialProgress<'_>,
) -> Result<Detection, ExperimentError> {
    Ok(detect_along(model, recordings, view, options, Some(progress))?.0)
}

/// Called with the number of finished trials and of all.
pub(crate) type TrialProgress<'p> = &'p (dyn Fn(usize, usize) + Sync);

/// As [`detect`], with the ways along which the limits were looked for, in the order of the limits. Without `progress` no trials are
/// made.
pub(crate) fn detect_along(
    model: &ExtendedModel,
    recordings: &[Subject],
    view: Option<&SensorView>,
    options: &DetectOptions,
    progress: Option<TrialProgress<'_>>,
) -> Result<(Detection, Vec<Ray>), ExperimentError> {
    let trials = PreparedTrials::new(model, recordings, &options.diagnosis.settings)?;
    let noise = view.map(|v| &v.noise);
    let signatures = Signatures::new(model, &trials, &options.diagnosis, noise)?;
    let mut ways: Vec<(&'static dyn AnyEffect, Ray)> = Vec::new();
    for (candidate, effect, given) in asked(options)? {
        let own = rays(&signatures, candidate, effect, &given.values)?;
        ways.extend(own.into_iter().map(|ray| (effect, ray)));
    }
    let directions = signatures.directions();
    let start = |(_, ray): &(_, Ray)| (ray.candidate, ray.values(ray.first_magnitude()));
    let starts: Vec<(usize, Vec<f64>)> = ways.iter().map(start).collect();
    let apparent = signatures.apparent_half_widths(model, &trials, &starts)?;
    let mut limits: Vec<Limits> = parallel::map(ways.len(), |k| {
        let (effect, ray) = &ways[k];
        let demand = Demand {
            signatures: &signatures,
            directions: &directions,
            seed: options.diagnosis.seed,
            parameters: ray.parameters,
            power: options.power,
            level: options.level,
            apparent: &apparent[k],
        };
        let nothing = of_nothing(&signatures, ray);
        let limit = |kind| demand.limit(ray, nothing.as_ref(), kind);
        let foretold = limit(Kind::Named);
        let kept = ray.kept(*effect).into_iter().map(|(name, v)| (name.to_owned(), v)).collect();
        Limits {
            effect: ray.effect.to_owned(),
            label: ray.label(),
            parameter: ray.parameter.to_owned(),
            kept,
            parameters: ray.parameters,
            familywise: limit(Kind::Familywise),
            listed: limit(Kind::Listed),
            named: foretold,
            foretold,
            tried: None,
        }
    });
    let span = |s: &Subject| {
        let (from, to) = s.recording.span_s();
        (s.recording.name.clone(), to - from)
    };
    let spans: Vec<(String, f64)> = recordings.iter().map(span).collect();
    let count = options.trials_for(spans.iter().map(|s| s.1).sum());
    if let Some(progress) = progress.filter(|_| count > 0) {
        let row_s = options.diagnosis.settings.data.points_per_row as f64 * ResampledRecord::STEP_S;
        let measured = view.map(|v| v.measured(recordings, row_s, options.diagnosis.seed));
        let diagnosis = &options.diagnosis;
        let recordings = measured.as_deref().unwrap_or(recordings);
        let synthesis = Synthesis::new(model, recordings, diagnosis)?;
        let power = options.power;
        let trials = Trials { model, recordings, synthesis: &synthesis, diagnosis, power, count };
        let tried = tried(&trials, &ways, &limits, progress);
        for ((limits, (_, ray)), tried) in limits.iter_mut().zip(&ways).zip(tried) {
            let Some(tried) = tried else { continue };
            let magnitude = ray.not_below_weakest(tried.magnitude);
            limits.named = ray.admits(magnitude).then(|| Limit {
                value: ray.value(magnitude),
                magnitude,
                noncentrality: (signatures.of(ray.candidate, &ray.values(magnitude)))
                    .map_or(f64::NAN, |s| s.square()),
            });
            limits.tried = Some(tried);
        }
    }
    let pairs = pairs(&signatures, &ways, &limits, options);
    let a = signatures.acceptance();
    let detection = Detection {
        recordings: spans,
        noise: signatures.noise().deviations(),
        rows: a.rows,
        power: options.power,
        level: options.level,
        limits,
        pairs,
    };
    Ok((detection, ways.into_iter().map(|(_, ray)| ray).collect()))
}

/// Tries every effect that is foretold to be seen, in parallel.
fn tried(
    trials: &Trials<'_>,
    ways: &[(&'static dyn AnyEffect, Ray)],
    limits: &[Limits],
    progress: TrialProgress<'_>,
) -> Vec<Option<TriedLimit>> {
    let first = |l: &Limits| match l.listed {
        Some(listed) => Some(NAMED_OVER_LISTED * listed.magnitude),
        None => l.foretold.map(|l| l.magnitude),
    };
    let all = trials.count * limits.iter().filter(|l| first(l).is_some()).count();
    let over = AtomicUsize::new(0);
    let done = || progress(over.fetch_add(1, Ordering::Relaxed) + 1, all);
    progress(0, all);
    parallel::map(ways.len(), |k| {
        let (effect, ray) = &ways[k];
        Some(trials.of((*effect, ray), first(&limits[k])?, k, &done))
    })
}
