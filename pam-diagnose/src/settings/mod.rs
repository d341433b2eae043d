//! Every number on which a diagnosis depends, with its meaning, unit, default and the default's origin.

mod groups;

pub use groups::{
    DataSettings, FitSettings, IntervalSettings, NoiseSettings, OnsetSettings, RejectionSettings,
    RemainderSettings, ResidualSettings, SearchSettings, VerdictSettings,
};

use crate::error::DiagnoseError;
use groups::Row;
#[cfg(feature = "joint")]
use pam_data::toml_file;
use serde::{Deserialize, Serialize};
#[cfg(feature = "joint")]
use toml::{Table, Value};

/// All settings of a diagnosis. In TOML each group is a table; values that are missing keep their defaults, unknown
/// keys are refused.
///
/// ```
/// use pam_diagnose::settings::DiagnosisSettings;
///
/// let settings = DiagnosisSettings::parse("[search]\nsingles = 5", &["search.max_causes=2".into()])?;
/// assert_eq!((settings.search.singles, settings.search.max_causes), (5, 2));
/// assert!(DiagnosisSettings::parse("", &["search.single=2".into()]).is_err());
/// # Ok::<(), pam_diagnose::DiagnoseError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct DiagnosisSettings {
    /// Rows, and the split of the recordings.
    pub data: DataSettings,
    /// The noise of each channel.
    pub noise: NoiseSettings,
    /// The fit of one hypothesis.
    pub fit: FitSettings,
    /// The search over sets of candidates.
    pub search: SearchSettings,
    /// The rejection of names.
    pub rejection: RejectionSettings,
    /// Causes that begin, end or grow at a time.
    pub onset: OnsetSettings,
    /// The verdict.
    pub verdict: VerdictSettings,
    /// The residual summary.
    pub residual: ResidualSettings,
    /// Confidence intervals.
    pub intervals: IntervalSettings,
    /// What no listed cause explains.
    pub remainder: RemainderSettings,
}

impl DiagnosisSettings {
    #[cfg(feature = "joint")]
    /// Reads settings from TOML text and changes single values, written as `search.singles=4`.
    ///
    /// # Errors
    /// [`DiagnoseError::Settings`] naming the key and the known keys, or the value and its range.
    pub fn parse(text: &str, changes: &[String]) -> Result<Self, DiagnoseError> {
        let fail =
            |message: String| DiagnoseError::Settings(message.trim_end().replace('\n', "; "));
        let mut table: Table = toml_file::table(text).map_err(fail)?;
        let mut settings: Self = toml_file::from_table(&table).map_err(fail)?;
        for change in changes {
            let fail = |message: String| fail(format!("`{change}`: {message}"));
            let (key, value) =
                change.split_once('=').ok_or_else(|| fail("write it as key=value".into()))?;
            let (group, field) = key.trim().split_once('.').ok_or_else(|| {
                fail(format!("the key has a group and a name, like {}", Self::table()[0].key))
            })?;
            let value = toml_file::single_value(value.trim())
                .ok_or_else(|| fail(format!("`{}` is not a value of TOML", value.trim())))?;
            let group = table.entry(group).or_insert_with(|| Value::Table(Table::new()));
            if let Some(group) = group.as_table_mut() {
                group.insert(field.to_owned(), value);
            }
            // Each change is checked by itself, so that the message names the one that is wrong.
            settings = toml_file::from_table(&table).map_err(fail)?;
        }
        settings.check()?;
        Ok(settings)
    }

    /// Refuses values outside their ranges.
    ///
    /// # Errors
    /// [`DiagnoseError::Settings`] naming the key, its range and the value.
    pub fn check(&self) -> Result<(), DiagnoseError> {
        self.data
            .check()
            .and_then(|()| self.noise.check())
            .and_then(|()| self.fit.check())
            .and_then(|()| self.search.check())
            .and_then(|()| self.rejection.check())
            .and_then(|()| self.onset.check())
            .and_then(|()| self.verdict.check())
            .and_then(|()| self.residual.check())
            .and_then(|()| self.intervals.check())
            .and_then(|()| self.remainder.check())
            .map_err(DiagnoseError::Settings)
    }

    fn table() -> Vec<Row> {
        [
            DataSettings::rows(),
            NoiseSettings::rows(),
            FitSettings::rows(),
            SearchSettings::rows(),
            RejectionSettings::rows(),
            OnsetSettings::rows(),
            VerdictSettings::rows(),
            ResidualSettings::rows(),
            IntervalSettings::rows(),
            RemainderSettings::rows(),
        ]
        .into_iter()
        .flatten()
        .collect()
    }

    /// The key of every setting, such as `search.singles`, with its least and its greatest value.
    #[must_use]
    pub fn ranges() -> Vec<(&'static str, [f64; 2])> {
        Self::table().into_iter().map(|row| (row.key, row.range)).collect()
    }

    /// The reference table of all settings in Markdown.
    #[must_use]
    pub fn reference() -> String {
        let mut text = String::from(
            "| key | meaning | unit | default | range | the default is |\n|---|---|---|---|---|---|\n",
        );
        let number = |value: f64| {
            let plain = value == 0.0 || (1e-3..1e5).contains(&value.abs());
            if plain { value.to_string() } else { format!("{value:e}") }
        };
        for row in Self::table() {
            let [low, high] = row.range.map(number);
            text += &format!(
                "| `{}` | {} | {} | {} | {low} to {high} | {} |\n",
                row.key, row.meaning, row.unit, row.default, row.origin
            );
        }
        text
    }
}
