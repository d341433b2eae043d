//! The result of a ladder.

use crate::fit::Interval;
use serde::Serialize;
use serde::ser::{SerializeMap, Serializer};

/// The error of a rung in one channel of the test set.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct RungError {
    /// Key of the channel.
    pub channel: String,
    /// Its unit.
    pub unit: String,
    /// Root-mean-square error.
    pub rmse: f64,
    /// 95 % interval of the reduction from the model without any rung.
    pub reduction_ci95: [f64; 2],
}

/// A fitted model of a ladder.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Rung {
    /// Id; `none` is the model without any rung.
    pub id: String,
    /// What it is.
    pub description: String,
    /// Parameters with 95 % intervals.
    #[serde(serialize_with = "by_name")]
    pub parameters: Vec<(&'static str, Interval)>,
    /// Parameters that ended at a limit of their range.
    pub at_limit: Vec<&'static str>,
    /// Description length of the open rows, bits more than the shortest.
    pub description_length_bits: f64,
    /// Normalised χ² of the open rows: 1 for errors at the level of the noise.
    pub chi_square: f64,
    /// Normalised χ² of the test rows; absent without a test set, or where the simulation fails.
    pub test_chi_square: Option<f64>,
    /// Errors on the test set.
    pub test: Vec<RungError>,
}

/// A ladder that was climbed.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Ladder {
    /// Its name.
    pub name: String,
    /// The model without any rung, then the rungs in their order.
    pub rungs: Vec<Rung>,
    /// Place of the rung of the shortest description.
    pub shortest: usize,
}

impl Ladder {
    /// The rung of the shortest description.
    #[must_use]
    pub fn supported(&self) -> &Rung {
        &self.rungs[self.shortest]
    }

    /// In words.
    #[must_use]
    pub fn sentence(&self) -> String {
        let best = self.supported();
        let rivals: Vec<&str> = self
            .rungs
            .iter()
            .filter(|r| r.id != best.id && r.description_length_bits < CLEAR_BITS)
            .map(|r| r.id.as_str())
            .collect();
        let close = if rivals.is_empty() {
            String::new()
        } else {
            format!("; the data do not tell it from {}", rivals.join(", "))
        };
        format!("The shortest description of the ladder {} is {}{close}.", self.name, best.id)
    }
}

/// Difference of the description length from which it is clear: odds of 20.
const CLEAR_BITS: f64 = 4.32;

fn by_name<S: Serializer>(list: &[(&'static str, Interval)], to: S) -> Result<S::Ok, S::Error> {
    let mut map = to.serialize_map(Some(list.len()))?;
    for (name, interval) in list {
        map.serialize_entry(name, interval)?;
    }
    map.end()
}
