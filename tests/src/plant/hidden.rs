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
/// | `cubic_spring` | `n_mm3`: force −k x³ |
/// | `quadratic_drag` | `n_s2_mm2`: force −c v abs(v) |
/// | `pressure_damping` | `n_s_mm_kpa`: damping that grows with the sum of the gauge pressures |
/// | `displacement_damping` | `n_s_mm3`: force −c x² v |
/// | `one_way_damping` | `n_s_mm`: damping of motion towards +x alone |
/// | `soft_stop` | `n_mm`, `from_mm`: spring beyond a displacement |
/// | `flexor_friction` | `n_kpa`: dry friction that grows with the gauge pressure of the flexor |
/// | `pressure_friction` | `n_kpa`: dry friction that grows with the sum of the gauge pressures |
/// | `second_path` | `share`, `time_s`: a share of the motor's force acts backwards, low-passed |
/// | `warming_damping` | `n_s3_mm3`, `time_s`: damping that grows with the low-passed square of the velocity |
/// | `reading_crosstalk` | `share`: the reading of P_e has a share of P_f − P_e |
/// | `edge_friction` | `n_mm`: dry friction that grows with abs(x) |
/// | `quartic_spring` | `n_mm4`: force −k x⁴, which pulls one way |
/// | `extensor_damping` | `n_s_mm_kpa`: damping that grows with the gauge pressure of the extensor |
/// | `saturating_damping` | `n`, `mm_s`: force −a tanh(v/w) |
/// | `pressure_ripple` | `n_kpa`, `pitch_mm`: force periodic in x whose amplitude grows with the sum of the gauge pressures |
/// | `one_sided_drag` | `n_s2_mm2`: quadratic drag of motion towards −x alone |
/// | `pressure_hysteresis` | `n_kpa`, `slip_mm`: a Maxwell-slip element whose force grows with the sum of the gauge pressures |
/// | `pressure_relaxation` | `n_mm_kpa`, `time_s`: a spring in series with a damper, stiffer at higher pressures |
/// | `position_coupling` | `n_s_mm2`: force −c x v |
/// | `moving_leak` | `g_mm_kpa`: the flexor loses air while the joint moves |
/// | `turbulent_crosstalk` | `g_s_kpa2`: air flows between the chambers with the signed square of the difference |
/// | `running_friction` | `n_s_mm`, `time_s`: dry friction that grows with the low-passed speed |
/// | `fading_damping` | `n_s_mm`, `time_s`: damping that decays with time |
/// | `extensor_friction` | `n_kpa`: dry friction that grows with the gauge pressure of the extensor |
/// | `stiffening_spring` | `n_mm`, `scale_mm`: force −k w (sinh(x/w) − x/w) |
/// | `outer_damping` | `n_s_mm2`, `from_mm`: damping that grows with abs(x) beyond a displacement |
/// | `difference_damping` | `n_s_mm_kpa`: damping that grows with P_f − P_e |
/// | `quadratic_spring` | `n_mm2`: force −k x abs(x) |
/// | `opening_crosstalk` | `g_s_mm_kpa`: air flows between the chambers at positive displacements |
/// | `bent_pressure` | `per_kpa`: the reading of P_f has a share of its own square |
/// | `bent_position` | `per_mm`: the reading of x has a share of its own square |
/// | `worked_spring` | `n_s2_mm3`, `time_s`: a spring as stiff as the low-passed square of the velocity |
/// | `loaded_damping` | `s_mm`, `time_s`: damping that grows with the low-passed size of the motor's force |
/// | other laws | see the fields of `Laws` |
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
    #[must_use]
    pub fn begins_s(&self) -> f64 {
        self.onset_s.max(self.values.get("time_s").copied().unwrap_or(0.0))
    }

    /// Id of the vocabulary's effect with the same equation: a step in the encoder's zero is a position offset with an onset, a step in a
    /// sensor's gain a pressure gain with an onset. Its own id otherwise.
    #[must_use]
    pub fn same_as(&self) -> &str {
        match self.id.as_str() {
            "tendon_slip" => "position_offset",
            "sensor_gain_jump" => "pressure_gain",
            own => own,
        }
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
