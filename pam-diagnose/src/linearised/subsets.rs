//! Shares that every set of one or two candidates would explain.

use super::gram::{Linearised, Start};
use pam_numerics::{ScaledCholesky, dot};

/// Ridge of the least squares over a subset, so that nearly parallel directions do not explain by their difference.
const RIDGE: f64 = 1e-6;

/// Candidates with the starting values at which they explain most.
#[derive(Debug, Clone)]
pub(crate) struct Subset<'l> {
    /// One for each candidate.
    pub(crate) starts: Vec<&'l Start>,
    /// Drop of the weighted squared residual by least squares.
    pub(crate) drop: f64,
}

/// Share that a direction must explain to outweigh its cost, about half of `ln n`.
const PRICE: f64 = 4.0;

/// Candidates that do nearly the same as another one, with starting values, by the index of that one.
#[derive(Debug, Clone, Default)]
pub(crate) struct Imitators(Vec<Vec<(usize, Vec<f64>)>>);

impl Imitators {
    /// Those of a candidate, the most similar first.
    pub(crate) fn of(&self, candidate: usize) -> &[(usize, Vec<f64>)] {
        self.0.get(candidate).map_or(&[], Vec::as_slice)
    }
}

impl Subset<'_> {
    /// The drop less the price of its directions.
    fn score(&self) -> f64 {
        let directions: usize = self.starts.iter().map(|s| s.directions.len()).sum();
        self.drop - PRICE * directions as f64
    }
}

impl Linearised {
    /// The drop of the weighted squared residual by least squares over the directions of several starting values.
    fn subset<'l>(&'l self, starts: &[&'l Start]) -> Subset<'l> {
        let all: Vec<usize> = starts.iter().flat_map(|s| self.directions_of(s)).collect();
        let right: Vec<f64> = all.iter().map(|&k| self.right[k]).collect();
        let drop = self.solved(&all, &right).map_or(0.0, |x| dot(&x, &right));
        Subset { starts: starts.to_vec(), drop }
    }

    /// Least squares over some directions.
    fn solved(&self, directions: &[usize], right: &[f64]) -> Option<Vec<f64>> {
        let entry = |i: usize, j: usize| self.gram[(directions[i], directions[j])];
        ScaledCholesky::new(directions.len(), entry, RIDGE).and_then(|f| f.solve(right))
    }

    /// For each candidate the `most` others that do nearly the same to the outputs: of its least-squares response `e` to the residual,
    /// their directions `D` hold at least the share `|P_D e|² / |e|²`, each at its best starting value.
    pub(crate) fn imitators(&self, share: f64, most: usize) -> Imitators {
        let all = self.singles();
        let directions: Vec<Vec<usize>> =
            all.iter().map(|s| self.directions_of(s.starts[0]).collect()).collect();
        let count = all.iter().map(|s| s.starts[0].candidate + 1).max().unwrap_or(0);
        let mut imitators = vec![Vec::new(); count];
        for (i, of) in all.iter().enumerate() {
            let right: Vec<f64> = directions[i].iter().map(|&k| self.right[k]).collect();
            let Some(step) = self.solved(&directions[i], &right) else { continue };
            // Products of the response with each direction.
            let with = |k: usize| -> f64 {
                step.iter().zip(&directions[i]).map(|(x, &j)| x * self.gram[(k, j)]).sum()
            };
            let size = dot(&step, &directions[i].iter().map(|&k| with(k)).collect::<Vec<_>>());
            if size <= 0.0 {
                continue;
            }
            let held = |j: usize| {
                let products: Vec<f64> = directions[j].iter().map(|&k| with(k)).collect();
                self.solved(&directions[j], &products).map_or(0.0, |x| dot(&x, &products))
            };
            let others = (0..all.len()).filter(|&j| j != i).map(|j| (held(j), all[j].starts[0]));
            let mut near: Vec<_> = others.filter(|(held, _)| *held >= share * size).collect();
            near.sort_by(|a, b| b.0.total_cmp(&a.0));
            let start = |s: &Start| (s.candidate, s.values.clone());
            imitators[of.starts[0].candidate] =
                near.iter().take(most).map(|(_, s)| start(s)).collect();
        }
        Imitators(imitators)
    }

    /// Every candidate at its best starting value, best first.
    pub(crate) fn singles(&self) -> Vec<Subset<'_>> {
        best_of_each(self.starts.iter().map(|s| self.subset(&[s])).collect())
    }

