//! The explainable variance: how much of the residual a flexible model without names removes.

use crate::fit::{ChannelErrors, Hypothesis, Problem, dot};
use crate::search::Candidates;
use pam_numerics::ScaledCholesky;

/// Errors that a learned residual leaves on rows that it has not seen.
///
/// The residual of each channel is regressed, with a ridge, on the system's features
/// ([`Candidates::features`]). The flexible model has no names; it measures how much of the error there is to explain.
#[derive(Debug, Clone, PartialEq)]
pub struct ExplainableReference {
    /// Errors that it leaves.
    pub errors: ChannelErrors,
}

impl ExplainableReference {
    /// Learns the residual of a hypothesis on the first rows and predicts it on the second.
    #[must_use]
    pub fn learn<C: Candidates + ?Sized>(
        learned: (&Problem<'_, C>, &Hypothesis),
        judged: (&Problem<'_, C>, &Hypothesis),
    ) -> Option<Self> {
        let (train, test) = (Rows::gather(learned)?, Rows::gather(judged)?);
        let noise = &judged.0.noise;
        let (n, rows) = (train.features.len(), train.len() as f64);
        let gram = |i: usize, j: usize| dot(&train.features[i], &train.features[j]) / rows;
        let ridge = learned.0.settings.verdict.explainable_ridge;
        let factor = ScaledCholesky::new(n, gram, ridge)?;
        let mut errors = ChannelErrors { sums: vec![0.0; noise.len()], rows: test.len() };
        for (c, noise) in noise.iter().enumerate() {
            let right: Vec<f64> =
                train.features.iter().map(|f| dot(f, &train.residuals[c]) / rows).collect();
            let weights = factor.solve(&right)?;
            let mut left = test.residuals[c].clone();
            for (w, feature) in weights.iter().zip(&test.features) {
                left.iter_mut().zip(feature).for_each(|(l, f)| *l -= w * f);
            }
            let learned = dot(&left, &left);
            let plain = dot(&test.residuals[c], &test.residuals[c]);
            // A channel at its noise has nothing to learn.
            let lowest = noise * noise * test.len() as f64;
            errors.sums[c] = learned.min(plain).max(lowest.min(plain));
        }
        Some(Self { errors })
    }
}

/// Residuals and features of all rows of a problem.
struct Rows {
    residuals: Vec<Vec<f64>>,
    features: Vec<Vec<f64>>,
}

impl Rows {
    fn gather<C: Candidates + ?Sized>(
        (problem, hypothesis): (&Problem<'_, C>, &Hypothesis),
    ) -> Option<Self> {
        let mut residuals = vec![Vec::new(); problem.noise.len()];
        let mut features: Vec<Vec<f64>> = Vec::new();
        let points = problem.system.points_per_row();
        for i in 0..problem.len() {
            let r = problem.residuals(hypothesis, i).ok()?;
            let (e, window) = (problem.experiments[i], problem.windows[i].clone());
            let all = problem.system.features(hypothesis, &hypothesis.locals[i], e).ok()?;
            features.resize(all.len(), Vec::new());
            for (feature, series) in features.iter_mut().zip(&all) {
                let rows = series[window.clone()].chunks_exact(points);
                feature.extend(rows.map(|c| c.iter().sum::<f64>() / points as f64));
            }
            for (all, own) in residuals.iter_mut().zip(r) {
                all.extend(own);
            }
        }
        Some(Self { residuals, features })
    }

    fn len(&self) -> usize {
        self.residuals[0].len()
    }
}
