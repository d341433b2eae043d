//! How recordings are read.

use super::accept::check_plausible;
use super::choice::choice;
use crate::arguments::GlobalOptions;
use crate::console::Console;
use crate::error::CliError;
use clap::Args;
use pam_data::{
    LoadOptions, MassChoice, MassOptions, MuscleSurfaces, PressureReference, Recording, RigFile,
    SavedModel, Subject, collect_paths_of, read_files,
};
use serde_json::{Value, json};
use std::path::{Path, PathBuf};

/// How recordings are read.
#[derive(Debug, Clone, Args)]
pub struct DataOptions {
    /// Source of the sealed air masses; masses in a file take precedence
    #[arg(long, value_parser = choice::<MassChoice>(), default_value = "auto", value_name = "SOURCE")]
    pub masses: MassChoice,
    /// Single-muscle surfaces (poly44_all_fits.mat)
    #[arg(long, value_name = "FILE")]
    pub surfaces: Option<PathBuf>,
    /// Filter CSV and .npz data like a raw log and recompute the velocity
    #[arg(long)]
    pub preprocess: bool,
    /// Change a constant of the raw-log loader, for example cutoff_hz=10 or search_from_row=0; may
    /// be given several times
    #[arg(long = "loader", value_name = "KEY=VALUE")]
    pub loader: Vec<String>,
    /// Reference of the pressures of CSV, .npz and .mat data; raw logs are gauge
    #[arg(long, alias = "mat-pressure", value_parser = choice::<PressureReference>(), default_value = "auto", value_name = "REFERENCE")]
    pub pressure: PressureReference,
    /// [`LoadOptions::filtered_force_only`].
    #[arg(skip)]
    pub filtered_force_only: bool,
}

impl DataOptions {
    /// The same for a model with or without effects: without them nothing reads the force before its filter.
    #[must_use]
    pub fn for_model(&self, has_effects: bool) -> Self {
        Self { filtered_force_only: !has_effects, ..self.clone() }
    }

    /// The loader's options.
    ///
    /// # Errors
    /// [`CliError::Usage`] naming a loader option that does not exist.
    pub fn load_options(&self, rig: Option<RigFile>) -> Result<LoadOptions, CliError> {
        let mut options = LoadOptions {
            rig,
            preprocess: self.preprocess,
            pressure_reference: self.pressure,
            filtered_force_only: self.filtered_force_only,
            ..LoadOptions::default()
        };
        for assignment in &self.loader {
            options
                .raw_log
                .set(assignment)
                .map_err(|e| CliError::Usage(format!("--loader {assignment}: {e}")))?;
        }
        Ok(options)
    }

    /// How the masses are found.
    ///
    /// # Errors
    /// [`CliError::Data`] if the file of the mass surfaces is invalid.
    pub fn mass_options(&self) -> Result<MassOptions, CliError> {
        let surfaces = self.surfaces.as_deref().map(MuscleSurfaces::read).transpose()?;
        Ok(MassOptions { choice: self.masses, surfaces })
    }

    /// Reads recordings of files and folders, of a rig if there is one, with a progress bar.
    ///
    /// # Errors
    /// [`CliError`] naming file, line and column, or the option.
    pub fn recordings(
        &self,
        paths: &[impl AsRef<Path>],
        rig: Option<RigFile>,
        console: &Console,
    ) -> Result<Vec<Recording>, CliError> {
        let options = self.load_options(rig)?;
        let paths = collect_paths_of(paths, options.rig.as_ref())?;
        let bar = console.progress(paths.len(), "reading");
        let recordings = read_files(&paths, &options, &|| bar.inc(1));
        bar.finish_and_clear();
        Ok(recordings?)
    }

    /// Reads recordings with their masses for a model, prints their notes, and checks them against the physics of
    /// the joint. They are read as files of the rig of `--rig-file`, or of the rig of the model.
    ///
    /// # Errors
    /// As [`recordings`](Self::recordings); [`CliError::Failed`] if units, columns or signs are wrong and `--accept`
    /// is not given.
    pub fn subjects(
        &self,
        paths: &[impl AsRef<Path>],
        saved: &SavedModel,
        global: &GlobalOptions,
        console: &Console,
    ) -> Result<Vec<Subject>, CliError> {
        let subjects = self.unchecked_subjects(paths, saved, global, console)?;
        check_plausible(saved, &subjects, global, console)?;
        Ok(subjects)
    }

    /// [`subjects`](Self::subjects) without the check.
    ///
    /// # Errors
    /// As [`recordings`](Self::recordings).
    pub fn unchecked_subjects(
        &self,
        paths: &[impl AsRef<Path>],
        saved: &SavedModel,
        global: &GlobalOptions,
        console: &Console,
    ) -> Result<Vec<Subject>, CliError> {
        let masses = self.mass_options()?;
        let rig = global.rig()?.or_else(|| saved.info.rig.clone());
        let subjects = Subject::resolve(self.recordings(paths, rig, console)?, saved, &masses)?;
        subjects.iter().for_each(|s| console.notes(&s.recording));
        Ok(subjects)
    }

    /// The options as JSON, for run folders.
    ///
    /// # Errors
    /// As [`load_options`](DataOptions::load_options).
    pub fn to_json(&self, global: &GlobalOptions) -> Result<Value, CliError> {
        let load = self.load_options(global.rig()?)?;
        Ok(json!({
            "masses": format!("{:?}", self.masses).to_lowercase(),
            "surfaces": self.surfaces,
            "preprocess": self.preprocess,
            "pressure": format!("{:?}", self.pressure).to_lowercase(),
            "raw_log": load.raw_log,
            "rig": load.rig,
            "accept": global.accept,
        }))
    }
}
