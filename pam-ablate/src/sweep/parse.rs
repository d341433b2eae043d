//! Sweeps from TOML text.

use super::{Assignment, Axis, Goal, MOST_CELLS, Range, Search, Sweep, Values, Variant};
use crate::error::AblateError;
use pam_data::{DataError, document, toml_file};
use serde::Deserialize;
use std::collections::{BTreeMap, HashSet};
use std::path::Path;
use toml::{Spanned, Value};

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawSweep {
    name: Option<String>,
    #[serde(default)]
    question: String,
    seeds: Option<Spanned<Value>>,
    #[serde(default)]
    metrics: Vec<String>,
    #[serde(default)]
    goal: Goal,
    #[serde(default)]
    experiment: Option<Spanned<toml::Table>>,
    #[serde(default)]
    set: BTreeMap<Spanned<String>, Value>,
    #[serde(default)]
    axis: Vec<Spanned<RawAxis>>,
    search: Option<Spanned<Search>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawAxis {
    name: Option<String>,
    key: Option<String>,
    values: Option<Vec<Spanned<Value>>>,
    uniform: Option<[f64; 2]>,
    log_uniform: Option<[f64; 2]>,
    integers: Option<[i64; 2]>,
    #[serde(default)]
    variant: Vec<RawVariant>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawVariant {
    name: String,
    #[serde(default)]
    set: BTreeMap<Spanned<String>, Value>,
}

/// The text of a value in tables.
pub(super) fn label(value: &Value) -> String {
    match value {
        Value::String(text) => text.clone(),
        other => other.to_string(),
    }
}

/// Turns byte offsets into errors with lines.
struct Places<'a> {
    text: &'a str,
    path: &'a Path,
}

impl Places<'_> {
    fn line(&self, offset: usize) -> u64 {
        document::line_of(self.text, offset)
    }

    fn error(&self, offset: usize, message: impl Into<String>) -> AblateError {
        DataError::line(self.path, self.line(offset), message).into()
    }

    /// Assignments in the order of the file, which a map does not keep.
    fn assignments(&self, map: BTreeMap<Spanned<String>, Value>) -> Vec<Assignment> {
        let mut found: Vec<(usize, Assignment)> = map
            .into_iter()
            .map(|(key, value)| {
                let at = key.span().start;
                (at, Assignment { key: key.into_inner(), value, line: self.line(at) })
            })
            .collect();
        found.sort_by_key(|(at, _)| *at);
        found.into_iter().map(|(_, a)| a).collect()
    }

    fn axis(&self, raw: Spanned<RawAxis>) -> Result<Axis, AblateError> {
        let start = raw.span().start;
        let fail = |message: String| self.error(start, message);
        let raw = raw.into_inner();
        let ranges = [
            raw.uniform.map(|[a, b]| Range::Uniform(a, b)),
            raw.log_uniform.map(|[a, b]| Range::LogUniform(a, b)),
            raw.integers.map(|[a, b]| Range::Integers(a, b)),
        ];
        let given = usize::from(raw.values.is_some())
            + usize::from(!raw.variant.is_empty())
            + ranges.iter().flatten().count();
        if given != 1 {
            return Err(fail(
                "an axis has one of: values = [...], uniform, log_uniform or integers = [low, high], \
                 or [[axis.variant]]s"
                    .into(),
            ));
        }
        if !raw.variant.is_empty() {
            let Some(name) = raw.name else {
                return Err(fail("an axis of variants needs a `name`".into()));
            };
            if raw.key.is_some() {
                return Err(fail(
                    "an axis of variants has no `key`; each says what it sets".into(),
                ));
            }
            let variant = |v: RawVariant| Variant { name: v.name, set: self.assignments(v.set) };
            let variants: Vec<Variant> = raw.variant.into_iter().map(variant).collect();
            for (i, v) in variants.iter().enumerate() {
                if variants[..i].iter().any(|w| w.name == v.name) {
                    return Err(fail(format!("two variants are called `{}`", v.name)));
                }
            }
            return Ok(Axis { name, values: Values::List(variants), line: self.line(start) });
        }
        let Some(key) = raw.key else {
            return Err(fail("the axis does not say which `key` it sets".into()));
        };
        let name = raw.name.unwrap_or_else(|| key.clone());
        let line = self.line(start);
        if let Some(range) = ranges.into_iter().flatten().next() {
            let sound = match range {
                Range::Uniform(a, b) => a.is_finite() && b.is_finite() && a < b,
                Range::LogUniform(a, b) => a > 0.0 && b.is_finite() && a < b,
                Range::Integers(a, b) => a <= b,
            };
            if !sound {
                return Err(fail(format!(
                    "the range of `{key}` must go from a smaller to a larger number, of log_uniform a \
                     positive one"
                )));
            }
            return Ok(Axis { name, values: Values::Range(key, range), line });
        }
        let mut variants: Vec<Variant> = Vec::new();
        for value in raw.values.unwrap_or_default() {
            let at = value.span().start;
            let value = value.into_inner();
            let text = label(&value);
            if variants.iter().any(|v| v.name == text) {
                return Err(self.error(at, format!("`{text}` is there twice")));
            }
            let set = vec![Assignment { key: key.clone(), value, line: self.line(at) }];
            variants.push(Variant { name: text, set });
        }
        if variants.is_empty() {
            return Err(fail(format!("the axis of `{key}` has no values")));
        }
        Ok(Axis { name, values: Values::List(variants), line })
    }

    fn seeds(&self, raw: Option<Spanned<Value>>) -> Result<Vec<u64>, AblateError> {
        let Some(raw) = raw else { return Ok(vec![1]) };
        let at = raw.span().start;
        let found = match raw.into_inner() {
            Value::Integer(n) if n > MOST_CELLS as i64 => {
                return Err(
                    self.error(at, format!("seeds = {n}: a sweep has at most {MOST_CELLS} cells"))
                );
            }
            Value::Integer(n) if n > 0 => Some((1..=n as u64).collect()),
            Value::Array(list) => {
                let seed = |v: &Value| v.as_integer().and_then(|i| u64::try_from(i).ok());
                list.iter().map(seed).collect::<Option<Vec<u64>>>()
            }
            _ => None,
        };
        let distinct = |list: &Vec<u64>| {
            !list.is_empty() && list.iter().collect::<HashSet<_>>().len() == list.len()
        };
        found.filter(distinct).ok_or_else(|| {
            self.error(at, "seeds is a number of seeds, or a list of different whole numbers")
        })
    }
}

