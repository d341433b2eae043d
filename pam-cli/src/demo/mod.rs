//! The main job on no data at all: a recording is made, predicted by the physics-only model, and
//! reported.

mod plant;

use crate::arguments::{DemoArguments, GlobalOptions};
use crate::commands::evaluate::evaluate_into;
use crate::console::Console;
use crate::error::CliError;
use crate::options::built_in_spring_damper;
use crate::run_record;
use pam_data::atomic::write_atomic;
use pam_data::{LoadOptions, MassChoice, open_recordings, resolve_masses};
use pam_train::{SolverSettings, Subject};
use serde_json::json;
use std::process::ExitCode;

/// Runs the demo.
///
/// # Errors
/// [`CliError::Data`] if a file cannot be written.
pub fn run(
    arguments: &DemoArguments,
    global: &GlobalOptions,
    console: &Console,
) -> Result<ExitCode, CliError> {
    let folder = &arguments.out;
    let plant = plant::Plant::seeded(global.seed);
    console.text(format!(
        "A made-up joint (seed {}) is recorded: {}.",
        global.seed,
        plant.describe()
    ));
    let path = folder.join(plant.log_name());
    write_atomic(&path, plant.record().as_bytes())?;

    let saved = built_in_spring_damper();
    let mut subjects = Vec::new();
    for recording in open_recordings(&path, &LoadOptions::default())? {
        let (masses, origin) =
            resolve_masses(&recording, &saved.model, false, MassChoice::GasLaw, None)?;
        subjects.push(Subject { recording, masses, origin });
    }
    console.text(
        "A linear spring–damper, which knows the joint's datasheet and no friction, predicts it.\n",
    );
    let settings = SolverSettings::default();
    let outcome = evaluate_into(folder, &saved, subjects, &settings, console)?;
    let configuration = json!({ "plant": plant.describe(), "solver": settings.describe() });
    run_record::write(folder, "demo", global.seed, &configuration)?;
    Ok(outcome.finish(folder, console))
}
