//! A flexible model of the residual that has no names: what can be learned from the motion, and what is left.

use crate::fit::{Hypothesis, Problem, dot};
use crate::noise::Autoregression;
use crate::search::Candidates;
use crate::settings::VerdictSettings;
use pam_core::parallel;
use pam_numerics::ScaledCholesky;
use std::ops::Range;

/// Residuals and features of all rows of a problem.
#[derive(Debug, Clone)]
pub struct FeatureRows {
    /// Each fitted channel over all experiments, one after another.
    pub residuals: Vec<Vec<f64>>,
    /// Each feature ([`Candidates::features`]) likewise.
    pub(crate) features: Vec<Vec<f64>>,
    /// The rows of each experiment.
    pub experiments: Vec<Range<usize>>,
}

impl FeatureRows {
    /// Residuals of a hypothesis with the features of its motion; `None` if the simulation fails.
    #[must_use]
    pub fn gather<C: Candidates + ?Sized>(
        problem: &Problem<'_, C>,
        hypothesis: &Hypothesis,
    ) -> Option<Self> {
        let points = problem.system.points_per_row();
        let of = |i: usize| {
            let (e, window) = (problem.experiments[i], problem.windows[i].clone());
            let simulated = problem.simulate(hypothesis, i).ok()?;
            let residuals = problem.residuals_of(&simulated, i);
            let local = &hypothesis.locals[i];
            let features = problem.system.features(hypothesis, local, e, &simulated).ok()?;
            let mean = |c: &[f64]| c.iter().sum::<f64>() / points as f64;
            let rows = |series: Vec<f64>| -> Vec<f64> {
                series[window.clone()].chunks_exact(points).map(mean).collect()
            };
            Some((residuals, features.into_iter().map(rows).collect::<Vec<_>>()))
        };
        let each: Option<Vec<_>> = parallel::map(problem.len(), of).into_iter().collect();
        let mut residuals = vec![Vec::new(); problem.noise.channels()];
        let mut features: Vec<Vec<f64>> = Vec::new();
        let mut experiments = Vec::new();
        let mut from = 0;
        for (i, (own_residuals, own_features)) in each?.into_iter().enumerate() {
            features.resize(own_features.len(), Vec::new());
            let all = features.iter_mut().zip(own_features);
            for (all, own) in all.chain(residuals.iter_mut().zip(own_residuals)) {
                all.extend(own);
            }
            experiments.push(from..from + problem.rows(i));
            from += problem.rows(i);
        }
        Some(Self { residuals, features, experiments })
    }

    /// Number of rows.
    #[must_use]
    pub fn len(&self) -> usize {
        self.residuals.first().map_or(0, Vec::len)
    }

    /// Whether there are no rows.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The flexible model of each channel's residual, by ordinary least squares.
    pub(crate) fn models(&self, settings: &VerdictSettings) -> Option<Vec<FlexibleModel>> {
        let of =
            |c: usize| FlexibleModel::of_settings(&self.features, &self.residuals[c], settings);
        parallel::map(self.residuals.len(), of).into_iter().collect()
    }

    /// The residual of each channel after a flexible model, which may have been learned from other rows.
    pub(crate) fn left(&self, models: &[FlexibleModel]) -> Vec<Vec<f64>> {
        let channels = models.iter().zip(&self.residuals);
        channels.map(|(model, r)| model.left(&self.features, r)).collect()
    }

    /// The rows in these ranges, each of which becomes the rows of an experiment.
    pub(crate) fn at(&self, ranges: &[Range<usize>]) -> Self {
        let of = |series: &Vec<f64>| -> Vec<f64> {
            ranges.iter().flat_map(|r| &series[r.clone()]).copied().collect()
        };
        let mut from = 0;
        let experiments = ranges.iter().map(|r| {
            let own = from..from + r.len();
            from = own.end;
            own
        });
        Self {
            residuals: self.residuals.iter().map(of).collect(),
            features: self.features.iter().map(of).collect(),
            experiments: experiments.collect(),
        }
    }

    /// The features as a channel with such noise shows them.
    fn whitened(&self, noise: &Autoregression) -> Vec<Vec<f64>> {
        let of = |f: &Vec<f64>| -> Vec<f64> {
            self.experiments.iter().flat_map(|r| noise.whitened(&f[r.clone()])).collect()
        };
        self.features.iter().map(of).collect()
    }
}

/// Factor by which the ridge is raised.
const RIDGE_STEP: f64 = 2.0;
/// Ridge at which a model has hardly any weight left.
const LARGEST_RIDGE: f64 = 1e6;

