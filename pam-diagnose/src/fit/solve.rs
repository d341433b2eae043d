//! Levenberg–Marquardt.

use super::hypothesis::{Common, Hypothesis, Local, coordinate, from_coordinate};
use super::likelihood::ChannelErrors;
use super::normal::Joint;
use super::problem::Problem;
use pam_effects::simulation::Diverged;
use rayon::prelude::*;

/// A hypothesis at its best fit.
#[derive(Debug, Clone)]
pub struct Fit<'e> {
    /// The hypothesis with fitted values.
    pub hypothesis: Hypothesis<'e>,
    /// Errors on the fitted rows.
    pub errors: ChannelErrors,
    /// What was minimised: [`Problem::cost`].
    pub cost: f64,
    /// Names of parameters that ended at a limit of their range.
    pub at_limit: Vec<&'static str>,
    /// Whether the last step was small.
    pub converged: bool,
}

impl Fit<'_> {
    /// Number of scales (lengths, times, cutoffs) that ended at the limit of their range.
    #[must_use]
    pub fn scales_at_limit(&self) -> usize {
        let parameters = self.hypothesis.parameters();
        let scale = |name: &&&str| {
            parameters.iter().any(|(_, info)| info.logarithmic && info.name == **name)
        };
        self.at_limit.iter().filter(scale).count()
    }
}

/// Rows that count as one independent observation, for the balance between data and ties: half a
/// second. Misfit of a model is correlated over about that long.
const ROWS_PER_OBSERVATION: f64 = 25.0;

impl Problem<'_> {
    /// Minus two times the log-likelihood of the data and of the uncertain numbers:
    /// `(rows/25) Σ_c ln(MSE_c + floor_c²) + Σ (deviation/tolerance)²`.
    #[must_use]
    pub fn cost(&self, hypothesis: &Hypothesis<'_>, errors: &ChannelErrors) -> f64 {
        let data = errors.rows as f64 / ROWS_PER_OBSERVATION * errors.deviance(&self.floors);
        data + self.tie_cost(hypothesis)
    }

    fn tie_cost(&self, hypothesis: &Hypothesis<'_>) -> f64 {
        let cost = |deviations: &[f64], scales: &[f64]| -> f64 {
            deviations.iter().zip(scales).map(|(d, s)| (d / s).powi(2)).sum()
        };
        let (common, local) = (self.tolerances.common(), self.tolerances.local());
        let locals = hypothesis.locals.iter().map(|l| cost(&l.values(), &local));
        cost(&hypothesis.common.values(), &common) + locals.sum::<f64>()
    }

    /// Weights of the channels at given errors.
    pub(crate) fn weights(&self, errors: &ChannelErrors) -> [f64; 3] {
        let mean = errors.mean();
        [0, 1, 2].map(|c| {
            let floor = self.floors.0[c];
            1.0 / (ROWS_PER_OBSERVATION * (mean[c] + floor * floor))
        })
    }

    /// Normal equations at a hypothesis whose errors are known.
    pub(super) fn linearised(
        &self,
        hypothesis: &Hypothesis<'_>,
        errors: &ChannelErrors,
    ) -> Result<Joint, Diverged> {
        let weights = self.weights(errors);
        let parts: Result<Vec<_>, Diverged> = (0..self.len())
            .into_par_iter()
            .map(|i| Ok(self.normal(i, &self.sensitivities(hypothesis, i)?, weights)))
            .collect();
        Ok(self.joint(hypothesis, &parts?))
    }

    /// Moves a hypothesis towards its best fit in at most `iterations` steps.
    ///
    /// # Errors
    /// [`Diverged`] if the simulation diverges at the start.
    pub fn fit<'e>(&self, start: Hypothesis<'e>, iterations: usize) -> Result<Fit<'e>, Diverged> {
        let mut best = start;
        let mut errors = self.errors(&best)?;
        let mut cost = self.cost(&best, &errors);
        let mut damping = 1e-3;
        let mut converged = false;
        for _ in 0..iterations {
            let joint = self.linearised(&best, &errors)?;
            let mut gained = 0.0;
            for _ in 0..4 {
                let step = joint.step_within(damping, &best);
                let moved = step.map(|step| moved(&best, &step));
                let tried = moved.and_then(|h| self.errors(&h).ok().map(|e| (h, e)));
                if let Some((next, next_errors)) = tried {
                    let next_cost = self.cost(&next, &next_errors);
                    if next_cost < cost {
                        gained = cost - next_cost;
                        (best, errors, cost) = (next, next_errors, next_cost);
                        damping = (damping * 0.2).max(1e-9);
                        break;
                    }
                }
                damping *= 12.0;
            }
            if gained < 0.05 {
                converged = true;
                break;
            }
        }
        let at_limit = best
            .parameters()
            .iter()
            .filter(|(at, info)| {
                let [low, high] = info.range;
                let margin = 1e-9 * (high - low);
                best.values[*at] <= low + margin || best.values[*at] >= high - margin
            })
            .map(|(_, info)| info.name)
            .collect();
        Ok(Fit { hypothesis: best, errors, cost, at_limit, converged })
    }
}

/// The hypothesis after a step in the joint unknowns.
fn moved<'e>(from: &Hypothesis<'e>, step: &[f64]) -> Hypothesis<'e> {
    let mut to = from.clone();
    let parameters = from.parameters();
    for ((at, info), change) in parameters.iter().zip(step) {
        // A scale moves by at most a factor of three in one step.
        let change = if info.logarithmic { change.clamp(-1.1, 1.1) } else { *change };
        let value = coordinate(from.values[*at], *info) + change;
        to.values[*at] = from_coordinate(value, *info);
    }
    let (common, locals) = step[parameters.len()..].split_at(Common::LEN);
    let mut values = from.common.values();
    values.iter_mut().zip(common).for_each(|(v, d)| *v += d);
    to.common = Common::from_values(&values);
    for (local, change) in to.locals.iter_mut().zip(locals.chunks_exact(Local::LEN)) {
        let mut values = local.values();
        values.iter_mut().zip(change).for_each(|(v, d)| *v += d);
        *local = Local::from_values(&values);
    }
    to
}
