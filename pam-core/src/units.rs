//! Physical constants and the datasheet of the published rig.
//!
//! Source: X. Wang and J. Realmuto, *Physics-Embedded Neural ODEs for Learning Antagonistic
//! Pneumatic Artificial Muscle Dynamics* (2026), sections II and III.

/// Standard atmosphere, kPa.
pub const ATMOSPHERE_KPA: f64 = 101.325;
/// One pound per square inch in kPa, to the digits that the published loader uses.
pub const KPA_PER_PSI: f64 = 6.89476;
/// Newtons in mN.
pub const MN_PER_N: f64 = 1000.0;

/// Nominal muscle radius r0, mm.
pub const NOMINAL_RADIUS_MM: f64 = 5.0;
/// Nominal muscle length L0, mm.
pub const NOMINAL_LENGTH_MM: f64 = 200.0;
/// Pulley radius r_p, mm; the tendon coordinate is `x = r_p q`.
pub const PULLEY_RADIUS_MM: f64 = 6.875;
/// Joint inertia as the paper rounds it, kg·m²: the motor's rotor through the 36:1 gear, squared,
/// plus the gearbox's own inertia, which sits on the output side (36² · 9.25e-6 + 5e-7 = 1.199e-2).
pub const JOINT_INERTIA_KG_M2: f64 = 1.20e-2;
/// Braid angle of the datasheet, degrees; the deformation coefficient starts at its squared cotangent.
pub const BRAID_ANGLE_DEG: f64 = 25.0;
/// Gas coefficient C = R T / m_air, kPa·mm³/g, as initialised in the paper.
pub const GAS_COEFFICIENT_KPA_MM3_PER_G: f64 = 8.47e7;
/// Torque constant of the motor, mN·m/A.
pub const TORQUE_CONSTANT_MNM_PER_A: f64 = 25.5;
/// Gear ratio of the motor.
pub const GEAR_RATIO: f64 = 36.0;

/// Reflected mass `m = I / r_p²` from the datasheet, kg (253.9 kg).
#[must_use]
pub fn datasheet_reflected_mass_kg() -> f64 {
    let pulley_m = PULLEY_RADIUS_MM * 1e-3;
    JOINT_INERTIA_KG_M2 / (pulley_m * pulley_m)
}

/// Deformation coefficient `nu = cot²(25°)` from the datasheet (4.60).
#[must_use]
pub fn datasheet_deformation_coefficient() -> f64 {
    BRAID_ANGLE_DEG.to_radians().tan().powi(-2)
}

/// Tendon force of one ampere of motor current, mN (133.5 N).
#[must_use]
pub fn tendon_force_mn_per_a() -> f64 {
    TORQUE_CONSTANT_MNM_PER_A * GEAR_RATIO / (PULLEY_RADIUS_MM * 1e-3)
}

/// A number to so many significant digits.
#[must_use]
pub fn significant(value: f64, digits: i32) -> String {
    if value == 0.0 || !value.is_finite() {
        return format!("{value}");
    }
    let places = (digits - 1 - value.abs().log10().floor() as i32).clamp(0, 12);
    format!("{value:.*}", places as usize)
}
