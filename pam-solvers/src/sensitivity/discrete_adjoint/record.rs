//! Storage of the forward solve for the reverse sweep.

use super::Checkpointing;
use crate::grid::Grid;
use crate::observer::{AcceptedStep, StepObserver};

/// Rows of numbers of one width, as a stack whose memory is kept.
#[derive(Debug, Clone, Default)]
pub(super) struct Rows {
    width: usize,
    data: Vec<f64>,
    /// The largest number of rows so far.
    peak: usize,
}

impl Rows {
    /// Forgets all rows, keeps the memory.
    pub(super) fn restart(&mut self, width: usize) {
        self.width = width;
        self.data.clear();
        self.peak = 0;
    }

    /// Appends the row `[first, second]`.
    pub(super) fn push(&mut self, first: &[f64], second: &[f64]) {
        debug_assert_eq!(first.len() + second.len(), self.width);
        self.data.extend_from_slice(first);
        self.data.extend_from_slice(second);
        self.peak = self.peak.max(self.data.len() / self.width);
    }

    pub(super) fn pop(&mut self) {
        self.data.truncate(self.data.len() - self.width);
    }

    /// Forgets all rows but not the peak.
    pub(super) fn clear(&mut self) {
        self.data.clear();
    }

    /// Row `index`, split after `n` numbers.
    pub(super) fn row(&self, index: usize, n: usize) -> (&[f64], &[f64]) {
        self.data[index * self.width..(index + 1) * self.width].split_at(n)
    }

    /// The last row, split in the middle.
    pub(super) fn top(&self) -> (&[f64], &[f64]) {
        self.data[self.data.len() - self.width..].split_at(self.width / 2)
    }

    pub(super) fn peak_bytes(&self) -> usize {
        self.peak * self.width * size_of::<f64>()
    }
}

/// Stores the grid of the first forward solve, and the states and stages that the checkpointing asks for.
pub(super) struct ForwardRecord<'a> {
    pub(super) checkpointing: Checkpointing,
    pub(super) grid: &'a mut Grid,
    /// `[y, k_1]` of some steps.
    pub(super) snapshots: &'a mut Rows,
    /// `[y, k_1 … k_s]` of steps.
    pub(super) stages: &'a mut Rows,
}

impl StepObserver<f64> for ForwardRecord<'_> {
    fn accepted(&mut self, step: AcceptedStep<'_, f64>) {
        let n = step.y.len();
        match self.checkpointing {
            Checkpointing::AllSave => self.stages.push(step.y, &step.k[..step.k.len() - n]),
            Checkpointing::Interval(every) => {
                if self.grid.steps().is_multiple_of(every) {
                    self.snapshots.push(step.y, &step.k[..n]);
                }
            }
            Checkpointing::Binomial { .. } => {}
        }
        self.grid.accepted(step);
    }
}
