use crate::document;
use pam_core::units;
use serde::{Deserialize, Serialize};

/// The constants with which a raw log is read. The defaults are those of the published loader.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct RawLogOptions {
    /// Row (from zero) at which the search for the excitation begins.
    pub search_from_row: usize,
    /// The excitation starts where |gradient(u)| exceeds this, DAC counts per row.
    pub excitation_threshold: f64,
    /// Rows before the excitation that are averaged into the sealed reading.
    pub sealed_rows: usize,
    /// Frames per second; taken from the log's header (`Fs = …`) if absent, else 1000.
    pub frame_rate_hz: Option<f64>,
    /// Cutoff of the zero-phase low-pass on x, F_e and pressures, Hz; 0 switches it off.
    pub cutoff_hz: f64,
    /// Pulley radius, mm.
    pub pulley_radius_mm: f64,
    /// Torque constant of the motor, mN·m/A.
    pub torque_constant_mnm_per_a: f64,
    /// Gear ratio of the motor.
    pub gear_ratio: f64,
    /// kPa per psi.
    pub kpa_per_psi: f64,
    /// Atmospheric pressure, kPa.
    pub atmosphere_kpa: f64,
    /// Sign between encoder angle and displacement.
    pub angle_sign: f64,
    /// Sign between motor current and external force.
    pub current_sign: f64,
}

impl Default for RawLogOptions {
    fn default() -> Self {
        Self {
            search_from_row: 2000,
            excitation_threshold: 0.01,
            sealed_rows: 100,
            frame_rate_hz: None,
            cutoff_hz: 20.0,
            pulley_radius_mm: units::PULLEY_RADIUS_MM,
            torque_constant_mnm_per_a: units::TORQUE_CONSTANT_MNM_PER_A,
            gear_ratio: units::GEAR_RATIO,
            kpa_per_psi: units::KPA_PER_PSI,
            atmosphere_kpa: units::ATMOSPHERE_KPA,
            angle_sign: -1.0,
            current_sign: -1.0,
        }
    }
}

impl RawLogOptions {
    /// Replaces one option by its name, `key=value`.
    ///
    /// # Errors
    /// A sentence that names the key, or the keys that exist.
    pub fn set(&mut self, assignment: &str) -> Result<(), String> {
        let (key, value) = assignment
            .split_once('=')
            .ok_or_else(|| format!("`{assignment}` is not of the form key=value"))?;
        let (key, value) = (key.trim(), value.trim());
        let number: serde_json::Value = serde_json::from_str(value)
            .map_err(|_| format!("`{value}` is not a number (option `{key}`)"))?;
        let mut all = serde_json::to_value(&*self).map_err(|e| e.to_string())?;
        let fields = all.as_object_mut().ok_or("options are not an object")?;
        if !fields.contains_key(key) {
            let known: Vec<&str> = fields.keys().map(String::as_str).collect();
            return Err(format!("unknown option `{key}`; known: {}", known.join(", ")));
        }
        fields.insert(key.to_owned(), number);
        *self = document::from_value(all).map_err(|e| format!("option `{key}`: {e}"))?;
        Ok(())
    }

    /// External force per ampere of motor current, mN.
    #[must_use]
    pub fn force_mn_per_a(&self) -> f64 {
        self.current_sign * self.torque_constant_mnm_per_a * self.gear_ratio
            / (self.pulley_radius_mm * 1e-3)
    }

    /// Displacement per degree of encoder angle, mm.
    #[must_use]
    pub fn displacement_mm_per_deg(&self) -> f64 {
        self.angle_sign * 1.0_f64.to_radians() * self.pulley_radius_mm
    }
}