impl Sweep {
    /// Reads a sweep from TOML text; `path` is for messages, and relative paths start from its folder.
    ///
    /// # Errors
    /// [`AblateError`] with the line.
    pub fn parse(text: &str, path: impl AsRef<Path>) -> Result<Self, AblateError> {
        Self::parse_at(text, path.as_ref())
    }

    /// One instance, whatever the path is given as.
    fn parse_at(text: &str, path: &Path) -> Result<Self, AblateError> {
        let places = Places { text, path };
        let raw: RawSweep = toml_file::parse(text, path)?;
        let axes: Vec<Axis> =
            raw.axis.into_iter().map(|a| places.axis(a)).collect::<Result<_, _>>()?;
        for (i, axis) in axes.iter().enumerate() {
            if axes[..i].iter().any(|a| a.name == axis.name) {
                let message = format!("two axes are called `{}`; give one a `name`", axis.name);
                return Err(DataError::line(path, axis.line, message).into());
            }
            if raw.search.is_none() && matches!(axis.values, Values::Range(..)) {
                let message = format!(
                    "`{}` is a range, which a grid cannot run through; give values, or [search] draws = N",
                    axis.name
                );
                return Err(DataError::line(path, axis.line, message).into());
            }
        }
        if let Some(search) = raw.search.as_ref().filter(|s| s.get_ref().draws == 0) {
            return Err(places.error(search.span().start, "draws must be at least one"));
        }
        let experiment_line = raw.experiment.as_ref().map_or(0, |e| places.line(e.span().start));
        let stem = || path.file_stem().map(|s| s.to_string_lossy().into_owned());
        Ok(Self {
            name: raw.name.or_else(stem).unwrap_or_default(),
            question: raw.question,
            seeds: places.seeds(raw.seeds)?,
            metrics: raw.metrics,
            goal: raw.goal,
            experiment: raw.experiment.map(Spanned::into_inner).unwrap_or_default(),
            set: places.assignments(raw.set),
            axes,
            search: raw.search.map(Spanned::into_inner),
            base: path.parent().unwrap_or(Path::new("")).to_owned(),
            data: BTreeMap::new(),
            path: path.to_owned(),
            experiment_line,
        })
    }

    /// Opens a sweep by the name of a built-in one or the path of a file.
    ///
    /// # Errors
    /// [`AblateError`] naming file and line.
    pub fn open(name: &str) -> Result<Self, AblateError> {
        if let Some(text) = Self::built_in_text(name) {
            return Self::parse(text, Path::new(name));
        }
        let path = Path::new(name);
        if !path.exists() && !name.ends_with(".toml") {
            return Err(AblateError::Unknown {
                name: name.to_owned(),
                known: Self::BUILT_IN.join(", "),
            });
        }
        Self::parse(&toml_file::text(path)?, path)
    }

    /// Sets a key in all cells, before the axes: `rate=3e-4`, the value in TOML or, if it is none, as
    /// text.
    ///
    /// # Errors
    /// [`AblateError::Setting`] if it is not of this form, or an axis sets the key.
    pub fn override_with(&mut self, text: &str) -> Result<(), AblateError> {
        let fail = |message: String| AblateError::setting(format!("--set {text}"), message);
        let (key, value) =
            text.split_once('=').ok_or_else(|| fail("write it as key=value".into()))?;
        let (key, value) = (key.trim(), value.trim());
        let swept = |a: &&Axis| match &a.values {
            Values::Range(k, _) => k == key,
            Values::List(list) => list.iter().flat_map(|v| &v.set).any(|s| s.key == key),
        };
        if let Some(axis) = self.axes.iter().find(swept) {
            return Err(fail(format!("the axis `{}` sets this key itself", axis.name)));
        }
        let value =
            toml_file::single_value(value).unwrap_or_else(|| Value::String(value.to_owned()));
        self.set.retain(|a| a.key != key);
        self.set.push(Assignment::new(key, value));
        Ok(())
    }
}
