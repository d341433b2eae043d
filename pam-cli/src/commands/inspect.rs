//! `pam inspect`.

use super::RunCommand;
use crate::arguments::GlobalOptions;
use crate::console::{Console, table};
use crate::error::CliError;
use crate::options::{DataOptions, built_in_spring_damper, describe_model};
use clap::Args;
use num_dual::Dual64;
use pam_autodiff::{FourPointSmoothed, linearise, stiffness_by_difference_n_mm};
use pam_core::units::{ATMOSPHERE_KPA, MN_PER_N};
use pam_core::{AnyForce, ForceInput, Scalar};
use pam_data::atomic::write_atomic;
use pam_data::formats::raw_log::RawLogText;
use pam_data::formats::{mat, npz};
use pam_data::plausibility::{self, Finding, PlausibilitySettings, Severity};
use pam_data::preprocess::recordings_from_raw_log;
use pam_data::quality::{self, Quality, QualitySettings};
use pam_data::recording::{contiguous_ranges, median_step_s};
use pam_data::{
    Channel, DataError, LoadOptions, MassOptions, RawLog, Recording, SavedModel, Subject,
    collect_paths_of, format_of, load_model, open_recordings, resolve_masses,
};
use pam_numerics::statistics::mean;
use pam_report::{InspectedRun, inspection_report};
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
    /// Write report.html, with a picture for every check, into this folder
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
}

impl RunCommand for InspectArguments {
    fn run(&self, global: &GlobalOptions, console: &Console) -> Result<ExitCode, CliError> {
        let model = match &self.model {
            Some(path) => load_model(path)?,
            None => built_in_spring_damper(global.rig()?.as_ref()),
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
        if let Some(line) = data_set_line(&all) {
            console.text(line);
        }
        if let Some(folder) = &self.out {
            let written = inspector.write_report(folder)?;
            console.text(format!("report: {}", written.display()));
        }
        console.json(&Value::from(all));
        Ok(if failed { ExitCode::FAILURE } else { ExitCode::SUCCESS })
    }
}

/// One line on all recordings together, if there are several.
fn data_set_line(files: &[Value]) -> Option<String> {
    let recordings: Vec<&Value> =
        files.iter().filter_map(|f| f["recordings"].as_array()).flatten().collect();
    if recordings.len() < 2 {
        return None;
    }
    let number = |r: &Value, key: &str| r[key].as_f64().unwrap_or(0.0);
    let duration: f64 = recordings.iter().map(|r| number(r, "to_s") - number(r, "from_s")).sum();
    let range = |key: &str| {
        let values = recordings.iter().map(|r| number(r, key));
        let (low, high) =
            values.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(v), h.max(v)));
        format!("{low:.4} to {high:.4} g")
    };
    Some(format!(
        "{} recordings, {duration:.1} s; air in the flexor {}, in the extensor {}",
        recordings.len(),
        range("mass_flexor_g"),
        range("mass_extensor_g")
    ))
}

/// Reads files and says what is in them, as text and as JSON.
struct Inspector {
    model: SavedModel,
    options: LoadOptions,
    masses: MassOptions,
    /// What the report shows.
    runs: Vec<InspectedRun>,
    findings: Vec<Finding>,
}

impl Inspector {
    /// Writes `report.html` into a folder and returns its path.
    fn write_report(&self, folder: &Path) -> Result<PathBuf, CliError> {
        let (errors, warnings) = self
            .runs
            .iter()
            .flat_map(|run| run.quality.findings.iter().map(|f| f.severity))
            .chain(self.findings.iter().map(|f| f.severity))
            .fold((0, 0), |(e, w), severity| match severity {
                Severity::Error => (e + 1, w),
                Severity::Warning => (e, w + 1),
            });
        let lead = format!(
            "{} recording(s): {errors} error(s) that stop other commands, {warnings} warning(s).",
            self.runs.len()
        );
        let made_by = format!("pam {} inspect", env!("CARGO_PKG_VERSION"));
        let html =
            inspection_report("Check of recordings", &lead, &self.runs, &self.findings, &made_by);
        std::fs::create_dir_all(folder).map_err(|e| DataError::io(folder, e))?;
        let path = folder.join("report.html");
        write_atomic(&path, html.as_bytes())?;
        Ok(path)
    }

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
            _ if format.holds_model() => model(&load_model(path)?),
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
        let mut rows = vec![["column", "min", "max", "mean"].map(str::to_owned).to_vec()];
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
            let (mut t, mut v) = self.recording(recording)?;
            let quality = quality::assess(recording, &QualitySettings::default());
            t += &quality_text(&quality);
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

