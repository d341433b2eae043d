//! The search for a protocol, and what it gains.

use super::objective::{Judge, LiveCause, Objective, separations};
use super::space::{DesignLimits, Proposal, standard};
use crate::detect::{DetectOptions, Detection, GivenValues, Limits, Ray, detect_along, reference};
use crate::error::ExperimentError;
use crate::plan::planned_runs;
use pam_core::parallel;
use pam_data::Subject;
use pam_diagnose::joint::{PreparedTrials, Signatures};
use pam_diagnose::noise::Noise;
use pam_effects::ExtendedModel;
use pam_numerics::statistics::median;
use pam_rig::Protocol;
use pam_rig::sensors::SensorParameters;
use pam_vocabulary::plain_name;
use rand::SeedableRng;
use rand::rngs::ChaCha8Rng;
use serde::Serialize;

/// Limits, objective and effort of [`design`].
#[derive(Debug, Clone)]
pub struct DesignOptions {
    /// Effects and diagnosis whose limits count.
    pub detect: DetectOptions,
    /// Limits of the rig.
    pub limits: DesignLimits,
    /// What is to improve.
    pub objective: Objective,
    /// Motor and sensors of the rig.
    pub sensors: SensorParameters,
    /// The noise model for all protocols. If `None`, each protocol gets the noise of its simulated sensors.
    pub noise: Option<Noise>,
    /// Protocols that are simulated.
    pub evaluations: usize,
    /// Seed of the search.
    pub seed: u64,
}

impl Default for DesignOptions {
    fn default() -> Self {
        Self {
            detect: DetectOptions::default(),
            limits: DesignLimits::default(),
            objective: Objective::MedianLimit,
            sensors: SensorParameters::default(),
            noise: None,
            evaluations: 1200,
            seed: 1,
        }
    }
}

/// The limit of an effect under the standard and under the design.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Gain {
    /// Label of the effect.
    pub label: String,
    /// Its parameter.
    pub parameter: String,
    /// The value from which it is named under the published excitation; absent where it is not within its range.
    pub standard: Option<f64>,
    /// The same under the design.
    pub designed: Option<f64>,
    /// By how much the magnitude is lower.
    pub factor: Option<f64>,
}

/// How far a cause is from another one, over what a diagnosis needs to distinguish them with 90 % power: from 1 on it does.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Separated {
    /// Id of the cause.
    pub cause: String,
    /// Id of what may be taken for it.
    pub other: String,
    /// Under the published excitation.
    pub standard: f64,
    /// Under the design.
    pub designed: f64,
}

/// A designed protocol with what it is expected to gain; `design.json`.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Design {
    /// The protocol.
    pub protocol: Protocol,
    /// The published excitation of the same length, with which it is compared.
    pub standard: Protocol,
    /// Detection limits under both.
    pub gains: Vec<Gain>,
    /// Median of the factors by which limits are lower.
    pub median_factor: f64,
    /// Separation of live causes under both.
    pub separations: Vec<Separated>,
    /// Protocols that were simulated.
    pub evaluations: usize,
    /// Limits and confusions under the design.
    #[serde(skip)]
    pub detection: Detection,
}

impl Design {
    /// Whether the design distinguishes every live cause from the others; `None` without live causes.
    #[must_use]
    pub fn separates(&self) -> Option<bool> {
        let enough = |s: &Separated| s.designed >= 1.0;
        (!self.separations.is_empty()).then(|| self.separations.iter().all(enough))
    }

    /// What is expected of it, in a sentence.
    #[must_use]
    pub fn sentence(&self) -> String {
        let left: Vec<String> = self
            .separations
            .iter()
            .filter(|s| s.designed < 1.0)
            .map(|s| {
                let share = 100.0 * s.designed;
                format!(
                    "{} and {} ({share:.0} % of the distance needed)",
                    plain_name(&s.cause),
                    plain_name(&s.other)
                )
            })
            .collect();
        match self.separates() {
            None if self.median_factor < WORTH => format!(
                "No protocol that was found within these limits lowers the detection limits notably (median {:.2} times those under \
                 the published excitation of the same length).",
                1.0 / self.median_factor
            ),
            None => format!(
                "Detection limits are expected to be lower by a factor of {:.1} (median) than under the published excitation of \
                 the same length.",
                self.median_factor
            ),
            Some(true) => "The design is expected to distinguish all live causes.".into(),
            Some(false) => format!(
                "No protocol that was found within these limits distinguishes {}: this rig cannot distinguish them in this time.",
                left.join(", ")
            ),
        }
    }
}

