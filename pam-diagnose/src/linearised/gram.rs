//! Inner products of the directions of all candidates.

use crate::fit::{Hypothesis, Problem, Sensitivities, dot};
use crate::search::{Candidates, Nuisance};
use pam_core::parallel;
use pam_numerics::{ScaledCholesky, SquareMatrix};
use std::ops::Range;

/// Ridge that leaves directions alone that nearly coincide.
const RIDGE: f64 = 1e-9;
/// Multiple of its own size by which a nuisance at its limit is held there.
pub(crate) const HELD: f64 = 1e9;
/// A direction of which nuisances and members imitate all but this share has no score of its own: its last digits are
/// rounding.
const OWN_SHARE: f64 = 1e-6;

/// A starting value of a candidate, and its directions.
#[derive(Debug, Clone)]
pub(crate) struct Start {
    /// Index of the candidate.
    pub(crate) candidate: usize,
    /// The starting value.
    pub(crate) values: Vec<f64>,
    /// Its directions: parameters, then switching it on.
    pub(crate) directions: Range<usize>,
}

/// Inner products of the directions of candidates at a hypothesis, of its members, and of its residual, over all
/// experiments.
#[derive(Debug)]
pub(crate) struct Products {
    starts: Vec<Start>,
    /// Over the parameters of the members, the shared nuisances, the directions and the residual, cleared of the
    /// experiments' own nuisances, with the priors of the shared ones.
    gram: SquareMatrix,
    /// With the residual, block by block.
    blocks: Vec<Vec<f64>>,
    /// Squared sizes of the directions before anything is cleared.
    sizes: Vec<f64>,
    /// The parameters of each member, with the value by which each of them differs from absent.
    members: Vec<Vec<(usize, f64)>>,
    /// Number of parameters of members and shared nuisances.
    joint: usize,
}

/// The directions of candidates that are not members of a hypothesis, cleared of nuisances and members.
#[derive(Debug)]
pub(crate) struct Linearised {
    /// All starting values of all candidates.
    pub(crate) starts: Vec<Start>,
    /// `D̃ᵀ W D̃` of the cleared directions.
    pub(super) gram: SquareMatrix,
    /// `D̃ᵀ W r`.
    pub(super) right: Vec<f64>,
    /// `D̃ᵀ W r` of each block of rows, direction by direction.
    pub(crate) blocks: Vec<Vec<f64>>,
    /// Weighted square of the residual that nuisances and members leave.
    pub(crate) residual: f64,
    /// Whether a direction has enough of its own.
    pub(super) usable: Vec<bool>,
}

/// Inner products of one experiment: over S (members and shared nuisances), D (directions) and the residual, cleared of
/// the experiment's own nuisances; and with the residual, block by block.
struct Part {
    gram: SquareMatrix,
    blocks: Vec<Vec<f64>>,
    /// `Dᵀ W D` before anything is cleared.
    sizes: Vec<f64>,
}

/// Rows of all channels, interleaved so that a block of time is one range, times the root of their weights.
pub(crate) struct Column(pub(crate) Vec<f64>);

impl Column {
    pub(crate) fn new(channels: &[Vec<f64>], roots: &[f64], rows: usize) -> Self {
        let count = roots.len();
        let mut all = vec![0.0; rows * count];
        for (c, (channel, root)) in channels.iter().zip(roots).enumerate() {
            for (k, value) in channel.iter().enumerate() {
                all[k * count + c] = root * value;
            }
        }
        Self(all)
    }
}

/// Every starting value of every candidate of a system.
pub(crate) fn all_starts<C: Candidates + ?Sized>(system: &C) -> Vec<(usize, Vec<f64>)> {
    let of = |c: usize| system.starts(c).into_iter().map(move |values| (c, values));
    (0..system.candidate_len()).flat_map(of).collect()
}

