//! The steps of a diagnosis.

use super::result::{Diagnosis, Explainable, SetScore, Stage};
use crate::data::{Roles, TestData};
use crate::error::DiagnoseError;
use crate::fit::{Fit, Hypothesis, Problem, fitted_outputs};
use crate::noise::{Noise, NoisePrior};
use crate::onset::{self, LateFault};
use crate::rejection::null_test::explained;
use crate::residual::ResidualSummary;
use crate::search::{Candidates, Remembered, Rows, Work, search};
use crate::settings::DiagnosisSettings;
use crate::test_set::TestSet;
use crate::verdict::{
    Anomaly, Cause, ChannelBand, Names, Naming, Refused, STRAINED, Verdict, VerdictInput,
    is_stationary, ranking, share, widen_by_unexplained,
};
use pam_core::parallel;
use std::fmt;
use std::sync::Arc;

/// A system whose experiments have their roles.
pub struct Prepared<'a> {
    /// The system with its candidates. The inference is compiled once, for any of them.
    pub system: &'a (dyn Candidates + 'a),
    /// The role of each experiment.
    pub roles: &'a Roles,
    /// First estimate of the standard deviation of the noise of each fitted channel; it is learned from there on.
    pub noise: Vec<f64>,
    /// Prior knowledge of the noise.
    pub prior: NoisePrior,
    /// Root mean squares of the errors of the model on baseline recordings that go with the motion, channel by channel; part
    /// of the prior. Empty without such recordings.
    pub baseline_discrepancy: Vec<f64>,
    /// Baseline recordings, if they were given.
    pub baseline: Option<Problem<'a, dyn Candidates + 'a>>,
    /// The settings.
    pub settings: &'a DiagnosisSettings,
    /// Seed of the null test and the bootstrap.
    pub seed: u64,
}

impl fmt::Debug for Prepared<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Prepared")
            .field("roles", self.roles)
            .field("noise", &self.noise)
            .field("prior", &self.prior)
            .field("baseline_discrepancy", &self.baseline_discrepancy)
            .field("settings", self.settings)
            .field("seed", &self.seed)
            .finish_non_exhaustive()
    }
}

impl Prepared<'_> {
    /// The first estimate of the noise with the errors of the model on baseline recordings.
    fn floor(&self) -> Vec<f64> {
        let discrepancy = self.baseline_discrepancy.iter().copied().chain(std::iter::repeat(0.0));
        self.noise.iter().zip(discrepancy).map(|(n, d)| n.hypot(d)).collect()
    }
}

/// Diagnoses any system: searches with the training and validation data, refits and names with both, and measures on the
/// test set. `model` makes the system's own part of the result from the final hypothesis.
///
/// # Errors
/// [`DiagnoseError`] if the system without any cause cannot be simulated.
pub fn run<M>(
    prepared: &Prepared<'_>,
    progress: &(dyn Fn(Stage, f64) + Sync),
    model: impl FnOnce(&Hypothesis) -> M,
) -> Result<Diagnosis<M>, DiagnoseError> {
    let (diagnosis, best) = findings(prepared, progress)?;
    Ok(diagnosis.with_model(model(&best)))
}

