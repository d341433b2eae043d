//! Findings of a check of plausibility.

use serde::Serialize;
use std::fmt;

/// The kind of a [`Finding`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum FindingKind {
    /// The pressures count from the atmosphere where absolute pressures are meant.
    GaugePressure,
    /// The pressures are in another unit, or no unit makes them possible.
    PressureUnit,
    /// A pressure never changes although the joint moves.
    DeadPressure,
    /// Both pressures rise and fall together.
    SameSignPressures,
    /// The pressures are those of the other muscle.
    SwappedMuscles,
    /// The displacement is in another unit.
    DisplacementUnit,
    /// The displacement counts in the other direction.
    DisplacementSign,
    /// The displacement never changes although the force does.
    DeadDisplacement,
    /// The volumes of the model's muscles do not fit the pressures.
    Geometry,
    /// The given masses do not fit pressure and volume.
    Masses,
    /// The time is in another unit.
    TimeUnit,
    /// The velocity is zero while the joint moves.
    VelocityMissing,
    /// The velocity is not the derivative of the displacement.
    Velocity,
    /// The force counts in the other direction.
    ForceSign,
    /// The force is in another unit, or off by a large factor.
    ForceUnit,
}

/// How sure a [`Finding`] is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Severity {
    /// Likely; reported, nothing is refused.
    Warning,
    /// Certain enough to refuse the data unless the caller insists.
    Error,
}

/// One number behind a [`Finding`].
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Evidence {
    /// The quantity, with its unit.
    pub quantity: String,
    /// Its value in the data.
    pub value: f64,
    /// The value that plausible data would have.
    pub expected: f64,
}

impl Evidence {
    pub(super) fn new(quantity: impl Into<String>, value: f64, expected: f64) -> Self {
        Self { quantity: quantity.into(), value, expected }
    }
}

/// Data that contradict the physics of a joint with two sealed muscles.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Finding {
    /// The problem.
    pub kind: FindingKind,
    /// How sure that is.
    pub severity: Severity,
    /// The columns concerned, by their names in CSV files.
    pub channel: String,
    /// Names of the recordings concerned.
    pub recordings: Vec<String>,
    /// The problem, its cause and the remedy.
    pub message: String,
    /// The numbers behind it.
    pub evidence: Vec<Evidence>,
}

impl fmt::Display for Finding {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let shown = 3.min(self.recordings.len());
        let more = self.recordings.len() - shown;
        write!(f, "{}", self.recordings[..shown].join(", "))?;
        if more > 0 {
            write!(f, " and {more} more")?;
        }
        write!(f, ": {}", self.message)
    }
}

/// The findings for which data are refused.
#[must_use]
pub fn errors(findings: &[Finding]) -> Vec<Finding> {
    findings.iter().filter(|f| f.severity == Severity::Error).cloned().collect()
}
