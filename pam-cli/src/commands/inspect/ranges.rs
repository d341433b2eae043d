//! Least value, greatest value and mean of a column.

use pam_numerics::statistics::mean;
use serde_json::{Value, json};

/// The titles above rows of [`range_row`].
pub(super) fn range_titles(first: &str) -> Vec<String> {
    [first, "min", "max", "mean"].map(str::to_owned).to_vec()
}

fn range_of(values: &[f64]) -> (f64, f64, f64) {
    let low = values.iter().copied().fold(f64::INFINITY, f64::min);
    let high = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    (low, high, mean(values))
}

pub(super) fn range_row(name: &str, values: &[f64]) -> Vec<String> {
    let (low, high, mean) = range_of(values);
    vec![name.to_owned(), format!("{low:.4}"), format!("{high:.4}"), format!("{mean:.4}")]
}

pub(super) fn range_json(values: &[f64]) -> Value {
    let (low, high, mean) = range_of(values);
    json!({ "min": low, "max": high, "mean": mean })
}
