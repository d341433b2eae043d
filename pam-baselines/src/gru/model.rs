//! A trained network in use.

use super::network::{Network, Running};
use super::parameters::{INPUTS, OUTPUTS};
use super::scaling::Scaling;
use super::train::History;
use crate::method::{
    FittedModel, LARGEST_DISPLACEMENT_MM, Run, Stopped, Structure, Trajectory, diverged,
};
use pam_data::formats::npz::Array;
use pam_data::recording::median_step_s;
use rayon::prelude::*;
use serde_json::{Value, json};
use std::collections::BTreeMap;

/// Recordings of one task.
const LANES: usize = 16;

/// A trained network.
#[derive(Debug, Clone)]
pub struct GruModel {
    /// The network.
    pub network: Network<f32>,
    /// Its numbers, in the order of [`Shape::parts`](super::Shape::parts).
    pub numbers: Vec<f64>,
    /// Scaling of inputs and outputs.
    pub scaling: Scaling,
    /// Samples from which the hidden states are taken.
    pub warm_up: usize,
    /// Time from sample to sample, s; unknown for the published network.
    pub step_s: Option<f64>,
    /// How it was trained; none if it was read from a file.
    pub history: Option<History>,
}

impl GruModel {
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

    /// Predicts a few runs side by side.
    fn predict(&self, runs: &[Run<'_>]) -> Vec<Result<Trajectory, Stopped>> {
        let n = runs.len();
        let mut running = Running::new(&self.network, n);
        let input =
            |run: &Run<'_>, k: usize| self.scaling.input(run.recording, k).map(|v| v as f32);
        // What is known until the start. A run that knows its first sample only has rested there.
        for back in (0..self.warm_up).rev() {
            let inputs: Vec<[f32; INPUTS]> =
                runs.iter().map(|run| input(run, run.start.saturating_sub(back))).collect();
            running.feed(&self.network, &inputs);
        }
        let longest = runs.iter().map(Run::len).max().unwrap_or(0);
        let mut results: Vec<Result<Trajectory, Stopped>> = runs
            .iter()
            .map(|run| {
                let [x, v, pf, pe] = run.state();
                Ok(Trajectory { x: vec![x], v: vec![v], pf: vec![pf], pe: vec![pe] })
            })
            .collect();
        let mut out = vec![[0.0_f32; OUTPUTS]; n];
        let mut inputs = vec![[0.0_f32; INPUTS]; n];
        for k in 1..longest {
            running.read(&self.network, &mut out);
            for (lane, run) in runs.iter().enumerate() {
                if k >= run.len() {
                    continue;
                }
                let sample = run.start + k;
                let [x, v, pf, pe] = out[lane];
                let force = self.scaling.scale(INPUTS - 1, run.recording.force_mn[sample]);
                inputs[lane] = [x, v, pf, pe, force as f32];
                let state = self.scaling.state(out[lane].map(f64::from));
                if let Ok(t) = &mut results[lane] {
                    if state[0].abs() < LARGEST_DISPLACEMENT_MM {
                        t.x.push(state[0]);
                        t.v.push(state[1]);
                        t.pf.push(state[2]);
                        t.pe.push(state[3]);
                    } else {
                        results[lane] = Err(diverged(run, k, state[0]));
                    }
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
        runs.par_chunks(LANES)
            .flat_map_iter(|part| {
                let results = match part.iter().try_for_each(|run| self.check_step(run)) {
                    Ok(()) => self.predict(part),
                    Err(_) => part.iter().map(|run| self.simulate(run)).collect(),
                };
                done(part.len());
                results
            })
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
            "warm_up_samples": self.warm_up,
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
        arrays
    }
}
