//! The data from which terms are learned.

use crate::data::Roles;
use crate::diagnosis::Diagnosis;
use crate::error::DiagnoseError;
use crate::fit::{Hypothesis, Member, Problem};
use crate::noise::{Noise, NoisePrior};
use crate::search::{Candidates, Rows, Work};
use crate::settings::{DiagnosisSettings, RemainderSettings};
use crate::verdict::{Cause, Verdict};
use pam_numerics::statistics::{mean, positive_mean_p_value};
use std::sync::Arc;

/// The data of a system, and the causes that are named already.
#[derive(Clone)]
pub(crate) struct Ground<'a> {
    pub(crate) roles: &'a Roles,
    pub(crate) noise: Noise,
    pub(crate) prior: NoisePrior,
    /// Named causes with their values.
    pub(crate) named: Vec<Member>,
    /// Those of them that are always there with the same value.
    pub(crate) settled: Vec<Member>,
    /// Causes that a law has to surpass.
    pub(crate) rivals: Vec<Member>,
    /// By how much, as a difference of minus two times the logarithm of the posterior probability.
    pub(crate) margin: f64,
    /// Whether a law may replace all named causes.
    pub(crate) replaceable: bool,
    /// Number of candidates of the system without any terms.
    pub(crate) listed: usize,
    /// Number of candidates from which the named causes were chosen.
    pub(crate) choices: usize,
    pub(crate) settings: &'a DiagnosisSettings,
    pub(crate) seed: u64,
    pub(crate) budget: Budget,
}

/// Simulation budget of the search for corrections and laws.
#[derive(Debug, Clone)]
pub(crate) struct Budget {
    /// Work so far, including the search for causes.
    pub(crate) work: Arc<Work>,
    /// Largest work, in integration steps of the system without causes.
    pub(crate) most_steps: f64,
}

impl Budget {
    /// No limit.
    pub(crate) fn unlimited(work: Arc<Work>) -> Self {
        Self { work, most_steps: f64::INFINITY }
    }

    /// Whether the budget is used up. Between two stages of the search the answer does not depend on the number of threads.
    pub(crate) fn is_spent(&self) -> bool {
        self.work.steps() > self.most_steps
    }
}

pub(crate) type Dyn<'s> = dyn Candidates + 's;

/// The causes of a diagnosis as members, numbered in their order: all that are named, the minor ones behind, and those of them
/// that are always there with the same value.
pub(crate) fn named_and_settled<M>(found: &Diagnosis<M>) -> (Vec<Member>, Vec<Member>) {
    let causes = || found.causes.iter().chain(&found.minor).enumerate();
    let member = |(candidate, c): (usize, &Cause)| Member { candidate, ..c.member.clone() };
    let is_settled = |c: &Cause| c.member.schedule.is_none() && c.stability_test.holds();
    (causes().map(member).collect(), causes().filter(|(_, c)| is_settled(c)).map(member).collect())
}

/// Whether a diagnosis leaves too little for a remainder: in no channel is the residual that its causes leave of training and
/// validation data above the first estimate of the noise and the errors of the model on baseline recordings by the factor that
/// its verdict asks for, and no law is to be tried in the place of its causes. It takes no simulation.
pub(crate) fn nothing_left<M>(found: &Diagnosis<M>, settings: &RemainderSettings) -> bool {
    let (named, settled) = named_and_settled(found);
    let most = most_left(found.verdict, settings);
    let some_change = settled.len() < named.len() && found.verdict != Verdict::Explained;
    let may_replace = some_change || is_replaceable(found);
    !may_replace && found.residual.channels.iter().all(|c| c.rms_left <= most * c.noise)
}

/// Whether a law may replace all causes of a diagnosis: causes that leave an error, or several causes that leave none, because
/// together they may imitate an unlisted one. Not with a single recording, whose end cannot confirm the law.
pub(crate) fn is_replaceable<M>(found: &Diagnosis<M>) -> bool {
    let least = if found.verdict == Verdict::Explained { 2 } else { 1 };
    found.causes.len() >= least && !found.test.is_last_part()
}

