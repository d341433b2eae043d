//! `pam diagnose`.

use super::RunCommand;
use super::design::{DesignEffort, design_into};
use crate::arguments::GlobalOptions;
use crate::console::{Console, table};
use crate::error::{CliError, failed};
use crate::options::{
    DataOptions, ModelOptions, check_quality, describe_model, effect, settings_of,
};
use crate::output::Output;
use crate::run_record::{self, made_by, write_json};
use clap::{Args, ValueEnum};
use indicatif::ProgressBar;
use pam_core::units::significant;
use pam_data::atomic::write_atomic;
use pam_data::models::save_model;
use pam_data::{SavedModel, Subject};
use pam_diagnose::fit::Interval;
use pam_diagnose::joint::{PreparedTrials, Signatures};
use pam_diagnose::ladder::Ladder;
use pam_diagnose::remainder::Remainder;
use pam_diagnose::report::{ReportContext, diagnosis_report, plain_name, verdict_sentence};
use pam_diagnose::{
    DiagnoseError, DiagnoseOptions, EffectLadder, JointDiagnosis, RecordingSets, Stage, Verdict,
    diagnose,
};
use pam_effects::ExtendedModel;
use pam_effects::effects;
use pam_experiment::ExperimentError;
use pam_experiment::certify::Certificate;
use pam_experiment::design::{Design, DesignOptions, Objective};
use pam_experiment::detect::DetectOptions;
use pam_experiment::standing::{Measurement, conclusion, live_causes, standing, standing_section};
use pam_report::page::{number, paragraph};
use pam_rig::protocol::CurrentSegment;
use pam_rig::{Conditions, Protocol};
use serde_json::json;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// What follows a diagnosis.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Next {
    /// Design the next measurement
    Design,
}

/// Arguments of `pam diagnose`.
#[derive(Debug, Args)]
pub struct DiagnoseArguments {
    /// The model.
    #[command(flatten)]
    pub model: ModelOptions,
    /// Recordings, or folders of them, in which something may be wrong. Several folders are measurements one after another: the
    /// report shows how the standing of each candidate changed with each
    #[arg(long, required = true, num_args = 1.., value_name = "PATH")]
    pub data: Vec<PathBuf>,
    /// Test set, which no decision sees [default: a third of the data, or of the only recording]
    #[arg(long, num_args = 1.., value_name = "PATH")]
    pub heldout: Vec<PathBuf>,
    /// Baseline recordings, on which the model was validated: its error there does not count as a fault [default: those of the
    /// certificate in --settings, if there is one]
    #[arg(long, num_args = 1.., value_name = "PATH")]
    pub healthy: Vec<PathBuf>,
    /// Candidates.
    #[arg(long, value_delimiter = ',', value_name = "ID,…", help = candidates())]
    pub effects: Vec<String>,
    /// Most effects that are named together: the setting `search.max_causes` [default: 3]
    #[arg(long, value_name = "N")]
    pub max_effects: Option<usize>,
    /// Settings of the diagnosis (see docs/diagnosis.md)
    #[arg(long, value_name = "FILE.toml")]
    pub settings: Option<PathBuf>,
    /// Change one setting, like `search.max_causes=4`; may be repeated
    #[arg(long = "set", value_name = "KEY=VALUE")]
    pub overrides: Vec<String>,
    /// Known noise of a channel, the standard deviation of its means over 20 ms: `x=0.004` (mm), `pf=0.3`, `pe=0.3` (kPa)
    /// [default: learned from the data]
    #[arg(long, value_delimiter = ',', value_name = "CHANNEL=DEVIATION,…")]
    pub noise: Vec<String>,
    /// Also fit models of one phenomenon, from a short one to a rich one, and compare their description lengths and test
    /// errors: `friction` (M1 Coulomb and viscous, M2 Stribeck, M3 load-dependent, M4 both, M5 each side, M6 quadratic), or a file
    /// of effects in that order
    #[arg(long, value_name = "friction|FILE.toml")]
    pub ladder: Option<String>,
    /// Also write a protocol for the rig that distinguishes the named cause from those it is confusable with
    #[arg(long)]
    pub design: bool,
    /// What to do next: `design` searches the protocol that distinguishes the live causes and writes it into the folder
    /// (design.toml, design.json, design.html, commands of each recording)
    #[arg(long, value_enum, value_name = "WHAT")]
    pub then: Option<Next>,
    /// Limits and effort of `--then design`.
    #[command(flatten)]
    pub effort: DesignEffort,
    /// Do not fit the error that remains after the named causes. By default a smooth correction of the model is fitted to it, or
    /// a short formula (a law) if one fits as well; `law.toml` or `correction.toml` defines the one that the test set confirms
    #[arg(long)]
    pub no_law: bool,
    /// Fit the error that remains: the default.
    #[arg(long, hide = true, conflicts_with = "no_law")]
    pub law: bool,
    /// How recordings are read.
    #[command(flatten)]
    pub reading: DataOptions,
    /// Folder for diagnosis.json, report.html and model.safetensors
    #[arg(long, value_name = "DIR")]
    pub out: PathBuf,
}

