//! What effects would do to the residuals that a diagnosis reads, cleared of what the nuisances can imitate.

use super::diagnose::{DiagnoseOptions, RecordingSets, resampled};
use super::spans::{roles, spans};
use super::system::JointSystem;
use crate::data::{OpenPart, Roles, TestSource};
use crate::error::DiagnoseError;
use crate::fit::{Hypothesis, Member, Problem, dot};
use crate::linearised::{Column, all_starts};
use crate::noise::Noise;
use crate::search::{Candidates, Nuisance, Rows};
use crate::settings::DiagnosisSettings;
use crate::test_set::CLEAR_PRIOR_COST;
use crate::verdict::Apparent;
use pam_core::parallel;
use pam_data::Subject;
use pam_effects::effects::DataScales;
use pam_effects::model::ExtendedModel;
use pam_effects::simulation::Trial;
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};
use std::ops::Range;

/// Share of its size that a nuisance column must keep beside the columns before it.
const OWN_SHARE: f64 = 1e-10;
/// Most iterations of the fits from which apparent values come.
const APPARENT_ITERATIONS: usize = 2;

/// Recordings made ready for simulation.
#[derive(Debug)]
pub struct PreparedTrials(Vec<Trial>);

impl PreparedTrials {
    /// Prepares recordings as [`diagnose`](super::diagnose()) does; all of their force counts as acting.
    ///
    /// # Errors
    /// [`DiagnoseError`] if a recording is too long to be simulated, or the model too fast.
    pub fn new(
        model: &ExtendedModel,
        subjects: &[Subject],
        settings: &DiagnosisSettings,
    ) -> Result<Self, DiagnoseError> {
        let subjects: Vec<&Subject> = subjects.iter().collect();
        Ok(Self(resampled(model, &subjects, settings)?))
    }
}

/// The change of all whitened residuals by an effect, less the part that nuisances can imitate.
#[derive(Debug, Clone, PartialEq)]
pub struct Signature(Vec<f64>);

impl Signature {
    /// Its square `‖s‖²`: the expected drop of the whitened squared residual when the effect is at work and fitted, beyond
    /// what its free parameters explain of the noise (a noncentrality).
    #[must_use]
    pub fn square(&self) -> f64 {
        dot(&self.0, &self.0)
    }

    /// Inner product with another one of the same [`Signatures`].
    #[must_use]
    pub fn dot(&self, other: &Self) -> f64 {
        dot(&self.0, &other.0)
    }

    /// The difference from another one of the same [`Signatures`].
    #[must_use]
    pub fn less(&self, other: &Self) -> Self {
        Self(self.0.iter().zip(&other.0).map(|(a, b)| a - b).collect())
    }

    /// The unit vector along it; `None` if it is zero.
    #[must_use]
    pub fn unit(&self) -> Option<Self> {
        let size = self.square().sqrt();
        (size > 0.0).then(|| Self(self.0.iter().map(|v| v / size).collect()))
    }

    /// The part that is orthogonal to a span of signatures.
    #[must_use]
    pub fn beside(&self, span: &SignatureSpan) -> Self {
        let mut left = self.0.clone();
        clear(&mut left, &span.0);
        Self(left)
    }
}

/// The linear span of signatures, by an orthonormal basis.
#[derive(Debug, Clone)]
pub struct SignatureSpan(Vec<Part>);

impl SignatureSpan {
    /// The span of some signatures.
    #[must_use]
    pub fn of(signatures: &[Signature]) -> Self {
        let mut basis = Vec::new();
        for signature in signatures {
            extend(&mut basis, 0, signature.0.clone());
        }
        Self(basis)
    }
}

