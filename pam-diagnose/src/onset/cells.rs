//! Inner products of all directions with the residual, cell of time by cell of time.
//!
//! A direction of a candidate that begins at a time is, to first order, the direction of the whole run from that time on: the
//! joint forgets within a fraction of a second what was before. So the inner products of every beginning are sums over the cells
//! of one that begins with the first sample, which the reading at rest does not know, and those of every end are sums
//! over the cells of one that is always there.

use super::schedule::{Acts, Pattern, Schedule};
use crate::fit::{Hypothesis, Member, Problem, dot};
use crate::linearised::{Column, HELD, Start, directions};
use crate::search::Candidates;
use pam_core::parallel;
use pam_numerics::ScaledCholesky;
use pam_vocabulary::course::{ActivityWindow, ONSET};
use std::sync::Arc;

/// Most cells of all experiments together.
const MOST_CELLS: f64 = 240.0;
/// Ridge that leaves unknowns alone that nearly coincide.
const RIDGE: f64 = 1e-9;

/// The cells of one experiment.
#[derive(Debug, Clone)]
pub(super) struct Cells {
    /// Time at which each cell begins, s after the first sample.
    pub(super) starts_s: Vec<f64>,
    /// Row at which each cell begins; the last entry is the number of rows.
    rows: Vec<usize>,
}

impl Cells {
    /// Cells of a length that all experiments share, counted from the first sample.
    fn new<C: Candidates + ?Sized>(problem: &Problem<'_, C>, place: usize, cell_s: f64) -> Self {
        let (system, e) = (problem.system, problem.experiments[place]);
        let (window, points) = (&problem.windows[place], problem.system.points_per_row());
        let (mut starts_s, mut rows, mut last) = (Vec::new(), Vec::new(), None);
        for (row, point) in window.clone().step_by(points).enumerate() {
            let cell = (system.time_s(e, point) / cell_s + 1e-9).floor();
            if last != Some(cell) {
                last = Some(cell);
                starts_s.push(cell * cell_s);
                rows.push(row);
            }
        }
        rows.push(problem.rows(place));
        Self { starts_s, rows }
    }

    pub(super) fn len(&self) -> usize {
        self.starts_s.len()
    }

    /// Number of cells that begin before a time.
    pub(super) fn before(&self, time_s: f64) -> usize {
        self.starts_s.partition_point(|s| *s < time_s - 1e-9)
    }
}

/// Length of a cell for a problem, s: shorter than the setting where there would be too few, longer where there would be too
/// many.
pub(super) fn cell_s<C: Candidates + ?Sized>(problem: &Problem<'_, C>) -> f64 {
    let settings = &problem.settings.onset;
    let span = |i: usize| problem.row_s(i) * problem.rows(i) as f64;
    let total: f64 = (0..problem.len()).map(span).filter(|s| s.is_finite()).sum();
    let row_s = problem.rows_s().fold(0.0, f64::max);
    let [least, most] = [settings.fewest_cell_rows, settings.cell_rows].map(|n| n as f64 * row_s);
    let enough = total / settings.fewest_cells as f64;
    enough.min(most).max(least).max(total / MOST_CELLS)
}

/// A direction: the change of the residual by switching a candidate on, or by one of its parameters.
#[derive(Debug, Clone)]
pub(super) struct Direction {
    /// The candidate.
    pub(super) candidate: usize,
    /// The values at which it is differentiated.
    pub(super) values: Vec<f64>,
    /// Place of the member whose parameter it is, if it is one of the hypothesis.
    pub(super) member: Option<usize>,
    /// Whether it is that of a beginning; otherwise that of an end.
    pub(super) begins: bool,
}

/// Products of one direction with the residual, with itself, and with the unknowns that are fitted along, in one experiment.
#[derive(Debug, Clone, Default)]
pub(super) struct Products {
    /// Sums over the cells before each.
    pub(super) residual: Vec<f64>,
    square: Vec<f64>,
    /// Unknown by unknown.
    unknowns: Vec<Vec<f64>>,
}

impl Products {
    fn over(sums: &[f64], range: &std::ops::Range<usize>) -> f64 {
        sums[range.end] - sums[range.start]
    }
}

/// All products at a hypothesis.
pub(super) struct CellProducts {
    pub(super) cells: Vec<Cells>,
    pub(super) directions: Vec<Direction>,
    /// Direction by direction, experiment by experiment.
    pub(super) products: Vec<Vec<Products>>,
    wholes: Vec<Whole>,
    /// Products of the residual with the unknowns, experiment by experiment, as sums over the cells before each.
    pub(super) residual: Vec<Vec<Vec<f64>>>,
    /// Number of unknowns that all experiments share, and of each experiment's own.
    shared: usize,
    local: usize,
    factor: ScaledCholesky,
    /// Weighted square of the residual.
    pub(super) square: f64,
}