/// Help of `pam diagnose --effects`.
fn candidates() -> String {
    let ids: Vec<&str> = effects::all().into_iter().map(|e| e.info().id).collect();
    format!("Effects that may be named, separated by commas [default: all of {}]", ids.join(", "))
}

impl RunCommand for DiagnoseArguments {
    fn outputs(&self) -> Vec<Output<'_>> {
        vec![Output::Folder("diagnose", &self.out)]
    }

    fn run(&self, global: &GlobalOptions, console: &Console) -> Result<ExitCode, CliError> {
        let options = options(self, global)?;
        let saved = self.model.load_extended(global.rig_for(&self.data)?.as_ref())?;
        let read = |paths: &[PathBuf]| -> Result<Option<Vec<Subject>>, CliError> {
            if paths.is_empty() {
                return Ok(None);
            }
            Ok(Some(self.reading.unchecked_subjects(paths, &saved, global, console)?))
        };
        let (measurements, data) = self.measurements(&saved, global, console)?;
        let test = read(&self.heldout)?;
        let certificate = settings_of(self.settings.as_deref(), &[])?.1;
        let healthy = self.healthy(certificate.as_ref())?;
        let baseline = read(healthy)?;
        for set in [Some(&data), test.as_ref(), baseline.as_ref()].into_iter().flatten() {
            check_quality(set, global, console)?;
        }
        let sets =
            RecordingSets { data: &data, test: test.as_deref(), baseline: baseline.as_deref() };
        let quoted = Quoted {
            measurements: &measurements,
            certificate: certificate.clone(),
            then: self.then_design(&options, global)?,
        };
        let (diagnosis, _) = diagnosed_into(&self.out, &saved, &sets, &options, quoted, console)?;
        let configuration = json!({
            "model": self.model.model,
            "data": self.data,
            "heldout": self.heldout,
            "healthy": healthy,
            "effects": options.candidates.iter().map(|e| e.info().id).collect::<Vec<_>>(),
            "settings": options.settings,
            "allow_implausible": options.allow_implausible,
            "noise": options.noise,
            "law": options.law,
            "ladder": self.ladder,
            "reading": self.reading.to_json(global)?,
        });
        run_record::write(&self.out, "diagnose", global.seed, &configuration)?;
        if self.design {
            write_design(&diagnosis, &self.out, console)?;
        }
        finish(&diagnosis, &self.out, console);
        Ok(ExitCode::SUCCESS)
    }
}

impl DiagnoseArguments {
    /// The baseline recordings: those that are given, else those of the certificate.
    fn healthy<'a>(
        &'a self,
        certificate: Option<&'a Certificate>,
    ) -> Result<&'a [PathBuf], CliError> {
        let certified = certificate.map_or(&[][..], |c| &c.baseline);
        if !self.healthy.is_empty() {
            return Ok(&self.healthy);
        }
        if let Some(missing) = certified.iter().find(|p| !p.exists()) {
            return Err(CliError::Usage(format!(
                "--settings: the certificate was made with the baseline recordings {}, which are not there; give baseline \
                 recordings of the rig by --healthy",
                missing.display()
            )));
        }
        Ok(certified)
    }

    /// The measurements with all their recordings: each folder one of its own, if there are several; else all together.
    fn measurements(
        &self,
        saved: &SavedModel,
        global: &GlobalOptions,
        console: &Console,
    ) -> Result<(Vec<Measurement>, Vec<Subject>), CliError> {
        let name = |p: &PathBuf| {
            p.file_name().map_or_else(|| p.display().to_string(), |n| n.to_string_lossy().into())
        };
        let read =
            |paths: &[PathBuf]| self.reading.unchecked_subjects(paths, saved, global, console);
        if self.data.len() < 2 || !self.data.iter().all(|p| p.is_dir()) {
            let data = read(&self.data)?;
            return Ok((vec![("data".into(), data.len())], data));
        }
        let (mut measurements, mut data) = (Vec::new(), Vec::new());
        for folder in &self.data {
            let own = read(std::slice::from_ref(folder))?;
            measurements.push((name(folder), own.len()));
            data.extend(own);
        }
        Ok((measurements, data))
    }

    fn then_design(
        &self,
        options: &DiagnoseOptions,
        global: &GlobalOptions,
    ) -> Result<Option<DesignOptions>, CliError> {
        if self.then != Some(Next::Design) {
            return Ok(None);
        }
        let diagnosis = DiagnoseOptions { law: false, ladder: None, ..options.clone() };
        let detect = DetectOptions { diagnosis, ..DetectOptions::default() };
        Ok(Some(self.effort.options(detect, global.seed)?))
    }
}

