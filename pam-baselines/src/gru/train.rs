//! Training by rollouts of recordings.
//!
//! A rollout warms up on measured samples, or on those of the joint at rest, and is then predicted
//! recursively in segments of `horizon` steps. Each segment is one step of Adam with the exact gradient of
//! its own steps; the next one goes on from its hidden states and last predictions. In the course of
//! training rollouts grow from one segment, the published scheme, to `rollout` of them: only then does the
//! network meet its own errors of long free runs, and learns to hold them.
//!
//! Free runs answer to small changes of the weights, so a running mean of the weights is what is used
//! (Polyak and Juditsky 1992). The epoch that is kept is the one whose mean has the least loss in free runs
//! over the whole training recordings.

use super::Gru;
use super::batch::{BatchGradient, Block, TASK_WINDOWS};
use super::network::{Network, Running};
use super::parameters::{INPUTS, OUTPUTS, Shape};
use super::samples::Samples;
use super::tape::{Begin, LOSS_WEIGHTS, Window};
use crate::batched::cosine_rate;
use crate::error::BaselineError;
use crate::method::go_on;
use pam_core::parallel;
use pam_train::optimiser::{Adam, AdamSettings, clip_to_norm};
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};
use serde::Serialize;

/// Share of the training in which rollouts grow.
const GROWING: f64 = 0.5;

/// How training went.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct History {
    /// Mean loss of the segments of each epoch.
    pub loss: Vec<f64>,
    /// Loss after each epoch of free runs over the whole training recordings.
    pub free_run: Vec<f64>,
    /// The epoch (from zero) whose numbers were kept.
    pub best_epoch: usize,
}

/// Rollouts of one task, side by side.
struct Rollouts<'a> {
    members: Vec<&'a [[f32; INPUTS]]>,
    segment: usize,
    segments: usize,
}

impl<'a> Rollouts<'a> {
    /// The next segments; new rollouts of up to `longest` segments if these are over.
    fn next(
        &mut self,
        settings: &Gru,
        samples: &'a Samples,
        members: usize,
        longest: usize,
        random: &mut ChaCha8Rng,
    ) -> Block<'a> {
        let (warm_up, horizon) = (settings.warm_up, settings.horizon);
        if self.segment == self.segments {
            self.segments = random.random_range(1..=longest);
            self.segment = 0;
            let len = warm_up + self.segments * horizon;
            self.members =
                (0..members).map(|_| samples.draw(len, settings.rest_share, random)).collect();
        }
        let (begin, from) = match self.segment {
            0 => (Begin::Rest, 0),
            k => (Begin::Carried, warm_up + k * horizon - 1),
        };
        self.segment += 1;
        let to = warm_up + self.segment * horizon;
        let windows = self.members.iter().map(|s| Window { samples: &s[from..to] }).collect();
        Block { begin, windows }
    }
}

