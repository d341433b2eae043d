//! Training in closed form against training through steps.

use pam_core::SealedMasses;
use pam_data::Recording;
use pam_train::curriculum::Curriculum;
use pam_train::training::Trainer;
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

fn trainer(solver: &str) -> Trainer {
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
    Trainer::new(curriculum, recordings, None, 3).unwrap()
}

/// Run by `cargo test --release --workspace --tests -- --ignored long::`.
mod long {
    use super::*;

    /// Every epoch of a run in closed form, done again from the same state through short steps, has the same loss.
    /// Two runs that are left to themselves part after a few epochs: Adam makes full steps of gradients that are zero
    /// but for the steps' error.
    #[test]
    #[ignore = "long"]
    fn training_in_closed_form_has_the_losses_of_training_through_steps() {
        let mut exact = trainer("method = \"exact\"");
        let mut losses = Vec::new();
        while !exact.is_done() {
            let mut steps = trainer("method = \"rk4\"\nstep_ms = 0.02");
            steps.resume(exact.state().clone()).unwrap();
            let b = steps.advance().unwrap().map(|row| row.loss);
            let a = exact.advance().unwrap().map(|row| row.loss);
            if let (Some(a), Some(b)) = (a, b) {
                assert!((a - b).abs() < 1e-6 * b, "epoch {}: {a} {b}", losses.len());
                losses.push(a);
            }
        }
        assert_eq!(losses.len(), 26);
        assert!(losses[25] < 0.95 * losses[14], "the run trains: {losses:?}");
    }
}
