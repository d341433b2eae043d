//! Losses written in one line, as a command line takes them.

use super::AnyLoss;
use crate::settings::SettingsError;
use pam_core::error::OWN_PART;
use pam_data::document;
use serde_json::{Map, Number, Value};
use std::str::FromStr;

/// Reads `NAME` or `NAME:KEY=VALUE,…`: a name of [`AnyLoss::all`] with the fields of that loss. Lists are separated
/// by slashes, intervals are written `FROM..TO`, and the loss that another one wraps comes last, as `of=LOSS`.
///
/// ```
/// use pam_trajectory::AnyLoss;
/// for text in [
///     "paper",
///     "squared:weights=100/100/1/1",
///     "huber:form=huber,thresholds=0.5/5/2/2,weights=1/1/1/1",
///     "masked:every=4,intervals_s=0..10/20..30,of=normalised:weights=2/1/1/1",
/// ] {
///     text.parse::<AnyLoss>()?;
/// }
/// # Ok::<(), pam_trajectory::SettingsError>(())
/// ```
///
/// # Errors
/// [`SettingsError`] for unknown names and fields, and for values out of range.
impl FromStr for AnyLoss {
    type Err = SettingsError;

    fn from_str(text: &str) -> Result<Self, SettingsError> {
        let fail = |why: String| SettingsError(format!("loss `{text}`: {why}"));
        let (name, _) = text.split_once(':').unwrap_or((text, ""));
        let known: Vec<&str> = Self::all().into_iter().map(|(name, _)| name).collect();
        if !known.contains(&name) {
            return Err(fail(format!(
                "unknown loss `{name}`; known: {}; {OWN_PART}",
                known.join(", ")
            )));
        }
        let loss: Self = table(text)
            .and_then(|table| document::from_value(table).map_err(|e| e.to_string()))
            .map_err(fail)?;
        loss.check().map_err(|e| fail(e.to_string()))?;
        Ok(loss)
    }
}

/// The table of a loss as a configuration file would hold it.
fn table(text: &str) -> Result<Value, String> {
    let (name, mut rest) = text.split_once(':').unwrap_or((text, ""));
    let mut table = Map::from_iter([("kind".to_owned(), Value::from(name))]);
    while !rest.is_empty() {
        if let Some(inner) = rest.strip_prefix("of=") {
            table.insert("of".into(), self::table(inner)?);
            break;
        }
        let (field, next) = rest.split_once(',').unwrap_or((rest, ""));
        let (key, value) =
            field.split_once('=').ok_or_else(|| format!("`{field}` is not KEY=VALUE"))?;
        if table.insert(key.to_owned(), parsed(value)?).is_some() {
            return Err(format!("`{key}` is given twice"));
        }
        rest = next;
    }
    Ok(Value::Object(table))
}

/// A number, a text, a list of either, or a list of intervals.
fn parsed(value: &str) -> Result<Value, String> {
    let number = |text: &str| -> Result<Value, String> {
        match (text.parse::<u64>(), text.parse::<f64>()) {
            (Ok(whole), _) => Ok(whole.into()),
            (_, Ok(number)) => Number::from_f64(number)
                .map(Value::Number)
                .ok_or_else(|| format!("`{text}` is not finite")),
            _ => Err(format!("`{text}` is not a number")),
        }
    };
    if value.contains("..") {
        let interval = |text: &str| {
            let (from, to) =
                text.split_once("..").ok_or_else(|| format!("`{text}` is not FROM..TO"))?;
            Ok(Value::from(vec![number(from)?, number(to)?]))
        };
        value.split('/').map(interval).collect::<Result<Vec<_>, String>>().map(Value::from)
    } else if value.contains('/') {
        value.split('/').map(number).collect::<Result<Vec<_>, _>>().map(Value::from)
    } else {
        Ok(number(value).unwrap_or_else(|_| value.into()))
    }
}