impl Products {
    /// The products at a fitted hypothesis for those starting values whose candidates are not members; `None` if the
    /// hypothesis cannot be simulated. A starting value that cannot be simulated has no score.
    pub(crate) fn at<C: Candidates + ?Sized>(
        problem: &Problem<'_, C>,
        hypothesis: &Hypothesis,
        candidates: &[(usize, Vec<f64>)],
    ) -> Option<Self> {
        let system = problem.system;
        let mut starts = Vec::new();
        let mut count = 0;
        for (candidate, values) in candidates.iter().filter(|c| !hypothesis.contains(c.0)) {
            let len = system.candidate(*candidate).parameters.len() + 1;
            let directions = count..count + len;
            starts.push(Start { candidate: *candidate, values: values.clone(), directions });
            count += len;
        }
        let errors = problem.errors(hypothesis).ok()?;
        let roots: Vec<f64> = problem.weights(&errors).iter().map(|w| w.sqrt()).collect();
        let block = block_rows(problem)?;
        let mut members = vec![Vec::new(); hypothesis.members.len()];
        let parameters = hypothesis.parameters(system);
        for (k, p) in parameters.iter().enumerate() {
            let value = hypothesis.members[p.member].values[p.value];
            let present = match p.info.off {
                Some(off) if !p.info.logarithmic => value - off,
                _ => 0.0,
            };
            members[p.member].push((k, present));
        }
        let joint = parameters.len() + system.shared().len();
        let parts: Option<Vec<Part>> = parallel::map(problem.len(), |i| {
            let s = problem.whitened_sensitivities(hypothesis, i).ok()?;
            let rows = problem.rows(i);
            // Only the new members are differentiated by.
            let with = |group: &[&Start]| {
                let add = |h: Hypothesis, start: &&Start| h.with(start.candidate, &start.values);
                let with = group.iter().fold(hypothesis.clone(), add);
                Hypothesis { fixed: hypothesis.members.len(), ..with }
            };
            let directions = directions(problem, with, &starts, &s, i);
            let columns: Vec<Column> =
                directions.iter().flatten().map(|d| Column::new(d, &roots, rows)).collect();
            let residual = Column::new(&s.residuals, &roots, rows);
            let own: Vec<Column> = s.columns.iter().map(|c| Column::new(c, &roots, rows)).collect();
            let (of_all, local) = own.split_at(joint);
            let all: Vec<&Column> = of_all.iter().chain(&columns).chain([&residual]).collect();
            let deviations = &hypothesis.locals[i];
            Some(part(&all, local, (system.local(), deviations), block * roots.len(), joint))
        })
        .into_iter()
        .collect();
        let parts = parts?;
        let mut gram = SquareMatrix::zeros(joint + count + 1);
        let mut sizes = vec![0.0; count];
        let mut blocks = vec![Vec::new(); joint + count];
        for part in parts {
            gram += &part.gram;
            sizes.iter_mut().zip(&part.sizes).for_each(|(sum, s)| *sum += s);
            blocks.iter_mut().zip(part.blocks).for_each(|(all, own)| all.extend(own));
        }
        for (k, n) in system.shared().iter().enumerate() {
            // The prior is an observation of its own, with the present deviation as its residual.
            let (k, precision) = (parameters.len() + k, n.deviation.powi(-2));
            let (last, deviation) = (joint + count, hypothesis.shared[k - parameters.len()]);
            gram[(k, k)] += precision;
            // One that is at its limit imitates nothing any more.
            if deviation <= n.limits[0] || deviation >= n.limits[1] {
                gram[(k, k)] += HELD * gram[(k, k)];
            }
            gram[(k, last)] -= precision * deviation;
            gram[(last, k)] -= precision * deviation;
            gram[(last, last)] += precision * deviation * deviation;
        }
        Some(Self { starts, gram, blocks, sizes, members, joint })
    }

    /// The directions beside the whole hypothesis.
    pub(crate) fn beside(&self) -> Linearised {
        self.cleared(None)
    }

    /// The directions in place of one member: the residual has, to first order, what that member explains.
    pub(crate) fn in_place_of(&self, member: usize) -> Linearised {
        self.cleared(Some(member))
    }

