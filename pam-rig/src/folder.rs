//! A folder of recordings, written in parallel and resumable; a log is complete or absent.

use crate::error::RigError;
use crate::protocol::{Protocol, Run};
use crate::record::{check_length, record};
use crate::rig::{Rig, RigParameters};
use crate::truth::Truth;
use pam_core::parallel;
use pam_data::DataError;
use pam_data::atomic::{remove_temporary, write_atomic};
use pam_data::document;
use pam_data::formats::raw_log::RawLog;
use serde::Serialize;
use serde_json::{Value, json};
use std::path::{Path, PathBuf};
use std::time::Duration;

/// Name of the file with all settings and hidden effects, which no estimator reads.
pub const SETTINGS_FILE: &str = "truth.json";

/// The settings of a folder of recordings.
#[derive(Debug, Clone, PartialEq)]
pub struct Session {
    /// The rig.
    pub rig: RigParameters,
    /// The protocol.
    pub protocol: Protocol,
    /// Seed of all noise.
    pub seed: u64,
    /// `true` writes the ground truth of each log.
    pub truth: bool,
    /// First line of each log.
    pub note: String,
}

/// One recording of a folder.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Entry {
    /// Its name.
    pub name: String,
    /// Its log.
    pub log: PathBuf,
    /// Measured pressures when the excitation began, psi gauge.
    pub sealed_psi: [f64; 2],
    /// Smallest and largest measured displacement from then on, mm.
    pub displacement_mm: [f64; 2],
    /// Frames of the log.
    pub frames: usize,
    /// `true` if the log existed before.
    #[serde(skip)]
    pub was_there: bool,
}

impl Session {
    /// Everything that determines the bytes of the recordings.
    ///
    /// # Errors
    /// [`RigError::Data`] if a value cannot be written as JSON (it can).
    pub fn settings(&self) -> Result<Value, RigError> {
        let value = |v: Result<Value, serde_json::Error>| {
            v.map_err(|e| DataError::Io { path: SETTINGS_FILE.into(), source: e.into() })
        };
        Ok(json!({
            "program": format!("pam-rig {}", env!("CARGO_PKG_VERSION")),
            "seed": self.seed,
            "truth_of_samples": self.truth,
            "note": self.note,
            "protocol": value(serde_json::to_value(&self.protocol))?,
            "rig": value(serde_json::to_value(&self.rig))?,
        }))
    }

    /// Writes all recordings into a folder, on all threads. `progress` is called for each that is done.
    ///
    /// Every file is complete or absent. The settings are written first, the truth before its log, so an
    /// existing log is finished, and an interrupted session continues if it is called again with the same
    /// settings. The bytes depend on settings and seed alone.
    ///
    /// # Errors
    /// [`RigError::Folder`] if the folder holds recordings made with other settings (unless
    /// `overwrite`), [`RigError`] if the settings are impossible or a file cannot be written.
    pub fn record_into(
        &self,
        folder: impl AsRef<Path>,
        overwrite: bool,
        progress: &(dyn Fn(&Entry) + Sync),
    ) -> Result<Vec<Entry>, RigError> {
        let folder = folder.as_ref();
        let runs = self.protocol.runs()?;
        // What is impossible is told before anything is written.
        Rig::new(&self.rig, self.seed, 0.0)?;
        check_length(&self.rig, &self.protocol)?;
        let resumes = self.claim(folder, &runs, overwrite)?;
        parallel::map_each(runs, |run| {
            let entry = self.record_one(folder, run, resumes)?;
            progress(&entry);
            Ok(entry)
        })
        .into_iter()
        .collect()
    }

    fn record_one(&self, folder: &Path, run: Run, resumes: bool) -> Result<Entry, RigError> {
        let path = folder.join(&run.name);
        let truth = Truth::path_for(&path);
        if resumes && path.exists() && (truth.exists() || !self.truth) {
            let log = RawLog::read(&path)?;
            let psi = [log.pressure_flexor_psi(), log.pressure_extensor_psi()];
            return Ok(self.entry(run.name, path, log.angle_deg(), psi, true));
        }
        let recorded = record(&self.rig, &self.protocol, &run, self.seed)?;
        if self.truth {
            recorded.truth.write(&truth)?;
        }
        let text = recorded.log_text(&self.note);
        write_atomic(&path, text.as_bytes())?;
        // From the log's text, so that a recording looks the same when it is found again.
        let log = RawLog::parse(&path, text.as_bytes())?;
        let psi = [log.pressure_flexor_psi(), log.pressure_extensor_psi()];
        Ok(self.entry(run.name, path, log.angle_deg(), psi, false))
    }

    fn entry(
        &self,
        name: String,
        log: PathBuf,
        angle_deg: &[f64],
        psi: [&[f64]; 2],
        was_there: bool,
    ) -> Entry {
        let rate_hz = self.rig.sensors.clock.rate_hz;
        let excited = (self.protocol.duration_s() * rate_hz).round() as usize;
        let start = angle_deg.len().saturating_sub(excited);
        let radius = self.rig.sensors.encoder.pulley_radius_mm;
        let x = || angle_deg[start..].iter().map(|a| -a.to_radians() * radius);
        Entry {
            name,
            log,
            sealed_psi: psi.map(|p| p.get(start).copied().unwrap_or(f64::NAN)),
            displacement_mm: [x().fold(f64::MAX, f64::min), x().fold(f64::MIN, f64::max)],
            frames: angle_deg.len(),
            was_there,
        }
    }

    /// Writes the settings into the folder, or checks that the existing ones are the same. `true` if the
    /// existing recordings are kept.
    fn claim(&self, folder: &Path, runs: &[Run], overwrite: bool) -> Result<bool, RigError> {
        let path = folder.join(SETTINGS_FILE);
        let settings = format!("{:#}\n", self.settings()?);
        let fail = |message: &str| {
            Err(RigError::Folder { folder: folder.to_owned(), message: message.to_owned() })
        };
        // Recordings of the settings that are replaced must not be taken for those of these.
        let mut replaced: Vec<String> = runs.iter().map(|run| run.name.clone()).collect();
        match pam_data::read_limit::read_text(&path) {
            Ok(there) if there == settings => {
                remove_temporary(folder, 1, Duration::ZERO);
                return Ok(true);
            }
            Ok(there) if overwrite => replaced.extend(names_in(&there)),
            Ok(_) => {
                return fail(
                    "holds recordings made with other settings; give another folder, or --overwrite",
                );
            }
            Err(_) if !overwrite && runs.iter().any(|run| folder.join(&run.name).exists()) => {
                return fail(
                    "holds logs of these names that this program did not make; give another folder, \
                     or --overwrite",
                );
            }
            _ => {}
        }
        for name in replaced {
            let log = folder.join(name);
            for file in [Truth::path_for(&log), log] {
                if file.exists() {
                    std::fs::remove_file(&file)
                        .map_err(|source| DataError::Io { path: file, source })?;
                }
            }
        }
        write_atomic(&path, settings.as_bytes())?;
        Ok(false)
    }
}

/// Names of the recordings of the settings; none if the settings cannot be read.
fn names_in(settings: &str) -> Vec<String> {
    serde_json::from_str::<Value>(settings)
        .ok()
        .and_then(|v| document::from_value::<Protocol>(v["protocol"].clone()).ok())
        .and_then(|protocol| protocol.runs().ok())
        .map_or_else(Vec::new, |runs| runs.into_iter().map(|run| run.name).collect())
}
