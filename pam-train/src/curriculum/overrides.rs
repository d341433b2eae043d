//! Curricula from text, with single values overridden.

use super::{Curriculum, CurriculumError};
use pam_data::document;
use pam_data::toml_file;
use std::path::Path;
use toml::{Table, Value};

impl Curriculum {
    /// Reads a curriculum from TOML text, with overrides like `rate=3e-4` or `stage.2.epochs=50`
    /// (stages count from zero); `path` is for messages.
    ///
    /// # Errors
    /// [`CurriculumError`] naming file and line, or the override.
    pub fn parse(
        text: &str,
        path: impl AsRef<Path>,
        overrides: &[String],
    ) -> Result<Self, CurriculumError> {
        Self::parse_at(text, path.as_ref(), overrides)
    }

    /// Compiled here once: the code of a deserializer is large.
    fn parse_at(text: &str, path: &Path, overrides: &[String]) -> Result<Self, CurriculumError> {
        let mut curriculum: Self = toml_file::parse(text, path)?;
        if !overrides.is_empty() {
            let mut table: Table = toml_file::parse(text, path)?;
            for change in overrides {
                let fail =
                    |message: String| CurriculumError::Override { text: change.clone(), message };
                set(&mut table, change).map_err(fail)?;
                // Each is checked by itself, so that the message names the one that is wrong.
                curriculum = toml_file::from_table(&table).map_err(fail)?;
            }
        }
        curriculum.check().map_err(|e| match e {
            // The name of a curriculum from a file may be that of another one.
            CurriculumError::Sense { message, .. }
                if !Self::BUILT_IN.iter().any(|n| path == Path::new(n)) =>
            {
                CurriculumError::Sense { name: path.display().to_string(), message }
            }
            other => other,
        })?;
        Ok(curriculum)
    }

    /// Opens a curriculum by the name of a built-in one or the path of a file.
    ///
    /// # Errors
    /// [`CurriculumError`].
    pub fn open(name: &str, overrides: &[String]) -> Result<Self, CurriculumError> {
        let path = Path::new(name);
        if let Some(text) = Self::built_in_text(name) {
            return Self::parse(text, path, overrides);
        }
        if !path.exists() && !name.ends_with(".toml") {
            return Err(CurriculumError::Unknown {
                name: name.to_owned(),
                known: Self::BUILT_IN.join(", "),
            });
        }
        Self::parse(&toml_file::text(path)?, path, overrides)
    }

    /// The curriculum as TOML text.
    ///
    /// # Panics
    /// Never: every part of a curriculum can be written as TOML.
    #[must_use]
    pub fn to_toml(&self) -> String {
        document::to_toml(self).expect("a curriculum is made of plain tables")
    }
}

/// Sets one value of a table from text: `a.b.0.c = value`, the value in TOML, or as text if it is none.
fn set(table: &mut Table, change: &str) -> Result<(), String> {
    let (path, text) = change.split_once('=').ok_or("write it as key=value")?;
    let text = text.trim();
    let value = toml_file::single_value(text).unwrap_or_else(|| Value::String(text.to_owned()));
    set_value(table, path.trim(), value)
}

/// Sets one value of a table by its path, `a.b.0.c`: tables that are not there are made, places of lists
/// count from zero.
///
/// # Errors
/// Which part of the path leads nowhere.
pub fn set_value(table: &mut Table, path: &str, value: Value) -> Result<(), String> {
    let keys: Vec<&str> = path.split('.').collect();
    let (last, parents) = keys.split_last().ok_or("the key is missing")?;
    let mut at = table;
    let mut rest = parents.iter().peekable();
    while let Some(key) = rest.next() {
        let next = at.entry((*key).to_owned()).or_insert_with(|| Value::Table(Table::new()));
        let next = match next {
            Value::Array(items) => {
                let index = rest.next().ok_or_else(|| format!("`{key}` is a list: {key}.0.…"))?;
                let len = items.len();
                index.parse::<usize>().ok().and_then(|i| items.get_mut(i)).ok_or_else(|| {
                    format!("`{key}` has the places 0 to {}", len.saturating_sub(1))
                })?
            }
            other => other,
        };
        at = next.as_table_mut().ok_or_else(|| format!("`{key}` holds no values of its own"))?;
    }
    at.insert((*last).to_owned(), value);
    Ok(())
}