/// Median factor of the detection limits from which a design is an improvement in words.
const WORTH: f64 = 1.05;
/// Proposals of a generation: the same at any number of threads.
const GENERATION: usize = 8;
/// Share of the evaluations that are drawn at random.
const RANDOM_SHARE: f64 = 0.2;
/// Best proposals of a lineage that are mutated.
const PARENTS: usize = 2;
/// Shares of the evaluations from which so many lineages go on, each from one of the best random proposals: they end in optima of
/// their own, and the better half goes on (successive halving; Jamieson and Talwalkar 2016).
const LINEAGES: [(f64, usize); 3] = [(RANDOM_SHARE, 4), (0.5, 2), (0.75, 1)];

/// Searches a protocol within the limits.
///
/// # Errors
/// [`ExperimentError`] if the model cannot be simulated under the published excitation, a live cause is no candidate with all
/// of its values, or no protocol that is tried stays within the limits.
pub fn design(
    model: &ExtendedModel,
    options: &DesignOptions,
    progress: &(dyn Fn(f64) + Sync),
) -> Result<Design, ExperimentError> {
    options.objective.check(&options.detect.diagnosis.candidates)?;
    let standard = standard(&options.limits);
    let recordings = simulated(model, &standard, options)?;
    let mut judge = Judge {
        model,
        options: &options.detect.diagnosis,
        sensors: &options.sensors,
        noise: options.noise.as_ref(),
        objective: &options.objective,
        ways: Vec::new(),
        limits: &options.limits,
        seed: options.seed,
    };
    let view = judge.view(&recordings)?;
    let compared = compared(options);
    let (before, rays) = detect_along(model, &recordings, Some(&view), &compared, None)?;
    // Proposals are compared by the effects at their limits under the standard.
    let at_limit = |(ray, limits): (Ray, &Limits)| {
        let magnitude = reference(limits, &ray);
        (ray, magnitude)
    };
    judge.ways = rays.into_iter().zip(&before.limits).map(at_limit).collect();
    let best = search(&judge, &standard, options, progress).ok_or_else(|| {
        let tried = options.evaluations;
        let message = format!("none of the {tried} protocols that were tried stays within them");
        ExperimentError::setting("limits", message)
    })?;
    let protocol = best.protocol("design");
    let after_recordings = simulated(model, &protocol, options)?;
    let after_view = judge.view(&after_recordings)?;
    let (after, _) = detect_along(model, &after_recordings, Some(&after_view), &compared, None)?;
    let gains = gains(&before, &after);
    let factors: Vec<f64> = gains.iter().filter_map(|g| g.factor).collect();
    let separations = match &options.objective {
        Objective::Separation(live) => {
            let sides = [(&recordings, &view.noise), (&after_recordings, &after_view.noise)];
            separated(model, sides, options, live)?
        }
        _ => Vec::new(),
    };
    Ok(Design {
        protocol,
        standard,
        gains,
        median_factor: if factors.is_empty() { f64::NAN } else { median(&factors) },
        separations,
        evaluations: options.evaluations,
        detection: after,
    })
}

/// The effects whose limits are compared: of a separation those that are live.
fn compared(options: &DesignOptions) -> DetectOptions {
    let Objective::Separation(live) = &options.objective else { return options.detect.clone() };
    let mut places: Vec<usize> =
        live.iter().flat_map(|l| l.others.iter().map(|o| o.0).chain([l.cause.0])).collect();
    places.sort_unstable();
    places.dedup();
    let given = |k: usize| GivenValues {
        effect: options.detect.diagnosis.candidates[k].info().id.to_owned(),
        values: Vec::new(),
    };
    DetectOptions { effects: places.into_iter().map(given).collect(), ..options.detect.clone() }
}

fn simulated(
    model: &ExtendedModel,
    protocol: &Protocol,
    options: &DesignOptions,
) -> Result<Vec<Subject>, ExperimentError> {
    let rate_hz = options.sensors.clock.rate_hz;
    let runs = planned_runs(protocol, &options.sensors.motor, rate_hz, options.seed)?;
    runs.iter().map(|run| run.simulated(model)).collect()
}

