//! Batches of windows over all cores.

use super::network::Network;
use super::tape::{Begin, Tape, Window};
use rayon::prelude::*;

/// Windows of one task. Sums of tasks are added in their order, so results do not depend on the number of
/// threads.
pub const TASK_WINDOWS: usize = 32;

/// Windows that one task runs side by side, and where they begin.
#[derive(Debug, Clone)]
pub struct Block<'a> {
    /// Where they begin; blocks that go on are those at the same place of the batch before.
    pub begin: Begin,
    /// Up to [`TASK_WINDOWS`] windows.
    pub windows: Vec<Window<'a, f32>>,
}

/// Mean loss of windows and its gradient, over all cores.
#[derive(Debug)]
pub struct BatchGradient {
    horizon: usize,
    tapes: Vec<Tape<f32>>,
    gradients: Vec<Vec<f64>>,
}

impl BatchGradient {
    /// For batches of up to `batch` windows.
    #[must_use]
    pub fn new(network: &Network<f32>, batch: usize, warm_up: usize, horizon: usize) -> Self {
        let tasks = batch.div_ceil(TASK_WINDOWS);
        let members = batch.min(TASK_WINDOWS);
        Self {
            horizon,
            tapes: (0..tasks).map(|_| Tape::new(network, members, warm_up, horizon)).collect(),
            gradients: vec![vec![0.0; network.shape.len()]; tasks],
        }
    }

    /// Mean over windows and predicted samples of the weighted squared error, all windows from rest; its
    /// gradient if asked for.
    pub fn run(
        &mut self,
        network: &Network<f32>,
        windows: &[Window<'_, f32>],
        gradient: Option<&mut [f64]>,
    ) -> f64 {
        let blocks: Vec<Block<'_>> = windows
            .chunks(TASK_WINDOWS)
            .map(|w| Block { begin: Begin::Rest, windows: w.to_vec() })
            .collect();
        self.run_blocks(network, &blocks, gradient)
    }

    /// The same of blocks, each with its own beginning.
    pub fn run_blocks(
        &mut self,
        network: &Network<f32>,
        blocks: &[Block<'_>],
        gradient: Option<&mut [f64]>,
    ) -> f64 {
        let wanted = gradient.is_some();
        let windows: usize = blocks.iter().map(|b| b.windows.len()).sum();
        let share = 1.0 / (windows * self.horizon) as f64;
        let tasks = blocks.par_iter().zip(&mut self.tapes).zip(&mut self.gradients);
        let losses: Vec<f64> = tasks
            .map(|((block, tape), own)| {
                own.fill(0.0);
                tape.run(network, block.begin, &block.windows, wanted.then_some(&mut own[..]))
            })
            .collect();
        if let Some(gradient) = gradient {
            gradient.fill(0.0);
            for own in &self.gradients[..losses.len()] {
                for (g, o) in gradient.iter_mut().zip(own) {
                    *g += share * o;
                }
            }
        }
        share * losses.iter().sum::<f64>()
    }
}
