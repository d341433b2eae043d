use crate::common::diagnosis;
use pam_core::AnyForce;
use pam_data::{LoadOptions, Subject, open_recordings};
use pam_diagnose::RecordingSets;
use pam_effects::ExtendedModel;
use pam_experiment::design::{DesignLimits, DesignOptions, Objective, design};
use pam_experiment::detect::DetectOptions;
use pam_experiment::standing::{conclusion, live_causes, standing};
use pam_rig::{Conditions, Protocol, RigParameters, Session};
use std::path::Path;

/// A measurement on the virtual rig, with an effect that the model does not know.
fn record(
    protocol: &Protocol,
    effect: Option<&str>,
    model: &ExtendedModel,
    seed: u64,
) -> Vec<Subject> {
    let mut rig = RigParameters { steps_per_sample: 4, ..RigParameters::default() };
    rig.effects.extend(effect.map(|e| e.parse::<pam_rig::Effect>().expect("an effect")));
    let session =
        Session { rig, protocol: protocol.clone(), seed, truth: false, note: String::new() };
    let folder = tempfile::tempdir().expect("a folder");
    let entries = session.record_into(folder.path(), true, &|_| {}).expect("the rig records");
    let read = |log: &Path| {
        let runs = open_recordings(log, &LoadOptions::default()).expect("a log");
        Subject::of(runs.into_iter().next().expect("a run"), &model.joint).expect("masses")
    };
    entries.iter().map(|e| read(&e.log)).collect()
}

/// Run by `cargo test --release --workspace --tests -- --ignored long::`.
mod long {
    use super::*;

    /// Measure, diagnose, design, measure again, diagnose both: without a person. The hidden cause is among those that are left, each
    /// measurement has its standing, and the end is one answer or the pairs that are not distinguished.
    #[test]
    #[ignore = "long"]
    fn the_loop_runs_on_the_virtual_rig() {
        let bytes = include_bytes!("../../../pam-cli/models/default.safetensors");
        let saved = pam_data::parse_model(Path::new("default"), bytes).expect("the model");
        assert!(matches!(saved.model.force, AnyForce::Network(_)));
        let model = ExtendedModel::from_saved(saved).expect("known effects");
        let ids = ["coulomb_friction", "load_friction", "viscous_damping"];
        let options = diagnosis(&ids);
        let hidden = Some("coulomb_friction:force_n=20");
        let first = Protocol {
            conditions: Some(Conditions::List(vec![[45, 45], [40, 40], [50, 50]])),
            ..Protocol::paper().with_duration(4.0)
        };
        let baseline = record(&first, None, &model, 3);
        let mut data = record(&first, hidden, &model, 1);
        let mut measurements = vec![("first".to_owned(), data.len())];
        let sets = RecordingSets { data: &data, test: None, baseline: Some(&baseline) };
        let (_, found) =
            standing(&model, &measurements, &sets, &options, &|_, _, _| {}).expect("found");
        let live = live_causes(&found);
        let objective =
            if live.is_empty() { Objective::MedianLimit } else { Objective::Separation(live) };
        let effort = DesignOptions {
            detect: DetectOptions { diagnosis: options.clone(), ..DetectOptions::default() },
            limits: DesignLimits { seconds: 4.0, psi: [35, 55], ..DesignLimits::default() },
            objective,
            evaluations: 8,
            ..DesignOptions::default()
        };
        let designed = design(&model, &effort, &|_| {}).expect("a design");
        let second = record(&designed.protocol, hidden, &model, 2);
        measurements.push(("second".to_owned(), second.len()));
        data.extend(second);
        let sets = RecordingSets { data: &data, test: None, baseline: Some(&baseline) };
        let (all, found) =
            standing(&model, &measurements, &sets, &options, &|_, _, _| {}).expect("found");
        assert_eq!(all.len(), 2);
        assert_eq!((all[0].recordings, all[1].recordings), (3, 6));
        assert!(all[1].live().contains(&"coulomb_friction"), "{all:?}");
        let end = conclusion(&found, Some(&designed));
        assert!(end.contains("one answer") || end.contains("do not distinguish"), "{end}");
    }
}
