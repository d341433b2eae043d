//! A trained network in use.

use super::network::{Network, Running};
use super::parameters::{INPUTS, OUTPUTS, Shape};
use super::scaling::Scaling;
use super::train::History;
use crate::error::BaselineError;
use crate::method::{FittedModel, Run, Stopped, Structure, Trajectory, diverged, out_of_range};
use crate::saved::SavedArrays;
use pam_core::parallel;
use pam_data::formats::npz::Array;
use pam_data::recording::median_step_s;
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::path::Path;

/// Recordings of one task.
const TASK_RUNS: usize = 16;

fn append(trajectory: &mut Trajectory, state: &[f64; OUTPUTS]) {
    let Trajectory { x, v, pf, pe } = trajectory;
    for (column, value) in [x, v, pf, pe].into_iter().zip(state) {
        column.push(*value);
    }
}

/// The state at a share of a step between two states.
fn between(
    before: &[f64; OUTPUTS],
    after: &[f64; OUTPUTS],
    share: f64,
    step_s: f64,
) -> [f64; OUTPUTS] {
    let mut state = std::array::from_fn(|c| before[c] + share * (after[c] - before[c]));
    // The cubic of Hermite, as its line and what the slopes at the ends add.
    let slopes = [before[1], after[1]].map(|v| v * step_s - (after[0] - before[0]));
    let rest = 1.0 - share;
    state[0] += share * rest * (rest * slopes[0] - share * slopes[1]);
    state
}

/// A trained network.
#[derive(Debug, Clone)]
pub struct GruModel {
    /// The network.
    pub network: Network<f32>,
    /// Its numbers, in the order of [`Shape::parts`].
    pub numbers: Vec<f64>,
    /// Scaling of inputs and outputs.
    pub scaling: Scaling,
    /// Steps from which the hidden states are taken.
    pub warm_up: usize,
    /// Samples of a step.
    pub samples_per_step: usize,
    /// Time from sample to sample, s; unknown for the published network.
    pub step_s: Option<f64>,
    /// How it was trained; none if it was read from a file.
    pub history: Option<History>,
}

impl GruModel {
    /// Reads a network from an `.npz` file with the arrays that [`FittedModel::arrays`] gives, as `pam compare`
    /// writes them:
    ///
    /// | array | shape | content |
    /// |---|---|---|
    /// | names of [`Shape::parts`] | theirs | weights and biases; the number of `gru.weight_hh_l…` is that of the layers |
    /// | `scaler_min`, `scaler_max` | `[5]` | ranges of x, ẋ, P_f, P_e (mm, mm/s, kPa) and F (mN) that scale to ±1 |
    /// | `warm_up`, `samples_per_step` | scalar | measured steps before a prediction; samples of a step |
    /// | `step_s` | scalar | optional: sampling interval, s |
    ///
    /// # Errors
    /// [`BaselineError`] if the file cannot be read, or an array is missing or of another shape.
    pub fn from_npz(path: impl AsRef<Path>) -> Result<Self, BaselineError> {
        Self::from_npz_at(path.as_ref())
    }

    /// One instance, whatever the path is given as.
    fn from_npz_at(path: &Path) -> Result<Self, BaselineError> {
        let saved = SavedArrays::read(path)?;
        let [_, hidden] = saved.rows_and_columns("gru.weight_hh_l0")?;
        let layers = (0..).take_while(|l| saved.has(&format!("gru.weight_hh_l{l}"))).count();
        if hidden == 0 || !hidden.is_multiple_of(16) {
            return Err(saved.error(format!("the width {hidden} must be a multiple of 16")));
        }
        let shape = Shape { hidden, layers };
        let mut numbers = Vec::with_capacity(shape.len());
        for part in shape.parts() {
            numbers.extend(saved.values(&part.name, &part.shape)?);
        }
        Ok(Self {
            network: Network::new(shape, &numbers),
            numbers,
            scaling: Scaling {
                low: saved.numbers("scaler_min")?,
                high: saved.numbers("scaler_max")?,
            },
            warm_up: saved.count("warm_up")?,
            samples_per_step: saved.count("samples_per_step")?,
            step_s: saved.optional("step_s")?,
            history: None,
        })
    }

    /// Feeds `history` (scaled measured samples, the last one being the present) from hidden states of
    /// zero, then predicts recursively under `forces` (scaled): scaled states, one more than forces.
    #[must_use]
    pub fn predict_scaled(&self, history: &[[f32; INPUTS]], forces: &[f32]) -> Vec<[f32; OUTPUTS]> {
        let mut running = Running::new(&self.network, 1);
        for input in history {
            running.feed(&self.network, &[*input]);
        }
        let mut out = [[0.0; OUTPUTS]];
        running.read(&self.network, &mut out);
        let mut predicted = vec![out[0]];
        for force in forces {
            let [x, v, pf, pe] = out[0];
            running.feed(&self.network, &[[x, v, pf, pe, *force]]);
            running.read(&self.network, &mut out);
            predicted.push(out[0]);
        }
        predicted
    }