/// The noise of x, P_f and P_e from texts like `pf=0.3`.
fn known_noise(texts: &[String]) -> Result<[Option<f64>; 3], CliError> {
    const CHANNELS: [&str; 3] = ["x", "pf", "pe"];
    let mut noise = [None; 3];
    for text in texts {
        let of = |t: &str| t.trim().parse::<f64>().ok().filter(|d| d.is_finite() && *d > 0.0);
        let known = text.split_once('=').and_then(|(channel, deviation)| {
            Some((CHANNELS.iter().position(|c| *c == channel.trim())?, of(deviation)?))
        });
        let (channel, deviation) = known.ok_or_else(|| {
            CliError::Usage(format!(
                "--noise: `{text}` is no channel (x, pf, pe) with a positive standard deviation, like `pf=0.3`"
            ))
        })?;
        noise[channel] = Some(deviation);
    }
    Ok(noise)
}

fn options(
    arguments: &DiagnoseArguments,
    global: &GlobalOptions,
) -> Result<DiagnoseOptions, CliError> {
    if arguments.max_effects == Some(0) {
        return Err(CliError::Usage("--max-effects must be at least 1".into()));
    }
    let most = arguments.max_effects.map(|most| format!("search.max_causes={most}"));
    let changes: Vec<String> = arguments.overrides.iter().cloned().chain(most).collect();
    let (settings, _) = settings_of(arguments.settings.as_deref(), &changes)?;
    let mut options = DiagnoseOptions {
        seed: global.seed,
        settings,
        allow_implausible: global.accept,
        noise: known_noise(&arguments.noise)?,
        ..DiagnoseOptions::default()
    };
    options.law = !arguments.no_law;
    options.ladder = arguments.ladder.as_deref().map(ladder).transpose()?;
    if !arguments.effects.is_empty() {
        options.candidates =
            arguments.effects.iter().map(|id| effect(id)).collect::<Result<_, _>>()?;
    }
    Ok(options)
}

/// The ladder of a name, or of the effects of a file.
fn ladder(name: &str) -> Result<EffectLadder, CliError> {
    let known = EffectLadder::named(name).ok_or_else(|| {
        CliError::Usage(format!(
            "--ladder: there is no ladder `{name}`; there is friction, or give a file of effects"
        ))
    })?;
    Ok(known?)
}

/// A ladder as a table.
fn ladder_table(ladder: &Ladder) -> String {
    let mut rows = vec![
        ["model", "bits", "χ² open", "χ² test", "x RMSE test", "parameters"]
            .map(str::to_owned)
            .to_vec(),
    ];
    for (k, rung) in ladder.rungs.iter().enumerate() {
        let value = |(name, i): &(&str, Interval)| {
            let n = |v: f64| significant(v, 3);
            format!("{name} {} [{}, {}]", n(i.value), n(i.ci95[0]), n(i.ci95[1]))
        };
        rows.push(vec![
            format!("{}{}", rung.id, if k == ladder.shortest { " *" } else { "" }),
            number(rung.description_length_bits, 1),
            number(rung.chi_square, 3),
            rung.test_chi_square.map_or_else(|| "–".into(), |chi| number(chi, 3)),
            rung.test
                .first()
                .map_or_else(String::new, |e| format!("{} {}", number(e.rmse, 4), e.unit)),
            rung.parameters.iter().map(value).collect::<Vec<_>>().join(", "),
        ]);
    }
    format!("{}\n{}", table(&rows), ladder.sentence())
}

/// Further contents of a report, and the step after the diagnosis.
#[derive(Default)]
pub struct Quoted<'a> {
    /// Measurements, if there are several; their recordings are those of the data.
    pub measurements: &'a [Measurement],
    /// The certificate that came with the settings.
    pub certificate: Option<Certificate>,
    /// The design of the next measurement.
    pub then: Option<DesignOptions>,
}