/// The regression of one channel's residual on features.
#[derive(Debug, Clone)]
pub struct FlexibleModel {
    weights: Vec<f64>,
    /// Effective number of fitted weights, the trace of the smoother `S`.
    pub weight_count: f64,
    /// Rows that the model uses up of a residual of white noise: the expected sum of squares that it leaves of `n` rows is
    /// `n − tr(2S − S²)` times their variance (Hastie, Tibshirani and Friedman, *The Elements of Statistical Learning*,
    /// §5.5).
    pub used_rows: f64,
}

impl FlexibleModel {
    /// Least squares with a ridge relative to columns of unit size, raised until the model has no more than `most_weights`
    /// effective weights; `None` if the normal equations cannot be solved.
    #[must_use]
    pub fn learn(
        features: &[Vec<f64>],
        residual: &[f64],
        ridge: f64,
        most_weights: f64,
    ) -> Option<Self> {
        let (n, rows) = (features.len(), residual.len().max(1) as f64);
        let mut gram = vec![0.0; n * n];
        for i in 0..n {
            for j in 0..=i {
                gram[i * n + j] = dot(&features[i], &features[j]) / rows;
                gram[j * n + i] = gram[i * n + j];
            }
        }
        let right: Vec<f64> = features.iter().map(|f| dot(f, residual) / rows).collect();
        let mut ridge = ridge;
        loop {
            let factor = ScaledCholesky::new(n, |i, j| gram[i * n + j], ridge)?;
            // The smoother in the space of the weights, column by column.
            let smoother: Vec<Vec<f64>> =
                gram.chunks_exact(n).map(|column| factor.solve(column)).collect::<Option<_>>()?;
            let weight_count = (0..n).map(|k| smoother[k][k]).sum::<f64>();
            if weight_count <= most_weights || ridge >= LARGEST_RIDGE {
                let square =
                    |k: usize| (0..n).map(|j| smoother[k][j] * smoother[j][k]).sum::<f64>();
                let used_rows = 2.0 * weight_count - (0..n).map(square).sum::<f64>();
                return Some(Self { weights: factor.solve(&right)?, weight_count, used_rows });
            }
            ridge *= RIDGE_STEP;
        }
    }

    /// [`learn`](Self::learn) with the ridge and the share of weights of the settings.
    fn of_settings(
        features: &[Vec<f64>],
        residual: &[f64],
        settings: &VerdictSettings,
    ) -> Option<Self> {
        let most = settings.explainable_weights * residual.len() as f64;
        Self::learn(features, residual, settings.explainable_ridge, most)
    }

    /// The residual after the learned weights.
    #[must_use]
    pub fn left(&self, features: &[Vec<f64>], residual: &[f64]) -> Vec<f64> {
        let mut left = residual.to_vec();
        for (w, feature) in self.weights.iter().zip(features) {
            left.iter_mut().zip(feature).for_each(|(l, f)| *l -= w * f);
        }
        left
    }
}

/// The residual of each whitened channel after a flexible model, on rows that it has not seen. The features are whitened as the
/// channel's own noise is, which makes this generalised least squares.
pub(crate) fn left_of_unseen<C: Candidates + ?Sized>(
    learned: (&Problem<'_, C>, &Hypothesis),
    judged: (&Problem<'_, C>, &Hypothesis),
) -> Option<Vec<Vec<f64>>> {
    let settings = &learned.0.settings.verdict;
    let noise = &judged.0.noise;
    let (train, test) =
        (FeatureRows::gather(learned.0, learned.1)?, FeatureRows::gather(judged.0, judged.1)?);
    let whitened = |rows: &FeatureRows, problem: &Problem<'_, C>, h: &Hypothesis| {
        let mut all = vec![Vec::with_capacity(rows.len()); noise.channels()];
        for i in 0..problem.len() {
            let own = problem.whitened_residuals(h, i).ok()?;
            all.iter_mut().zip(own).for_each(|(all, own)| all.extend(own));
        }
        Some(all)
    };
    let (to_learn, to_judge) =
        (whitened(&train, learned.0, learned.1)?, whitened(&test, judged.0, judged.1)?);
    (0..noise.channels())
        .map(|c| {
            let [of_train, of_test] = [&train, &test].map(|rows| rows.whitened(noise.channel(c)));
            let model = FlexibleModel::of_settings(&of_train, &to_learn[c], settings)?;
            Some(model.left(&of_test, &to_judge[c]))
        })
        .collect()
}