/// A direction over all times: how much of each unknown imitates it, and the squared size of what is left.
struct Whole {
    shares: Vec<f64>,
    size: f64,
}

/// A beginning or an end, ready to be drawn again: what it explains beside the unknowns.
pub(super) struct Piece {
    /// Which direction.
    pub(super) direction: usize,
    /// Its cells in each experiment.
    pub(super) ranges: Vec<std::ops::Range<usize>>,
    /// How much of each unknown imitates it.
    shares: Vec<f64>,
    /// Squared size of what is left.
    size: f64,
    /// The same beside the direction over all times: its share, the shares of the unknowns, the squared size.
    pub(super) contrast: (f64, Vec<f64>, f64),
}

impl CellProducts {
    /// The cells of each experiment of a problem.
    pub(super) fn cells_of<C: Candidates + ?Sized>(problem: &Problem<'_, C>) -> Vec<Cells> {
        let cell_s = cell_s(problem);
        (0..problem.len()).map(|i| Cells::new(problem, i, cell_s)).collect()
    }

    /// The products of starting values and of the parameters of the members; `None` if the hypothesis cannot be simulated. In
    /// experiments that are not `asked` for, starting values have none.
    pub(super) fn at<C: Candidates + ?Sized>(
        problem: &Problem<'_, C>,
        hypothesis: &Hypothesis,
        starts: &[(usize, Vec<f64>)],
        asked: &[bool],
    ) -> Option<Self> {
        let system = problem.system;
        let errors = problem.errors(hypothesis).ok()?;
        let roots: Vec<f64> = problem.weights(&errors).iter().map(|w| w.sqrt()).collect();
        let parameters = hypothesis.parameters(system);
        let shared = parameters.len() + system.shared().len();
        let local = system.local().len();
        let timed = |c: usize| system.may_be_timed(c);
        let starts: Vec<Start> = starts
            .iter()
            .filter(|s| timed(s.0) && !hypothesis.contains(s.0))
            .map(|(candidate, values)| Start {
                candidate: *candidate,
                values: values.clone(),
                directions: 0..system.candidate(*candidate).parameters.len() + 1,
            })
            .collect();
        let of_start = |s: &Start| {
            let (candidate, values) = (s.candidate, s.values.clone());
            let one =
                |begins| Direction { candidate, values: values.clone(), member: None, begins };
            let len = s.directions.len();
            [vec![one(true); len], vec![one(false); len]].concat()
        };
        let mut all: Vec<Direction> = starts.iter().flat_map(of_start).collect();
        // Parameters of members that are there always: a change of one of them at a time.
        let own: Vec<usize> = (0..parameters.len())
            .filter(|&k| {
                let member = &hypothesis.members[parameters[k].member];
                member.schedule.is_none() && timed(member.candidate)
            })
            .collect();
        all.extend(own.iter().map(|&k| {
            let place = parameters[k].member;
            let member = &hypothesis.members[place];
            let values = member.values.clone();
            Direction { candidate: member.candidate, values, member: Some(place), begins: true }
        }));
        let cells = Self::cells_of(problem);
        let channels = roots.len();
        let each: Option<Vec<_>> = parallel::map(problem.len(), |i| {
            let s = problem.whitened_sensitivities(hypothesis, i).ok()?;
            let rows = problem.rows(i);
            let column = |c: &Vec<Vec<f64>>| Column::new(c, &roots, rows);
            let residual = column(&s.residuals);
            let unknowns: Vec<Column> = s.columns.iter().map(column).collect();
            let ranges: Vec<std::ops::Range<usize>> =
                cells[i].rows.windows(2).map(|w| w[0] * channels..w[1] * channels).collect();
            let sums = |a: &Column, b: &Column| -> Vec<f64> {
                let mut sum = 0.0;
                std::iter::once(0.0)
                    .chain(ranges.iter().map(|r| {
                        sum += dot(&a.0[r.clone()], &b.0[r.clone()]);
                        sum
                    }))
                    .collect()
            };
            let of = |d: &Column| Products {
                residual: sums(d, &residual),
                square: sums(d, d),
                unknowns: unknowns.iter().map(|u| sums(d, u)).collect(),
            };
            // Only the new members are differentiated by.
            let added = |group: &[&Start], member: &dyn Fn(&Start) -> Member| {
                let mut with = hypothesis.clone();
                with.fixed = with.members.len();
                with.members.extend(group.iter().map(|start| member(start)));
                with
            };
            let begin = |group: &[&Start]| added(group, &|s| from_the_first_sample(system, s));
            let always =
                |group: &[&Start]| added(group, &|s| Member::always(s.candidate, &s.values));
            let here = |all: &[Start], with: &(dyn Fn(&[&Start]) -> Hypothesis + Sync)| {
                if asked[i] {
                    return directions(problem, with, all, &s, i);
                }
                let none = vec![Vec::new(); channels];
                all.iter().map(|start| vec![none.clone(); start.directions.len()]).collect()
            };
            let ends = here(&starts, &always);
            // For effects that do not act at rest, beginnings have the directions of ends.
            let at_rest: Vec<Start> =
                starts.iter().filter(|s| system.acts_at_rest(s.candidate)).cloned().collect();
            let mut begins = here(&at_rest, &begin).into_iter();
            let all = starts.iter().zip(ends).flat_map(|(start, ends)| {
                let begins = if system.acts_at_rest(start.candidate) {
                    begins.next().unwrap_or_default()
                } else {
                    ends.clone()
                };
                [begins, ends].concat()
            });
            let all: Vec<Vec<Vec<f64>>> = all.collect();
            let mut products: Vec<Products> = parallel::map(all.len(), |k| of(&column(&all[k])));
            products.extend(own.iter().map(|&k| of(&unknowns[k])));
            let gram: Vec<Vec<f64>> = unknowns
                .iter()
                .map(|a| unknowns.iter().map(|b| dot(&a.0, &b.0)).collect())
                .collect();
            let right: Vec<Vec<f64>> = unknowns.iter().map(|u| sums(u, &residual)).collect();
            Some((products, gram, right, dot(&residual.0, &residual.0)))
        })
        .into_iter()
        .collect();
        let each = each?;
        let count = shared + local * problem.len();
        // Place of an unknown of an experiment among all.
        let place =
            |e: usize, k: usize| if k < shared { k } else { shared + local * e + (k - shared) };
        let mut gram = pam_numerics::SquareMatrix::zeros(count);
        for (e, (_, own, ..)) in each.iter().enumerate() {
            for (i, row) in own.iter().enumerate() {
                for (j, value) in row.iter().enumerate() {
                    gram[(place(e, i), place(e, j))] += value;
                }
            }
        }
        for (k, n) in system.shared().iter().enumerate() {
            let (k, deviation) = (parameters.len() + k, hypothesis.shared[k]);
            gram[(k, k)] += n.deviation.powi(-2);
            if deviation <= n.limits[0] || deviation >= n.limits[1] {
                gram[(k, k)] += HELD * gram[(k, k)];
            }
        }
        for e in 0..problem.len() {
            for (k, n) in system.local().iter().enumerate() {
                let k = shared + local * e + k;
                gram[(k, k)] += n.deviation.powi(-2);
            }
        }
        let factor = ScaledCholesky::new(count, |i, j| gram[(i, j)], RIDGE)?;
        let mut products: Vec<Vec<Products>> = vec![Vec::new(); all.len()];
        let (mut residual, mut square) = (Vec::new(), 0.0);
        for (own, _, right, own_square) in each {
            products.iter_mut().zip(own).for_each(|(all, own)| all.push(own));
            residual.push(right);
            square += own_square;
        }
        let wholes = Vec::new();
        let mut found = Self {
            cells,
            directions: all,
            products,
            wholes,
            residual,
            shared,
            local,
            factor,
            square,
        };
        found.wholes = found.wholes();
        Some(found)
    }

