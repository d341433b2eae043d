//! The baseline discrepancy: the error of a model on recordings on which it was validated.

use crate::data::Roles;
use crate::error::DiagnoseError;
use crate::fit::{Hypothesis, Interval, Member, Problem};
use crate::noise::{Discrepancy, MotionErrors, Noise, NoisePrior};
use crate::search::{Candidates, Nuisance, Rows, search};
use crate::settings::DiagnosisSettings;
use crate::verdict::{Cause, Naming};
use pam_core::parallel;
use pam_numerics::dot;
use pam_vocabulary::ParameterInfo;

/// Candidates and errors of baseline recordings. A model that misses something small everywhere misses it in the
/// data under diagnosis as well; that counts as no fault.
pub(crate) struct Baseline {
    /// Candidates that the baseline recordings show; part of the model from there on.
    pub(crate) members: Vec<Member>,
    /// Standard deviation of the magnitude of each, relative to it.
    #[cfg_attr(not(feature = "joint"), expect(dead_code, reason = "the joint reads it"))]
    pub(crate) deviations: Vec<f64>,
    /// By how much the deviations of the experiments' own nuisances have to be wider for these recordings: a model with
    /// a wrong force needs other sealed masses than the measured ones, with and without a fault.
    pub(crate) local_widenings: Vec<f64>,
    /// Root-mean-square errors of the fitted channels that are left then.
    pub(crate) rms: Vec<f64>,
    /// The part of these errors that goes with the motion.
    pub(crate) discrepancy: Discrepancy,
    /// The noise of the recordings.
    pub(crate) noise: Noise,
    /// Names of the recordings.
    pub(crate) recordings: Vec<String>,
}

impl Baseline {
    /// Learns the discrepancy from experiments, of which a test set confirms what is found.
    pub(crate) fn learn(
        system: &dyn Candidates,
        roles: &Roles,
        noise: &[f64],
        prior: NoisePrior,
        settings: &DiagnosisSettings,
        seed: u64,
        done: &(dyn Fn(f64) + Sync),
    ) -> Result<Self, DiagnoseError> {
        let most = settings.search.max_causes.max(settings.verdict.baseline_causes);
        let diverges =
            || DiagnoseError::TooLittle("the model diverges on the baseline recordings".into());
        let noise = Noise::white(noise);
        let mut rows = Rows::of(roles, system, &noise, prior, settings);
        let found = search(&mut rows, most, seed, done).ok_or_else(diverges)?;
        let names =
            Naming { rows: &mut rows, found: &found, baseline: None, timed: None }.names()?;
        let test = roles.test(system, &rows.whole.noise, settings);
        let test = test.opened(&names.base.hypothesis)?;
        let confirmed = test.is_reduced(&names.base.hypothesis, &names.best.hypothesis);
        let best = if confirmed { &names.best.hypothesis } else { &names.base.hypothesis };
        let unseen = errors_of_unseen(&rows.whole, test.problem(), best);
        let left = match unseen {
            Some(left) => left,
            None => rows.whole.motion_errors(best).ok_or_else(diverges)?,
        };
        let mut discrepancy = Discrepancy { covariances: left.covariances, levels: Vec::new() };
        discrepancy.levels =
            levels(&rows.whole, best, &rows.prior_with(&discrepancy)).ok_or_else(diverges)?;
        let deviation = |m: &Member| {
            let cause = names.causes.iter().find(|c| c.member.candidate == m.candidate);
            cause.map_or(0.0, |c| relative_deviation(system, c))
        };
        Ok(Self {
            deviations: best.members.iter().map(deviation).collect(),
            members: best.members.clone(),
            local_widenings: Nuisance::widenings(system.local(), &best.locals),
            rms: left.rms,
            discrepancy,
            noise: rows.whole.noise.clone(),
            recordings: rows.whole.names(),
        })
    }
}

/// The mean square of the whitened residual of each channel beside the noise with the model's own errors, of the recording where it is
/// largest.
fn levels<C: Candidates + ?Sized>(
    open: &Problem<'_, C>,
    best: &Hypothesis,
    prior: &NoisePrior,
) -> Option<Vec<f64>> {
    let noise = Noise::learned(open, best, prior)?;
    let mut problem = open.clone();
    problem.noise = noise;
    let mut largest = vec![0.0_f64; problem.noise.channels()];
    for i in 0..problem.len() {
        let white = problem.whitened_residuals(best, i).ok()?;
        for (largest, own) in largest.iter_mut().zip(&white) {
            *largest = largest.max(dot(own, own) / own.len().max(1) as f64);
        }
    }
    Some(largest)
}

/// The errors that go with the motion in recordings to which the members of a hypothesis were not fitted: in each `open` one after a
/// fit to the others, and in the `test` ones; the mean over recordings. In the recordings to which they were
/// fitted members take errors of the model that are others elsewhere. Of a recording the smaller error counts, with or without the
/// members, since other recordings need not have all of them. `None` without members, or where there is no unseen recording.
fn errors_of_unseen<C: Candidates + ?Sized>(
    open: &Problem<'_, C>,
    test: &Problem<'_, C>,
    best: &Hypothesis,
) -> Option<MotionErrors> {
    if best.members.is_empty() {
        return None;
    }
    let search = &open.settings.search;
    let errors = |part: &Problem<'_, C>, from: &Hypothesis, members: &[Member]| {
        let members = members.to_vec();
        let held = Hypothesis { fixed: members.len(), members, ..part.base() };
        let held = Hypothesis { shared: from.shared.clone(), ..held };
        let fit = part.fit(held, search.first_iterations).ok()?;
        Some((fit.cost, part.motion_errors(&fit.hypothesis)?))
    };
    let better = |part: &Problem<'_, C>, from: &Hypothesis| {
        let [with, without] = [&from.members[..], &[]].map(|members| errors(part, from, members));
        let both = [with, without].into_iter().flatten();
        both.min_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, errors)| errors)
    };
    let of_open = |i: usize| {
        let others = open.others(i);
        let locals = best.locals.iter().enumerate().filter(|(k, _)| *k != i);
        let locals = locals.map(|(_, l)| l.clone()).collect();
        let from =
            others.fit(Hypothesis { locals, ..best.clone() }, search.tried_iterations).ok()?;
        better(&open.part(i, open.windows[i].clone()), &from.hypothesis)
    };
    let test = test.as_fitted();
    let several = if open.len() > 1 { open.len() } else { 0 };
    let mut all: Vec<MotionErrors> =
        parallel::map(several, of_open).into_iter().flatten().collect();
    let of_test = |i: usize| better(&test.part(i, test.windows[i].clone()), best);
    all.extend(parallel::map(test.len(), of_test).into_iter().flatten());
    MotionErrors::means(&all)
}

/// The largest standard deviation of the magnitudes of a cause, relative to them.
fn relative_deviation(system: &dyn Candidates, cause: &Cause) -> f64 {
    let infos = system.candidate(cause.member.candidate).parameters;
    let of = |(info, (_, interval)): (&ParameterInfo, &(&str, Interval))| {
        let magnitude = (interval.value - info.off?).abs();
        Some(interval.deviation() / magnitude.max(f64::MIN_POSITIVE))
    };
    infos.iter().zip(&cause.parameters).filter_map(of).fold(0.0, f64::max)
}