/// What a diagnosis of these recordings asks of a cause; see [`DiagnosisSettings`](crate::DiagnosisSettings).
#[derive(Debug, Clone, PartialEq)]
pub struct Acceptance {
    /// Rows of each channel that may train or validate.
    pub rows: usize,
    /// Fitted channels.
    pub channels: usize,
    /// Number of candidates.
    pub candidates: usize,
    /// Whitened rows that count as one observation.
    pub rows_per_observation: f64,
    /// Logarithm of the odds that a cause must reach.
    pub log_odds: f64,
    /// Quantile of the largest score by chance that must be exceeded.
    pub null_quantile: f64,
    /// A cause that removes less than this share of the squared residual is minor,
    pub minor_of_residual: f64,
    /// unless the mean square of some channel rises by this without it, in variances of its noise.
    pub minor_rise: f64,
    /// or unless the nuisances, which imitate it in its place, then lie further from their priors than this sum of squares of
    /// deviations over prior standard deviations.
    pub most_prior_square: f64,
    /// Drop of the cost of the nuisances on the test data that confirms a cause by itself.
    pub clear_prior_cost: f64,
    /// Probability by chance below which the direction of the test residual confirms a cause.
    pub score_p_value: f64,
    /// Odds below which another candidate is confusable with a cause.
    pub confusable_odds: f64,
    /// Share of what a cause removes from which another candidate is confusable with it.
    pub confusable_share: f64,
}

impl Acceptance {
    /// The price of a set: `p ln n + 2 ln K` for `p` parameters of one of `K` candidates.
    #[must_use]
    pub fn price(&self, parameters: usize) -> f64 {
        parameters as f64 * (self.rows.max(2) as f64).ln()
            + 2.0 * (self.candidates.max(1) as f64).ln()
    }
}

/// A part of a column of all rows: it begins at a row and is zero elsewhere.
#[derive(Debug, Clone)]
struct Part {
    from: usize,
    values: Vec<f64>,
}

/// A shared nuisance with limits: its column, cleared of those without, and how far it may move.
#[derive(Debug, Clone)]
struct Limited {
    column: Vec<f64>,
    room: [f64; 2],
}

/// Takes an orthonormal basis out of a column.
fn clear(column: &mut [f64], basis: &[Part]) {
    for part in basis {
        remove(&mut column[part.from..part.from + part.values.len()], &part.values);
    }
}

/// Takes the direction of a unit vector out of another.
fn remove(column: &mut [f64], unit: &[f64]) {
    let share = dot(column, unit);
    column.iter_mut().zip(unit).for_each(|(o, b)| *o -= share * b);
}

/// Adds a column, which begins at a row, to an orthonormal basis, unless it is in its span.
fn extend(basis: &mut Vec<Part>, from: usize, mut column: Vec<f64>) {
    let size = dot(&column, &column);
    if size <= 0.0 || !size.is_finite() {
        return;
    }
    let to = from + column.len();
    // Twice is enough (Kahan; Giraud and others 2005).
    for _ in 0..2 {
        for part in basis.iter() {
            // Columns of one experiment overlap with those of the same one alone.
            if part.from >= from && part.from + part.values.len() <= to {
                remove(&mut column[part.from - from..][..part.values.len()], &part.values);
            }
        }
    }
    let left = dot(&column, &column);
    if left > OWN_SHARE * size {
        let scale = left.sqrt().recip();
        column.iter_mut().for_each(|v| *v *= scale);
        basis.push(Part { from, values: column });
    }
}

/// Recordings, real or simulated, with the noise of a diagnosis, and the signatures of effects in them.
///
/// A signature is the difference between the simulations with and without the effect, whitened by the noise, on the rows
/// that train and validate, less its projection on the sensitivities by all nuisances with their priors (masses, start,
/// timing, the model's own numbers): `‖s‖²` is the information on the effect by the Schur complement of the nuisances,
/// and it is that of the simulation itself, not of a tangent.
pub struct Signatures<'a> {
    system: JointSystem<'a>,
    options: &'a DiagnoseOptions,
    noise: Noise,
    experiments: Vec<usize>,
    windows: Vec<Range<usize>>,
    base: Hypothesis,
    nuisances: Vec<Part>,
    limited: Vec<Limited>,
    plain: Vec<f64>,
    acceptance: Acceptance,
}

impl<'a> Signatures<'a> {
    /// Signatures in recordings. The noise is learned beside the base model as a diagnosis does, unless it is given: then
    /// the recordings are taken as they are simulated, with all nuisances at their means.
    ///
    /// # Errors
    /// [`DiagnoseError`] if there is too little data or the model diverges on them.
    pub fn new(
        model: &ExtendedModel,
        trials: &'a PreparedTrials,
        options: &'a DiagnoseOptions,
        noise: Option<&Noise>,
    ) -> Result<Self, DiagnoseError> {
        let all: Vec<&Trial> = trials.0.iter().collect();
        let roles = roles(&all, &RecordingSets::default(), options)?;
        Self::with_roles(model, trials, options, noise, &roles)
    }

