//! Faults that begin in the middle of a recording, in the later recordings, in the test part, and not at all.
//!
//! ```sh
//! cargo run --release -p pam-tests --features studies --example onset -- --out target/onset.json
//! ```

use clap::Parser;
use pam_data::atomic::write_atomic;
use pam_diagnose::{DiagnoseOptions, JointDiagnosis, RecordingSets, diagnose};
use pam_effects::ExtendedModel;
use pam_tests::plant::Hidden;
use pam_tests::study::{Case, Factors, Fault, Kind, data};
use serde_json::{Value, json};
use std::path::PathBuf;

#[derive(Parser)]
#[command(about = "Onsets of a dry friction of 25 N, and recordings in which nothing begins")]
struct Arguments {
    /// Runs of each kind; 40 of those without a fault where this is not said.
    #[arg(long)]
    runs: Option<usize>,
    /// Seed of the first run.
    #[arg(long, default_value_t = 0)]
    first: u64,
    /// Kinds: middle, later, test, null.
    #[arg(long, value_delimiter = ',', default_value = "middle,later,test,null")]
    kinds: Vec<String>,
    /// File for the counts and each run.
    #[arg(long)]
    out: PathBuf,
}

const FRICTION_N: f64 = 25.0;
const MIDDLE_S: f64 = 35.0;
const TEST_S: f64 = 55.0;
/// Most by which a time may be wrong, s.
const LARGEST_ERROR_S: f64 = 0.5;

fn case(kind: &str, seed: u64) -> Case {
    let friction = Hidden::new("coulomb_friction", &[("force_n", FRICTION_N)]);
    let one = Factors { recordings: 1, duration_s: 70.0, ..Factors::default() };
    let (factors, faults) = match kind {
        "middle" => (one, vec![friction.from_s(MIDDLE_S)]),
        "test" => (one, vec![friction.from_s(TEST_S)]),
        "later" => {
            let four = Factors { recordings: 4, duration_s: 20.0, ..Factors::default() };
            (four, vec![friction.in_recordings(vec![2, 3])])
        }
        _ => (one, Vec::new()),
    };
    Case {
        id: format!("{kind}-{seed}"),
        kind: Kind::Onset,
        factors,
        faults: faults.into_iter().map(Fault::Given).collect(),
        conditions: Vec::new(),
        seed: 80_000 + seed,
        diagnosis_seed: 1,
        repeats: None,
    }
}

fn diagnosed(case: &Case) -> JointDiagnosis {
    let made = data::data(case);
    let model = ExtendedModel::from_saved(made.model).expect("known effects");
    let sets = RecordingSets { data: &made.subjects, test: None, baseline: None };
    let options = DiagnoseOptions { law: false, ..DiagnoseOptions::default() };
    diagnose(&model, &sets, &options, &|_, _| {}).expect("it can be diagnosed")
}

/// Whether the run is right, and what it said.
fn judged(kind: &str, d: &JointDiagnosis) -> (bool, Value) {
    let only = match d.causes.as_slice() {
        [one] if one.effect == "coulomb_friction" => Some(one),
        _ => None,
    };
    let timed = d.causes.iter().chain(&d.minor).any(|c| c.acts.is_some());
    let said = json!({
        "verdict": d.verdict,
        "named": d.named(),
        "parameters": only.map(|c| json!(c)["parameters"].clone()),
        "acts": only.and_then(|c| c.acts.clone()),
        "late": d.late_fault,
        "timed": timed,
        "causes": d.causes.iter().chain(&d.minor).map(|c| json!({ "id": c.effect, "values": c.member.values, "acts": c.acts.as_ref().map(|a| a.sentence("it")) })).collect::<Vec<_>>(),
        "reasons": d.reasons,
        "confusable": d.causes.iter().map(|c| c.confusable_with.clone()).collect::<Vec<_>>(),
    });
    let right = match kind {
        "middle" => only.is_some_and(|c| {
            let onset = c.parameters.iter().find(|p| p.0 == "onset_s");
            onset.is_some_and(|(_, i)| (i.value - MIDDLE_S).abs() < LARGEST_ERROR_S)
        }),
        "test" => d.late_fault.as_ref().is_some_and(|late| {
            let onset = late.parameters.get("onset_s");
            late.effect == "coulomb_friction"
                && onset.is_some_and(|i| (i.value - TEST_S).abs() < LARGEST_ERROR_S)
        }),
        "later" => {
            let acts = only.and_then(|c| c.acts.as_ref());
            let told = d.late_fault.as_ref().map(|l| &l.acts);
            acts.or(told).is_some_and(|acts| {
                acts.recordings.iter().all(|r| {
                    let later = r.recording.ends_with("_2") || r.recording.ends_with("_3");
                    r.acts == if later { "always" } else { "never" }
                })
            })
        }
        _ => !timed && d.late_fault.is_none(),
    };
    (right, said)
}

fn main() {
    let arguments = Arguments::parse();
    let mut all = serde_json::Map::new();
    for kind in &arguments.kinds {
        let runs = arguments.runs.unwrap_or(if kind == "null" { 40 } else { 10 });
        let mut right = 0;
        let mut each = Vec::new();
        for seed in arguments.first..arguments.first + runs as u64 {
            let (holds, said) = judged(kind, &diagnosed(&case(kind, seed)));
            right += usize::from(holds);
            println!("{kind} {seed} {}: {said}", if holds { "right" } else { "WRONG" });
            each.push(json!({ "seed": seed, "right": holds, "said": said }));
        }
        println!("{kind}: {right} of {runs}");
        let errors = each.iter().filter_map(|run| {
            Some((run["said"]["parameters"]["onset_s"]["value"].as_f64()? - MIDDLE_S).abs())
        });
        let largest = errors.fold(0.0, f64::max);
        all.insert(
            kind.clone(),
            json!({ "right": right, "runs": runs, "largest_error_s": largest, "each": each }),
        );
    }
    let text = serde_json::to_string_pretty(&Value::Object(all)).expect("plain values");
    write_atomic(&arguments.out, text.as_bytes()).expect("the file can be written");
}
