//! What terms would do to the residual, to first order.

use crate::error::DiagnoseError;
use crate::fit::{Hypothesis, Problem};
use crate::remainder::Dyn;
use pam_core::parallel;
use pam_numerics::dot;

/// The rows of a problem at a hypothesis, whitened and weighted, with the priors of the nuisances as further rows; everything
/// is cleared of the nuisances.
pub(crate) struct Design {
    /// Square roots of the weights of the channels.
    roots: Vec<f64>,
    /// Rows of each experiment in each channel.
    rows: Vec<usize>,
    /// An orthonormal basis of the nuisances.
    nuisances: Vec<Vec<f64>>,
    /// The residual with all that the members of the hypothesis explain, to first order.
    pub(crate) target: Vec<f64>,
    /// What each fitted parameter of the members does.
    pub(crate) own: Vec<Vec<f64>>,
    priors: usize,
}

impl Design {
    /// The rows of all experiments of a problem; members of the hypothesis are taken out again, to first order.
    pub(crate) fn at(
        problem: &Problem<'_, Dyn<'_>>,
        hypothesis: &Hypothesis,
    ) -> Result<Self, DiagnoseError> {
        let system = problem.system;
        let weights = problem.weights(&problem.errors(hypothesis)?);
        let roots: Vec<f64> = weights.iter().map(|w| w.sqrt()).collect();
        let rows: Vec<usize> = (0..problem.len()).map(|i| problem.rows(i)).collect();
        let (shared, local) = (system.shared(), system.local());
        let priors = shared.len() + local.len() * problem.len();
        let mut design = Self {
            roots,
            rows,
            nuisances: Vec::new(),
            target: Vec::new(),
            own: Vec::new(),
            priors,
        };
        let each: Result<Vec<_>, DiagnoseError> =
            parallel::map(problem.len(), |i| problem.whitened_sensitivities(hypothesis, i))
                .into_iter()
                .collect();
        let each = each?;
        let parameters = hypothesis.parameters(system);
        let count = parameters.len();
        let column = |k: usize| {
            design.joined(&each.iter().map(|s| s.columns[k].clone()).collect::<Vec<_>>())
        };
        let mut own: Vec<Vec<f64>> = (0..count).map(column).collect();
        let mut target =
            design.joined(&each.iter().map(|s| s.residuals.clone()).collect::<Vec<_>>());
        for (p, column) in parameters.iter().zip(&own) {
            let value = hypothesis.members[p.member].values[p.value];
            let present = p.info.off.filter(|_| !p.info.logarithmic).map_or(0.0, |off| value - off);
            target.iter_mut().zip(column).for_each(|(t, c)| *t += present * c);
        }
        let first_prior = target.len() - priors;
        let mut nuisances = Vec::with_capacity(priors);
        for (k, n) in shared.iter().enumerate() {
            let mut column = column(count + k);
            column[first_prior + k] = n.deviation.recip();
            target[first_prior + k] = -hypothesis.shared[k] / n.deviation;
            // One that is at its limit imitates nothing any more.
            if hypothesis.shared[k] > n.limits[0] && hypothesis.shared[k] < n.limits[1] {
                nuisances.push(column);
            }
        }
        for (i, s) in each.iter().enumerate() {
            for (k, n) in local.iter().enumerate() {
                let mut columns = vec![vec![Vec::new(); design.roots.len()]; problem.len()];
                columns[i].clone_from(&s.columns[count + shared.len() + k]);
                let mut column = design.joined(&columns);
                let at = first_prior + shared.len() + i * local.len() + k;
                column[at] = n.deviation.recip();
                target[at] = -hypothesis.locals[i][k] / n.deviation;
                nuisances.push(column);
            }
        }
        design.nuisances = orthonormal(nuisances);
        design.clear(&mut target);
        own.iter_mut().for_each(|c| design.clear(c));
        (design.target, design.own) = (target, own);
        Ok(design)
    }

    /// One column of the channels of all experiments, weighted; channels that are empty are zero.
    fn joined(&self, experiments: &[Vec<Vec<f64>>]) -> Vec<f64> {
        let mut all =
            Vec::with_capacity(self.rows.iter().sum::<usize>() * self.roots.len() + self.priors);
        for (channels, &rows) in experiments.iter().zip(&self.rows) {
            for (channel, root) in channels.iter().zip(&self.roots) {
                if channel.is_empty() {
                    all.resize(all.len() + rows, 0.0);
                } else {
                    all.extend(channel.iter().map(|v| root * v));
                }
            }
        }
        all.resize(all.len() + self.priors, 0.0);
        all
    }

