//! `pam inspect`.

mod model;
mod ranges;
mod recording;
mod report;

use super::RunCommand;
use crate::arguments::GlobalOptions;
use crate::console::{Console, table};
use crate::error::CliError;
use crate::options::{DataOptions, built_in_spring_damper};
use crate::output::Output;
use clap::Args;
use pam_data::formats::raw_log::RawLogText;
use pam_data::formats::{mat, npz};
use pam_data::plausibility::{self, Finding, PlausibilitySettings, Severity};
use pam_data::preprocess::recordings_from_raw_log;
use pam_data::quality::{self, QualitySettings};
use pam_data::recording::contiguous_ranges;
use pam_data::{
    DataError, LoadOptions, MassOptions, RawLog, Recording, SavedModel, Subject, collect_paths_of,
    format_of, load_model, open_recordings,
};
use pam_report::InspectedRun;
use ranges::{range_json, range_row, range_titles};
use serde_json::{Value, json};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Arguments of `pam inspect`.
#[derive(Debug, Args)]
pub struct InspectArguments {
    /// Files of any kind, or folders of recordings
    #[arg(required = true, value_name = "FILE")]
    pub files: Vec<PathBuf>,
    /// How recordings are read.
    #[command(flatten)]
    pub data: DataOptions,
    /// Model whose gas law gives the masses [default: datasheet parameters]
    #[arg(long, value_name = "MODEL")]
    pub model: Option<PathBuf>,
    /// Write report.html, with a figure for every check, to this folder
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
}

impl RunCommand for InspectArguments {
    fn outputs(&self) -> Vec<Output<'_>> {
        self.out.as_deref().map(|path| Output::Folder("inspect", path)).into_iter().collect()
    }

    fn run(&self, global: &GlobalOptions, console: &Console) -> Result<ExitCode, CliError> {
        let model = match &self.model {
            Some(path) => load_model(path)?,
            None => built_in_spring_damper(global.rig_for(&self.files)?.as_ref()),
        };
        let rig = global.rig()?.or_else(|| model.info.rig.clone());
        let mut inspector = Inspector {
            model,
            options: self.data.load_options(rig)?,
            masses: self.data.mass_options()?,
            runs: Vec::new(),
            findings: Vec::new(),
        };
        let mut all = Vec::new();
        let mut failed = false;
        for path in collect_paths_of(&self.files, inspector.options.rig.as_ref())? {
            match inspector.file(&path) {
                Ok((text, value)) => {
                    console.text(text);
                    all.push(value);
                }
                // One bad file does not hide the others.
                Err(e) => {
                    eprintln!("error: {e}");
                    all.push(json!({ "file": path, "error": e.to_string() }));
                    failed = true;
                }
            }
        }
        if let Some(line) = recording::data_set_line(&all) {
            console.text(line);
        }
        if let Some(folder) = &self.out {
            let written = report::write_report(folder, &inspector.runs, &inspector.findings)?;
            console.text(format!("report: {}", written.display()));
        }
        console.json(&Value::from(all));
        Ok(if failed { ExitCode::FAILURE } else { ExitCode::SUCCESS })
    }
}

/// Reads files and summarises them as text or JSON.
struct Inspector {
    model: SavedModel,
    options: LoadOptions,
    masses: MassOptions,
    /// Content of the report.
    runs: Vec<InspectedRun>,
    findings: Vec<Finding>,
}

impl Inspector {
    /// Writes `report.html` into a folder and returns its path.
    fn file(&mut self, path: &Path) -> Result<(String, Value), CliError> {
        if let Some(rig) = self.options.rig.clone().filter(|rig| rig.describes_file(path)) {
            let kind = if rig.name.is_empty() {
                "a file of the rig".into()
            } else {
                format!("a file of {}", rig.name)
            };
            let (body, mut value) = self.recordings(&open_recordings(path, &self.options)?)?;
            value["file"] = json!(path);
            value["kind"] = json!(kind);
            return Ok((format!("{}: {kind}\n{body}\n", path.display()), value));
        }
        let format = format_of(path)?;
        let kind = format.name();
        let (body, mut value) = match format.id() {
            RawLogText::ID => self.raw_log(path)?,
            _ if format.holds_model() => model::model(&load_model(path)?),
            "npz" if !format.holds_recording(path) => {
                let arrays = npz::read(path)?;
                let sizes = arrays.iter().map(|(k, a)| (k.as_str(), format!("{:?}", a.shape)));
                other_arrays(sizes.collect())
            }
            "mat" if !format.holds_recording(path) => {
                let arrays = mat::read(path)?;
                let sizes = arrays.iter().map(|(k, a)| (k.as_str(), format!("[{}]", a.len())));
                other_arrays(sizes.collect())
            }
            _ => self.recordings(&open_recordings(path, &self.options)?)?,
        };
        value["file"] = json!(path);
        value["kind"] = json!(kind);
        Ok((format!("{}: {kind}\n{body}\n", path.display()), value))
    }

