//! Training of weights and effects together: it finds what neither finds alone, goes on where it stopped, and
//! writes a model that reads back.

#[path = "../../pam-effects/tests/effects/support/mod.rs"]
#[allow(dead_code)]
mod support;

use pam_core::{AnyForce, ParametricForce};
use pam_data::Subject;
use pam_data::models::safetensors_file;
use pam_data::{MassOrigin, Recording, load_model};
use pam_effects::ExtendedModel;
use pam_effects::effects::ALL;
use pam_train::curriculum::Curriculum;
use pam_train::effects_of;
use pam_train::training::{RunFolder, RunSettings, Trainer, train_into};
use pam_trajectory::{Predictor, SolverSettings};
use rand::SeedableRng;
use rand::rngs::ChaCha8Rng;
use rand_distr::{Distribution, Normal};
use std::path::Path;
use std::sync::atomic::AtomicBool;
use std::time::Duration;
use support::extended::extended;
use support::published::exact_run;

/// Runs of a plant with noise of its sensors: 3 µm, 0.2 mm/s, 0.05 kPa.
fn recordings(plant: &ExtendedModel, conditions: &[[f64; 2]]) -> Vec<Subject> {
    let mut random = ChaCha8Rng::seed_from_u64(7);
    conditions
        .iter()
        .map(|&[flexor, extensor]| {
            let at_rest = exact_run(&plant.joint, [flexor, extensor], 0.1);
            let masses = at_rest.masses;
            let run = plant
                .predict(&at_rest.recording, masses, &SolverSettings::default())
                .expect("the plant runs");
            let mut recording: Recording = run.to_recording(&at_rest.recording, masses);
            recording.name = format!("nn_{flexor}{extensor}");
            for (channel, size) in [
                (&mut recording.displacement_mm, 3e-3),
                (&mut recording.velocity_mm_s, 0.2),
                (&mut recording.pressure_flexor_kpa, 0.05),
                (&mut recording.pressure_extensor_kpa, 0.05),
            ] {
                let noise = Normal::new(0.0, size).expect("a size");
                channel.iter_mut().for_each(|v| *v += noise.sample(&mut random));
            }
            Subject { recording, masses, origin: MassOrigin::Given }
        })
        .collect()
}

/// The model with every weight off by a factor of about so much.
fn perturbed(model: &ExtendedModel, share: f64) -> ExtendedModel {
    let AnyForce::Network(force) = &model.joint.force else { panic!("a network") };
    let mut random = ChaCha8Rng::seed_from_u64(5);
    let factor = Normal::new(1.0, share).expect("a share");
    let weights: Vec<f64> =
        force.parameters().iter().map(|w| w * factor.sample(&mut random)).collect();
    let mut moved = model.clone();
    moved.joint.force = AnyForce::Network(force.with_parameters(&weights));
    moved
}

/// A trainer that starts from a file.
fn trainer(file: &Path, subjects: &[Subject], more: &[&str]) -> Trainer {
    let start = format!("model.start={{ file = {:?} }}", file.display().to_string());
    let more: Vec<String> =
        [start].into_iter().chain(more.iter().map(|m| (*m).to_owned())).collect();
    let curriculum = Curriculum::open("joint", &more).expect("a curriculum");
    let effects = effects_of(&curriculum, ALL).expect("known effects");
    let data = subjects.iter().map(|s| s.recording.clone()).collect();
    Trainer::extended(curriculum, data, None, effects, 1).expect("a trainer")
}

fn settings() -> RunSettings {
    RunSettings {
        checkpoint_every: Duration::ZERO,
        model_name: "joint".into(),
        made_by: "test".into(),
    }
}

/// Mean error of the displacement, mm.
fn error_mm(model: &ExtendedModel, subjects: &[Subject]) -> f64 {
    let one = |s: &Subject| {
        let run = model
            .predict(&s.recording, s.masses, &SolverSettings::default())
            .expect("the model runs");
        let pairs = run.channels.x.iter().zip(&s.recording.displacement_mm);
        (pairs.map(|(a, b)| (a - b).powi(2)).sum::<f64>() / run.channels.x.len() as f64).sqrt()
    };
    subjects.iter().map(one).sum::<f64>() / subjects.len() as f64
}