/// Diagnoses and writes `diagnosis.json`, `report.html` and `model.safetensors` into a folder, and `law.toml` or `correction.toml`
/// if a law or a correction was learned.
///
/// # Errors
/// [`CliError`] if there is too little data, the model diverges, or a file cannot be written.
pub fn diagnose_into(
    folder: impl AsRef<Path>,
    saved: &SavedModel,
    sets: &RecordingSets<'_>,
    options: &DiagnoseOptions,
    console: &Console,
) -> Result<JointDiagnosis, CliError> {
    Ok(diagnosed_into(folder, saved, sets, options, Quoted::default(), console)?.0)
}

/// As [`diagnose_into`], with the standing after each measurement, the certificate of the settings, and a design.
///
/// # Errors
/// As [`diagnose_into`].
pub fn diagnosed_into(
    folder: impl AsRef<Path>,
    saved: &SavedModel,
    sets: &RecordingSets<'_>,
    options: &DiagnoseOptions,
    quoted: Quoted<'_>,
    console: &Console,
) -> Result<(JointDiagnosis, Option<Design>), CliError> {
    let folder = folder.as_ref();
    let model = ExtendedModel::from_saved(saved.clone())?;
    let bar = console.progress(1000, "diagnosing");
    let count = quoted.measurements.len();
    let (standings, diagnosis) = if count > 1 {
        let done = |k: usize, stage, share| show(&bar, stage, share, (k, count));
        match standing(&model, quoted.measurements, sets, options, &done) {
            Ok((all, found)) => (all, Ok(found)),
            Err(ExperimentError::Diagnose(e)) => (Vec::new(), Err(e)),
            Err(other) => return Err(other.into()),
        }
    } else {
        let done = |stage, share| show(&bar, stage, share, (0, 1));
        (Vec::new(), diagnose(&model, sets, options, &done))
    };
    bar.finish_and_clear();
    let diagnosis = diagnosis.map_err(|e| match e {
        DiagnoseError::Implausible(_) => failed(format!(
            "{e}. Nothing was fitted; correct the data, or give --allow-implausible to go on"
        )),
        other => other.into(),
    })?;
    for finding in &diagnosis.model.plausibility {
        console.warn(finding.to_string());
    }
    for cut in &diagnosis.model.cut_recordings {
        console.warn(cut.to_string());
    }
    let mut extended = diagnosis.model.extended.to_saved();
    let remainder = diagnosis.remainder.as_ref();
    if diagnosis.is_extended() {
        extended.info.provenance = format!("{}; extended by a diagnosis", saved.info.provenance);
    }
    let path = folder.join("model.safetensors");
    save_model(&path, &extended)?;
    if let Some((name, text)) = remainder.and_then(Remainder::file) {
        write_atomic(folder.join(name), text.as_bytes())?;
    }
    let designed = match &quoted.then {
        Some(options) => next_measurement(folder, &diagnosis, saved, (sets, options), console)?,
        None => None,
    };
    let mut json = diagnosis.to_json("model.safetensors");
    let mut sections = Vec::new();
    let ends = conclusion(&diagnosis, designed.as_ref());
    if !standings.is_empty() || designed.is_some() {
        json["conclusion"] = json!(ends);
        json["measurements"] = json!(standings);
        console.text(&ends);
        let section = standing_section(&standings, &ends);
        sections.push(("The measurements one after another".to_owned(), section));
    }
    if let Some(certificate) = &quoted.certificate {
        let sentence = certificate.sentence(diagnosis.score.log_odds);
        json["certificate"] = json!({ "sentence": sentence, "trials": certificate });
        console.text(&sentence);
        sections.push(("How far to trust it here".to_owned(), paragraph(&sentence)));
    }
    write_json(folder.join("diagnosis.json"), &json)?;
    let context = ReportContext {
        model: saved.info.name.clone(),
        model_line: describe_model(saved),
        made_by: made_by(),
        sections,
    };
    let report = diagnosis_report(&diagnosis, &context);
    write_atomic(folder.join("report.html"), report.as_bytes())?;
    Ok((diagnosis, designed))
}

