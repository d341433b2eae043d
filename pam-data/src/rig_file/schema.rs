//! The tables of a rig file.

use super::units::{self, Quantity};
use crate::load_options::PressureReference;
use pam_core::units::{ATMOSPHERE_KPA, GEAR_RATIO, PULLEY_RADIUS_MM, TORQUE_CONSTANT_MNM_PER_A};
use serde::{Deserialize, Serialize};

/// The description of a rig and of its files: which column is what, in which unit, and the sizes of the joint.
///
/// Read from TOML with [`RigFile::read`]; [docs/own-rig.md] explains every key. All tables but `columns` may be left out.
///
/// [docs/own-rig.md]: https://github.com/pam-ode/pam/blob/main/docs/own-rig.md
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct RigFile {
    /// Name of the rig, for reports.
    pub name: String,
    /// How files are laid out.
    #[serde(skip_serializing_if = "is_default")]
    pub file: FileLayout,
    /// Where the quantities are. Without it files have the columns of their format, and the rest of this
    /// description holds for them.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub columns: Option<Columns>,
    /// Pulley and motor.
    #[serde(skip_serializing_if = "is_default")]
    pub drive: Drive,
    /// Size of the two equal muscles.
    #[serde(skip_serializing_if = "is_default")]
    pub muscles: Muscles,
    /// The moving parts.
    #[serde(skip_serializing_if = "is_default")]
    pub joint: JointSheet,
    /// The air, inside and outside.
    #[serde(skip_serializing_if = "is_default")]
    pub air: Air,
    /// Low-pass filters of the channels.
    #[serde(skip_serializing_if = "is_default")]
    pub filter: Filters,
    /// Limits of the rig, for plans and designs.
    #[serde(skip_serializing_if = "is_default")]
    pub limits: Limits,
}

/// How files are laid out. What is left out is found by looking at the file.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct FileLayout {
    /// Separator of text files: one character, `"tab"` or `"space"`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub separator: Option<String>,
    /// Decimal mark of text files: `"."` or `","`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub decimal: Option<String>,
    /// Lines above the line of column names (above the data, if `header = false`).
    pub skip_lines: usize,
    /// Whether a line names the columns.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub header: Option<bool>,
    /// Samples per second, for files without a column of times or with counted samples.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rate_hz: Option<f64>,
    /// Topic of an MCAP log whose messages are the rows; the other topics hold their last value. Without it the topic
    /// with the most messages.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub clock: Option<String>,
}

/// Where the quantities are in a file.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Columns {
    /// Time; without it samples are `1/rate_hz` apart.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub time: Option<Column>,
    /// Displacement of the tendon or angle of the pulley.
    pub displacement: Column,
    /// Velocity; without it the derivative of the displacement.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub velocity: Option<Column>,
    /// Pressure of the flexor: it falls as x rises if the muscles widen as they shorten (ν > ½).
    pub pressure_flexor: PressureColumn,
    /// Pressure of the extensor.
    pub pressure_extensor: PressureColumn,
    /// External force, torque, or current of the motor.
    pub force: Column,
}

/// One column. Its values are `sign · (scale · value + offset)` in its unit.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Column {
    /// Name, or number counted from one.
    pub column: ColumnKey,
    /// Unit of the scaled values.
    pub unit: String,
    /// 1, or -1 if the column counts in the other direction.
    #[serde(default = "one", skip_serializing_if = "is_one")]
    pub sign: f64,
    /// Factor before the unit: counts per revolution, volts per newton.
    #[serde(default = "one", skip_serializing_if = "is_one")]
    pub scale: f64,
    /// Added after the factor, in the unit.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub offset: f64,
}

/// A column of pressures, whose zero must be said.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PressureColumn {
    /// Name, or number counted from one.
    pub column: ColumnKey,
    /// Unit of the scaled values.
    pub unit: String,
    /// `absolute` (zero is vacuum) or `gauge` (zero is the atmosphere).
    pub reference: Zero,
    /// Factor before the unit: volts per bar.
    #[serde(default = "one", skip_serializing_if = "is_one")]
    pub scale: f64,
    /// Added after the factor, in the unit.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub offset: f64,
}

impl PressureColumn {
    /// The column without its reference.
    #[must_use]
    pub fn as_column(&self) -> Column {
        Column {
            column: self.column.clone(),
            unit: self.unit.clone(),
            sign: 1.0,
            scale: self.scale,
            offset: self.offset,
        }
    }
}

/// The zero of a pressure.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Zero {
    /// Vacuum.
    Absolute,
    /// The atmosphere.
    Gauge,
}

impl From<Zero> for PressureReference {
    fn from(zero: Zero) -> Self {
        match zero {
            Zero::Absolute => Self::Absolute,
            Zero::Gauge => Self::Gauge,
        }
    }
}

/// A column by its name, or by its number counted from one.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(untagged, expecting = "expected the name of a column, or its number counted from one")]
pub enum ColumnKey {
    /// Its number, counted from one.
    Number(usize),
    /// Its name.
    Name(String),
}