    /// The same with all recordings in training and validation, for a comparison of excitations of which none is held out.
    ///
    /// # Errors
    /// As [`new`](Self::new).
    pub fn of_all(
        model: &ExtendedModel,
        trials: &'a PreparedTrials,
        options: &'a DiagnoseOptions,
        noise: Option<&Noise>,
    ) -> Result<Self, DiagnoseError> {
        let all: Vec<&Trial> = trials.0.iter().collect();
        let (spans, data) = (spans(&all), &options.settings.data);
        let roles = Roles::assign(&spans, TestSource::Absent, data)?;
        Self::with_roles(model, trials, options, noise, &roles)
    }

    fn with_roles(
        model: &ExtendedModel,
        trials: &'a PreparedTrials,
        options: &'a DiagnoseOptions,
        noise: Option<&Noise>,
        roles: &Roles,
    ) -> Result<Self, DiagnoseError> {
        let settings = &options.settings;
        settings.check()?;
        let all: Vec<&Trial> = trials.0.iter().collect();
        let open = roles.open();
        let effects = options.candidates.clone();
        let mut system =
            JointSystem::new(all, &open, model.base(), &model.effects, effects, settings);
        let (first, mut prior) = system.first_noise(&open, options.noise);
        if let Some(baseline) = &options.discrepancy {
            prior.discrepancy.add(&baseline.discrepancy);
            system.learn(baseline);
        }
        let first = noise.cloned().unwrap_or_else(|| Noise::white(&first));
        let mut rows = Rows::of(roles, &system, &first, prior, settings);
        let mut base = rows.whole.base();
        rows.whole.errors(&base)?;
        if noise.is_none() {
            let fit = rows.learn_beside(&base);
            let failed = || {
                DiagnoseError::TooLittle("the model diverges on the recordings to be fitted".into())
            };
            base = fit.ok_or_else(failed)?.hypothesis;
        }
        let count: usize = (0..rows.whole.len()).map(|i| rows.whole.rows(i)).sum();
        let (rejection, verdict) = (&settings.rejection, &settings.verdict);
        let acceptance = Acceptance {
            rows: count,
            channels: rows.whole.noise.channels(),
            candidates: options.candidates.len(),
            rows_per_observation: rows.whole.rows_per_observation,
            log_odds: rows.needed_log_odds(),
            null_quantile: rejection.null_quantile,
            minor_of_residual: verdict.minor_of_residual,
            minor_rise: verdict.minor_rise,
            most_prior_square: rows.whole.most_prior_cost(&base),
            clear_prior_cost: CLEAR_PRIOR_COST,
            score_p_value: verdict.score_p_value,
            confusable_odds: verdict.confusable_odds,
            confusable_share: verdict.confusable_share,
        };
        let Problem { experiments, windows, noise, .. } = rows.whole;
        let mut made = Self {
            system,
            options,
            noise,
            experiments,
            windows,
            base,
            nuisances: Vec::new(),
            limited: Vec::new(),
            plain: Vec::new(),
            acceptance,
        };
        made.plain = made.column(&made.base)?;
        (made.nuisances, made.limited) = made.basis()?;
        Ok(made)
    }

    fn problem(&self) -> Problem<'_, JointSystem<'a>> {
        Problem {
            system: &self.system,
            settings: &self.options.settings,
            experiments: self.experiments.clone(),
            windows: self.windows.clone(),
            noise: self.noise.clone(),
            rows_per_observation: self.acceptance.rows_per_observation,
            jacobian_reuses: 0,
            unseen: None,
        }
    }

    /// First row of each experiment in a column: the rows of its channels, then one for the prior of each of its
    /// nuisances; the priors of the shared ones are at the end.
    fn firsts(&self, problem: &Problem<'_, JointSystem<'a>>) -> Vec<usize> {
        let mut firsts = vec![0];
        for i in 0..problem.len() {
            let own = problem.rows(i) * self.acceptance.channels + self.system.local().len();
            firsts.push(firsts[i] + own);
        }
        firsts
    }

