//! A neural ODE without physics: all four rates of the state are a network of state and force.
//!
//! Training predicts short windows by Runge–Kutta steps of fourth order and differentiates through them
//! exactly; longer ones would diverge before anything is learned.

mod model;
mod network;
mod windows;

pub use model::NeuralOdeModel;
pub use network::{Field, STATES, parameter_len, random};
pub use windows::{Tape, Window};

use crate::batched::{check_counts, check_positive, check_width, cosine_rate};
use crate::error::BaselineError;
use crate::koopman::{Standard, common_step_s, standard_of};
use crate::method::{FittedModel, Method, TrainingSet, go_on};
use pam_data::Channel;
use pam_train::optimiser::{Adam, AdamSettings, clip_to_norm};
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

/// Windows of one task; sums of tasks are added in their order.
const TASK_WINDOWS: usize = 16;

/// How the field is made and trained.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct NeuralOde {
    /// Width of both hidden layers; a multiple of 16.
    pub width: usize,
    /// Samples of a Runge–Kutta step; even, for the force in its middle.
    pub samples_per_step: usize,
    /// Runge–Kutta steps of a window.
    pub steps_per_window: usize,
    /// Windows in a step of Adam.
    pub batch: usize,
    /// Steps of Adam.
    pub updates: usize,
    /// Rate at the start; it falls as a cosine.
    pub rate: f64,
    /// Largest norm of the gradient.
    pub clip: f64,
}

impl Default for NeuralOde {
    fn default() -> Self {
        Self {
            width: 64,
            samples_per_step: 4,
            steps_per_window: 125,
            batch: 64,
            updates: 4000,
            rate: 3e-3,
            clip: 1.0,
        }
    }
}

impl Method for NeuralOde {
    fn title(&self) -> String {
        "Black-box neural ODE".into()
    }

    fn check(&self) -> Result<(), String> {
        check_width("width", self.width)?;
        if self.samples_per_step == 0 || !self.samples_per_step.is_multiple_of(2) {
            return Err(format!("samples_per_step = {} must be even", self.samples_per_step));
        }
        check_counts(&[
            ("steps_per_window", self.steps_per_window),
            ("batch", self.batch),
            ("updates", self.updates),
        ])?;
        check_positive(&[("rate", self.rate), ("clip", self.clip)])
    }

    fn fit(
        &self,
        training: &TrainingSet<'_>,
        progress: &(dyn Fn(f64) -> bool + Sync),
    ) -> Result<Box<dyn FittedModel>, BaselineError> {
        let fail = |why: String| BaselineError::unfit("Black-box neural ODE", why);
        let recordings: Vec<_> = training.subjects.iter().map(|s| &s.recording).collect();
        let sample_s = common_step_s(&recordings).map_err(fail)?;
        let (state, input) = standard_of(&recordings).map_err(fail)?;
        let len = self.samples_per_step * self.steps_per_window + 1;
        let starts: Vec<usize> =
            recordings.iter().map(|r| (r.len() + 1).saturating_sub(len)).collect();
        let total: usize = starts.iter().sum();
        if total == 0 {
            return Err(fail(format!("no recording holds a window of {len} samples")));
        }
        let step_s = sample_s * self.samples_per_step as f64;
        let rates = typical_rates(&recordings, &state, self.samples_per_step, step_s);
        let draw = |random: &mut ChaCha8Rng| -> Window<f32> {
            let mut k = random.random_range(0..total);
            let mut i = 0;
            while k >= starts[i] {
                k -= starts[i];
                i += 1;
            }
            let r = recordings[i];
            let at =
                |j: usize| state.apply(&Channel::ALL.map(|c| r.channel(c)[j])).map(|v| v as f32);
            let half = self.samples_per_step / 2;
            Window {
                states: (0..=self.steps_per_window)
                    .map(|s| at(k + s * self.samples_per_step))
                    .collect(),
                forces: (0..=2 * self.steps_per_window)
                    .map(|s| input.apply(&[r.force_mn[k + s * half]])[0] as f32)
                    .collect(),
            }
        };
        let mut numbers = random(self.width, training.seed);
        let mut generator = ChaCha8Rng::seed_from_u64(training.seed ^ 0x51ed_270b);
        let mut adam = Adam::new(AdamSettings::default(), numbers.len());
        let tasks = self.batch.div_ceil(TASK_WINDOWS);
        let mut tapes: Vec<Tape<f32>> = (0..tasks)
            .map(|_| Tape::new(self.width, TASK_WINDOWS, self.steps_per_window, step_s))
            .collect();
        let mut parts = vec![vec![0.0; numbers.len()]; tasks];
        let mut gradient = vec![0.0; numbers.len()];
        let share = 1.0 / (self.batch * self.steps_per_window) as f64;
        let mut recent = 0.0;
        for update in 0..self.updates {
            let done = update as f64 / self.updates as f64;
            go_on(progress, done)?;
            let windows: Vec<Window<f32>> = (0..self.batch).map(|_| draw(&mut generator)).collect();
            let windows: Vec<&Window<f32>> = windows.iter().collect();
            let field = Field::<f32>::new(self.width, &numbers, rates);
            let losses: Vec<f64> = windows
                .par_chunks(TASK_WINDOWS)
                .zip(&mut tapes)
                .zip(&mut parts)
                .map(|((part, tape), own)| {
                    own.fill(0.0);
                    tape.run(&field, part, Some(own))
                })
                .collect();
            gradient.fill(0.0);
            for own in &parts {
                for (g, o) in gradient.iter_mut().zip(own) {
                    *g += share * o;
                }
            }
            let loss = share * losses.iter().sum::<f64>();
            recent = if update == 0 { loss } else { recent + 0.02 * (loss - recent) };
            clip_to_norm(&mut gradient, self.clip);
            // A window that left all bounds says nothing.
            if gradient.iter().all(|g| g.is_finite()) {
                adam.step(&mut numbers, &gradient, cosine_rate(self.rate, done));
            }
        }
        Ok(Box::new(NeuralOdeModel {
            field: Field::new(self.width, &numbers, rates),
            numbers,
            state,
            input,
            rates,
            sample_s,
            samples_per_step: self.samples_per_step,
            loss: recent,
        }))
    }
}

/// Root mean square rates of the scaled states, 1/s.
fn typical_rates(
    recordings: &[&pam_data::Recording],
    state: &Standard<4>,
    stride: usize,
    step_s: f64,
) -> [f64; STATES] {
    let mut rates = [0.0; STATES];
    for (c, rate) in Channel::ALL.into_iter().zip(&mut rates) {
        let (mut sum, mut count) = (0.0, 0.0_f64);
        let scale =
            state.deviation[Channel::ALL.iter().position(|d| *d == c).unwrap_or(0)] * step_s;
        for r in recordings {
            let column = r.channel(c);
            for k in (stride..column.len()).step_by(stride) {
                sum += ((column[k] - column[k - stride]) / scale).powi(2);
                count += 1.0;
            }
        }
        *rate = (sum / count.max(1.0)).sqrt().max(1e-6);
    }
    rates
}