impl std::fmt::Display for ColumnKey {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Number(number) => write!(f, "column {number}"),
            Self::Name(name) => write!(f, "`{name}`"),
        }
    }
}

fn one() -> f64 {
    1.0
}

fn is_default<T: Default + PartialEq>(value: &T) -> bool {
    *value == T::default()
}

#[allow(clippy::trivially_copy_pass_by_ref, reason = "the signature that serde calls")]
fn is_one(value: &f64) -> bool {
    *value == 1.0
}

#[allow(clippy::trivially_copy_pass_by_ref, reason = "the signature that serde calls")]
fn is_zero(value: &f64) -> bool {
    *value == 0.0
}

/// Pulley and motor.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Drive {
    /// Radius of the pulley on which the tendon runs, mm: `x = r q`, `F = τ/r`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub pulley_radius_mm: Option<f64>,
    /// Torque constant of the motor, N·m/A.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub torque_constant_nm_per_a: Option<f64>,
    /// Gear ratio between motor and pulley.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub gear_ratio: Option<f64>,
}

impl Drive {
    /// The drive of the published rig.
    #[must_use]
    pub fn published() -> Self {
        Self {
            pulley_radius_mm: Some(PULLEY_RADIUS_MM),
            torque_constant_nm_per_a: Some(1e-3 * TORQUE_CONSTANT_MNM_PER_A),
            gear_ratio: Some(GEAR_RATIO),
        }
    }
}

/// Size of the two equal muscles at x = 0.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Muscles {
    /// Radius, mm.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub radius_mm: Option<f64>,
    /// Length, mm.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub length_mm: Option<f64>,
    /// Angle of the braid to the axis, degrees: the deformation coefficient starts at its squared cotangent.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub braid_angle_deg: Option<f64>,
    /// Deformation coefficient ν, in place of the braid's angle.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub deformation: Option<f64>,
}

/// The moving parts.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct JointSheet {
    /// Reflected mass `I/r²` at the tendon, kg.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mass_kg: Option<f64>,
    /// Inertia about the joint, kg·m², in place of the mass.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub inertia_kg_m2: Option<f64>,
}

/// The air, inside and outside.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Air {
    /// Pressure of the atmosphere, kPa.
    pub atmosphere_kpa: f64,
    /// Temperature of the sealed air, °C; C = R T/M follows from it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub temperature_c: Option<f64>,
    /// Sealed mass of the flexor's air, g, if it is known and the same in all recordings.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mass_flexor_g: Option<f64>,
    /// Sealed mass of the extensor's air, g.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mass_extensor_g: Option<f64>,
    /// Time at the start of each recording in which the joint is at rest, s: its mean gives the masses. 0 for the
    /// first sample.
    pub rest_s: f64,
}

impl Default for Air {
    fn default() -> Self {
        Self {
            atmosphere_kpa: ATMOSPHERE_KPA,
            temperature_c: None,
            mass_flexor_g: None,
            mass_extensor_g: None,
            rest_s: 0.0,
        }
    }
}

/// Zero-phase low-pass filters (first-order Butterworth, forward and back) of the channels, by their cutoffs in Hz.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Filters {
    /// Of the displacement.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub displacement_hz: Option<f64>,
    /// Of both pressures.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub pressure_hz: Option<f64>,
    /// Of the force.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub force_hz: Option<f64>,
    /// Of the displacement before its derivative is taken as the velocity, where no column gives it; 0 for none.
    pub velocity_hz: f64,
    /// True if the columns in the file have been filtered so already.
    pub in_file: bool,
}

/// Cutoff of the derived velocity, Hz: that of the published loader.
const VELOCITY_HZ: f64 = 20.0;

impl Default for Filters {
    fn default() -> Self {
        Self {
            displacement_hz: None,
            pressure_hz: None,
            force_hz: None,
            velocity_hz: VELOCITY_HZ,
            in_file: false,
        }
    }
}

/// Limits of the rig.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Limits {
    /// Lowest and highest absolute pressure, kPa.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub pressure_kpa: Option<[f64; 2]>,
    /// Lowest and highest displacement, mm.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub displacement_mm: Option<[f64; 2]>,
    /// Largest force, N.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub force_n: Option<f64>,
}

impl RigFile {
    /// The factor from a unit to that of a recording (s, mm, mm/s, kPa, mN).
    ///
    /// # Errors
    /// A sentence naming the unit that does not exist, or the key of this file that it needs.
    pub fn factor(&self, quantity: Quantity, unit: &str) -> Result<f64, String> {
        let found = units::find(quantity, unit).ok_or_else(|| {
            format!(
                "`{unit}` is no unit of {}; known are {}",
                quantity.name(),
                units::names_of(quantity).join(", ")
            )
        })?;
        found.size(&self.drive, self.file.rate_hz)
    }
}