    /// Takes out what the nuisances can be.
    fn clear(&self, column: &mut [f64]) {
        for basis in &self.nuisances {
            let share = dot(basis, column);
            column.iter_mut().zip(basis).for_each(|(c, b)| *c -= share * b);
        }
    }

    /// What the parameters of further candidates do beside a hypothesis, candidate by candidate; `None` for one that cannot
    /// be simulated.
    pub(crate) fn columns(
        &self,
        problem: &Problem<'_, Dyn<'_>>,
        hypothesis: &Hypothesis,
        candidates: &[(usize, Vec<f64>)],
    ) -> Vec<Option<Vec<Vec<f64>>>> {
        parallel::map(candidates.len(), |k| {
            let (candidate, values) = &candidates[k];
            let mut with = hypothesis.with(*candidate, values);
            with.fixed = hypothesis.members.len();
            let count = problem.system.candidate(*candidate).parameters.len();
            let each: Vec<_> = (0..problem.len())
                .map(|i| problem.whitened_parameter_sensitivities(&with, i).ok())
                .collect::<Option<_>>()?;
            let column = |p: usize| {
                let mut column =
                    self.joined(&each.iter().map(|s| s.columns[p].clone()).collect::<Vec<_>>());
                self.clear(&mut column);
                column
            };
            Some((0..count).map(column).collect())
        })
    }

    /// Sum of squares of a residual in each channel, without the weights.
    pub(crate) fn by_channel(&self, residual: &[f64]) -> Vec<f64> {
        let mut sums = vec![0.0; self.roots.len()];
        let mut from = 0;
        for rows in &self.rows {
            for (sum, root) in sums.iter_mut().zip(&self.roots) {
                let own = &residual[from..from + rows];
                *sum += dot(own, own) / (root * root);
                from += rows;
            }
        }
        sums
    }

    /// The same rows, cleared of the first `count` parameters of the members as well.
    pub(crate) fn beside(mut self, count: usize) -> Self {
        let own = self.own.drain(..count).collect();
        let more = orthonormal(own);
        for basis in &more {
            let columns = self.own.iter_mut().chain([&mut self.target]);
            for column in columns {
                let share = dot(basis, column);
                column.iter_mut().zip(basis).for_each(|(c, b)| *c -= share * b);
            }
        }
        self.nuisances.extend(more);
        self
    }

    /// Mean over the channels of mean squares, with the weights of the rows.
    pub(crate) fn weighted_mean(&self, squares: &[f64]) -> f64 {
        let all = self.roots.iter().zip(squares).map(|(root, s)| root * root * s);
        all.sum::<f64>() / self.roots.len().max(1) as f64
    }

    /// Number of channels.
    pub(crate) fn channels(&self) -> usize {
        self.roots.len()
    }

    /// Rows of blocks of time: `block(i)` rows of the `i`-th experiment, of all channels.
    pub(crate) fn blocks(
        &self,
        block: impl Fn(usize) -> usize,
    ) -> Vec<Vec<std::ops::Range<usize>>> {
        let (mut all, mut from) = (Vec::new(), 0);
        for (i, &rows) in self.rows.iter().enumerate() {
            let length = block(i).max(1);
            for start in (0..rows).step_by(length) {
                let end = (start + length).min(rows);
                let of = |c: usize| from + c * rows + start..from + c * rows + end;
                all.push((0..self.roots.len()).map(of).collect());
            }
            from += rows * self.roots.len();
        }
        all
    }

    /// Number of rows of a channel.
    pub(crate) fn row_count(&self) -> usize {
        self.rows.iter().sum()
    }
}

/// Modified Gram–Schmidt, twice; columns that vanish are left out.
pub(super) fn orthonormal(columns: Vec<Vec<f64>>) -> Vec<Vec<f64>> {
    let mut basis: Vec<Vec<f64>> = Vec::with_capacity(columns.len());
    for mut column in columns {
        let size = dot(&column, &column).sqrt();
        for _ in 0..2 {
            for b in &basis {
                let share = dot(b, &column);
                column.iter_mut().zip(b).for_each(|(c, b)| *c -= share * b);
            }
        }
        let left = dot(&column, &column).sqrt();
        if left > 1e-9 * size && left > 0.0 {
            column.iter_mut().for_each(|c| *c /= left);
            basis.push(column);
        }
    }
    basis
}