    fn interleaved(&self, channels: &[Vec<f64>], rows: usize) -> Vec<f64> {
        Column::new(channels, &vec![1.0; channels.len()], rows).0
    }

    /// The whitened residuals under a hypothesis as one column, with empty rows for the priors.
    fn column(&self, hypothesis: &Hypothesis) -> Result<Vec<f64>, DiagnoseError> {
        let problem = self.problem();
        let firsts = self.firsts(&problem);
        let mut all = vec![0.0; firsts[problem.len()] + self.system.shared().len()];
        for i in 0..problem.len() {
            let residuals = problem.whitened_residuals(hypothesis, i)?;
            let own = self.interleaved(&residuals, problem.rows(i));
            all[firsts[i]..firsts[i] + own.len()].copy_from_slice(&own);
        }
        Ok(all)
    }

    /// An orthonormal basis of what the nuisances without limits do, and the others.
    fn basis(&self) -> Result<(Vec<Part>, Vec<Limited>), DiagnoseError> {
        let problem = self.problem();
        let firsts = self.firsts(&problem);
        let (shared, local) = (self.system.shared(), self.system.local());
        let length = firsts[problem.len()] + shared.len();
        let mut basis = Vec::new();
        let mut of_shared = vec![vec![0.0; length]; shared.len()];
        for i in 0..problem.len() {
            let s = problem.whitened_sensitivities(&self.base, i)?;
            let rows = problem.rows(i);
            let (all, own) = s.columns.split_at(shared.len());
            for (to, column) in of_shared.iter_mut().zip(all) {
                let values = self.interleaved(column, rows);
                to[firsts[i]..firsts[i] + values.len()].copy_from_slice(&values);
            }
            for (k, (column, nuisance)) in own.iter().zip(local).enumerate() {
                let mut values = self.interleaved(column, rows);
                values.extend((0..local.len()).map(|l| prior(l == k, nuisance)));
                extend(&mut basis, firsts[i], values);
            }
        }
        let mut limited = Vec::new();
        for (k, (mut column, nuisance)) in of_shared.into_iter().zip(shared).enumerate() {
            column[firsts[problem.len()] + k] = prior(true, nuisance);
            if nuisance.limits.iter().all(|l| l.is_infinite()) {
                extend(&mut basis, 0, column);
            } else {
                let room = nuisance.limits.map(|limit| limit - self.base.shared[k]);
                limited.push(Limited { column, room });
            }
        }
        limited.iter_mut().for_each(|l| clear(&mut l.column, &basis));
        Ok((basis, limited))
    }

    /// The signature of a candidate with these values (parameters, then switches); `None` if the simulation diverges.
    #[must_use]
    pub fn of(&self, candidate: usize, values: &[f64]) -> Option<Signature> {
        let with = self.column(&self.base.with(candidate, values)).ok()?;
        let change = self.plain.iter().zip(with).map(|(a, b)| a - b).collect();
        self.cleared(change, false)
    }

    /// For candidates with values at which fits begin: the half-widths of the 95 % intervals that each parameter gets from the values
    /// that the candidate seems to have in baseline recordings, where it is absent. All are zero without
    /// [`DiagnoseOptions::discrepancy`].
    ///
    /// # Errors
    /// [`DiagnoseError`] if the recordings are too short.
    pub fn apparent_half_widths(
        &self,
        model: &ExtendedModel,
        baseline: &PreparedTrials,
        candidates: &[(usize, Vec<f64>)],
    ) -> Result<Vec<Vec<f64>>, DiagnoseError> {
        let parameters = |candidate: usize| self.system.candidate(candidate).parameters;
        let Some(learned) = &self.options.discrepancy else {
            return Ok(candidates.iter().map(|c| vec![0.0; parameters(c.0).len()]).collect());
        };
        let known = model.with(learned.effects.iter().cloned());
        let system = JointSystem::new(
            baseline.0.iter().collect(),
            &OpenPart::whole(baseline.0.len()),
            model.base(),
            &known.effects,
            self.options.candidates.clone(),
            &self.options.settings,
        );
        // A few steps are enough for the size of a limit.
        let mut quick = self.options.settings;
        quick.intervals.baseline_iterations =
            quick.intervals.baseline_iterations.min(APPARENT_ITERATIONS);
        let absent = learned.problem(&system, &quick)?;
        let half_widths = |k: usize| {
            let (candidate, values) = &candidates[k];
            let infos = parameters(*candidate);
            let cause = Member::always(*candidate, values);
            let apparent = Apparent::of(Some(&absent), &cause, infos, self.experiments.len());
            (0..infos.len()).map(|place| apparent.half_width(place)).collect()
        };
        Ok(parallel::map(candidates.len(), half_widths))
    }

