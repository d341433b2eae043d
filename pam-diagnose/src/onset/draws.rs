//! What pieces explain where blocks of the residual have random signs, many draws at once.

use super::cells::{CellProducts, Piece, Products};

impl CellProducts {
    /// Products of the residual with all unknowns for many signs of the cells, draw by draw.
    pub(super) fn draws(&self, signs: &[Vec<Vec<f64>>]) -> Draws {
        let of_cell = |e: usize, k: usize| signs.iter().map(move |draw| draw[e][k]).collect();
        let cells = (0..self.cells.len())
            .map(|e| (0..self.cells[e].len()).map(|k| of_cell(e, k)).collect())
            .collect();
        let draws = Draws { count: signs.len(), signs: cells, unknowns: Vec::new() };
        let mut unknowns = vec![vec![0.0; draws.count]; self.unknown_len()];
        for (e, own) in self.residual.iter().enumerate() {
            for (k, sums) in own.iter().enumerate() {
                for (w, signs) in sums.windows(2).zip(&draws.signs[e]) {
                    add(&mut unknowns[self.place(e, k)], w[1] - w[0], signs);
                }
            }
        }
        Draws { unknowns, ..draws }
    }

    /// The largest [`contrast`](Self::contrast) of some pieces of one direction in each draw.
    pub(super) fn largest_contrasts(
        &self,
        direction: usize,
        pieces: &[&Piece],
        draws: &Draws,
    ) -> Vec<f64> {
        // Sums over the cells before each, experiment by experiment.
        let of_experiment = |(p, signs): (&Products, &Vec<Vec<f64>>)| -> Vec<Vec<f64>> {
            let mut sums = vec![vec![0.0; draws.count]];
            for (k, (w, signs)) in p.residual.windows(2).zip(signs).enumerate() {
                let mut sum = sums[k].clone();
                add(&mut sum, w[1] - w[0], signs);
                sums.push(sum);
            }
            sums
        };
        let own = self.products[direction].iter().zip(&draws.signs);
        let own: Vec<Vec<Vec<f64>>> = own.map(of_experiment).collect();
        let mut largest = vec![0.0; draws.count];
        let mut cleared = vec![0.0; draws.count];
        for piece in pieces {
            let (of_whole, shares, size) = &piece.contrast;
            if *size <= 0.0 {
                continue;
            }
            cleared.fill(0.0);
            for (sums, range) in own.iter().zip(&piece.ranges) {
                if !range.is_empty() {
                    add(&mut cleared, 1.0, &sums[range.end]);
                    add(&mut cleared, -1.0, &sums[range.start]);
                }
                add(&mut cleared, -of_whole, &sums[sums.len() - 1]);
            }
            for (share, unknown) in shares.iter().zip(&draws.unknowns) {
                add(&mut cleared, -share, unknown);
            }
            for (largest, cleared) in largest.iter_mut().zip(&cleared) {
                *largest = f64::max(*largest, cleared * cleared / size);
            }
        }
        largest
    }
}

/// Adds a multiple of a series.
fn add(to: &mut [f64], factor: f64, series: &[f64]) {
    to.iter_mut().zip(series).for_each(|(to, value)| *to += factor * value);
}

/// Many draws of the signs of the cells, side by side.
pub(super) struct Draws {
    count: usize,
    /// Experiment by experiment, cell by cell.
    signs: Vec<Vec<Vec<f64>>>,
    /// Unknown by unknown.
    unknowns: Vec<Vec<f64>>,
}