    /// A direction in some cells of each experiment, cleared of what the unknowns imitate; `None` if nothing is left.
    pub(super) fn piece(
        &self,
        direction: usize,
        ranges: Vec<std::ops::Range<usize>>,
    ) -> Option<Piece> {
        let own = &self.products[direction];
        let mut right = vec![0.0; self.unknown_len()];
        let mut square = 0.0;
        for (e, (p, range)) in own.iter().zip(&ranges).enumerate() {
            square += Products::over(&p.square, range);
            for (k, sums) in p.unknowns.iter().enumerate() {
                right[self.place(e, k)] += Products::over(sums, range);
            }
        }
        let shares = self.factor.solve(&right)?;
        let size = square - dot(&right, &shares);
        if !(size > LEAST_OWN * square && size > 0.0) {
            return None;
        }
        let whole = &self.wholes[direction];
        let of_whole = match whole.size > 0.0 {
            true => (square - dot(&right, &whole.shares)) / whole.size,
            false => 0.0,
        };
        let own = size - of_whole * of_whole * whole.size;
        let imitated = shares.iter().zip(&whole.shares).map(|(s, w)| s - of_whole * w).collect();
        let contrast = (of_whole, imitated, if own > LEAST_OWN * square { own } else { 0.0 });
        Some(Piece { direction, ranges, shares, size, contrast })
    }

