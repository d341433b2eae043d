//! An effect that is hidden in the plant.

use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// A hidden effect: an id of the vocabulary with its parameters, or one that the vocabulary does not list:
///
/// | id | parameters |
/// |---|---|
/// | `periodic_disturbance` | `force_n`, `frequency_hz` |
/// | `chamber_crosstalk` | `rate_per_s`: air flows from the flexor to the extensor |
/// | `tendon_slip` | `time_s`, `slip_mm`: the encoder's zero jumps |
/// | `sensor_gain_jump` | `time_s`, `relative`: of the flexor's sensor |
/// | `encoder_freeze` | `period_s`, `duration_s` |
/// | `valve_glitch` | `time_s`, `mass_mg`: air enters the flexor |
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Hidden {
    /// Id.
    pub id: String,
    /// Parameters by name; absent ones are zero.
    pub values: BTreeMap<String, f64>,
    /// Time from which it acts, s from the start of the recording.
    #[serde(default)]
    pub onset_s: f64,
    /// Numbers of the recordings in which it acts; all if absent.
    #[serde(default)]
    pub only: Option<Vec<usize>>,
}

impl Hidden {
    /// An effect that acts always.
    #[must_use]
    pub fn new(id: &str, values: &[(&str, f64)]) -> Self {
        let values = values.iter().map(|(k, v)| ((*k).to_owned(), *v)).collect();
        Self { id: id.to_owned(), values, onset_s: 0.0, only: None }
    }

    /// The effect from a time (s) of each recording on.
    #[must_use]
    pub fn from_s(self, onset_s: f64) -> Self {
        Self { onset_s, ..self }
    }

    /// The effect in some recordings only.
    #[must_use]
    pub fn in_recordings(self, only: Vec<usize>) -> Self {
        Self { only: Some(only), ..self }
    }

    /// Whether it acts in the recording of this number.
    #[must_use]
    pub fn acts_in(&self, recording: usize) -> bool {
        self.only.as_ref().is_none_or(|only| only.contains(&recording))
    }

    /// From which time it acts: the onset, or the time of an event outside the vocabulary.
    pub(super) fn begins_s(&self) -> f64 {
        self.onset_s.max(self.values.get("time_s").copied().unwrap_or(0.0))
    }

    /// A parameter; zero if absent.
    pub(super) fn get(&self, name: &str) -> f64 {
        self.values.get(name).copied().unwrap_or(0.0)
    }

    /// As the command line of the rig writes it.
    #[must_use]
    pub fn text(&self) -> String {
        let values: Vec<String> = self.values.iter().map(|(k, v)| format!("{k}={v}")).collect();
        format!("{}:{}", self.id, values.join(","))
    }

    /// Reads what [`text`](Self::text) writes; `None` if it is not of that form.
    #[must_use]
    pub fn parse(text: &str) -> Option<Self> {
        let (id, rest) = text.split_once(':').unwrap_or((text, ""));
        let pairs = rest.split(',').filter(|p| !p.is_empty()).map(|pair| {
            let (name, value) = pair.split_once('=')?;
            Some((name, value.parse().ok()?))
        });
        let values: Vec<(&str, f64)> = pairs.collect::<Option<_>>()?;
        Some(Self::new(id, &values))
    }
}