/// The diagnosis without the system's own part, and the final hypothesis.
fn findings(
    prepared: &Prepared<'_>,
    progress: &(dyn Fn(Stage, f64) + Sync),
) -> Result<(Diagnosis<()>, Hypothesis), DiagnoseError> {
    let Prepared { roles, settings, seed, .. } = prepared;
    let work = Arc::new(Work::default());
    let remembered = Remembered::new(prepared.system, Arc::clone(&work));
    let system: &(dyn Candidates + '_) = &remembered;
    let noise = Noise::white(&prepared.noise);
    let mut rows = Rows::of(roles, system, &noise, prepared.prior.clone(), settings);
    rows.choosing.train.check_rows("training")?;
    rows.choosing.validation.check_rows("validation")?;
    roles.test(system, &noise, settings).check_rows()?;
    // The model alone must be able to run at all.
    rows.whole.errors(&rows.whole.base())?;
    let searching = |s| progress(Stage::Searching, s);
    let found =
        search(&mut rows, settings.search.max_causes, *seed, &searching).ok_or_else(|| {
            DiagnoseError::TooLittle("the model diverges on the recordings to be fitted".into())
        })?;
    progress(Stage::Judging, 0.0);
    let baseline = prepared.baseline.as_ref();
    let mut names = Naming { rows: &mut rows, found: &found, baseline, timed: None }.names()?;
    // What begins or ends may be named as something else that is always there, or not at all.
    let in_time = onset::search(&mut rows, &names.best, &names.base, &found.starts, *seed);
    if let Some(timed) = &in_time.timed {
        let timed = Some(timed);
        let others = Naming { rows: &mut rows, found: &found, baseline, timed }.names()?;
        // Where the times are refuted, the names stand that were chosen without.
        if others.best.hypothesis.members.iter().any(|m| m.schedule.is_some()) {
            names = others;
        } else {
            rows.learn_beside(&names.best.hypothesis);
        }
    }
    widen_by_unexplained(&rows.whole, &names.best, &mut names.causes);
    progress(Stage::Judging, 0.5);
    let mut null_test = found.null_test;
    if let Some(test) = &mut null_test {
        test.named_share = explained(&rows.whole, &names.base, &names.best);
    }
    // Every decision on names is made. Only now is the test set opened.
    let open = &rows.whole;
    let base = names.base.hypothesis.clone();
    let test = roles.test(system, &open.noise, settings).opened(&base)?;
    names.best.hypothesis = test.with_own_times(&names.best.hypothesis);
    for cause in &mut names.causes {
        let own =
            names.best.hypothesis.members.iter().find(|m| {
                m.candidate == cause.member.candidate && m.schedule == cause.member.schedule
            });
        if let (Some(acts), Some(member)) = (&mut cause.acts, own) {
            acts.renew(system, member);
        }
    }
    let judged = Judged::of(&test, open, &names, prepared);
    let late = if judged.is_left() {
        test.late_fault(open, &names.best.hypothesis, &found.starts, *seed)
    } else {
        None
    };
    let (mut minor, mut causes): (Vec<Cause>, Vec<Cause>) =
        std::mem::take(&mut names.causes).into_iter().partition(|c| c.minor);
    let input = VerdictInput {
        causes: causes.len(),
        confirmed: judged.confirmed,
        untested: judged.untested.is_some(),
        reduced: judged.reduced,
        named_share: judged.explainable.named,
        left: judged.is_left(),
        doubtful: causes.iter().any(|c| !c.at_limit.is_empty() || !c.stability_test.holds())
            || !repeated(&causes).is_empty(),
        inadequate: judged.inadequate,
    };
    let verdict = Verdict::of(input, &settings.verdict);
    let mut reasons = judged.reasons(&causes, &names.best.hypothesis, &test);
    reasons.extend(late.as_ref().map(LateFault::sentence));
    if matches!(verdict, Verdict::Unconfirmed | Verdict::Unexplained) {
        let why = if judged.confirmed {
            "it removes too little of the error to stand for it"
        } else {
            "the test data do not confirm it"
        };
        let taken = causes.drain(..).chain(minor.drain(..)).map(|c| Refused {
            effect: c.effect,
            inclusion: c.inclusion,
            reason: why.to_owned(),
        });
        let taken: Vec<Refused> = taken.collect();
        names.refused.splice(0..0, taken);
    }
    if causes.is_empty() {
        names.best = names.base.clone();
    }
    names.refused.sort_by(|a, b| b.inclusion.total_cmp(&a.inclusion));
    let best = &names.best.hypothesis;
    // What all recordings share, such as the timing of the force, is the same before and after.
    let start =
        Hypothesis { shared: best.shared.clone(), ..base }.without_locals(system, open.len());
    let diagnosis = Diagnosis {
        verdict,
        reasons,
        score: SetScore {
            log_posterior: -0.5 * total(open, &names.best),
            log_odds: log_odds(open, &names),
        },
        ranking: ranking(system, &found),
        residual: ResidualSummary::of(open, &start, best, &prepared.floor()),
        error_reduction: test.error_reduction(&start, best, *seed),
        explainable: judged.explainable,
        null_test,
        onset_test: in_time.test,
        untested_change: judged.untested,
        late_fault: late,
        ladder: None,
        onset_curves: in_time.curves,
        bands: judged.bands,
        anomalies: judged.anomalies,
        refused: names.refused,
        remainder: None,
        validation: roles.validation_data.clone(),
        test: roles.test_data.clone().unwrap_or(TestData::Given { recordings: Vec::new() }),
        fitted: open.names(),
        model: (),
        noise: open.noise.deviations(),
        outputs: system.outputs().to_vec(),
        excitation_label: system.excitation_label(),
        traces: test.traces(&start, best),
        causes,
        minor,
        work_steps: work.steps(),
    };
    Ok((diagnosis, names.best.hypothesis))
}

/// Minus two times the logarithm of the posterior probability of a set that was fitted to the open rows, up to a constant,
/// with what is known of the noise beside the named set.
pub(crate) fn total<C: Candidates + ?Sized>(open: &Problem<'_, C>, fit: &Fit) -> f64 {
    let observations = (fit.errors.rows.max(2)) as f64;
    let parameters = fit.hypothesis.parameters(open.system).len() as f64;
    let members = (fit.hypothesis.members.len() - fit.hypothesis.fixed) as f64;
    let choice = 2.0 * members * (open.system.candidate_len().max(1) as f64).ln();
    // Times are chosen from many.
    let schedules = fit.hypothesis.members.iter().filter_map(|m| m.schedule.as_ref());
    let choice = choice + schedules.map(|s| 2.0 * s.choices.max(1.0).ln()).sum::<f64>();
    let limits = open.settings.search.limit_cost * fit.scales_at_limit as f64;
    observations * fit.errors.deviance_above(open.noise.discrepancy_levels())
        / open.rows_per_observation
        + open.prior_cost(&fit.hypothesis)
        + parameters * observations.ln()
        + choice
        + limits
}

/// Findings on the test data.
struct Judged {
    bands: Vec<ChannelBand>,
    anomalies: Vec<Anomaly>,
    explainable: Explainable,
    confirmed: bool,
    /// Whether they are not confirmed because the error of the simulation grows.
    grows: bool,
    /// The [change](Comparison::change) that they make to the test data, if it is too small for the score test, and training and
    /// validation data alone establish them.
    untested: Option<f64>,
    reduced: bool,
    inadequate: bool,
}

impl Judged {
    fn of<C: Candidates + ?Sized>(
        test: &TestSet<'_, C>,
        open: &Problem<'_, C>,
        names: &Names,
        prepared: &Prepared<'_>,
    ) -> Self {
        let (base, best) = (&names.base.hypothesis, &names.best.hypothesis);
        let (comparison, ((bands, mut anomalies), of_base)) = parallel::join(
            || test.compared(base, best),
            || parallel::join(|| test.bands_and_anomalies(open, best), || test.bands(open, base)),
        );
        let [before, after] = if test.problem().is_empty() {
            [&names.base, &names.best].map(|fit| fit.errors.chi_square())
        } else {
            comparison.map_or([f64::INFINITY; 2], |c| c.chi_squares)
        };
        let learnable = |band: &ChannelBand| band.ratio.powi(2) * band.learnable_share;
        let removable: f64 = of_base.iter().map(learnable).sum();
        let count = bands.len().max(1) as f64;
        let lowest = after.min(1.0);
        // Nuisances that imitate a cause against their priors do not count as the model without it.
        let plain = Hypothesis { shared: best.shared.clone(), ..base.clone() };
        let without = if comparison.is_some_and(|c| c.is_strained()) { &plain } else { base };
        let reduction = test.error_reduction(without, best, prepared.seed).overall;
        // The one that is reported, with the same timing of the force before and after.
        let reported = test.error_reduction(&plain, best, prepared.seed).overall;
        // Without a test set, names are as good as training and validation data make them.
        let settings = &prepared.settings.verdict;
        let established = are_established(open, names);
        let only_noise = bands.iter().all(|band| !band.outside);
        let confirmed = test.problem().is_empty()
            || comparison
                .is_some_and(|c| c.confirms(&reduction, established, only_noise, settings));
        let lacks_power = comparison.is_some_and(|c| c.lacks_power(settings));
        anomalies.extend(unmodelled(prepared, open, best));
        if open.prior_strain(best) > STRAINED {
            anomalies.push(Anomaly {
                kind: "start",
                channel: String::new(),
                recording: None,
                time_s: None,
                frequency_hz: None,
                description: "starts, sealed masses or offsets must be further from their measured values than their \
                              uncertainty allows"
                    .into(),
            });
        }
        Self {
            anomalies,
            explainable: Explainable {
                any_correction: share(before, before - removable / count, lowest),
                named: share(before, after, lowest),
            },
            confirmed,
            grows: comparison.is_some_and(|c| c.reduced) && !confirmed && !lacks_power,
            untested: comparison
                .filter(|_| !confirmed && lacks_power && established)
                .map(|c| c.change),
            reduced: test.problem().is_empty() || reported.ci95[0] > 0.0,
            inadequate: inadequate(prepared, open, names),
            bands,
        }
    }

    /// Whether something is left that is no noise.
    fn is_left(&self) -> bool {
        self.bands.iter().any(|b| b.outside) || !self.anomalies.is_empty()
    }

    /// Reasons against `explained`, in sentences.
    fn reasons<C: Candidates + ?Sized>(
        &self,
        causes: &[Cause],
        best: &Hypothesis,
        test: &TestSet<'_, C>,
    ) -> Vec<String> {
        let mut reasons = Vec::new();
        let names: Vec<&str> = causes.iter().map(|c| c.effect.as_str()).collect();
        let names = names.join(" and ");
        if let Some(change) = self.untested {
            reasons.push(format!(
                "the test data do not test {names}: the simulation there changes by only {change:.1} standard deviations, too little for a \
                 test of it"
            ));
        } else if !causes.is_empty() && !self.confirmed {
            let why = if self.grows {
                "the error of the simulation grows there, and its starts and masses are less likely"
            } else {
                "the error there is not proven to be smaller"
            };
            reasons.push(format!("the test data do not confirm {names}: {why}"));
        }
        if !causes.is_empty() && self.confirmed && !self.reduced {
            reasons.push(
                "beside the noise of the test data the error of the simulation is not proven to be smaller".into(),
            );
        }
        let outputs = fitted_outputs(test.problem().system);
        for (k, (band, (_, output))) in self.bands.iter().zip(outputs).enumerate() {
            if !band.outside {
                continue;
            }
            let error = if causes.is_empty() { "an error" } else { "a second error" };
            let with = test.goes_with(best, k);
            let with = with.filter(|w| w.1 > test.problem().settings.residual.mentioned_share);
            let with = with.map_or_else(String::new, |w| format!(", which goes with {}", w.0));
            reasons.push(format!(
                "{error} remains in the {}{with}: {:.2} times its noise (at most {:.2} by chance), of which a flexible \
                 model removes {:.0} %",
                output.name,
                band.ratio,
                band.upper,
                100.0 * band.learnable_share.max(0.0)
            ));
        }
        reasons.extend(self.anomalies.iter().map(|a| a.description.clone()));
        for cause in causes {
            let limits = cause.at_limit.iter();
            reasons.extend(
                limits.map(|p| format!("`{p}` of {} is at a limit of its range", cause.effect)),
            );
            let sentence = cause.stability_test.sentence(&cause.effect);
            if !sentence.is_empty() {
                reasons.push(sentence);
            }
        }
        for effect in repeated(causes) {
            reasons.push(format!(
                "{effect} is named more than once, with values of its own in each part of the data: its value is not constant"
            ));
        }
        if self.inadequate && causes.is_empty() {
            reasons.push(
                "the model's own errors on the baseline recordings are as large as the errors in these data".into(),
            );
        }
        reasons
    }
}

/// Whether training and validation data alone establish the causes of the headline: their odds against the model without causes are
/// decisive, and each magnitude is significant after a Bonferroni correction for the number of candidates. False if there are none.
fn are_established<C: Candidates + ?Sized>(open: &Problem<'_, C>, names: &Names) -> bool {
    let decisive = open.settings.verdict.confusable_odds.ln();
    let mut headline = names.causes.iter().filter(|c| !c.minor).peekable();
    headline.peek().is_some()
        && log_odds(open, names) > decisive
        && headline.all(|c| !c.may_be_chance)
}

/// Logarithm of the odds of the named causes against none.
fn log_odds<C: Candidates + ?Sized>(open: &Problem<'_, C>, names: &Names) -> f64 {
    0.5 * (total(open, &names.base) - total(open, &names.best))
}

/// Effects that are named more than once: what acts with other values at other times or in other recordings may depend on something
/// that the effect does not know.
fn repeated(causes: &[Cause]) -> Vec<&str> {
    let ids: Vec<&str> = causes.iter().map(|c| c.effect.as_str()).collect();
    let again = |k: &usize| ids[..*k].contains(&ids[*k]);
    let mut all: Vec<&str> = (0..ids.len()).filter(again).map(|k| ids[k]).collect();
    all.dedup();
    all
}

/// Channels whose noise is too much for noise: a part of their variation that goes with nothing, and that is not
/// stationary either.
fn unmodelled<C: Candidates + ?Sized>(
    prepared: &Prepared<'_>,
    open: &Problem<'_, C>,
    best: &Hypothesis,
) -> Vec<Anomaly> {
    let settings = &prepared.settings.verdict;
    let floor = prepared.floor();
    let channels = fitted_outputs(open.system).enumerate();
    let of_channel = |(k, (c, output)): (usize, (usize, &crate::search::OutputInfo))| {
        let noise = open.noise.deviation(k);
        let much = noise > settings.unmodelled_share * open.variation(c)
            && noise > settings.unmodelled_ratio * floor[k]
            && !is_stationary(open, best, k);
        let number = |v: f64| pam_core::units::significant(v, 3);
        much.then(|| Anomaly {
            kind: "unmodelled",
            channel: output.key.clone(),
            recording: None,
            time_s: None,
            frequency_hz: None,
            description: format!(
                "{} {} of the {} go with nothing that a flexible model knows, {:.0} times its noise from one row to the \
                 next",
                number(noise),
                output.unit,
                output.name,
                noise / floor[k]
            ),
        })
    };
    channels.filter_map(of_channel).collect()
}

/// Whether some channel has errors of the model on the baseline recordings that are a notable part of its variation and
/// much larger than the noise, and errors in the data that are no larger than those.
fn inadequate<C: Candidates + ?Sized>(
    prepared: &Prepared<'_>,
    open: &Problem<'_, C>,
    names: &Names,
) -> bool {
    let settings = &prepared.settings.verdict;
    let ratio = settings.inadequate_ratio;
    let own = names.base.errors.mean();
    let mut channels = fitted_outputs(open.system).zip(&prepared.baseline_discrepancy).enumerate();
    channels.any(|(c, ((output, _), &discrepancy))| {
        if discrepancy < settings.inadequate_share * open.variation(output) {
            return false;
        }
        let noise = open.noise.deviation(c);
        // The noise holds the discrepancy.
        let sensors = (noise * noise - discrepancy * discrepancy).max(0.0).sqrt();
        let error = own[c].sqrt() * noise;
        discrepancy > ratio * sensors && error > ratio * sensors && error < ratio * discrepancy
    })
}