fn trained(file: &Path, subjects: &[Subject], out: &Path, more: &[&str]) -> ExtendedModel {
    let mut trainer = trainer(file, subjects, more);
    let stop = AtomicBool::new(false);
    let run =
        train_into(&mut trainer, &RunFolder::new(out), &settings(), false, &stop, &mut |_, _| {})
            .expect("training ends");
    assert!(run.finished && run.events.is_empty(), "{:?}", run.events);
    let saved = load_model(out.join("model.safetensors")).expect("a model");
    ExtendedModel::from_saved(saved).expect("known effects")
}

/// A run that was stopped and goes on ends with the same bits, and its history tells the effects.
#[test]
fn a_run_that_goes_on_ends_with_the_same_bits() {
    let folder = tempfile::tempdir().expect("a folder");
    let plant = extended(&[("coulomb_friction", vec![20.0])]);
    let data = recordings(&plant, &[[30.0, 60.0]]);
    let file = folder.path().join("start.safetensors");
    let start = ExtendedModel { effects: Vec::new(), ..plant };
    safetensors_file::write(&file, &start.to_saved()).expect("written");
    let more = [
        "stage.0.epochs=6",
        "model.effects=[{ effect = \"creep\", values = { stiffness_n_mm = 4.0, time_constant_s = 0.7 } }]",
    ];
    let [whole, parts] = ["whole", "parts"].map(|n| folder.path().join(n));
    let model = trained(&file, &data, &whole, &more);
    assert_eq!(model.effects[0].effect.info().id, "creep");
    assert!(model.effects[0].values != [4.0, 0.7]);
    let stop = AtomicBool::new(false);
    let mut first = trainer(&file, &data, &more);
    let run = train_into(
        &mut first,
        &RunFolder::new(&parts),
        &settings(),
        false,
        &stop,
        &mut |row, _| stop.store(row.total_epoch == 3, std::sync::atomic::Ordering::Relaxed),
    );
    assert!(!run.expect("it stops").finished);
    let mut again = trainer(&file, &data, &more);
    let go_on = AtomicBool::new(false);
    let run =
        train_into(&mut again, &RunFolder::new(&parts), &settings(), true, &go_on, &mut |_, _| {});
    assert_eq!(run.expect("it ends").rows.len(), 6);
    let bytes = |out: &Path| std::fs::read(out.join("model.safetensors")).expect("a model");
    assert!(bytes(&whole) == bytes(&parts));
    let metrics = std::fs::read_to_string(parts.join("metrics.csv")).expect("a history");
    let header = metrics.lines().next().expect("a header");
    assert!(header.ends_with("seconds,creep.stiffness_n_mm,creep.time_constant_s"), "{header}");
    let last: Vec<f64> = metrics
        .lines()
        .last()
        .expect("a row")
        .split(',')
        .skip(13)
        .map(|cell| cell.parse().expect("a number"))
        .collect();
    assert_eq!(last.len(), 2);
    assert!(last[0] != 4.0 && (0.5..1.0).contains(&last[1]), "{last:?}");
}

/// Windows with trained starts, and batches of windows, train both as well.
#[test]
fn windows_and_shooting_train_both() {
    let folder = tempfile::tempdir().expect("a folder");
    let plant = extended(&[("viscous_damping", vec![900.0])]);
    let data = recordings(&plant, &[[30.0, 60.0], [45.0, 45.0]]);
    let file = folder.path().join("start.safetensors");
    let start = extended(&[("viscous_damping", vec![0.0])]);
    safetensors_file::write(&file, &start.to_saved()).expect("written");
    for kind in ["shooting={}", "batch=5"] {
        let kind = format!("stage.0.{kind}");
        let more = ["stage.0.epochs=12", "rate=3e-4", "stage.0.horizon_s=1.0", &kind];
        let mut trainer = trainer(&file, &data, &more);
        let mut losses = Vec::new();
        while let Some(row) = trainer.advance().expect("an epoch") {
            losses.push(row.loss);
        }
        let [(_, damping)] = &trainer.effect_values()[..] else { panic!("one parameter") };
        println!("{kind}: {damping} N s/m, {losses:?}");
        assert!(losses[11] < 0.75 * losses[0], "{kind}: {losses:?}");
        assert!((150.0..1500.0).contains(damping), "{kind}: {damping}");
    }
}

