//! Protocols: the motor's current, the pressures, and the conditions of each run.
//!
//! A protocol has two parallel tracks that begin at time zero. `[[current]]` segments follow
//! each other and drive the motor; `[[pressure]]` segments follow each other and drive the servo, and
//! where there are none (left) the muscles are sealed. Before time zero the muscles are inflated by
//! the servo, sealed, and left to rest.
//!
//! ```
//! let protocol = pam_rig::Protocol::parse(r#"
//!     name = "mine"
//!     conditions = [[30, 60], [45, 45]]      # psi gauge, flexor and extensor
//!     [[current]]
//!     kind = "sine"
//!     amplitude_a = 1.0
//!     frequency_hz = 0.5
//!     duration_s = 4.0
//! "#, std::path::Path::new("mine.toml"))?;
//! assert_eq!(protocol.runs()?.len(), 2);
//! # Ok::<(), pam_rig::RigError>(())
//! ```

mod builtin;
mod conditions;
mod current;
mod pressure;
mod read;
mod table;

pub use conditions::{ConditionSet, Conditions};
pub use current::CurrentSegment;
pub use pressure::PressureSegment;
pub use table::Table;

use crate::error::RigError;
use pam_data::conditions::name_of;
use serde::{Deserialize, Serialize};

/// Edges fall on samples whose times carry rounding, s.
const TOLERANCE_S: f64 = 0.5e-9;

/// Inflation and rest before time zero.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct LeadIn {
    /// Time for which the servo inflates and holds the muscles, s.
    pub inflate_s: f64,
    /// Time at rest after the valves closed, s. The loader averages its last 0.1 s.
    pub rest_s: f64,
}

impl Default for LeadIn {
    fn default() -> Self {
        Self { inflate_s: 12.0, rest_s: 2.5 }
    }
}

/// A protocol.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Protocol {
    /// Its name.
    pub name: String,
    /// Sealed pressures at which it is run, one recording each; absent where the pressures are driven.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub conditions: Option<Conditions>,
    /// Suffix of the names `nn_FFEE` of its logs.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub suffix: Option<String>,
    /// Inflation and rest before time zero.
    #[serde(default)]
    pub lead_in: LeadIn,
    /// The motor's current, one segment after another.
    #[serde(default)]
    pub current: Vec<CurrentSegment>,
    /// The pressures, one segment after another.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub pressure: Vec<PressureSegment>,
}

/// One run of a protocol.
#[derive(Debug, Clone, PartialEq)]
pub struct Run {
    /// Name of the recording.
    pub name: String,
    /// Pressures to which the muscles are inflated before time zero, psi gauge.
    pub start_psi: [f64; 2],
}

impl Protocol {
    /// Its runs.
    ///
    /// # Errors
    /// [`RigError::Protocol`] if it has neither conditions nor driven pressures, or both.
    pub fn runs(&self) -> Result<Vec<Run>, RigError> {
        let fail = |message: &str| {
            Err(RigError::Protocol { name: self.name.clone(), message: message.to_owned() })
        };
        match (&self.conditions, self.pressure.first()) {
            (Some(_), Some(_)) => fail(
                "has both conditions and [[pressure]] segments; driven pressures start where their \
                 first segment starts, leave `conditions` out",
            ),
            (None, None) => fail(
                "has neither conditions nor [[pressure]] segments; give conditions = \"train\", \
                 \"grid\", \"symmetric\" or a list like [[30, 60]]",
            ),
            (None, Some(first)) => {
                let suffix = self.suffix.as_ref().map_or(String::new(), |s| format!("_{s}"));
                Ok(vec![Run {
                    name: format!("{}{suffix}", self.name),
                    start_psi: first.start_psi(),
                }])
            }
            (Some(conditions), None) => {
                let suffix = self.suffix.as_ref().map_or(String::new(), |s| format!("_{s}"));
                let run = |[f, e]: [u8; 2]| Run {
                    name: format!("{}{suffix}", name_of([f, e])),
                    start_psi: [f64::from(f), f64::from(e)],
                };
                Ok(conditions.psi().into_iter().map(run).collect())
            }
        }
    }

    /// Length after time zero, s: that of the longer track.
    #[must_use]
    pub fn duration_s(&self) -> f64 {
        let current: f64 = self.current.iter().map(CurrentSegment::duration_s).sum();
        let pressure: f64 = self.pressure.iter().map(PressureSegment::duration_s).sum();
        current.max(pressure)
    }

    /// Largest current of the amplifier, A.
    pub const LARGEST_A: f64 = current::LARGEST_A;
    /// Largest sealed pressure that the supply can hold, psi gauge.
    pub const LARGEST_PSI: u8 = conditions::LARGEST_PSI;

    /// The protocol with the lengths of its current segments multiplied so that they last `length_s` together; files of
    /// currents keep theirs.
    #[must_use]
    pub fn with_duration(mut self, length_s: f64) -> Self {
        let factor = length_s / self.current.iter().map(CurrentSegment::duration_s).sum::<f64>();
        let stretched = |s: CurrentSegment| {
            let own = factor * s.duration_s();
            s.with_duration(own)
        };
        self.current = self.current.into_iter().map(stretched).collect();
        self
    }

    /// The motor's current at a time, A; random segments are drawn from the seed.
    #[must_use]
    pub fn current_a(&self, time_s: f64, seed: u64) -> f64 {
        let mut start_s = 0.0;
        for (index, segment) in self.current.iter().enumerate() {
            let within = time_s - start_s;
            if within < -TOLERANCE_S {
                return 0.0;
            }
            if within + TOLERANCE_S < segment.duration_s() {
                return segment.current_a(within.max(0.0), seed.wrapping_add(index as u64));
            }
            start_s += segment.duration_s();
        }
        0.0
    }

    /// The servo's targets at a time, psi gauge; `None` where the muscles are sealed.
    #[must_use]
    pub fn targets_psi(&self, time_s: f64) -> Option<[f64; 2]> {
        let mut start_s = 0.0;
        for segment in &self.pressure {
            let within = time_s - start_s;
            if within + TOLERANCE_S < segment.duration_s() {
                return segment.targets_psi(within.max(0.0));
            }
            start_s += segment.duration_s();
        }
        None
    }
}