    /// Predicts a few runs side by side. Between steps x is the cubic with the predicted values and
    /// velocities at their ends, the rest a straight line.
    fn predict(&self, runs: &[Run<'_>]) -> Vec<Result<Trajectory, Stopped>> {
        let (n, stride) = (runs.len(), self.samples_per_step);
        let mut running = Running::new(&self.network, n);
        let known = |run: &Run<'_>, back: usize| {
            let k = run.start.saturating_sub(back * stride);
            self.scaling.input_over(run.recording, k, stride).map(|v| v as f32)
        };
        // Samples up to the start. A run without earlier samples has rested at its first one.
        for back in (0..self.warm_up).rev() {
            let inputs: Vec<[f32; INPUTS]> = runs.iter().map(|run| known(run, back)).collect();
            running.feed(&self.network, &inputs);
        }
        let longest = runs.iter().map(Run::len).max().unwrap_or(0);
        let step_s: Vec<f64> =
            runs.iter().map(|run| median_step_s(&run.recording.time_s) * stride as f64).collect();
        let mut results: Vec<Result<Trajectory, Stopped>> = runs
            .iter()
            .map(|run| {
                let mut trajectory = Trajectory::default();
                append(&mut trajectory, &run.state());
                Ok(trajectory)
            })
            .collect();
        let mut states: Vec<[f64; OUTPUTS]> = runs.iter().map(Run::state).collect();
        let mut out = vec![[0.0_f32; OUTPUTS]; n];
        let mut inputs = vec![[0.0_f32; INPUTS]; n];
        // Samples 0 to `from` of the runs are done.
        for from in (0..longest - 1).step_by(stride) {
            running.read(&self.network, &mut out);
            for (member, run) in runs.iter().enumerate() {
                let left = run.len().saturating_sub(from + 1).min(stride);
                if left == 0 {
                    continue;
                }
                let before = std::mem::replace(
                    &mut states[member],
                    self.scaling.state(out[member].map(f64::from)),
                );
                let state = states[member];
                if let Ok(trajectory) = &mut results[member] {
                    for k in 1..=left {
                        let share = k as f64 / stride as f64;
                        append(trajectory, &between(&before, &state, share, step_s[member]));
                    }
                    if out_of_range(state[0]) {
                        results[member] = Err(diverged(run, from + stride, state[0]));
                    }
                }
                let [x, v, pf, pe] = out[member];
                let sample = run.start + from + stride;
                if sample < run.recording.len() {
                    let force = self.scaling.force_over(run.recording, sample, stride);
                    inputs[member] = [x, v, pf, pe, force as f32];
                }
            }
            running.feed(&self.network, &inputs);
        }
        results
    }

    fn check_step(&self, run: &Run<'_>) -> Result<(), Stopped> {
        let own = median_step_s(&run.recording.time_s);
        match self.step_s {
            Some(step_s) if (own - step_s).abs() > 0.01 * step_s => Err(Stopped {
                why: format!("samples are {own} s apart; the network was trained with {step_s} s"),
            }),
            _ => Ok(()),
        }
    }
}

impl FittedModel for GruModel {
    fn simulate(&self, run: &Run<'_>) -> Result<Trajectory, Stopped> {
        self.check_step(run)?;
        self.predict(&[*run]).pop().expect("one run, one result")
    }

    fn simulate_all(
        &self,
        runs: &[Run<'_>],
        done: &(dyn Fn(usize) + Sync),
    ) -> Vec<Result<Trajectory, Stopped>> {
        parallel::map_each(runs.chunks(TASK_RUNS).collect(), |part| {
            let results = match part.iter().try_for_each(|run| self.check_step(run)) {
                Ok(()) => self.predict(part),
                Err(_) => part.iter().map(|run| self.simulate(run)).collect(),
            };
            done(part.len());
            results
        })
        .into_iter()
        .flatten()
        .collect()
    }

    fn parameter_count(&self) -> usize {
        self.numbers.len()
    }

    fn structure(&self) -> Structure {
        Structure::Network
    }

    fn details(&self) -> Value {
        json!({
            "layers": self.network.shape.layers,
            "hidden": self.network.shape.hidden,
            "warm_up_steps": self.warm_up,
            "samples_per_step": self.samples_per_step,
            "history": self.history,
        })
    }

    fn arrays(&self) -> BTreeMap<String, Array> {
        let mut arrays: BTreeMap<String, Array> = self
            .network
            .shape
            .parts()
            .into_iter()
            .map(|part| {
                let shape = part.shape.iter().map(|n| *n as u64).collect();
                (part.name, Array { shape, values: self.numbers[part.range].to_vec() })
            })
            .collect();
        arrays.insert("scaler_min".into(), Array::vector(self.scaling.low.to_vec()));
        arrays.insert("scaler_max".into(), Array::vector(self.scaling.high.to_vec()));
        arrays.insert("warm_up".into(), Array::scalar(self.warm_up as f64));
        arrays.insert("samples_per_step".into(), Array::scalar(self.samples_per_step as f64));
        arrays.extend(self.step_s.map(|s| ("step_s".into(), Array::scalar(s))));
        arrays
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cubic_lies_between_steps() {
        let at =
            |t: f64| [1.0 + t * (2.0 + t * (-3.0 + 4.0 * t)), 2.0 + t * (-6.0 + 12.0 * t), t, 5.0];
        let (from, step_s) = (0.3, 0.05);
        for share in [0.1, 0.5, 0.8, 1.0] {
            let own = between(&at(from), &at(from + step_s), share, step_s);
            let exact = at(from + share * step_s);
            assert!((own[0] - exact[0]).abs() < 1e-14, "{own:?} {exact:?}");
            assert!((own[2] - exact[2]).abs() < 1e-14 && own[3] == 5.0);
        }
    }
}
