//! `pam rig record`.

use crate::arguments::GlobalOptions;
use crate::console::{Console, table};
use crate::error::{CliError, usage};
use crate::options::possible_values;
use crate::run_record::{self, made_by};
use clap::Args;
use clap::builder::{PossibleValue, PossibleValuesParser};
use pam_core::NamedChoice;
use pam_data::atomic::write_atomic;
use pam_data::{LoadOptions, Recording, open_recordings};
use pam_report::page::{count, number};
use pam_report::{RecordedRun, recordings_report};
use pam_rig::folder::SETTINGS_FILE;
use pam_rig::protocol::ConditionSet;
use pam_rig::sensors::Part;
use pam_rig::{Conditions, Entry, Protocol, RigParameters, Session};
use serde_json::json;
use std::path::PathBuf;

/// Arguments of `pam rig record`.
#[derive(Debug, Args)]
pub struct RigRecordArguments {
    /// Protocol.
    #[arg(long, default_value = "paper", value_name = "NAME|FILE", help = protocols())]
    pub protocol: String,
    /// Sealed pressures.
    #[arg(long, value_name = "SET|PAIRS", help = conditions())]
    pub conditions: Option<String>,
    /// Parameters of the rig: default, measured (as rough as the published real run), or a TOML file; what that leaves
    /// out has its default
    #[arg(long, value_name = "NAME|FILE", default_value = "default")]
    pub rig: String,
    /// Hidden effects.
    #[arg(long = "effect", value_name = "ID[:NAME=VALUE,…]", help = hidden_effects())]
    pub effects: Vec<String>,
    /// Parts to make ideal, separated by commas
    #[arg(long, value_delimiter = ',', value_name = "PARTS", value_parser = parts())]
    pub ideal: Vec<String>,
    /// Write no ground truth of the samples, only the settings
    #[arg(long)]
    pub no_truth: bool,
    /// Replace recordings made with other settings
    #[arg(long)]
    pub overwrite: bool,
    /// Folder for the logs; existing recordings of an interrupted run are kept
    #[arg(long, value_name = "DIR")]
    pub out: PathBuf,
    /// Also write a report with figures
    #[arg(long, value_name = "FILE.html")]
    pub report: Option<PathBuf>,
}

/// Parser of `pam rig record --ideal`.
fn parts() -> PossibleValuesParser {
    possible_values::<Part>().chain([PossibleValue::new("all").help("all of them")]).into()
}

/// Help of `pam rig record --protocol`.
fn protocols() -> String {
    format!("A built-in protocol ({}), or a TOML file", Protocol::BUILT_IN.join(", "))
}

/// Help of `pam rig record --conditions`.
fn conditions() -> String {
    let sets = ConditionSet::ALL.iter().map(|(name, _, what)| format!("{name} ({what})"));
    format!(
        "Sealed pressures instead of the protocol's: {}, or pairs of psi gauge like 30/60,45/45 (flexor/extensor)",
        sets.collect::<Vec<_>>().join(", ")
    )
}

/// Help of `pam rig record --effect`.
fn hidden_effects() -> String {
    let ids = |listed: bool| {
        let some = pam_rig::effects::ALL.iter().filter(|e| e.is_listed() == listed);
        some.map(|e| e.info.id).collect::<Vec<_>>().join(", ")
    };
    format!(
        "Hide an effect, with or without its parameters: coulomb_friction:force_n=20. Can be repeated. Effects: \
         {}. Phenomena outside the vocabulary: {}",
        ids(true),
        ids(false)
    )
}

/// Most rows of the printed table; the rest is in the files.
const MOST_ROWS: usize = 30;
/// Recordings whose time series are drawn.
const MOST_DRAWN: usize = 4;

