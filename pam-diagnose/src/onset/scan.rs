//! Every candidate at every time: which beginning or end explains most, and how much chance explains.

use super::cells::{CellProducts, Cells, Direction, Piece, Signed};
use super::schedule::Pattern;
use crate::settings::OnsetSettings;
use pam_core::parallel;
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};
use serde::Serialize;
use std::ops::Range;

/// Where an effect begins or ends.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Edge {
    /// What experiments have in common.
    pub(super) pattern: Pattern,
    /// Whether it begins; otherwise it ends.
    pub(super) begins: bool,
    /// The time in each experiment of the problem, s after its first sample: −∞ before all of it, ∞ behind.
    pub(super) times_s: Vec<f64>,
}

/// An edge with what it explains.
#[derive(Debug, Clone)]
pub(super) struct Scored {
    pub(super) direction: Direction,
    pub(super) edge: Edge,
    /// Drop of the weighted squared residual, to first order.
    pub(super) drop: f64,
    /// The part of it that the same candidate does not explain if it is always there.
    pub(super) contrast: f64,
}

/// How much of a residual the beginning or end of a candidate explains by chance, beyond what the candidate explains if it is
/// always there: as the [null test](crate::rejection::NullTest) of the
/// candidates that are always there, with the maximum taken over all times as well.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct OnsetTest {
    /// Largest share of the squared residual that a beginning or an end explains so, to first order.
    pub largest_share: f64,
    /// Quantile of that share where nothing begins or ends ([`probability`](OnsetSettings::probability)).
    pub share_by_chance: f64,
    /// Share of the draws that reach it.
    pub p_value: f64,
    /// Number of draws.
    pub draws: usize,
    /// Beginnings and ends that were looked at, over all candidates.
    pub tried: usize,
}

/// All edges at a hypothesis.
pub(super) struct Scan<'c> {
    products: &'c CellProducts,
    pieces: Vec<(Piece, Edge)>,
    margin: usize,
}

impl<'c> Scan<'c> {
    /// The edges that `may_be`.
    pub(super) fn new(
        products: &'c CellProducts,
        settings: &OnsetSettings,
        may_be: &dyn Fn(&Edge) -> bool,
    ) -> Self {
        let margin = settings.margin_cells;
        let mut edges = edges(&products.cells, margin);
        edges.retain(|(edge, _)| may_be(edge));
        let pieces = parallel::map(products.directions.len(), |direction| {
            // What a parameter of a member loses before a time it gains behind.
            let begins = products.directions[direction].begins;
            edges
                .iter()
                .filter(|(edge, _)| edge.begins == begins)
                .filter_map(|(edge, ranges)| {
                    Some((products.piece(direction, ranges.clone())?, edge.clone()))
                })
                .collect::<Vec<_>>()
        });
        Self { products, pieces: pieces.into_iter().flatten().collect(), margin }
    }

    /// Number of edges of one direction.
    pub(super) fn edges_per_direction(&self) -> usize {
        // Beginnings and ends are directions of their own.
        (2 * self.pieces.len()).div_ceil(self.products.directions.len().max(1)).max(1)
    }

    /// Signs of all cells, block by block, experiment by experiment.
    fn signs(&self, sign: &mut impl FnMut() -> f64, block: usize) -> Vec<Vec<f64>> {
        let of = |cells: &Cells| {
            let mut now = 1.0;
            let mut next = |k: usize| {
                if k.is_multiple_of(block) {
                    now = sign();
                }
                now
            };
            (0..cells.len()).map(&mut next).collect()
        };
        self.products.cells.iter().map(of).collect()
    }

    /// The residual as it is.
    fn plain(&self) -> Signed {
        self.products.signed(&self.signs(&mut || 1.0, 1))
    }

    /// The best edge of each candidate, or member, and pattern; the best first. `of_each` asks for times of each experiment's
    /// own as well.
    pub(super) fn best(&self, of_each: bool) -> Vec<Scored> {
        let signed = self.plain();
        let mut all: Vec<Scored> = self
            .pieces
            .iter()
            .map(|(piece, edge)| Scored {
                direction: self.products.directions[piece.direction].clone(),
                edge: edge.clone(),
                drop: CellProducts::drop(piece, &signed),
                contrast: CellProducts::contrast(piece, &signed),
            })
            .collect();
        if of_each {
            all.extend(self.of_each(&signed));
        }
        all.retain(|s| s.drop.is_finite());
        all.sort_by(|a, b| b.drop.total_cmp(&a.drop));
        let mut known = Vec::new();
        all.retain(|s| {
            let key = (s.direction.candidate, s.direction.member, s.edge.pattern, s.edge.begins);
            let new = !known.contains(&key);
            if new {
                known.push(key);
            }
            new
        });
        all
    }

