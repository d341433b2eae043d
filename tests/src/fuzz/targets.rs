//! What reads a mutated input.

use super::mutate::Kind;
use pam_ablate::sweep::Sweep;
use pam_baselines::comparison::ComparisonConfig;
use pam_control::motion::MotionSpec;
use pam_core::{JointModel, SpringDamper};
use pam_data::plausibility::{self, PlausibilitySettings};
use pam_data::quality::{self, QualitySettings};
use pam_data::{
    LoadOptions, MassOptions, MuscleSurfaces, PressureReference, RawLogOptions, Recording, RigFile,
    SavedModel, Subject, load_model, open_recordings, rig_of, toml_file,
};
use pam_diagnose::DiagnosisSettings;
use pam_effects::ExtendedModel;
use pam_rig::{Protocol, RigParameters};
use pam_train::curriculum::Curriculum;
use pam_trajectory::{Predictor, SolverSettings};
use std::fmt::Display;
use std::path::{Path, PathBuf};

/// A reader with its seed.
#[derive(Debug)]
pub struct Target {
    /// Its name.
    pub name: &'static str,
    /// Name of the file, which is that of the seed.
    pub file: &'static str,
    /// What the file is made of.
    pub kind: Kind,
    /// Reads the file and uses what was read; the message of a refusal.
    pub read: fn(&Path) -> Result<(), String>,
}

impl Target {
    /// The file of the corpus.
    #[must_use]
    pub fn seed(&self) -> PathBuf {
        Path::new(env!("CARGO_MANIFEST_DIR")).join("fixtures/fuzz").join(self.file)
    }
}

macro_rules! targets {
    ($($name:literal $file:literal $kind:ident $read:expr;)*) => {
        /// All of them.
        pub static TARGETS: &[Target] =
            &[$(Target { name: $name, file: $file, kind: Kind::$kind, read: $read }),*];
    };
}

targets! {
    "recording, CSV" "run.csv" Text recording;
    "recording, npz" "run.npz" Archive recording;
    "recording, mat" "run.mat" Words recording;
    "recording, raw log" "nn_3060" Text recording;
    "recording, preprocessed" "run.csv" Text preprocessed;
    "table of a rig" "elbow.csv" Text table;
    "guess of a rig file" "elbow.csv" Text guess;
    "model, eqx" "model.eqx" Arrays model;
    "model, safetensors" "model.safetensors" Safetensors model;
    "mass surfaces" "surfaces.mat" Words |path| named(MuscleSurfaces::read(path));
    "rig file" "rig-file.toml" Text |path| named(RigFile::read(path));
    "curriculum" "curriculum.toml" Text |path| named(Curriculum::open(&path.to_string_lossy(), &[]));
    "sweep" "sweep.toml" Text sweep;
    "comparison" "comparison.toml" Text |path| named(ComparisonConfig::open(path));
    "rig parameters" "rig.toml" Text rig;
    "protocol" "protocol.toml" Text protocol;
    "settings of a diagnosis" "settings.toml" Text settings;
    "effects" "effects.toml" Text effects;
    "effects of the rig" "effects.toml" Text hidden_effects;
    "motion" "motion.csv" Text |path| named(MotionSpec::parse(&path.to_string_lossy()));
    "table of a plan" "table.bin" Words controller_table;
    "network of a controller" "network.bin" Words controller_network;
}

fn named<T>(result: Result<T, impl Display>) -> Result<(), String> {
    result.map(drop).map_err(|e| e.to_string())
}

/// The physics-only model.
fn spring_damper() -> SavedModel {
    let model = JointModel::datasheet(pam_core::AnyForce::SpringDamper(SpringDamper::published()));
    SavedModel {
        model,
        info: pam_data::ModelInfo {
            name: "spring-damper".into(),
            provenance: String::new(),
            trained: false,
            trained_on: Vec::new(),
            effects: Vec::new(),
            rig: None,
            source: None,
        },
    }
}

fn load_options() -> LoadOptions {
    let raw_log = RawLogOptions { search_from_row: 0, sealed_rows: 5, ..RawLogOptions::default() };
    LoadOptions {
        raw_log,
        pressure_reference: PressureReference::Absolute,
        ..LoadOptions::default()
    }
}

/// Reads recordings and does with them what every command does first.
fn read_with(path: &Path, options: &LoadOptions) -> Result<(), String> {
    let recordings = open_recordings(path, options).map_err(|e| e.to_string())?;
    let saved = spring_damper();
    let subjects =
        Subject::resolve(recordings, &saved, &MassOptions::default()).map_err(|e| e.to_string())?;
    let _ = rig_of(&[path]);
    let findings =
        plausibility::check_with(&saved.model, &subjects, &PlausibilitySettings::for_model(&saved));
    findings.iter().for_each(|finding| drop(finding.to_string()));
    for subject in &subjects {
        let _ = quality::assess(&subject.recording, &QualitySettings::default());
        predict(&saved, subject);
    }
    Ok(())
}

/// A prediction may stop early, but it stops.
fn predict(saved: &SavedModel, subject: &Subject) {
    if let Ok(extended) = ExtendedModel::from_saved(saved.clone()) {
        for settings in
            [SolverSettings::default(), SolverSettings::exact(pam_solvers::Interpolation::Hold)]
        {
            if settings == SolverSettings::default()
                || settings.exact_applies_to(&saved.model.force)
            {
                let _ = extended.predict(&subject.recording, subject.masses, &settings);
            }
        }
    }
}

fn recording(path: &Path) -> Result<(), String> {
    // The constants of the raw log are an error for other formats.
    let raw = path.extension().is_none();
    let options = load_options();
    let plain = LoadOptions { raw_log: RawLogOptions::default(), ..load_options() };
    read_with(path, if raw { &options } else { &plain })
}

