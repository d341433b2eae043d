//! Settings of a training cell in addition to its curriculum.

use super::StiffnessProbe;
use crate::experiment::Problem;
use crate::sweep::Assignment;
use pam_data::toml_file;
use pam_train::curriculum::{Curriculum, CurriculumError, set_value};
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};
use toml::Table;

/// The keys of a cell that are not its curriculum's.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CellSettings {
    /// A curriculum that comes with the program, or a TOML file.
    #[serde(default = "recommended")]
    pub curriculum: String,
    /// Files and folders of recordings.
    pub recordings: Vec<PathBuf>,
    /// Number of training recordings, drawn by the seed from those that `data.train` selects; all if
    /// absent. Those that are not drawn are not held out either, so that all sizes have the same held-out
    /// recordings.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub subset: Option<usize>,
    /// Only the first seconds of each recording.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub seconds: Option<f64>,
    /// Stiffness of the trained model, by some scheme.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub stiffness: Option<StiffnessProbe>,
}

fn recommended() -> String {
    "recommended".into()
}

/// First parts of the keys that are not the curriculum's.
const OWN: [&str; 5] = ["curriculum", "recordings", "subset", "seconds", "stiffness"];

impl CellSettings {
    /// The settings and the curriculum that a table with some assignments makes; relative paths start
    /// from `base`.
    ///
    /// # Errors
    /// [`Problem`] naming the assignment.
    pub fn of(
        experiment: &Table,
        base: impl AsRef<Path>,
        assignments: &[Assignment],
    ) -> Result<(Self, Curriculum), Problem> {
        let base = base.as_ref();
        let mut table = experiment.clone();
        let mut overrides: Vec<(usize, String)> = Vec::new();
        let read = |table: &Table, assignment: Option<usize>| {
            let settings: Self = toml_file::from_table(table).map_err(|message| match message {
                m if m.contains("missing field `recordings`") => Problem::new(
                    "there are no recordings; give [experiment] recordings = [\"folder\"] or --data",
                ),
                message => Problem { assignment, message },
            })?;
            settings.check().map_err(|message| Problem { assignment, message })?;
            Ok::<Self, Problem>(settings)
        };
        let mut settings = read(&table, None)?;
        for (i, a) in assignments.iter().enumerate() {
            let first = a.key.split('.').next().unwrap_or_default();
            if OWN.contains(&first) {
                set_value(&mut table, &a.key, a.value.clone())
                    .map_err(|message| Problem { assignment: Some(i), message })?;
                // Each is checked by itself, so that the message names the one that is wrong.
                settings = read(&table, Some(i))?;
            } else {
                overrides.push((i, format!("{}={}", a.key, a.value)));
            }
        }
        let chosen = assignments.iter().rposition(|a| a.key == "curriculum");
        let file = base.join(&settings.curriculum);
        let built_in = Curriculum::built_in_text(&settings.curriculum).is_some();
        let name = if built_in { settings.curriculum.clone() } else { file.display().to_string() };
        let open = |n: usize| {
            let texts: Vec<String> = overrides[..n].iter().map(|(_, text)| text.clone()).collect();
            Curriculum::open(&name, &texts)
        };
        let curriculum = open(overrides.len()).map_err(|e| {
            let message = match &e {
                CurriculumError::Override { message, .. } => message.clone(),
                other => other.to_string(),
            };
            // The first override without which it would still be sound, or the curriculum itself.
            let first = (0..=overrides.len()).find(|&n| open(n).is_err()).unwrap_or(0);
            let assignment = match first {
                0 => chosen,
                n => Some(overrides[n - 1].0),
            };
            Problem { assignment, message }
        })?;
        Ok((settings, curriculum))
    }

    fn check(&self) -> Result<(), String> {
        if self.recordings.is_empty() {
            return Err("recordings is empty; name files or folders".into());
        }
        if self.subset == Some(0) {
            return Err("subset must be at least one".into());
        }
        if self.seconds.is_some_and(|s| !(s.is_finite() && s > 0.0)) {
            return Err("seconds must be positive".into());
        }
        self.stiffness.as_ref().map_or(Ok(()), StiffnessProbe::check)
    }
}
