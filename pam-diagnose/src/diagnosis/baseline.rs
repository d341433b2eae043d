//! The baseline discrepancy: the error of a model on recordings on which it was validated.

use crate::data::Roles;
use crate::error::DiagnoseError;
use crate::fit::{Interval, Member};
use crate::noise::{Noise, NoisePrior};
use crate::search::{Candidates, Rows, search};
use crate::settings::DiagnosisSettings;
use crate::verdict::{Cause, Naming};
use pam_vocabulary::ParameterInfo;

/// Candidates and errors of baseline recordings. A model that misses something small everywhere misses it in the
/// data under diagnosis as well; that counts as no fault.
pub(crate) struct Baseline {
    /// Candidates that the baseline recordings show; part of the model from there on.
    pub(crate) members: Vec<Member>,
    /// Standard deviation of the magnitude of each, relative to it.
    #[cfg_attr(not(feature = "joint"), expect(dead_code, reason = "the joint reads it"))]
    pub(crate) deviations: Vec<f64>,
    /// Root-mean-square errors of the fitted channels that are left then.
    pub(crate) rms: Vec<f64>,
    /// Autocovariances of the part of these errors that goes with the motion: the discrepancy of the model.
    pub(crate) discrepancy: Vec<Vec<f64>>,
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
        let (choosing, whole) =
            (roles.split(system, &noise, settings), roles.whole(system, &noise, settings));
        let mut rows = Rows::new(choosing, whole, prior);
        let found = search(&mut rows, most, seed, done).ok_or_else(diverges)?;
        let names =
            Naming { rows: &mut rows, found: &found, baseline: None, timed: None }.names()?;
        let test = roles.test(system, &rows.whole.noise, settings);
        let test = test.opened(&names.base.hypothesis)?;
        let confirmed = test.is_reduced(&names.base.hypothesis, &names.best.hypothesis);
        let best = if confirmed { &names.best.hypothesis } else { &names.base.hypothesis };
        let left = rows.whole.motion_errors(best).ok_or_else(diverges)?;
        let deviation = |m: &Member| {
            let cause = names.causes.iter().find(|c| c.member.candidate == m.candidate);
            cause.map_or(0.0, |c| relative_deviation(system, c))
        };
        Ok(Self {
            deviations: best.members.iter().map(deviation).collect(),
            members: best.members.clone(),
            rms: left.iter().map(|l| l.rms).collect(),
            discrepancy: left.into_iter().map(|l| l.autocovariance).collect(),
            noise: rows.whole.noise.clone(),
            recordings: rows.whole.names(),
        })
    }
}

/// The largest standard deviation of the magnitudes of a cause, relative to them.
fn relative_deviation(system: &dyn Candidates, cause: &Cause) -> f64 {
    let infos = system.candidate(cause.member.candidate).parameters;
    let of = |(info, (_, interval)): (&ParameterInfo, &(&str, Interval))| {
        let magnitude = (interval.value - info.off?).abs();
        let half = 0.5 * (interval.ci95[1] - interval.ci95[0]);
        Some(half / 1.96 / magnitude.max(f64::MIN_POSITIVE))
    };
    infos.iter().zip(&cause.parameters).filter_map(of).fold(0.0, f64::max)
}