    /// The `count` best starting values of each candidate, in the order of the candidates.
    pub(crate) fn best_starts(&self, count: usize) -> Vec<(usize, Vec<f64>)> {
        let mut all: Vec<Subset<'_>> = self.starts.iter().map(|s| self.subset(&[s])).collect();
        all.sort_by(|a, b| {
            let candidate = a.starts[0].candidate.cmp(&b.starts[0].candidate);
            candidate.then(b.drop.total_cmp(&a.drop))
        });
        let same = |a: &Subset<'_>, b: &Subset<'_>| a.starts[0].candidate == b.starts[0].candidate;
        let of_each = all.chunk_by(same).flat_map(|own| own.iter().take(count));
        of_each.map(|s| (s.starts[0].candidate, s.starts[0].values.clone())).collect()
    }

    /// Every pair of candidates at its best starting values, best first.
    pub(crate) fn pairs(&self) -> Vec<Subset<'_>> {
        let mut all = Vec::new();
        for (i, a) in self.starts.iter().enumerate() {
            for b in self.starts[i + 1..].iter().filter(|b| b.candidate != a.candidate) {
                all.push(self.subset(&[a, b]));
            }
        }
        best_of_each(all)
    }
}

/// The best subset of each set of candidates, best first.
fn best_of_each(mut all: Vec<Subset<'_>>) -> Vec<Subset<'_>> {
    all.sort_by(|a, b| b.score().total_cmp(&a.score()));
    let mut known = std::collections::HashSet::new();
    all.retain(|s| known.insert(s.starts.iter().map(|s| s.candidate).collect::<Vec<_>>()));
    all
}

#[cfg(test)]
mod tests {
    use super::*;
    use pam_numerics::SquareMatrix;

    /// One direction for each candidate, as explicit columns, and a residual.
    fn linearised(columns: &[[f64; 3]], residual: [f64; 3]) -> Linearised {
        let n = columns.len();
        let mut gram = SquareMatrix::zeros(n);
        for (i, a) in columns.iter().enumerate() {
            for (j, b) in columns.iter().enumerate() {
                gram[(i, j)] = dot(a, b);
            }
        }
        let start = |k: usize| Start { candidate: k, values: vec![1.0], directions: k..k + 1 };
        Linearised {
            starts: (0..n).map(start).collect(),
            gram,
            right: columns.iter().map(|c| dot(c, &residual)).collect(),
            blocks: Vec::new(),
            residual: dot(&residual, &residual),
            usable: vec![true; n],
        }
    }

    /// Cosines of 0.995, 0.8 and 0 with the first column.
    #[test]
    fn what_is_nearly_parallel_imitates() {
        let all = linearised(
            &[[1.0, 0.0, 0.0], [0.995, 0.1, 0.0], [0.8, 0.6, 0.0], [0.0, 0.0, 1.0]],
            [1.0; 3],
        );
        let of = |share: f64, k: usize| -> Vec<usize> {
            all.imitators(share, 2).of(k).iter().map(|(candidate, _)| *candidate).collect()
        };
        assert_eq!(of(0.9, 0), [1]);
        assert_eq!(of(0.6, 0), [1, 2]);
        assert_eq!(of(0.9, 3), [0_usize; 0]);
        assert_eq!(all.imitators(0.6, 1).of(0).len(), 1);
        assert!(all.imitators(0.9, 2).of(17).is_empty());
        // Of what does nothing, nothing is known.
        let none = linearised(&[[0.0; 3], [1.0, 0.0, 0.0]], [1.0; 3]);
        assert!(none.imitators(0.9, 2).of(0).is_empty());
    }
}
