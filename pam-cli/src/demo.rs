//! The main job on no data at all: the virtual rig makes a recording, the physics-only model predicts
//! it, and the report shows what the model misses.

use crate::arguments::{DemoArguments, GlobalOptions};
use crate::commands::evaluate::evaluate_into;
use crate::console::Console;
use crate::error::CliError;
use crate::options::built_in_spring_damper;
use crate::run_record;
use pam_data::{LoadOptions, MassChoice, open_recordings, resolve_masses};
use pam_rig::protocol::CurrentSegment;
use pam_rig::{Conditions, Protocol, RigParameters, Session};
use pam_train::{SolverSettings, Subject};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde_json::json;
use std::process::ExitCode;

/// Excitation: frequency (Hz), length at 1 A and at 1.5 A (s). The published one, shortened.
const EXCITATION: [(f64, f64); 3] = [(0.5, 6.0), (1.0, 3.0), (2.0, 2.0)];

/// Runs the demo.
///
/// # Errors
/// [`CliError`] if a file cannot be written.
pub fn run(
    arguments: &DemoArguments,
    global: &GlobalOptions,
    console: &Console,
) -> Result<ExitCode, CliError> {
    let folder = &arguments.out;
    let session = session(global.seed);
    let runs = session.protocol.runs()?;
    let [psi, _] = runs[0].start_psi;
    console.text(format!(
        "The virtual rig (seed {}) records a run: both muscles at {psi:.0} psi, torque at 0.5, 1 and \
         2 Hz.",
        global.seed
    ));
    session.record_into(folder, true, &|_| {})?;

    let saved = built_in_spring_damper();
    let mut subjects = Vec::new();
    for recording in open_recordings(&folder.join(&runs[0].name), &LoadOptions::default())? {
        let (masses, origin) =
            resolve_masses(&recording, &saved.model, false, MassChoice::GasLaw, None)?;
        subjects.push(Subject { recording, masses, origin });
    }
    console.text(
        "A linear spring–damper, which knows the joint's datasheet and no friction, predicts it.\n",
    );
    let settings = SolverSettings::default();
    let outcome = evaluate_into(folder, &saved, subjects, &settings, console)?;
    let configuration = json!({ "rig": session.settings()?, "solver": settings.describe() });
    run_record::write(folder, "demo", global.seed, &configuration)?;
    Ok(outcome.finish(folder, console))
}

/// A short run of the published excitation at a pressure that the seed chooses.
fn session(seed: u64) -> Session {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let psi = 5 * random.random_range(5..=12_u8);
    let sines = EXCITATION.iter().flat_map(|&(frequency_hz, duration_s)| {
        [1.0, 1.5].map(|amplitude_a| CurrentSegment::Sine { amplitude_a, frequency_hz, duration_s })
    });
    let protocol = Protocol {
        name: "demo".into(),
        conditions: Some(Conditions::List(vec![[psi, psi]])),
        current: sines.collect(),
        ..Protocol::paper()
    };
    Session {
        rig: RigParameters::default(),
        protocol,
        seed,
        truth: true,
        note: run_record::rig_note(seed),
    }
}