/// Runs the command.
///
/// # Errors
/// [`CliError`] naming file and line, or the option.
pub(super) fn run(
    arguments: &RigRecordArguments,
    global: &GlobalOptions,
    console: &Console,
) -> Result<(), CliError> {
    let session = session(arguments, global.seed)?;
    let names = session.protocol.runs()?.into_iter().map(|r| r.name).collect::<Vec<_>>();
    let bar = console.progress(names.len(), "recording");
    let entries = session.record_into(&arguments.out, arguments.overwrite, &|_| bar.inc(1))?;
    bar.finish_and_clear();
    // Hidden effects are recorded in the sealed settings only.
    let configuration = json!({
        "protocol": session.protocol,
        "recordings": names,
        "rig": SETTINGS_FILE,
    });
    run_record::write(&arguments.out, "rig record", global.seed, &configuration)?;
    if let Some(path) = &arguments.report {
        write_atomic(path, report(&session, &entries)?.as_bytes())?;
    }
    console.json(&json!({ "recordings": entries, "settings": arguments.out.join(SETTINGS_FILE) }));
    console.text(summary(&session, &entries));
    Ok(())
}

/// The session of the arguments.
fn session(arguments: &RigRecordArguments, seed: u64) -> Result<Session, CliError> {
    let mut rig = RigParameters::open(&arguments.rig)?;
    for text in &arguments.effects {
        rig.effects.push(text.parse().map_err(|e| usage(format!("--effect {text}: {e}")))?);
    }
    for name in &arguments.ideal {
        rig.sensors = match Part::from_name(name) {
            Ok(part) => rig.sensors.with_ideal(part),
            Err(_) => rig.sensors.all_ideal(),
        };
    }
    let mut protocol = Protocol::open(&arguments.protocol)?;
    if let Some(text) = &arguments.conditions {
        let conditions = Conditions::parse(text)
            .map_err(|why| CliError::Usage(format!("--conditions: {why}")))?;
        if protocol.conditions.replace(conditions).is_none() {
            return Err(CliError::Usage(format!(
                "--conditions: the protocol `{}` drives the pressures itself",
                protocol.name
            )));
        }
    }
    let note = run_record::rig_note(seed);
    Ok(Session { rig, protocol, seed, truth: !arguments.no_truth, note })
}

fn summary(session: &Session, entries: &[Entry]) -> String {
    let mut rows = vec![
        ["recording", "flexor (psi)", "extensor (psi)", "x from (mm)", "to (mm)", "frames"]
            .map(str::to_owned)
            .to_vec(),
    ];
    for e in entries.iter().take(MOST_ROWS) {
        let [flexor, extensor] = e.sealed_psi;
        let [low, high] = e.displacement_mm;
        let mut row = vec![e.name.clone()];
        row.extend([(flexor, 2), (extensor, 2), (low, 3), (high, 3)].map(|(v, d)| number(v, d)));
        row.push(e.frames.to_string());
        rows.push(row);
    }
    if entries.len() > MOST_ROWS {
        rows.push(vec![format!("… {} more", entries.len() - MOST_ROWS)]);
    }
    let mut text = table(&rows);
    let kept = entries.iter().filter(|e| e.was_there).count();
    if kept > 0 {
        text += &format!("\n\n  {kept} of {} recordings were there already.", entries.len());
    }
    let hidden: Vec<String> = session.rig.effects.iter().map(ToString::to_string).collect();
    if !hidden.is_empty() {
        text += &format!("\n\n  hidden: {}", hidden.join("; "));
    }
    text
}

/// The report: all recordings in numbers, some of them drawn as the loader reads them.
fn report(session: &Session, entries: &[Entry]) -> Result<String, CliError> {
    let runs: Vec<RecordedRun> = entries
        .iter()
        .map(|e| RecordedRun {
            name: e.name.clone(),
            sealed_psi: e.sealed_psi,
            displacement_mm: e.displacement_mm,
            frames: e.frames,
        })
        .collect();
    let step = entries.len().div_ceil(MOST_DRAWN).max(1);
    let mut drawn: Vec<Recording> = Vec::new();
    for entry in entries.iter().step_by(step) {
        drawn.extend(open_recordings(&entry.log, &LoadOptions::default())?);
    }
    let lead = format!(
        "Protocol {}, {} of {:.0} s, seed {}. {SETTINGS_FILE} lists the hidden effects.",
        session.protocol.name,
        count(entries.len(), "recording"),
        session.protocol.duration_s(),
        session.seed
    );
    Ok(recordings_report("Recordings of the virtual rig", &lead, &runs, &drawn, &made_by()))
}
