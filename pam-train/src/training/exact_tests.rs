//! Training in closed form beside training through steps.

use super::Trainer;
use crate::curriculum::Curriculum;
use pam_core::SealedMasses;
use pam_data::Recording;
use std::path::Path;

/// A joint that swings under a sine, as two sensors might have seen it.
fn recording(name: &str, phase: f64) -> Recording {
    let mut r = Recording::empty(Path::new("joint"));
    r.name = name.into();
    r.time_s = (0..1200).map(|k| f64::from(k) * 1e-3).collect();
    let wave = |amplitude: f64, shift: f64| -> Vec<f64> {
        r.time_s.iter().map(|t| amplitude * (9.0 * t + phase + shift).sin()).collect()
    };
    (r.force_mn, r.displacement_mm) = (wave(1e5, 0.0), wave(0.5, -0.1));
    r.velocity_mm_s = wave(4.5, -0.1 + std::f64::consts::FRAC_PI_2);
    r.pressure_flexor_kpa = wave(-5.0, -0.1).iter().map(|p| 380.0 + p).collect();
    r.pressure_extensor_kpa = wave(5.0, -0.1).iter().map(|p| 420.0 + p).collect();
    r.given_masses = Some(SealedMasses { flexor_g: 0.07, extensor_g: 0.08 });
    r
}

/// The losses of a whole run, epoch by epoch.
fn losses(solver: &str) -> Vec<f64> {
    let text = format!(
        "name = \"both\"\nrate = 1e-3\nloss = {{ kind = \"published\" }}\n\
         [data]\ntrain = \"all\"\n\
         [model]\nhidden = [16, 16]\nactivation = \"leaky_relu\"\n\
         [solver]\n{solver}\ninput = \"zoh\"\nprecision = \"f64\"\n\
         [[stage]]\nkind = \"gas\"\nname = \"gas\"\n\
         [[stage]]\nkind = \"derivatives\"\nname = \"network\"\n\
         matching = {{ steps = 400, rate = 6e-3, mass_steps = 100 }}\n\
         [[stage]]\nkind = \"solve\"\nname = \"damped\"\nauxiliary_damping = 1000.0\nepochs = 12\n\
         [[stage]]\nkind = \"solve\"\nname = \"free\"\nepochs = 12\n"
    );
    let curriculum = Curriculum::parse(&text, Path::new("both.toml"), &[]).unwrap();
    let recordings = vec![recording("nn_3030", 0.0), recording("nn_4045", 1.1)];
    let mut trainer = Trainer::new(curriculum, recordings, None, 3).unwrap();
    let mut losses = Vec::new();
    while let Some(row) = trainer.advance().unwrap() {
        losses.push(row.loss);
    }
    losses
}

/// A run in closed form goes as one through short steps, epoch by epoch: each loss follows from the
/// gradients of all epochs before it.
#[test]
fn training_in_closed_form_goes_as_training_through_steps() {
    let exact = losses("method = \"exact\"");
    let steps = losses("method = \"rk4\"\nstep_ms = 0.02");
    assert_eq!(exact.len(), 26);
    assert!(exact[25] < 0.95 * exact[14], "the run trains: {exact:?}");
    for (epoch, (a, b)) in exact.iter().zip(&steps).enumerate() {
        assert!((a - b).abs() < 1e-6 * b, "epoch {epoch}: {a} {b}");
    }
}