    /// The derivatives of the signature of a candidate by its parameters, of scales by their logarithm.
    #[must_use]
    pub fn tangents(&self, candidate: usize, values: &[f64]) -> Option<Vec<Signature>> {
        let mut with = self.base.with(candidate, values);
        with.fixed = self.base.members.len();
        let problem = self.problem();
        let firsts = self.firsts(&problem);
        let parameters = self.system.candidate(candidate).parameters.len();
        let mut all = vec![vec![0.0; self.plain.len()]; parameters];
        for i in 0..problem.len() {
            let s = problem.whitened_parameter_sensitivities(&with, i).ok()?;
            for (to, column) in all.iter_mut().zip(&s.columns) {
                let own = self.interleaved(column, problem.rows(i));
                to[firsts[i]..firsts[i] + own.len()].copy_from_slice(&own);
            }
        }
        all.into_iter().map(|column| self.cleared(column, true)).collect()
    }

    /// Takes out what the nuisances imitate; those with limits only as far as these allow, unless it is a `tangent`.
    fn cleared(&self, mut column: Vec<f64>, tangent: bool) -> Option<Signature> {
        if column.iter().any(|v| !v.is_finite()) {
            return None;
        }
        clear(&mut column, &self.nuisances);
        for Limited { column: own, room } in &self.limited {
            let size = dot(own, own);
            if size <= 0.0 {
                continue;
            }
            // The simulation changes by `column`; the nuisance by `-change` undoes it.
            let wanted = -dot(&column, own) / size;
            let at_limit = room[0] >= 0.0 || room[1] <= 0.0;
            let change = match tangent {
                true if at_limit => 0.0,
                true => wanted,
                false => wanted.clamp(room[0].min(0.0), room[1].max(0.0)),
            };
            column.iter_mut().zip(own).for_each(|(c, o)| *c += change * o);
        }
        Some(Signature(column))
    }

    /// The square of a signature in each fitted channel.
    #[must_use]
    pub fn channel_squares(&self, signature: &Signature) -> Vec<f64> {
        let (problem, channels) = (self.problem(), self.acceptance.channels);
        let firsts = self.firsts(&problem);
        let mut squares = vec![0.0; channels];
        for (i, &first) in firsts.iter().enumerate().take(problem.len()) {
            let rows = &signature.0[first..first + problem.rows(i) * channels];
            for row in rows.chunks_exact(channels) {
                squares.iter_mut().zip(row).for_each(|(sum, v)| *sum += v * v);
            }
        }
        squares
    }

    /// The square of a signature in the rows of the priors: the cost of the nuisances that imitate the effect. First that of the
    /// nuisances of each recording, then that of those which all share.
    #[must_use]
    pub fn prior_squares(&self, signature: &Signature) -> Vec<f64> {
        let (problem, channels) = (self.problem(), self.acceptance.channels);
        let firsts = self.firsts(&problem);
        let own = |i: usize| &signature.0[firsts[i] + problem.rows(i) * channels..firsts[i + 1]];
        let shared = &signature.0[firsts[problem.len()]..];
        (0..problem.len()).map(own).chain([shared]).map(|rows| dot(rows, rows)).collect()
    }

    /// Unit vectors along all directions that the test against chance looks in: by every parameter of every candidate, and by
    /// switching it on, at each of its starting values.
    #[must_use]
    pub fn directions(&self) -> Vec<Signature> {
        let starts = all_starts(&self.system);
        let of = |k: usize| {
            let (candidate, values) = &starts[k];
            let mut all = self.tangents(*candidate, values).unwrap_or_default();
            all.extend(self.of(*candidate, values));
            all.iter().filter_map(Signature::unit).collect::<Vec<_>>()
        };
        parallel::map(starts.len(), of).into_iter().flatten().collect()
    }