    fn cleared(&self, left_out: Option<usize>) -> Linearised {
        let taken: &[(usize, f64)] = left_out.map_or(&[], |m| &self.members[m]);
        let kept: Vec<usize> =
            (0..self.joint).filter(|k| taken.iter().all(|(t, _)| t != k)).collect();
        let (gram, directions) = (&self.gram, self.sizes.len());
        let last = self.joint + directions;
        // Products with the residual, which gets back what the member that is left out explains.
        let with_residual =
            |i: usize| gram[(i, last)] + taken.iter().map(|(k, v)| v * gram[(i, *k)]).sum::<f64>();
        let square =
            with_residual(last) + taken.iter().map(|(k, v)| v * with_residual(*k)).sum::<f64>();
        let n = kept.len();
        let factor = ScaledCholesky::new(n, |i, j| gram[(kept[i], kept[j])], RIDGE);
        let solved = |column: Vec<f64>| {
            let solved = factor.as_ref().and_then(|f| f.solve(&column));
            solved.unwrap_or_else(|| vec![0.0; n])
        };
        // What each direction has of the members and shared nuisances that stay.
        let shares: Vec<Vec<f64>> = (0..directions)
            .map(|k| solved(kept.iter().map(|&s| gram[(s, self.joint + k)]).collect()))
            .collect();
        let of_residual: Vec<f64> = kept.iter().map(|&s| with_residual(s)).collect();
        let mut of_directions = SquareMatrix::zeros(directions);
        for i in 0..directions {
            for j in 0..=i {
                let imitated: f64 =
                    (0..n).map(|s| shares[i][s] * gram[(kept[s], self.joint + j)]).sum();
                let value = gram[(self.joint + i, self.joint + j)] - imitated;
                of_directions[(i, j)] = value;
                of_directions[(j, i)] = value;
            }
        }
        let blocks = (0..directions)
            .map(|k| {
                let mut own = self.blocks[self.joint + k].clone();
                for (share, &s) in shares[k].iter().zip(&kept) {
                    own.iter_mut().zip(&self.blocks[s]).for_each(|(o, b)| *o -= share * b);
                }
                own
            })
            .collect();
        let usable = (0..directions)
            .map(|k| {
                let own = of_directions[(k, k)];
                own > OWN_SHARE * self.sizes[k] && own > 0.0
            })
            .collect();
        Linearised {
            right: (0..directions)
                .map(|k| with_residual(self.joint + k) - dot(&shares[k], &of_residual))
                .collect(),
            residual: (square - dot(&solved(of_residual.clone()), &of_residual)).max(0.0),
            gram: of_directions,
            starts: self.starts.clone(),
            blocks,
            usable,
        }
    }
}

/// Rows of a block: those of the shortest recording, or fewer where there would not be enough blocks.
fn block_rows<C: Candidates + ?Sized>(problem: &Problem<'_, C>) -> Option<usize> {
    let block = (0..problem.len()).map(|i| problem.rows_per_block(i)).min()?;
    let rows: usize = (0..problem.len()).map(|i| problem.rows(i)).sum();
    Some(block.min(rows / problem.settings.rejection.fewest_blocks).max(1))
}

impl Linearised {
    /// The usable directions of a starting value.
    pub(super) fn directions_of(&self, start: &Start) -> impl Iterator<Item = usize> {
        start.directions.clone().filter(|&k| self.usable[k])
    }

    /// All usable directions.
    pub(crate) fn usable(&self) -> impl Iterator<Item = usize> {
        (0..self.usable.len()).filter(|&k| self.usable[k])
    }

    /// The squared size of a cleared direction.
    pub(crate) fn size(&self, direction: usize) -> f64 {
        self.gram[(direction, direction)]
    }
}