/// Designs the measurement that distinguishes the live causes of a diagnosis; `None` if there is but one answer.
fn next_measurement(
    folder: &Path,
    diagnosis: &JointDiagnosis,
    saved: &SavedModel,
    (sets, options): (&RecordingSets<'_>, &DesignOptions),
    console: &Console,
) -> Result<Option<Design>, CliError> {
    let live = live_causes(diagnosis);
    if live.is_empty() {
        return Ok(None);
    }
    // Causes that are certain are part of the model under which the others are distinguished.
    let ids: Vec<&str> = diagnosis
        .causes
        .iter()
        .filter(|c| !c.alternatives.is_empty())
        .map(|c| c.effect.as_str())
        .collect();
    let mut model = diagnosis.model.extended.clone();
    // The noise of these recordings, with the errors of the model in it.
    let trials = PreparedTrials::new(&model, sets.data, &options.detect.diagnosis.settings)?;
    let learned = Signatures::new(&model, &trials, &options.detect.diagnosis, None)?;
    let noise = Some(learned.noise().common());
    model.effects.retain(|a| !ids.contains(&a.effect.info().id));
    let options =
        DesignOptions { objective: Objective::Separation(live), noise, ..options.clone() };
    design_into(folder, &model, &describe_model(saved), &options, "design.html", console).map(Some)
}

/// Writes `design.toml`, a protocol for the rig, and `design.json`, how well each excitation separates.
fn write_design(
    diagnosis: &JointDiagnosis,
    folder: &Path,
    console: &Console,
) -> Result<(), CliError> {
    let all = diagnosis.design();
    write_json(folder.join("design.json"), &json!(all))?;
    let Some(best) = all.first() else {
        console.text("Nothing is confusable: there is no experiment to design.");
        return Ok(());
    };
    let per_ampere = pam_core::units::tendon_force_mn_per_a() / pam_core::units::MN_PER_N;
    let protocol = Protocol {
        name: "design".into(),
        conditions: Some(Conditions::List(best.psi.iter().map(|p| p.map(|v| v as u8)).collect())),
        current: best
            .excitation
            .pieces
            .iter()
            .map(|&[force_n, frequency_hz, duration_s]| CurrentSegment::Sine {
                amplitude_a: (1e3 * force_n / per_ampere).round() / 1e3,
                frequency_hz,
                duration_s,
            })
            .collect(),
        ..Protocol::paper()
    };
    let path = folder.join("design.toml");
    write_atomic(&path, protocol.to_toml().as_bytes())?;
    console.text(format!(
        "Excitation that separates best ({}; {:.1} times the noise): {}\n",
        best.excitation.name,
        best.least(),
        path.display()
    ));
    Ok(())
}

fn show(bar: &ProgressBar, stage: Stage, share: f64, (done, of): (usize, usize)) {
    let (what, share) = stage.progress(share);
    bar.set_message(what);
    let whole = (done as f64 + share) / of as f64;
    bar.set_position((1000.0 * whole) as u64);
}

/// Prints the result.
pub fn finish(diagnosis: &JointDiagnosis, folder: impl AsRef<Path>, console: &Console) {
    let folder = folder.as_ref();
    console.json(&diagnosis.to_json(&folder.join("model.safetensors").display().to_string()));
    console.text(format!("{}\n\n{}", diagnosis.verdict, verdict_sentence(diagnosis)));
    for cause in &diagnosis.causes {
        if !cause.confusable_with.is_empty() {
            console.text(format!(
                "These recordings do not distinguish {} from {}.",
                plain_name(&cause.effect),
                cause
                    .confusable_with
                    .iter()
                    .map(|id| plain_name(id))
                    .collect::<Vec<_>>()
                    .join(", ")
            ));
        }
    }
    if let Some(remainder) = diagnosis.remainder.as_ref().filter(|r| r.correction.is_some()) {
        console.text(format!("\n{}", remainder.sentence));
        for (name, i) in remainder.law.iter().flat_map(|l| &l.parameters) {
            let n = |v: f64| significant(v, 4);
            let [low, high] = i.ci95;
            console.text(format!("  {name} = {} [{}, {}]", n(i.value), n(low), n(high)));
        }
    } else if diagnosis.remainder.is_none()
        && matches!(diagnosis.verdict, Verdict::Unexplained | Verdict::PartlyExplained)
    {
        console.text("\nAn error remains: without --no-law it is fitted, by a short formula if there is one.");
    }
    let reduction = &diagnosis.error_reduction;
    let (x, overall) = (&reduction.channels[0], &reduction.overall);
    // Zero has no sign.
    let change_percent = |reduction: f64| (-100.0 * reduction).round() + 0.0;
    console.text(format!(
        "\n{}\nx: RMSE {:.4} -> {:.4} mm, R² {:.4} -> {:.4}; overall error {:+.0} % [{:.0}, {:.0}].",
        diagnosis.test.sentence(),
        x.rmse_before,
        x.rmse_after,
        x.r2_before,
        x.r2_after,
        change_percent(overall.error_reduction),
        change_percent(overall.ci95[1]),
        change_percent(overall.ci95[0]),
    ));
    if let Some(ladder) = &diagnosis.ladder {
        console.text(format!("\n{}", ladder_table(ladder)));
    }
    console.text(format!("\nreport: {}", folder.join("report.html").display()));
}