    /// Directions over all times.
    fn wholes(&self) -> Vec<Whole> {
        let of = |own: &Vec<Products>| {
            let mut right = vec![0.0; self.unknown_len()];
            let mut square = 0.0;
            for (e, p) in own.iter().enumerate() {
                square += p.square.last().copied().unwrap_or(0.0);
                for (k, sums) in p.unknowns.iter().enumerate() {
                    right[self.place(e, k)] += sums.last().copied().unwrap_or(0.0);
                }
            }
            let shares = self.factor.solve(&right).unwrap_or_else(|| vec![0.0; right.len()]);
            let size = square - dot(&right, &shares);
            // A parameter of a member is imitated wholly by itself.
            let size = if size > LEAST_OWN * square { size } else { 0.0 };
            Whole { shares, size }
        };
        self.products.iter().map(of).collect()
    }

    /// Number of unknowns of all experiments together.
    pub(super) fn unknown_len(&self) -> usize {
        self.shared + self.local * self.cells.len()
    }

    /// Place of an unknown of an experiment among all.
    pub(super) fn place(&self, experiment: usize, unknown: usize) -> usize {
        if unknown < self.shared {
            unknown
        } else {
            self.shared + self.local * experiment + (unknown - self.shared)
        }
    }

    /// Products of the residual with all unknowns, with a sign for each cell.
    pub(super) fn signed(&self, signs: &[Vec<f64>]) -> Signed {
        let mut unknowns = vec![0.0; self.unknown_len()];
        for (e, own) in self.residual.iter().enumerate() {
            for (k, sums) in own.iter().enumerate() {
                let place = self.place(e, k);
                let cells = sums.windows(2).zip(&signs[e]);
                unknowns[place] += cells.map(|(w, sign)| sign * (w[1] - w[0])).sum::<f64>();
            }
        }
        let directions = self
            .products
            .iter()
            .map(|own| {
                own.iter()
                    .zip(signs)
                    .map(|(p, signs)| {
                        let mut sum = 0.0;
                        let cells = p.residual.windows(2).zip(signs).map(|(w, sign)| {
                            sum += sign * (w[1] - w[0]);
                            sum
                        });
                        std::iter::once(0.0).chain(cells).collect()
                    })
                    .collect()
            })
            .collect();
        Signed { unknowns, directions }
    }

    /// The share of the weighted square of the residual that each piece explains where blocks of it have these signs.
    pub(super) fn drop(piece: &Piece, signed: &Signed) -> f64 {
        let cleared = Self::sum(piece, signed) - dot(&piece.shares, &signed.unknowns);
        cleared * cleared / piece.size
    }

    /// As [`drop`](Self::drop), beside the same direction over all times: what says that it comes or goes.
    pub(super) fn contrast(piece: &Piece, signed: &Signed) -> f64 {
        let (of_whole, shares, size) = &piece.contrast;
        let own = &signed.directions[piece.direction];
        let whole: f64 = own.iter().filter_map(|sums| sums.last()).sum();
        let cleared = Self::sum(piece, signed) - of_whole * whole - dot(shares, &signed.unknowns);
        if *size > 0.0 { cleared * cleared / size } else { 0.0 }
    }

    fn sum(piece: &Piece, signed: &Signed) -> f64 {
        let own = signed.directions[piece.direction].iter();
        own.zip(&piece.ranges).map(|(sums, range)| Products::over(sums, range)).sum()
    }
}

/// A starting value that begins with the first sample.
fn from_the_first_sample<C: Candidates + ?Sized>(system: &C, start: &Start) -> Member {
    let schedule = Schedule {
        pattern: Pattern::Shared,
        acts: vec![Acts::Within(ActivityWindow::BEGINS, 0); system.experiment_len()],
        times: vec![ONSET],
        fitted: false,
        choices: 1.0,
    };
    Member {
        candidate: start.candidate,
        // Nothing of it is there at the first sample.
        values: [start.values.as_slice(), &[0.5 * system.ramp_s()]].concat(),
        schedule: Some(Arc::new(schedule)),
        scales_held: false,
    }
}

/// Share of a direction that must be its own, so that what it explains is no rounding.
const LEAST_OWN: f64 = 1e-4;

/// Products with the residual under signs of its cells.
pub(super) struct Signed {
    unknowns: Vec<f64>,
    /// Direction by direction, experiment by experiment, as sums over the cells before each.
    directions: Vec<Vec<Vec<f64>>>,
}