/// The directions of starting values in one experiment: for each of them by its parameters, and by switching it on; empty
/// channels where it cannot be simulated. `with` adds starting values to the hypothesis as members.
///
/// Those at which a candidate is absent leave the simulation as it is. They are differentiated by together, and switching them
/// on changes nothing.
pub(crate) fn directions<C: Candidates + ?Sized>(
    problem: &Problem<'_, C>,
    with: impl Fn(&[&Start]) -> Hypothesis + Sync,
    starts: &[Start],
    here: &Sensitivities,
    place: usize,
) -> Vec<Vec<Vec<Vec<f64>>>> {
    let (absent, present): (Vec<usize>, Vec<usize>) =
        (0..starts.len()).partition(|&k| is_absent(problem.system, &starts[k]));
    // The longest first, so that all threads end together.
    let groups: Vec<Vec<usize>> = [absent]
        .into_iter()
        .filter(|group| !group.is_empty())
        .chain(present.into_iter().map(|k| vec![k]))
        .collect();
    let found = parallel::map(groups.len(), |g| {
        let group: Vec<&Start> = groups[g].iter().map(|&k| &starts[k]).collect();
        let there = problem.whitened_parameter_sensitivities(&with(&group), place).ok()?;
        let mut columns = there.columns.into_iter();
        let each = group.iter().map(|start| {
            let mut own: Vec<Vec<Vec<f64>>> =
                columns.by_ref().take(start.directions.len() - 1).collect();
            own.push(if is_absent(problem.system, start) {
                here.residuals.iter().map(|r| vec![0.0; r.len()]).collect()
            } else {
                let change = |(a, b): (&Vec<f64>, &Vec<f64>)| -> Vec<f64> {
                    a.iter().zip(b).map(|(a, b)| a - b).collect()
                };
                here.residuals.iter().zip(&there.residuals).map(change).collect()
            });
            own
        });
        Some(each.collect::<Vec<_>>())
    });
    let mut all: Vec<Vec<Vec<Vec<f64>>>> = starts
        .iter()
        .map(|start| vec![vec![Vec::new(); here.residuals.len()]; start.directions.len()])
        .collect();
    for (group, found) in groups.iter().zip(found) {
        for (&k, own) in group.iter().zip(found.into_iter().flatten()) {
            if own.iter().flatten().flatten().all(|v| v.is_finite()) {
                all[k] = own;
            }
        }
    }
    all
}

/// Whether a candidate with this starting value changes nothing.
fn is_absent<C: Candidates + ?Sized>(system: &C, start: &Start) -> bool {
    let parameters = system.candidate(start.candidate).parameters;
    parameters.iter().zip(&start.values).all(|(p, value)| p.off == Some(*value))
}

fn part(
    all: &[&Column],
    local: &[Column],
    (priors, deviations): (&[Nuisance], &[f64]),
    block: usize,
    joint: usize,
) -> Part {
    let last = all.len() - 1;
    let products = |(k, z): (usize, &Column)| -> Vec<f64> {
        let mut own: Vec<f64> = all.iter().map(|a| dot(&z.0, &a.0)).collect();
        // The prior is an observation of its own, with the present deviation as its residual.
        own[last] -= deviations[k] * priors[k].deviation.powi(-2);
        own
    };
    let cross: Vec<Vec<f64>> = local.iter().enumerate().map(products).collect();
    let entry = |i: usize, j: usize| {
        dot(&local[i].0, &local[j].0) + if i == j { priors[i].deviation.powi(-2) } else { 0.0 }
    };
    let factor = ScaledCholesky::new(local.len(), entry, RIDGE);
    let shares: Vec<Vec<f64>> = (0..all.len())
        .map(|k| {
            let column: Vec<f64> = cross.iter().map(|c| c[k]).collect();
            let solved = factor.as_ref().and_then(|f| f.solve(&column));
            solved.unwrap_or_else(|| vec![0.0; local.len()])
        })
        .collect();
    let rows: Vec<Vec<f64>> = parallel::map(all.len(), |i| {
        (0..=i)
            .map(|j| {
                let own: f64 = shares[i].iter().zip(&cross).map(|(s, c)| s * c[j]).sum();
                dot(&all[i].0, &all[j].0) - own
            })
            .collect()
    });
    let mut gram = SquareMatrix::zeros(all.len());
    for (i, row) in rows.iter().enumerate() {
        for (j, value) in row.iter().enumerate() {
            gram[(i, j)] = *value;
            gram[(j, i)] = *value;
        }
    }
    let prior_cost = priors.iter().zip(deviations).map(|(p, d)| (d / p.deviation).powi(2));
    gram[(last, last)] += prior_cost.sum::<f64>();
    let residual = &all[last].0;
    let in_blocks = |column: &[f64]| -> Vec<f64> {
        column.chunks(block).zip(residual.chunks(block)).map(|(a, r)| dot(a, r)).collect()
    };
    let of_local: Vec<Vec<f64>> = local.iter().map(|z| in_blocks(&z.0)).collect();
    let blocks = (0..last)
        .map(|k| {
            let mut own = in_blocks(&all[k].0);
            for (share, z) in shares[k].iter().zip(&of_local) {
                own.iter_mut().zip(z).for_each(|(o, z)| *o -= share * z);
            }
            own
        })
        .collect();
    let sizes = all[joint..last].iter().map(|d| dot(&d.0, &d.0)).collect();
    Part { gram, blocks, sizes }
}
