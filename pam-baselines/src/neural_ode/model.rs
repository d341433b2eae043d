//! A trained field in use.

use super::network::{Field, STATES, STRIDE};
use crate::koopman::Standard;
use crate::method::{FittedModel, Run, Stopped, Structure, Trajectory, diverged, out_of_range};
use pam_data::formats::npz::Array;
use pam_data::recording::median_step_s;
use pam_solvers::rk4_step;
use serde_json::{Value, json};
use std::collections::BTreeMap;

/// A trained field.
#[derive(Debug, Clone)]
pub struct NeuralOdeModel {
    /// The field, in single precision as it was trained.
    pub field: Field<f32>,
    /// Its numbers.
    pub numbers: Vec<f64>,
    /// Scaling of the state.
    pub state: Standard<4>,
    /// Scaling of the force.
    pub input: Standard<1>,
    /// Rates by which the network's outputs are multiplied, 1/s.
    pub rates: [f64; STATES],
    /// Time between samples in training, s.
    pub sample_s: f64,
    /// Samples of a Runge–Kutta step.
    pub samples_per_step: usize,
    /// Mean squared scaled error at the end of training, a running mean.
    pub loss: f64,
}

impl NeuralOdeModel {
    fn rate(&self, z: &[f64; STATES], u: f64, work: &mut Work) -> [f64; STATES] {
        for (to, from) in work.inputs.iter_mut().zip(z.iter().chain([&u])) {
            *to = *from as f32;
        }
        let [first, second] = &mut work.kept;
        self.field.eval(1, &work.inputs, [first, second], &mut work.rates);
        std::array::from_fn(|c| f64::from(work.rates[c]))
    }
}

struct Work {
    inputs: Vec<f32>,
    kept: [Vec<f32>; 2],
    rates: Vec<f32>,
}

impl FittedModel for NeuralOdeModel {
    /// Runge–Kutta steps as in training; samples within a step by cubic Hermite interpolation.
    fn simulate(&self, run: &Run<'_>) -> Result<Trajectory, Stopped> {
        let r = run.recording;
        let own = median_step_s(&r.time_s);
        if (own - self.sample_s).abs() > 0.01 * self.sample_s {
            return Err(Stopped {
                why: format!(
                    "samples are {own} s apart; the field was trained with {} s",
                    self.sample_s
                ),
            });
        }
        let m = self.samples_per_step;
        let h = m as f64 * self.sample_s;
        let mut work = Work {
            inputs: vec![0.0; STRIDE],
            kept: [vec![0.0; self.field.width], vec![0.0; self.field.width]],
            rates: vec![0.0; STRIDE],
        };
        let last = r.len() - 1;
        let force = |k: usize| self.input.apply(&[r.force_mn[k.min(last)]])[0];
        let mut out = Trajectory::from_fn(|_| Vec::with_capacity(run.len()));
        let mut push = |k: usize, state: [f64; 4]| {
            if out_of_range(state[0]) {
                return Err(diverged(run, k, state[0]));
            }
            out.x.push(state[0]);
            out.v.push(state[1]);
            out.pf.push(state[2]);
            out.pe.push(state[3]);
            Ok(())
        };
        push(0, run.state())?;
        let mut z = self.state.apply(&run.state());
        let mut at = run.start;
        let mut k1 = self.rate(&z, force(at), &mut work);
        while at < last {
            let u = [force(at), force(at + m / 2), force(at + m)];
            let next = rk4_step(z, k1, h, |half, z| self.rate(&z, u[half], &mut work));
            let end = self.rate(&next, u[2], &mut work);
            for j in 1..=m.min(last - at) {
                let s = j as f64 / m as f64;
                let (s2, s3) = (s * s, s * s * s);
                let between: [f64; STATES] = std::array::from_fn(|c| {
                    (2.0 * s3 - 3.0 * s2 + 1.0) * z[c]
                        + (3.0 * s2 - 2.0 * s3) * next[c]
                        + h * ((s3 - 2.0 * s2 + s) * k1[c] + (s3 - s2) * end[c])
                });
                push(at + j - run.start, self.state.invert(&between))?;
            }
            (z, k1) = (next, end);
            at += m;
        }
        Ok(out)
    }

    fn parameter_count(&self) -> usize {
        self.numbers.len()
    }

    fn structure(&self) -> Structure {
        Structure::Network
    }

    fn details(&self) -> Value {
        json!({ "width": self.field.width, "loss": self.loss, "rates_per_second": self.rates })
    }

    fn arrays(&self) -> BTreeMap<String, Array> {
        BTreeMap::from([
            ("numbers".into(), Array::vector(self.numbers.clone())),
            ("rates".into(), Array::vector(self.rates.to_vec())),
            ("X_mean".into(), Array::vector(self.state.mean.to_vec())),
            ("X_std".into(), Array::vector(self.state.deviation.to_vec())),
            ("U_mean".into(), Array::vector(self.input.mean.to_vec())),
            ("U_std".into(), Array::vector(self.input.deviation.to_vec())),
        ])
    }
}