fn search(
    judge: &Judge<'_>,
    standard: &Protocol,
    options: &DesignOptions,
    progress: &(dyn Fn(f64) + Sync),
) -> Option<Proposal> {
    let limits = &options.limits;
    let mut random = ChaCha8Rng::seed_from_u64(options.seed ^ 0x0de5_1691);
    let all = options.evaluations.max(GENERATION);
    let judged = |proposals: Vec<Proposal>| -> Vec<(f64, Proposal)> {
        let worths = parallel::map(proposals.len(), |k| {
            let proposal = &proposals[k];
            if proposal.longest_hold_s() > limits.hold_s {
                return f64::NEG_INFINITY;
            }
            judge.worth(&proposal.protocol("design"))
        });
        worths.into_iter().zip(proposals).collect()
    };
    let best_first = |of: &mut Vec<(f64, Proposal)>| of.sort_by(|a, b| b.0.total_cmp(&a.0));
    let mut made = 0;
    let mut drawn = vec![(judge.worth(standard), Proposal::of(standard))];
    while (made as f64) < RANDOM_SHARE * all as f64 {
        let count = GENERATION.min(all - made);
        drawn.extend(judged((0..count).map(|_| Proposal::random(limits, &mut random)).collect()));
        made += count;
        progress(made as f64 / all as f64);
    }
    best_first(&mut drawn);
    let mut lineages: Vec<Vec<(f64, Proposal)>> = drawn.into_iter().map(|one| vec![one]).collect();
    while made < all {
        let share = made as f64 / all as f64;
        let kept = LINEAGES.iter().rev().find(|(from, _)| share >= *from).map_or(1, |l| l.1);
        lineages.sort_by(|a, b| b[0].0.total_cmp(&a[0].0));
        lineages.truncate(kept);
        let count = GENERATION.min(all - made);
        let mutated = |k: usize| {
            let own = &lineages[k % lineages.len()];
            own[(k / lineages.len()) % own.len()].1.mutated(limits, &mut random)
        };
        let generation = judged((0..count).map(mutated).collect());
        let among = lineages.len();
        for (k, one) in generation.into_iter().enumerate() {
            lineages[k % among].push(one);
        }
        for own in &mut lineages {
            best_first(own);
            own.truncate(PARENTS);
        }
        made += count;
        progress(made as f64 / all as f64);
    }
    let best = lineages.into_iter().flatten().max_by(|a, b| a.0.total_cmp(&b.0));
    best.filter(|(worth, _)| *worth > f64::NEG_INFINITY).map(|(_, proposal)| proposal)
}

fn gains(before: &Detection, after: &Detection) -> Vec<Gain> {
    let of = |own: &crate::detect::Limits| {
        let other = after.of(&own.label).and_then(|l| l.named);
        let factor = own.named.zip(other).map(|(a, b)| a.magnitude / b.magnitude);
        Gain {
            label: own.label.clone(),
            parameter: own.parameter.clone(),
            standard: own.value(),
            designed: other.map(|l| l.value),
            factor,
        }
    };
    before.limits.iter().map(of).collect()
}

/// The separations of live causes under the standard and the design, each with its noise.
fn separated(
    model: &ExtendedModel,
    sides: [(&Vec<Subject>, &Noise); 2],
    options: &DesignOptions,
    live: &[LiveCause],
) -> Result<Vec<Separated>, ExperimentError> {
    let diagnosis = &options.detect.diagnosis;
    let id = |candidate: usize| diagnosis.candidates[candidate].info().id.to_owned();
    let mut sides = sides.into_iter().map(|(side, noise)| {
        let trials = PreparedTrials::new(model, side, &diagnosis.settings)?;
        let signatures = Signatures::of_all(model, &trials, diagnosis, Some(noise))?;
        Ok(live.iter().flat_map(|c| separations(&signatures, &diagnosis.candidates, c)).collect())
    });
    let mut side =
        || -> Result<Vec<f64>, ExperimentError> { sides.next().unwrap_or(Ok(Vec::new())) };
    let (standard, designed) = (side()?, side()?);
    let pairs = live.iter().flat_map(|l| l.others.iter().map(|o| (l.cause.0, o.0)));
    let all = pairs.zip(standard.into_iter().zip(designed));
    let one = |((cause, other), (standard, designed))| Separated {
        cause: id(cause),
        other: id(other),
        standard,
        designed,
    };
    Ok(all.map(one).collect())
}
