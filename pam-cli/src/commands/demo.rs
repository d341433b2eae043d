//! The main job on no data at all: the virtual rig records with an effect hidden in it, the default model
//! predicts, the diagnosis names what is hidden, and the report shows the gain.

use crate::arguments::GlobalOptions;
use crate::commands::RunCommand;
use crate::commands::diagnose::{diagnose_into, finish};
use crate::console::Console;
use crate::error::{CliError, failed};
use crate::options::default_model;
use crate::output::Output;
use crate::run_record;
use clap::Args;
use pam_data::{LoadOptions, MassChoice, MassOptions, SavedModel, Subject, read_recordings};
use pam_diagnose::{DiagnoseOptions, RecordingSets};
use pam_rig::protocol::CurrentSegment;
use pam_rig::{Conditions, Protocol, RigParameters, Session};
use rand::SeedableRng;
use rand::rngs::ChaCha8Rng;
use rand::seq::IndexedRandom;
use serde_json::json;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Arguments of `pam demo`.
#[derive(Debug, Args)]
pub struct DemoArguments {
    /// Folder for the recording, the predictions and the report
    #[arg(long, value_name = "DIR", default_value = "pam-demo")]
    pub out: PathBuf,
    /// Parameters of the rig: default, measured (as rough as the published real run), or a TOML file
    #[arg(long, value_name = "NAME|FILE", default_value = "default")]
    pub rig: String,
}

impl Default for DemoArguments {
    fn default() -> Self {
        Self { out: PathBuf::from("pam-demo"), rig: "default".into() }
    }
}

/// Excitation: frequency (Hz), length at 1 A and at 1.5 A (s). The published one, shortened.
const EXCITATION: [(f64, f64); 3] = [(0.5, 6.0), (1.0, 3.0), (2.0, 2.0)];

/// Sealed pressures of the recordings in question and of the healthy ones, psi.
const CONDITIONS: [[u8; 2]; 3] = [[45, 45], [30, 60], [70, 60]];
const HEALTHY: [[u8; 2]; 3] = [[45, 45], [60, 30], [60, 60]];

/// Effects that may be hidden.
const HIDDEN: [&str; 10] = [
    "coulomb_friction:force_n=20",
    "viscous_damping:coefficient_ns_m=1500",
    "backlash:gap_mm=0.15",
    "tendon_slack:displacement_mm=0.9,stiffness_loss=0.3",
    "stiffness_drift:relative_per_min=0.3",
    "leak:flexor_rate_per_s=2e-3,extensor_rate_per_s=1e-3",
    "force_gain:relative=-0.12",
    "force_saturation:force_n=150",
    "actuation_delay:delay_ms=18",
    "position_gain:relative=0.08",
];

impl RunCommand for DemoArguments {
    fn outputs(&self) -> Vec<Output<'_>> {
        vec![Output::Folder("demo", &self.out)]
    }

    fn run(&self, global: &GlobalOptions, console: &Console) -> Result<ExitCode, CliError> {
        let folder = &self.out;
        let mut random = ChaCha8Rng::seed_from_u64(global.seed);
        let hidden = HIDDEN.choose(&mut random).copied().unwrap_or(HIDDEN[0]);
        let saved = default_model()?;
        console.text(format!(
        "The virtual rig (seed {}) records a healthy joint and one in which something is hidden: three \
         pressures each, torque at 0.5, 1 and 2 Hz.",
        global.seed
    ));
        let rig = RigParameters::open(&self.rig)?;
        let healthy =
            recorded(&folder.join("healthy"), &rig, &HEALTHY, None, global.seed + 1, &saved)?;
        let data =
            recorded(&folder.join("logs"), &rig, &CONDITIONS, Some(hidden), global.seed, &saved)?;
        console
            .text("The default model predicts; the diagnosis asks what it gets wrong, and why.\n");
        let sets = RecordingSets { data: &data, test: None, baseline: Some(&healthy) };
        // Something of the list is hidden: there is no law to look for.
        let options =
            DiagnoseOptions { seed: global.seed, law: false, ..DiagnoseOptions::default() };
        let diagnosis = diagnose_into(folder, &saved, &sets, &options, console)?;
        run_record::write(
            folder,
            "demo",
            global.seed,
            &json!({ "hidden": hidden, "rig": self.rig }),
        )?;
        console.text(format!("Hidden in the logs was {hidden}.\n"));
        finish(&diagnosis, folder, console);
        Ok(ExitCode::SUCCESS)
    }
}

/// Records a short run of the published excitation at each pressure and reads the logs.
fn recorded(
    folder: &Path,
    rig: &RigParameters,
    conditions: &[[u8; 2]],
    hidden: Option<&str>,
    seed: u64,
    saved: &SavedModel,
) -> Result<Vec<Subject>, CliError> {
    let sines = EXCITATION.iter().flat_map(|&(frequency_hz, duration_s)| {
        [1.0, 1.5].map(|amplitude_a| CurrentSegment::Sine { amplitude_a, frequency_hz, duration_s })
    });
    let protocol = Protocol {
        name: "demo".into(),
        conditions: Some(Conditions::List(conditions.to_vec())),
        current: sines.collect(),
        ..Protocol::paper()
    };
    let effects: Result<Vec<pam_rig::effects::Effect>, _> =
        hidden.iter().map(|text| text.parse()).collect();
    let effects = effects.map_err(|e| failed(format!("the demo's effect: {e}")))?;
    let rig = RigParameters { effects, ..rig.clone() };
    let session = Session { rig, protocol, seed, truth: true, note: run_record::rig_note(seed) };
    session.record_into(folder, true, &|_| {})?;
    let recordings = read_recordings([folder], &LoadOptions::default())?;
    let masses = MassOptions { choice: MassChoice::GasLaw, surfaces: None };
    Ok(Subject::resolve(recordings, saved, &masses)?)
}