    /// What in the recordings of a file contradicts the physics of the joint.
    fn plausibility(&self, recordings: &[Recording]) -> Result<Vec<Finding>, CliError> {
        let subjects = Subject::resolve(recordings.to_vec(), &self.model, &self.masses)?;
        let settings = PlausibilitySettings::for_model(&self.model);
        Ok(plausibility::check_with(&self.model.model, &subjects, &settings))
    }

    fn recording(&self, r: &Recording) -> Result<(String, Value), CliError> {
        let (masses, origin) = resolve_masses(
            r,
            &self.model.model,
            self.model.info.trained,
            self.masses.choice,
            self.masses.surfaces.as_ref(),
        )?;
        let (t0, t1) = r.span_s();
        let rate = 1.0 / median_step_s(&r.time_s);
        let force_n: Vec<f64> = r.force_mn.iter().map(|f| f / MN_PER_N).collect();
        let mut rows = vec![["channel", "min", "max", "mean"].map(str::to_owned).to_vec()];
        let mut ranges = serde_json::Map::new();
        for c in Channel::ALL {
            rows.push(range_row(c.label(), r.channel(c)));
            ranges.insert(c.key().to_owned(), range_json(r.channel(c)));
        }
        rows.push(range_row("external force (N)", &force_n));
        ranges.insert("force_n".to_owned(), range_json(&force_n));
        let rest = r.reading_at_rest();
        let at_rest = if r.sealed.is_some() { "sealed" } else { "first sample" };
        let mut text = format!(
            "  recording {}: {} samples, {t0:.3} to {t1:.3} s at {rate:.1} Hz; {}\n{}\n",
            r.name,
            r.len(),
            r.preprocessing,
            table(&rows)
        );
        text += &format!(
            "  {at_rest}: {:.2} and {:.2} kPa abs ({:.2} and {:.2} gauge) at x = {:.4} mm\n",
            rest.pressure_flexor_kpa,
            rest.pressure_extensor_kpa,
            rest.pressure_flexor_kpa - ATMOSPHERE_KPA,
            rest.pressure_extensor_kpa - ATMOSPHERE_KPA,
            rest.displacement_mm
        );
        text += &format!(
            "  masses: {:.6} g flexor, {:.6} g extensor ({}{})",
            masses.flexor_g,
            masses.extensor_g,
            origin.label(),
            if origin == pam_data::MassOrigin::GasLaw {
                format!(" with ν = {:.3}", self.model.model.physical().deformation)
            } else {
                String::new()
            }
        );
        for note in &r.notes {
            text += &format!("\n  note: {note}");
        }
        let value = json!({
            "name": r.name,
            "samples": r.len(),
            "from_s": t0,
            "to_s": t1,
            "rate_hz": rate,
            "ranges": ranges,
            "at_rest": {
                "source": at_rest,
                "displacement_mm": rest.displacement_mm,
                "pressure_flexor_kpa": rest.pressure_flexor_kpa,
                "pressure_extensor_kpa": rest.pressure_extensor_kpa,
            },
            "mass_flexor_g": masses.flexor_g,
            "mass_extensor_g": masses.extensor_g,
            "mass_origin": origin,
            "commanded_psi": r.command_psi,
            "preprocessing": r.preprocessing,
            "notes": r.notes,
        });
        Ok((text, value))
    }
}

/// The quality of a recording in sentences.
fn quality_text(quality: &Quality) -> String {
    let mut rows = vec![["channel", "noise", "resolution", "drift"].map(str::to_owned).to_vec()];
    for c in &quality.channels {
        let resolution = c.resolution.map_or("-".into(), |r| format!("{r:.5}"));
        rows.push(vec![
            format!("{} ({})", c.column, c.unit),
            format!("{:.5}", c.noise),
            resolution,
            format!("{:.4}", c.drift),
        ]);
    }
    let mut text = format!("\n{}", table(&rows));
    for f in &quality.findings {
        let word = if f.severity == Severity::Error { "error" } else { "warning" };
        text += &format!("\n  {word}: {}", f.message);
    }
    for sentence in quality.excitation.sentences(&QualitySettings::default()) {
        text += &format!("\n  {sentence}");
    }
    text
}

