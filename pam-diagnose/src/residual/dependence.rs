//! The dependence of a residual on factors.

use crate::fit::{Hypothesis, Problem};
use crate::search::Candidates;

/// The share of a residual's variance that one factor explains.
#[derive(Debug, Clone, PartialEq)]
pub struct Dependence {
    /// Name of the factor.
    pub factor: String,
    /// Its unit.
    pub unit: String,
    /// Correlation ratio η², 0 to 1: variance of the means in groups of equal size over the whole variance, less the
    /// expectation for unrelated groups.
    pub share: f64,
    /// Middle of each group (in the factor's unit) and mean residual there.
    pub groups: Vec<[f64; 2]>,
}

/// Names and units of the factors of a system, and their values at the rows of all experiments. The last factor is the
/// experiment.
pub(crate) struct Factors {
    names: Vec<(String, String)>,
    columns: Vec<Vec<f64>>,
}

impl Factors {
    pub(crate) fn of<C: Candidates + ?Sized>(
        problem: &Problem<'_, C>,
        hypothesis: &Hypothesis,
        residuals: &[Vec<Vec<f64>>],
    ) -> Self {
        let mut names = problem.system.factor_names();
        let mut columns = vec![Vec::new(); names.len() + 1];
        names.push(("recording".into(), "–".into()));
        for (i, r) in residuals.iter().enumerate() {
            let rows = r.first().map_or(0, Vec::len);
            let (e, window) = (problem.experiments[i], problem.windows[i].clone());
            let local = &hypothesis.locals[i];
            let own = problem.system.factors(hypothesis, local, e, window).unwrap_or_default();
            for (column, more) in columns.iter_mut().zip(own.iter().chain([&vec![i as f64; rows]]))
            {
                column.extend(more.iter().take(rows));
            }
        }
        Self { names, columns }
    }

    /// Tests a residual against every factor, strongest first.
    pub(crate) fn dependences(
        &self,
        values: &[f64],
        rows_per_observation: f64,
        groups: usize,
    ) -> Vec<Dependence> {
        let mut all: Vec<Dependence> = self
            .names
            .iter()
            .zip(&self.columns)
            .filter(|(_, column)| column.len() == values.len())
            .map(|((factor, unit), column)| {
                let (share, groups) =
                    correlation_ratio(column, values, rows_per_observation, groups);
                Dependence { factor: factor.clone(), unit: unit.clone(), share, groups }
            })
            .collect();
        all.sort_by(|a, b| b.share.total_cmp(&a.share));
        all
    }
}

/// The correlation ratio η² of `values` in `count` groups of `factor`, less the expectation for unrelated groups if so
/// many rows are one independent observation; middle and mean of each group.
pub(super) fn correlation_ratio(
    factor: &[f64],
    values: &[f64],
    rows_per_observation: f64,
    count: usize,
) -> (f64, Vec<[f64; 2]>) {
    let n = values.len();
    let mean = values.iter().sum::<f64>() / n.max(1) as f64;
    let total: f64 = values.iter().map(|v| (v - mean).powi(2)).sum();
    let mut order: Vec<usize> = (0..n).collect();
    order.sort_by(|&a, &b| factor[a].total_cmp(&factor[b]));
    let mut distinct: Vec<f64> = order.iter().map(|&i| factor[i]).collect();
    distinct.dedup();
    let cuts: Vec<&[usize]> = if distinct.len() <= count {
        order.chunk_by(|&a, &b| factor[a] == factor[b]).collect()
    } else {
        order.chunks(n.div_ceil(count).max(1)).collect()
    };
    let mut between = 0.0;
    let groups = cuts
        .iter()
        .map(|group| {
            let size = group.len() as f64;
            let middle = group.iter().map(|&i| factor[i]).sum::<f64>() / size;
            let height = group.iter().map(|&i| values[i]).sum::<f64>() / size;
            between += size * (height - mean).powi(2);
            [middle, height]
        })
        .collect();
    let observations = (n as f64 / rows_per_observation).max(2.0);
    let by_chance = ((cuts.len() as f64 - 1.0) / observations).min(1.0);
    let share = if total > 0.0 { between / total } else { 0.0 };
    (((share - by_chance) / (1.0 - by_chance).max(1e-9)).max(0.0), groups)
}