    /// What the largest squared inner product with the directions exceeds by chance with the probability of the
    /// [`NullTest`](crate::rejection::NullTest), if the residual is a signature and noise and the signs of blocks are drawn.
    #[must_use]
    pub fn by_chance(&self, signature: &Signature, directions: &[Signature], seed: u64) -> f64 {
        let settings = &self.options.settings.rejection;
        let blocks = self.blocks();
        let of = |d: &Signature| -> Vec<[f64; 2]> {
            let products = blocks.iter().map(|b| {
                let own = &d.0[b.clone()];
                [dot(own, &signature.0[b.clone()]), dot(own, own).sqrt()]
            });
            products.collect()
        };
        let products: Vec<Vec<[f64; 2]>> = directions.iter().map(of).collect();
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let mut largest: Vec<f64> = (0..settings.null_draws)
            .map(|_| {
                // The noise of neighbouring directions is nearly the same.
                let draw = |_| {
                    let sign = if random.random_bool(0.5) { 1.0 } else { -1.0 };
                    let noise: f64 = (0..12).map(|_| random.random::<f64>()).sum::<f64>() - 6.0;
                    [sign, noise]
                };
                let draws: Vec<[f64; 2]> = (0..blocks.len()).map(draw).collect();
                let square = |p: &Vec<[f64; 2]>| {
                    let terms = p.iter().zip(&draws);
                    terms
                        .map(|(p, [sign, noise])| sign * (p[0] + noise * p[1]))
                        .sum::<f64>()
                        .powi(2)
                };
                products.iter().map(square).fold(0.0, f64::max)
            })
            .collect();
        largest.sort_by(f64::total_cmp);
        let at = (largest.len() as f64 * settings.null_quantile + 1e-9) as usize;
        largest[at.min(largest.len() - 1)]
    }

    /// The blocks of rows whose sign the test against chance draws, as ranges of a column.
    fn blocks(&self) -> Vec<Range<usize>> {
        let (problem, channels) = (self.problem(), self.acceptance.channels);
        let firsts = self.firsts(&problem);
        let block = (0..problem.len()).map(|i| problem.rows_per_block(i)).min().unwrap_or(1);
        let fewest = self.options.settings.rejection.fewest_blocks;
        let block = block.min(self.acceptance.rows / fewest).max(1);
        let of = |i: usize| {
            let rows = problem.rows(i);
            let (first, count) = (firsts[i], rows.div_ceil(block));
            (0..count).map(move |b| {
                first + b * block * channels..first + ((b + 1) * block).min(rows) * channels
            })
        };
        (0..problem.len()).flat_map(of).collect()
    }

    /// The square of a signature in each of the blocks in which a test set would be read, recording after recording.
    #[must_use]
    pub fn test_block_squares(&self, signature: &Signature) -> Vec<Vec<f64>> {
        let (problem, channels) = (self.problem(), self.acceptance.channels);
        let firsts = self.firsts(&problem);
        let fewest = self.options.settings.rejection.fewest_blocks;
        let of = |i: usize| {
            let rows = problem.rows(i);
            let block = problem.rows_per_block(i).min(rows / fewest).max(1);
            let own = &signature.0[firsts[i]..firsts[i] + rows * channels];
            own.chunks_exact(block * channels).map(|b| dot(b, b)).collect()
        };
        (0..problem.len()).map(of).collect()
    }

    /// The noise of the rows.
    #[must_use]
    pub fn noise(&self) -> &Noise {
        &self.noise
    }

    /// What a diagnosis of these recordings asks of a cause.
    #[must_use]
    pub fn acceptance(&self) -> &Acceptance {
        &self.acceptance
    }

    /// The magnitudes of the recordings, from which starting values follow.
    #[must_use]
    pub fn scales(&self) -> &DataScales {
        self.system.scales()
    }
}

/// The row of a prior: one over its standard deviation for the nuisance's own.
fn prior(own: bool, nuisance: &Nuisance) -> f64 {
    if own && nuisance.deviation.is_finite() { nuisance.deviation.recip() } else { 0.0 }
}