/// The message of an error without the path that stands above it already.
fn reason(error: &DataError) -> String {
    match error {
        DataError::File { message, .. } => message.clone(),
        other => other.to_string(),
    }
}

fn range_of(values: &[f64]) -> (f64, f64, f64) {
    let low = values.iter().copied().fold(f64::INFINITY, f64::min);
    let high = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    (low, high, mean(values))
}

fn range_row(name: &str, values: &[f64]) -> Vec<String> {
    let (low, high, mean) = range_of(values);
    vec![name.to_owned(), format!("{low:.4}"), format!("{high:.4}"), format!("{mean:.4}")]
}

fn range_json(values: &[f64]) -> Value {
    let (low, high, mean) = range_of(values);
    json!({ "min": low, "max": high, "mean": mean })
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

/// Equal air masses at which a model's slopes are shown, g: 170, 412 and 653 kPa at x = 0.
const SHOWN_MASSES_G: [f64; 3] = [0.031_527_2, 0.076_314_35, 0.121_101_5];

fn model(saved: &SavedModel) -> (String, Value) {
    let p = saved.model.physical();
    let dual: AnyForce<Dual64> = saved.model.force.map(Dual64::constant);
    let mut rows = vec![
        ["m_f = m_e (g)", "P at x = 0 (kPa)", "K exact (N/mm)", "K h = 1 mm", "B exact (kg/s)"]
            .map(str::to_owned)
            .to_vec(),
    ];
    let mut slopes = Vec::new();
    for mass in SHOWN_MASSES_G {
        let at = ForceInput {
            displacement_mm: 0.0,
            velocity_mm_s: 0.0,
            mass_flexor_g: mass,
            mass_extensor_g: mass,
        };
        let line = linearise(&dual, &at);
        let smoothed =
            stiffness_by_difference_n_mm(&saved.model.force, &at, &FourPointSmoothed::default());
        let masses = pam_core::SealedMasses { flexor_g: mass, extensor_g: mass };
        let pressure = saved.model.gas_law_pressures_kpa(0.0, masses)[0];
        rows.push(vec![
            format!("{mass:.7}"),
            format!("{pressure:.1}"),
            format!("{:.2}", line.stiffness_n_mm),
            format!("{smoothed:.2}"),
            format!("{:.1}", line.damping_kg_s),
        ]);
        slopes.push(json!({
            "mass_flexor_g": mass,
            "mass_extensor_g": mass,
            "pressure_kpa": pressure,
            "stiffness_exact_n_mm": line.stiffness_n_mm,
            "stiffness_four_point_n_mm": smoothed,
            "damping_exact_kg_s": line.damping_kg_s,
            "force_mn": line.force_mn,
        }));
    }
    let text = format!(
        "  {}\n  {}\n  muscles {} mm x {} mm (radius x length); auxiliary damping {} kg/s; {}\n  at x = 0, v = 0:\n{}",
        describe_model(saved),
        saved.info.provenance,
        saved.model.geometry.radius_mm,
        saved.model.geometry.length_mm,
        saved.model.auxiliary_damping_kg_s,
        if saved.info.trained { "trained" } else { "not trained" },
        table(&rows)
    );
    let mut value = json!({
        "name": saved.info.name,
        "provenance": saved.info.provenance,
        "trained": saved.info.trained,
        "force": saved.model.force.kind(),
        "mass_kg": p.mass_kg,
        "gas_coefficient_kpa_mm3_per_g": p.gas_coefficient,
        "deformation": p.deformation,
        "radius_mm": saved.model.geometry.radius_mm,
        "length_mm": saved.model.geometry.length_mm,
        "auxiliary_damping_kg_s": saved.model.auxiliary_damping_kg_s,
        "slopes": slopes,
    });
    if !saved.info.effects.is_empty() {
        value["effects"] = json!(saved.info.effects);
    }
    if let AnyForce::Network(n) = &saved.model.force {
        let widths: Vec<usize> = n.mlp().layers().iter().map(|l| l.outputs()).collect();
        value["activation"] = json!(n.mlp().activation().name());
        value["layer_outputs"] = json!(widths);
        value["parameters"] = json!(n.mlp().parameter_count() + 3);
    }
    (text, value)
}