    fn raw_log(&mut self, path: &Path) -> Result<(String, Value), CliError> {
        let log = RawLog::read(path)?;
        let mut rows = vec![range_titles("column")];
        let mut ranges = serde_json::Map::new();
        for (name, values) in log.names.iter().zip(&log.columns) {
            rows.push(range_row(name, values));
            ranges.insert(name.clone(), range_json(values));
        }
        let gaps: Vec<(f64, f64)> = contiguous_ranges(log.frame())
            .windows(2)
            .map(|w| (log.frame()[w[0].end - 1], log.frame()[w[1].start]))
            .collect();
        let rate = log.frame_rate_hz.map_or("not given".into(), |r| format!("{r} Hz"));
        let mut text = format!("  {} rows, frame rate {rate}\n{}\n", log.len(), table(&rows));
        for (before, after) in gaps.iter().take(8) {
            text += &format!("  gap: frame {before} is followed by {after}\n");
        }
        let mut value = json!({
            "rows": log.len(),
            "frame_rate_hz": log.frame_rate_hz,
            "header": log.header,
            "columns": ranges,
            "gaps": gaps,
        });
        // A log too short to preprocess is still worth looking at.
        match recordings_from_raw_log(&log, &self.options.raw_log) {
            Ok(recordings) => {
                let (body, inner) = self.recordings(&recordings)?;
                text += &body;
                value["recordings"] = inner["recordings"].clone();
                value["plausibility"] = inner["plausibility"].clone();
            }
            Err(e) => {
                text += &format!("  no recording: {}", reason(&e));
                value["no_recording"] = json!(reason(&e));
            }
        }
        Ok((text, value))
    }

    fn recordings(&mut self, recordings: &[Recording]) -> Result<(String, Value), CliError> {
        let mut text = Vec::new();
        let mut values = Vec::new();
        for recording in recordings {
            let (mut t, mut v) = recording::recording(recording, &self.model, &self.masses)?;
            let quality = quality::assess(recording, &QualitySettings::default());
            t += &recording::quality_text(&quality);
            v["quality"] = json!(quality);
            v["quality"]["can_be_told"] =
                json!(quality.excitation.sentences(&QualitySettings::default()));
            self.runs.push(InspectedRun { recording: recording.clone(), quality });
            text.push(t);
            values.push(v);
        }
        let findings = self.plausibility(recordings)?;
        self.findings.extend(findings.iter().cloned());
        text.extend(findings.iter().map(|f| match f.severity {
            Severity::Error => format!("  implausible: {f}"),
            Severity::Warning => format!("  possibly implausible: {f}"),
        }));
        Ok((text.join("\n"), json!({ "recordings": values, "plausibility": findings })))
    }

    /// Contradictions between the recordings of a file and the physics of the joint.
    fn plausibility(&self, recordings: &[Recording]) -> Result<Vec<Finding>, CliError> {
        let subjects = Subject::resolve(recordings.to_vec(), &self.model, &self.masses)?;
        let settings = PlausibilitySettings::for_model(&self.model);
        Ok(plausibility::check_with(&self.model.model, &subjects, &settings))
    }
}

/// The message of an error without the path that stands above it already.
fn reason(error: &DataError) -> String {
    match error {
        DataError::File { message, .. } => message.clone(),
        other => other.to_string(),
    }
}

fn other_arrays(arrays: Vec<(&str, String)>) -> (String, Value) {
    let lines: Vec<String> = arrays.iter().map(|(name, size)| format!("  {name} {size}")).collect();
    let text = if lines.is_empty() {
        "  no arrays of numbers".to_owned()
    } else {
        format!("  no recording; arrays of numbers:\n{}", lines.join("\n"))
    };
    let value = json!({ "arrays": arrays.iter().map(|(n, s)| json!([n, s])).collect::<Vec<_>>() });
    (text, value)
}
