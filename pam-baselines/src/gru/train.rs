//! Training on windows of recordings.

use super::Gru;
use super::gradient::{Tape, Window};
use super::network::Network;
use super::parameters::{INPUTS, Shape};
use super::scaling::Scaling;
use crate::error::BaselineError;
use crate::method::go_on;
use pam_train::Subject;
use pam_train::optimiser::{Adam, AdamSettings, clip_to_norm};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;
use serde::Serialize;

/// Windows of one task. Sums of tasks are added in their order, so results do not depend on the number of
/// threads.
pub const LANES: usize = 32;

/// The scaled samples of all recordings.
#[derive(Debug, Clone)]
pub struct Samples {
    recordings: Vec<Vec<[f32; INPUTS]>>,
}

impl Samples {
    /// Scales recordings.
    #[must_use]
    pub fn of(subjects: &[Subject], scaling: &Scaling) -> Self {
        let recordings = subjects
            .par_iter()
            .map(|s| {
                let r = &s.recording;
                (0..r.len()).map(|k| scaling.input(r, k).map(|v| v as f32)).collect()
            })
            .collect();
        Self { recordings }
    }

    /// Draws a window of `len` samples, all starts of all recordings alike.
    fn draw(&self, len: usize, random: &mut ChaCha8Rng) -> (usize, usize) {
        let starts = |r: &Vec<[f32; INPUTS]>| (r.len() + 1).saturating_sub(len);
        let total: usize = self.recordings.iter().map(starts).sum();
        let mut k = random.random_range(0..total);
        for (i, r) in self.recordings.iter().enumerate() {
            if k < starts(r) {
                return (i, k);
            }
            k -= starts(r);
        }
        unreachable!("the draw is below the total")
    }
}

/// Mean loss of windows and its gradient, over all cores.
#[derive(Debug)]
pub struct BatchGradient {
    warm_up: usize,
    horizon: usize,
    tapes: Vec<Tape<f32>>,
    gradients: Vec<Vec<f64>>,
}

impl BatchGradient {
    /// For batches of up to `batch` windows.
    #[must_use]
    pub fn new(network: &Network<f32>, batch: usize, warm_up: usize, horizon: usize) -> Self {
        let tasks = batch.div_ceil(LANES);
        let lanes = batch.min(LANES);
        Self {
            warm_up,
            horizon,
            tapes: (0..tasks).map(|_| Tape::new(network, lanes, warm_up, horizon)).collect(),
            gradients: vec![vec![0.0; network.shape.len()]; tasks],
        }
    }

    /// Mean over windows and predicted samples of the weighted squared error; its gradient if asked for.
    pub fn run(
        &mut self,
        network: &Network<f32>,
        windows: &[Window<'_, f32>],
        gradient: Option<&mut [f64]>,
    ) -> f64 {
        let wanted = gradient.is_some();
        let share = 1.0 / (windows.len() * self.horizon) as f64;
        let tasks = windows.par_chunks(LANES).zip(&mut self.tapes).zip(&mut self.gradients);
        let losses: Vec<f64> = tasks
            .map(|((part, tape), own)| {
                own.fill(0.0);
                tape.run(network, part, wanted.then_some(&mut own[..]))
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

    /// Samples of a window.
    #[must_use]
    pub fn window_len(&self) -> usize {
        self.warm_up + self.horizon
    }
}

/// How training went.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct History {
    /// Mean loss of each epoch.
    pub loss: Vec<f64>,
    /// Loss on the validation windows after each epoch.
    pub validation: Vec<f64>,
    /// The epoch (from zero) whose numbers were kept.
    pub best_epoch: usize,
}

/// Trains from random numbers; returns the best ones by the validation windows.
pub(super) fn train(
    settings: &Gru,
    shape: Shape,
    samples: &Samples,
    seed: u64,
    progress: &(dyn Fn(f64) -> bool + Sync),
) -> Result<(Vec<f64>, History), BaselineError> {
    let len = settings.warm_up + settings.horizon;
    if samples.recordings.iter().all(|r| r.len() < len) {
        return Err(BaselineError::unfit(
            "GRU",
            format!("no recording holds a window of {len} samples; shorten warm_up or horizon"),
        ));
    }
    let mut numbers = shape.random(seed);
    let mut random = ChaCha8Rng::seed_from_u64(seed ^ 0x9e37_79b9_7f4a_7c15);
    let draw = |count: usize, random: &mut ChaCha8Rng| -> Vec<Window<'_, f32>> {
        (0..count)
            .map(|_| {
                let (i, k) = samples.draw(len, random);
                Window { samples: &samples.recordings[i][k..k + len] }
            })
            .collect()
    };
    let validation = draw(settings.validation_windows, &mut random);
    let network = Network::new(shape, &numbers);
    let size = settings.batch.max(settings.validation_windows);
    let mut engine = BatchGradient::new(&network, size, settings.warm_up, settings.horizon);
    let mut adam = Adam::new(AdamSettings::default(), numbers.len());
    let mut gradient = vec![0.0; numbers.len()];
    let mut best = numbers.clone();
    let mut history = History { loss: Vec::new(), validation: Vec::new(), best_epoch: 0 };
    let batches = settings.windows_per_epoch.div_ceil(settings.batch).max(1);
    let total = (settings.epochs * batches) as f64;
    for epoch in 0..settings.epochs {
        let mut sum = 0.0;
        for k in 0..batches {
            let done = (epoch * batches + k) as f64 / total;
            go_on(progress, done)?;
            let windows = draw(settings.batch, &mut random);
            let network = Network::new(shape, &numbers);
            sum += engine.run(&network, &windows, Some(&mut gradient));
            clip_to_norm(&mut gradient, settings.clip);
            let rate = 0.5 * settings.rate * (1.0 + (std::f64::consts::PI * done).cos());
            adam.step(&mut numbers, &gradient, rate);
        }
        let network = Network::new(shape, &numbers);
        let loss = engine.run(&network, &validation, None);
        history.loss.push(sum / batches as f64);
        history.validation.push(loss);
        // The first epoch counts as best whatever it reached; NaN is never better.
        if epoch == 0 || loss < history.validation[history.best_epoch] {
            history.best_epoch = epoch;
            best.copy_from_slice(&numbers);
        } else if epoch - history.best_epoch >= settings.patience {
            break;
        }
    }
    Ok((best, history))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The same loss and gradient, to the bit, with one thread and with several.
    #[test]
    fn threads_change_nothing() {
        let shape = Shape { hidden: 16, layers: 2 };
        let network = Network::<f32>::new(shape, &shape.random(2));
        let data: Vec<Vec<[f32; INPUTS]>> = (0..70)
            .map(|w| {
                (0..8)
                    .map(|t| std::array::from_fn(|c| ((w * 7 + t * 3 + c) as f32).sin()))
                    .collect()
            })
            .collect();
        let run = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| {
                let windows: Vec<Window<'_, f32>> =
                    data.iter().map(|s| Window { samples: s }).collect();
                let mut gradient = vec![0.0; shape.len()];
                let mut engine = BatchGradient::new(&network, 70, 4, 4);
                (engine.run(&network, &windows, Some(&mut gradient)), gradient)
            })
        };
        assert_eq!(run(1), run(3));
    }
}