/// What cannot be trained is refused with the reason.
#[test]
fn what_cannot_be_trained_is_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("start.safetensors");
    let data = recordings(&extended(&[]), &[[30.0, 60.0]]);
    let refused = |effects: &[(&str, Vec<f64>)], more: &[&str], expected: &str| {
        safetensors_file::write(&file, &extended(effects).to_saved()).expect("written");
        let error = trainer(&file, &data, more).advance().expect_err("refused").to_string();
        assert!(error.contains(expected), "{error}");
    };
    let leak = [("leak", vec![1e-3, 1e-3])];
    refused(&leak, &["stage.0.horizon_s=1.0"], "effect `leak`: it depends on what was before");
    let far = [("force_saturation", vec![5e4])];
    refused(&far, &[], "`force_n` = 50000 changes no prediction");
    let gradient = "solver.gradient=forward";
    let curriculum = Curriculum::open(
        "joint",
        &[gradient.into(), format!("model.start={{ file = {:?} }}", file.display().to_string())],
    )
    .expect("a curriculum");
    let effects = effects_of(&curriculum, ALL).expect("known");
    let recordings = data.iter().map(|s| s.recording.clone()).collect();
    let error = Trainer::extended(curriculum, recordings, None, effects, 1).expect_err("refused");
    assert!(error.to_string().contains("solver.gradient forward"), "{error}");
}

/// Run by `cargo test --release --workspace --tests -- --ignored long::`.
mod long {
    use super::*;

    /// A plant with a dry friction of 20 N; a model whose weights are off and which believes in 5 N.
    #[test]
    #[ignore = "long"]
    fn weights_and_friction_are_found_together() {
        let folder = tempfile::tempdir().expect("a folder");
        let plant = extended(&[("coulomb_friction", vec![20.0])]);
        let data = recordings(&plant, &[[30.0, 60.0], [45.0, 45.0], [60.0, 40.0], [20.0, 20.0]]);
        let held_out = recordings(&plant, &[[40.0, 50.0], [55.0, 35.0]]);
        let start = perturbed(&extended(&[("coulomb_friction", vec![5.0])]), 0.03);
        let file = folder.path().join("start.safetensors");
        safetensors_file::write(&file, &start.to_saved()).expect("written");
        let long = ["stage.0.epochs=40", "rate=4e-4"];
        let with = |name: &str, more: &[&str]| {
            trained(&file, &data, &folder.path().join(name), &[&long, more].concat())
        };
        let both = with("both", &[]);
        let weights = with("weights", &["coordinates.frozen.effects=true"]);
        let effects = with("effects", &["coordinates.frozen.network=true"]);
        let force_n = both.effects[0].values[0];
        let errors = [&start, &both, &weights, &effects].map(|m| error_mm(m, &held_out));
        println!("friction {force_n} N, effects alone {} N", effects.effects[0].values[0]);
        println!("errors in mm: start, both, weights alone, effects alone {errors:?}");
        assert!((force_n / 20.0 - 1.0).abs() < 0.1, "{force_n} N");
        assert_eq!(weights.effects[0].values, [5.0]);
        assert!(errors[1] < 0.65 * errors[2] && errors[1] < 0.65 * errors[3], "{errors:?}");
        // What was frozen is as it was.
        let AnyForce::Network(network) = &start.joint.force else { panic!("a network") };
        let AnyForce::Network(kept) = &effects.joint.force else { panic!("a network") };
        for (a, b) in network.parameters().iter().zip(kept.parameters()) {
            assert!((a - b).abs() <= 1e-9 * a.abs().max(1e-3), "{a} {b}");
        }
    }
}