/// Multiple of the first estimate of the noise up to which nothing is left. Where the diagnosis found nothing, or causes that
/// leave noise alone, only an error that the learned noise has swallowed asks for more.
pub(crate) fn most_left(verdict: Verdict, settings: &RemainderSettings) -> f64 {
    match verdict {
        Verdict::Explained | Verdict::NothingFound => settings.doubt_ratio,
        _ => settings.nothing_ratio,
    }
}

impl Ground<'_> {
    /// The same for parts of the experiments with roles of their own; `whole` gives the experiment of each part.
    #[cfg(feature = "joint")]
    pub(crate) fn of_parts<'r>(&self, roles: &'r Roles, whole: &[usize]) -> Ground<'r>
    where
        Self: 'r,
    {
        let of = |members: &[Member]| -> Vec<Member> {
            let part = |m: &Member| Member {
                schedule: m.schedule.as_ref().map(|s| Arc::new(s.of_parts(whole))),
                ..m.clone()
            };
            members.iter().map(part).collect()
        };
        Ground {
            roles,
            named: of(&self.named),
            settled: of(&self.settled),
            rivals: of(&self.rivals),
            ..self.clone()
        }
    }

    /// The same with fewer causes; a law has to surpass those that were named.
    pub(crate) fn beside(&self, named: Vec<Member>) -> Self {
        let rivals = if self.rivals.is_empty() { &self.named } else { &self.rivals };
        Self { rivals: rivals.clone(), named, ..self.clone() }
    }

    /// The same beside the causes that hold.
    pub(crate) fn beside_settled(&self) -> Self {
        self.beside(self.settled.clone())
    }

    /// The same beside no cause: a law has to surpass all of them by clear odds.
    pub(crate) fn beside_none(&self) -> Self {
        let margin = 2.0 * self.settings.verdict.confusable_odds.ln();
        Self { margin, ..self.beside(Vec::new()) }
    }

    /// Training and validation rows of a system, in units of the noise; as many rows are one observation as the residual of
    /// a hypothesis is correlated over. `None` if it cannot be simulated.
    pub(crate) fn rows<'s>(
        &'s self,
        system: &'s Dyn<'s>,
        beside: &Hypothesis,
    ) -> Option<Rows<'s, Dyn<'s>>> {
        let mut rows = Rows::of(self.roles, system, &self.noise, self.prior.clone(), self.settings);
        let beside = rows.whole.with_base_locals(beside);
        rows.set_noise(&self.noise, &beside)?;
        rows.set_jacobian_reuses(self.settings.remainder.jacobian_reuses);
        Some(rows)
    }

    /// The named causes, without nuisances of any experiment.
    pub(crate) fn start(&self, system: &Dyn<'_>) -> Hypothesis {
        Hypothesis { members: self.named.clone(), ..Hypothesis::base(system, 0) }
    }
}

/// The drop of the squared error from one hypothesis to another, over blocks of time: its mean relative to that before, and
/// the probability of so large a drop by chance.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Drop {
    pub(crate) share: f64,
    pub(crate) p_value: f64,
}

/// The drop of the whitened squared error of the rows of a problem.
pub(crate) fn drop_by_blocks(
    problem: &Problem<'_, Dyn<'_>>,
    before: &Hypothesis,
    after: &Hypothesis,
) -> Result<Drop, DiagnoseError> {
    let (mut own, mut drops) = (Vec::new(), Vec::new());
    for i in 0..problem.len() {
        let [old, new] =
            [problem.squares_by_block(before, i)?, problem.squares_by_block(after, i)?];
        drops.extend(old.iter().zip(&new).map(|(old, new)| old - new));
        own.extend(old);
    }
    // Relative drops, so that one block with most of the error does not decide.
    let relative: Vec<f64> =
        drops.iter().zip(&own).map(|(d, o)| d / o.max(f64::MIN_POSITIVE)).collect();
    Ok(Drop {
        share: mean(&drops) / mean(&own).max(f64::MIN_POSITIVE),
        p_value: (2.0 * positive_mean_p_value(&relative).min(positive_mean_p_value(&drops)))
            .min(1.0),
    })
}