fn preprocessed(path: &Path) -> Result<(), String> {
    read_with(path, &LoadOptions { preprocess: true, ..LoadOptions::default() })
}

fn table(path: &Path) -> Result<(), String> {
    let rig = Path::new(env!("CARGO_MANIFEST_DIR")).join("../data/elbow/rig.toml");
    let rig = RigFile::read(rig).map_err(|e| e.to_string())?;
    read_with(path, &LoadOptions { rig: Some(rig), ..LoadOptions::default() })
}

fn guess(path: &Path) -> Result<(), String> {
    named(RigFile::guess(path).map(|guessed| guessed.to_toml()))
}

fn model(path: &Path) -> Result<(), String> {
    let saved = load_model(path).map_err(|e| e.to_string())?;
    let n = 200;
    let mut run = Recording::empty(path);
    run.time_s = (0..n).map(|k| 0.005 * f64::from(k)).collect();
    run.force_mn = run.time_s.iter().map(|t| 5e4 * (6.0 * t).sin()).collect();
    run.displacement_mm = vec![0.1; n as usize];
    run.velocity_mm_s = vec![0.0; n as usize];
    run.pressure_flexor_kpa = vec![400.0; n as usize];
    run.pressure_extensor_kpa = vec![420.0; n as usize];
    let subjects = Subject::resolve(vec![run], &saved, &MassOptions::default())
        .map_err(|e| format!("{}: {e}", path.display()))?;
    subjects.iter().for_each(|subject| predict(&saved, subject));
    Ok(())
}

fn sweep(path: &Path) -> Result<(), String> {
    let sweep = Sweep::open(&path.to_string_lossy()).map_err(|e| e.to_string())?;
    if sweep.cell_count() <= 1000 {
        let _ = sweep.cells();
    }
    Ok(())
}

fn rig(path: &Path) -> Result<(), String> {
    let parameters = RigParameters::open(&path.to_string_lossy()).map_err(|e| e.to_string())?;
    let mut rig =
        pam_rig::Rig::new(&parameters, 1, 0.0).map_err(|e| format!("{}: {e}", path.display()))?;
    if parameters.steps_per_sample <= 100 {
        let command = pam_rig::Command {
            current_a: 0.5,
            pressure: pam_rig::PressureCommand::Servo([45.0, 45.0]),
        };
        for _ in 0..20 {
            let _ = rig.tick(&command);
        }
    }
    Ok(())
}

fn protocol(path: &Path) -> Result<(), String> {
    let protocol = Protocol::open(&path.to_string_lossy()).map_err(|e| e.to_string())?;
    protocol.runs().map_err(|e| format!("{}: {e}", path.display()))?;
    for k in 0..100 {
        let _ = protocol.current_a(f64::from(k), 1);
    }
    Ok(())
}

fn settings(path: &Path) -> Result<(), String> {
    let text = toml_file::text(path).map_err(|e| e.to_string())?;
    // The command puts the file before the message.
    named(DiagnosisSettings::parse(&text, &[])).map_err(|e| format!("{}: {e}", path.display()))
}

/// Read, compiled, and evaluated in a model for a moment.
fn effects(path: &Path) -> Result<(), String> {
    let found = pam_effects::expression::load(path).map_err(|e| e.to_string())?;
    let mut run = Recording::empty(path);
    run.time_s = (0..20).map(|k| 0.005 * f64::from(k)).collect();
    run.force_mn = vec![5e3; 20];
    run.displacement_mm = vec![0.1; 20];
    run.velocity_mm_s = vec![0.0; 20];
    run.pressure_flexor_kpa = vec![400.0; 20];
    run.pressure_extensor_kpa = vec![420.0; 20];
    for effect in found {
        let values = effect.info().value_names().map(|_| 0.1).collect();
        let mut model = ExtendedModel::from_saved(spring_damper()).map_err(|e| e.to_string())?;
        model.effects.push(pam_effects::ActiveEffect { effect, values });
        let masses = pam_core::SealedMasses { flexor_g: 0.076, extensor_g: 0.076 };
        let _ = model.predict(&run, masses, &SolverSettings::default());
    }
    Ok(())
}

fn hidden_effects(path: &Path) -> Result<(), String> {
    // The rig keeps what it reads: another effect of the same id is refused.
    match pam_rig::effects::expression::load(path) {
        Err(e) if e.to_string().contains("another effect") => Ok(()),
        other => named(other),
    }
}

/// Bytes that a controller reads, from memory: the file is named here.
fn bytes(path: &Path) -> Result<Vec<u8>, String> {
    pam_data::read_limit::read(path).map_err(|e| e.to_string())
}

fn controller_table(path: &Path) -> Result<(), String> {
    let bytes = bytes(path)?;
    let table = pam_embedded::Table::new(&bytes).map_err(|e| format!("{}: {e}", path.display()))?;
    for time_s in [-1.0, 0.0, 0.5, 1e9, f64::NAN] {
        for k in 0..table.columns() {
            std::hint::black_box(table.value(k, time_s));
        }
        let _ = std::hint::black_box(table.pressures_kpa(time_s));
    }
    Ok(())
}

fn controller_network(path: &Path) -> Result<(), String> {
    let bytes = bytes(path)?;
    let network = pam_embedded::Network::<f32>::new(&bytes)
        .map_err(|e| format!("{}: {e}", path.display()))?;
    let mut work = vec![0.0; network.work_len().min(1 << 20)];
    let _ = network.force_mn([0.07, 0.07, 0.1, 0.0], &mut work);
    Ok(())
}