/// Trains from random numbers; returns those of the best epoch.
pub(super) fn train(
    settings: &Gru,
    shape: Shape,
    samples: &Samples,
    seed: u64,
    progress: &(dyn Fn(f64) -> bool + Sync),
) -> Result<(Vec<f64>, History), BaselineError> {
    let longest = samples.longest().saturating_sub(settings.warm_up) / settings.horizon;
    if longest == 0 {
        return Err(BaselineError::unfit(
            "GRU",
            format!(
                "no recording holds {} samples; shorten horizon or samples_per_step",
                settings.horizon * settings.samples_per_step + 1
            ),
        ));
    }
    let longest = longest.min(settings.rollout);
    let mut numbers = shape.random(seed);
    let mut random = ChaCha8Rng::seed_from_u64(seed ^ 0x9e37_79b9_7f4a_7c15);
    let network = Network::new(shape, &numbers);
    let mut engine =
        BatchGradient::new(&network, settings.batch, settings.warm_up, settings.horizon);
    let mut adam = Adam::new(AdamSettings::default(), numbers.len());
    let mut gradient = vec![0.0; numbers.len()];
    let mut mean = numbers.clone();
    let mut best = numbers.clone();
    let mut history = History { loss: Vec::new(), free_run: Vec::new(), best_epoch: 0 };
    let mut tasks: Vec<(usize, Rollouts<'_>)> = (0..settings.batch.div_ceil(TASK_WINDOWS))
        .map(|k| {
            let members = (settings.batch - k * TASK_WINDOWS).min(TASK_WINDOWS);
            (members, Rollouts { members: Vec::new(), segment: 0, segments: 0 })
        })
        .collect();
    let total = (settings.epochs * settings.updates_per_epoch) as f64;
    for epoch in 0..settings.epochs {
        let mut sum = 0.0;
        for k in 0..settings.updates_per_epoch {
            let done = (epoch * settings.updates_per_epoch + k) as f64 / total;
            go_on(progress, done)?;
            let grown = 1 + ((done / GROWING).min(1.0) * (longest - 1) as f64).round() as usize;
            let blocks: Vec<Block<'_>> = tasks
                .iter_mut()
                .map(|(members, rollouts)| {
                    rollouts.next(settings, samples, *members, grown, &mut random)
                })
                .collect();
            let network = Network::new(shape, &numbers);
            sum += engine.run_blocks(&network, &blocks, Some(&mut gradient));
            clip_to_norm(&mut gradient, settings.clip);
            adam.step(&mut numbers, &gradient, cosine_rate(settings.rate, done));
            // At first over as many updates as there are, so that the random start is soon forgotten.
            let kept = settings.averaging.min(1.0 - 1.0 / (done * total + 1.0));
            for (m, n) in mean.iter_mut().zip(&numbers) {
                *m += (1.0 - kept) * (n - *m);
            }
        }
        let network = Network::new(shape, &mean);
        let loss = free_run_loss(&network, samples, settings.warm_up);
        history.loss.push(sum / settings.updates_per_epoch as f64);
        history.free_run.push(loss);
        // The first epoch counts as best whatever it reached; NaN is never better.
        if epoch == 0 || loss < history.free_run[history.best_epoch] {
            history.best_epoch = epoch;
            best.copy_from_slice(&mean);
        } else if epoch - history.best_epoch >= settings.patience {
            break;
        }
    }
    Ok((best, history))
}

/// Mean loss over all samples of free runs from rest over whole recordings.
fn free_run_loss(network: &Network<f32>, samples: &Samples, warm_up: usize) -> f64 {
    let whole: Vec<&[[f32; INPUTS]]> = samples.whole().filter(|s| s.len() > warm_up).collect();
    let sums: Vec<(f64, usize)> =
        parallel::map_each(whole.chunks(TASK_WINDOWS / 2).collect(), |part| {
            let mut running = Running::new(network, part.len());
            let mut out = vec![[0.0_f32; OUTPUTS]; part.len()];
            let mut inputs = vec![[0.0_f32; INPUTS]; part.len()];
            let longest = part.iter().map(|s| s.len()).max().unwrap_or(0);
            let (mut sum, mut count) = (0.0, 0);
            for t in 0..longest {
                if t >= warm_up {
                    running.read(network, &mut out);
                }
                for ((input, predicted), s) in inputs.iter_mut().zip(&out).zip(part) {
                    let Some(measured) = s.get(t) else { continue };
                    *input = *measured;
                    if t >= warm_up {
                        input[..OUTPUTS].copy_from_slice(predicted);
                        count += 1;
                        for c in 0..OUTPUTS {
                            let error = f64::from(predicted[c] - measured[c]);
                            sum += LOSS_WEIGHTS[c] * error * error;
                        }
                    }
                }
                running.feed(network, &inputs);
            }
            (sum, count)
        });
    let count: usize = sums.iter().map(|s| s.1).sum();
    sums.iter().map(|s| s.0).sum::<f64>() / count.max(1) as f64
}