    /// What the best edge of a candidate explains over the time, experiment by experiment; for figures.
    pub(super) fn curve(&self, candidate: usize, begins: bool) -> Vec<Vec<(f64, f64)>> {
        let signed = self.plain();
        let mut curves = vec![Vec::<(f64, f64)>::new(); self.products.cells.len()];
        for (piece, edge) in &self.pieces {
            let own = self.products.directions[piece.direction].candidate == candidate;
            if !own || edge.begins != begins {
                continue;
            }
            let drop = CellProducts::drop(piece, &signed);
            for (curve, &time_s) in curves.iter_mut().zip(&edge.times_s) {
                if !time_s.is_finite() {
                    continue;
                }
                match curve.iter_mut().find(|p| p.0 == time_s) {
                    Some(point) => point.1 = point.1.max(drop),
                    None => curve.push((time_s, drop)),
                }
            }
        }
        curves.iter_mut().for_each(|c| c.sort_by(|a, b| a.0.total_cmp(&b.0)));
        curves
    }

    /// Whether the largest drop is more than chance.
    pub(super) fn test(&self, settings: &OnsetSettings, seed: u64) -> Option<OnsetTest> {
        if self.pieces.is_empty() {
            return None;
        }
        let square = self.products.square.max(f64::MIN_POSITIVE);
        let plain = self.plain();
        let contrasts = self.pieces.iter().map(|(piece, _)| CellProducts::contrast(piece, &plain));
        let largest_share = contrasts.fold(0.0, f64::max) / square;
        let draws = settings.draws;
        let signs: Vec<Vec<Vec<f64>>> = (0..draws)
            .map(|draw| {
                let seed = seed ^ 0xbb67_ae85_84ca_a73b ^ ((draw as u64) << 20);
                let mut random = ChaCha8Rng::seed_from_u64(seed);
                let mut sign = || if random.random_bool(0.5) { 1.0 } else { -1.0 };
                self.signs(&mut sign, settings.block_cells)
            })
            .collect();
        let drawn = self.products.draws(&signs);
        let mut of_direction: Vec<Vec<&Piece>> = vec![Vec::new(); self.products.directions.len()];
        self.pieces.iter().for_each(|(piece, _)| of_direction[piece.direction].push(piece));
        let each = parallel::map(of_direction.len(), |direction| {
            self.products.largest_contrasts(direction, &of_direction[direction], &drawn)
        });
        let mut null = vec![0.0; draws];
        for own in each {
            null.iter_mut().zip(own).for_each(|(largest, own)| *largest = f64::max(*largest, own));
        }
        null.iter_mut().for_each(|largest| *largest /= square);
        null.sort_by(f64::total_cmp);
        let reached = null.iter().filter(|&&s| s >= largest_share).count();
        let at = (draws as f64 * settings.probability + 1e-9) as usize;
        Some(OnsetTest {
            largest_share: largest_share.min(1.0),
            share_by_chance: null[at.min(draws - 1)].min(1.0),
            p_value: (reached + 1) as f64 / (draws + 1) as f64,
            draws,
            tried: self.pieces.len(),
        })
    }

