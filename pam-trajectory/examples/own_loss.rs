//! A loss of one's own for the joint: log-cosh, which is quadratic for small errors and linear for large ones.
//!
//! With `NamedLoss` it has a name in every command of a program of one's own (`templates/own-pam`). To ship it, put it into
//! `pam-trajectory/src/loss/log_cosh.rs`, and add two lines: `mod log_cosh;` in `mod.rs` and
//! `LogCosh(log_cosh::LogCosh),` in the list of `any.rs`.

use pam_core::{JointModel, SpringDamper};
use pam_data::Subject;
use pam_data::{Channel, MassOrigin, Recording};
use pam_trajectory::loss::loss_fn;
use pam_trajectory::{
    GeneralEngine, GradientChoice, Predictor, SolverSettings, TrajectoryEngine, TrajectoryLoss,
    TrajectoryRequest, Windows,
};
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;

/// `Σ_c mean_k ln cosh((predicted − measured) / scale_c)`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct LogCosh {
    /// Scale of each channel: mm, mm/s, kPa, kPa.
    pub scales: [f64; 4],
}

impl TrajectoryLoss for LogCosh {
    fn value_and_cotangents(
        &self,
        measured: &Recording,
        predicted: &[[f64; 4]],
        cotangents: &mut [[f64; 4]],
    ) -> f64 {
        let share = 1.0 / predicted.len() as f64;
        let mut value = 0.0;
        for (k, (p, w)) in predicted.iter().zip(cotangents).enumerate() {
            for (c, channel) in Channel::ALL.into_iter().enumerate() {
                let e = (p[c] - measured.channel(channel)[k]) / self.scales[c];
                // ln cosh e without overflow.
                value += share * (e.abs() + (-2.0 * e.abs()).exp().ln_1p() - 2.0_f64.ln());
                w[c] = share * e.tanh() / self.scales[c];
            }
        }
        value
    }
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    // A recording of two seconds, made by a joint that is stiffer than the model will be.
    let plant = JointModel::datasheet(SpringDamper::constant(170e3, 6500.0));
    let masses = plant.gas_law_masses(0.0, [412.0, 412.0]);
    let time_s: Vec<f64> = (0..1000).map(|k| 2e-3 * f64::from(k)).collect();
    let command = Recording {
        displacement_mm: vec![0.0; time_s.len()],
        velocity_mm_s: vec![0.0; time_s.len()],
        pressure_flexor_kpa: vec![412.0; time_s.len()],
        pressure_extensor_kpa: vec![412.0; time_s.len()],
        force_mn: time_s.iter().map(|t| 100e3 * (TAU * t).sin()).collect(),
        time_s,
        ..Recording::empty("made up")
    };
    let settings = SolverSettings::default();
    let run = plant.predict(&command, masses, &settings)?;
    let recording = run.to_recording(&command, masses);
    let subject = Subject { recording, masses, origin: MassOrigin::Given };
    let windows = Windows::of([subject], None);

    let loss = LogCosh { scales: [0.1, 1.0, 5.0, 5.0] };
    let at = |stiffness_mn_mm: f64| {
        let model = JointModel::datasheet(SpringDamper::constant(stiffness_mn_mm, 6500.0));
        let mut engine = GeneralEngine::new(GradientChoice::Adjoint, settings.clone());
        engine.value_and_gradient(&TrajectoryRequest::new(&model, &windows), &loss)
    };
    let gradient = at(150e3)?;
    let slope = gradient.force[0];
    println!("loss {:.6}, slope by the stiffness {slope:.3e} per mN/mm", gradient.value);
    assert!(slope < 0.0, "the plant is stiffer than the model");
    let difference = (at(150e3 + 10.0)?.value - at(150e3 - 10.0)?.value) / 20.0;
    assert!((slope - difference).abs() < 1e-4 * slope.abs(), "{slope} {difference}");

    // A closure is a loss as well.
    let last_only = loss_fn(|measured, predicted, cotangents| {
        let k = predicted.len() - 1;
        let e = predicted[k][0] - measured.displacement_mm[k];
        cotangents[k][0] = 2.0 * e;
        e * e
    });
    let model = JointModel::datasheet(SpringDamper::constant(150e3, 6500.0));
    let g = GeneralEngine::new(GradientChoice::Forward, settings)
        .value_and_gradient(&TrajectoryRequest::new(&model, &windows), &last_only)?;
    assert!(g.value > 0.0);
    Ok(())
}