    /// Times of each experiment's own: of every direction the ones that explain most with one value of it, found experiment by
    /// experiment in turn.
    fn of_each(&self, signed: &Signed) -> Vec<Scored> {
        let cells = &self.products.cells;
        if cells.len() < 2 {
            return Vec::new();
        }
        let margin = self.margin;
        let found = parallel::map(self.products.directions.len(), |direction| {
            if self.products.directions[direction].member.is_some() {
                return Vec::new();
            }
            [self.products.directions[direction].begins]
                .into_iter()
                .filter_map(|begins| {
                    let all = |e: usize, from: usize| {
                        if begins { from..cells[e].len() } else { 0..from }
                    };
                    // First the best single time of all, then each experiment in turn.
                    let mut ranges: Vec<Range<usize>> =
                        (0..cells.len()).map(|e| all(e, cells[e].len() / 2)).collect();
                    let piece =
                        |ranges: &[Range<usize>]| self.products.piece(direction, ranges.to_vec());
                    let drop = |ranges: &[Range<usize>]| {
                        piece(ranges).map_or(0.0, |p| CellProducts::drop(&p, signed))
                    };
                    let mut best = drop(&ranges);
                    for _ in 0..SWEEPS {
                        let before = best;
                        for e in 0..cells.len() {
                            let n = cells[e].len();
                            let inner = margin..(n + 1).saturating_sub(margin);
                            for edge in [0, n].into_iter().chain(inner.step_by(STRIDE)) {
                                let mut tried = ranges.clone();
                                tried[e] = all(e, edge);
                                let reached = drop(&tried);
                                if reached > best {
                                    (best, ranges) = (reached, tried);
                                }
                            }
                        }
                        if best <= before {
                            break;
                        }
                    }
                    let times_s: Vec<f64> = ranges
                        .iter()
                        .zip(cells)
                        .map(|(range, cells)| {
                            let edge = if begins { range.start } else { range.end };
                            time_of(&cells.starts_s, edge)
                        })
                        .collect();
                    // One experiment at most has a time: that is the pattern of a single time.
                    let finite = times_s.iter().filter(|t| t.is_finite()).count();
                    (finite > 1).then(|| Scored {
                        direction: self.products.directions[direction].clone(),
                        edge: Edge { pattern: Pattern::Each, begins, times_s },
                        drop: best,
                        contrast: piece(&ranges)
                            .map_or(0.0, |p| CellProducts::contrast(&p, signed)),
                    })
                })
                .collect()
        });
        found.into_iter().flatten().collect()
    }
}

/// The experiments in which something is there behind the beginnings or before the ends that `may_be`.
pub(super) fn touched(
    cells: &[Cells],
    settings: &OnsetSettings,
    may_be: &dyn Fn(&Edge) -> bool,
) -> Vec<bool> {
    let edges = edges(cells, settings.margin_cells);
    let edges: Vec<_> = edges.into_iter().filter(|(edge, _)| may_be(edge)).collect();
    (0..cells.len()).map(|e| edges.iter().any(|(_, ranges)| !ranges[e].is_empty())).collect()
}

/// Rounds over the experiments in which each gets a time of its own.
const SWEEPS: usize = 3;
/// Every how many cells a time of its own is tried.
const STRIDE: usize = 4;

/// The time of an edge before the cell of this number: −∞ before the first, ∞ behind the last.
fn time_of(starts_s: &[f64], edge: usize) -> f64 {
    match edge {
        0 => f64::NEG_INFINITY,
        edge if edge >= starts_s.len() => f64::INFINITY,
        edge => starts_s[edge],
    }
}

/// All edges with the cells of each experiment in which the effect is there.
fn edges(cells: &[Cells], margin: usize) -> Vec<(Edge, Vec<Range<usize>>)> {
    let mut all = Vec::new();
    let mut add = |pattern: Pattern, at: Vec<usize>, times_s: Vec<f64>| {
        for begins in [true, false] {
            let ranges: Vec<Range<usize>> = at
                .iter()
                .zip(cells)
                .map(|(&at, c)| if begins { at..c.len() } else { 0..at })
                .collect();
            let there: usize = ranges.iter().map(ExactSizeIterator::len).sum();
            let whole: usize = cells.iter().map(Cells::len).sum();
            if there >= margin && whole - there >= margin {
                all.push((Edge { pattern, begins, times_s: times_s.clone() }, ranges));
            }
        }
    };
    let Some(longest) = cells.iter().max_by_key(|c| c.len()) else { return all };
    for &time_s in longest.starts_s.iter().skip(1) {
        let at: Vec<usize> = cells.iter().map(|c| c.before(time_s)).collect();
        add(Pattern::Shared, at, vec![time_s; cells.len()]);
    }
    if cells.len() > 1 {
        for (e, own) in cells.iter().enumerate() {
            // Between two experiments, or well inside one. Before the first it is there always.
            let between = usize::from(e == 0)..1;
            let inside = margin..(own.len() + 1).saturating_sub(margin);
            for edge in between.chain(inside) {
                let of = |k: usize| match k.cmp(&e) {
                    std::cmp::Ordering::Less => (cells[k].len(), f64::INFINITY),
                    std::cmp::Ordering::Equal => (edge, time_of(&own.starts_s, edge)),
                    std::cmp::Ordering::Greater => (0, f64::NEG_INFINITY),
                };
                let (at, times_s) = (0..cells.len()).map(of).unzip();
                add(Pattern::Once, at, times_s);
            }
        }
    }
    all
}
